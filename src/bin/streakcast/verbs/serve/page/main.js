// Page: one night, one exposure of its schedule or of any target, and the crossings for other start times.

import { TokenRequired, latest, request as send, unlock } from "./api.js";
import * as link from "./link.js";
import { light, onScheme } from "./colours.js";
import { Night, legend } from "./night.js";
import { Strip } from "./strip.js";
import { Field, size } from "./field.js";
import { Dome } from "./dome.js";
import { Curve } from "./curve.js";
import { TonightPanel, showExamples } from "./tonight_panel.js";
import * as crossings from "./crossings.js";
import { hover } from "./hover.js";
import { clock, copy, delay, fixed, fromLocal, hours, iso, moment, offsetAt, sexagesimal, typed, zones } from "./words.js";

const $ = (id) => document.getElementById(id);
/** Points along each track. */
const SAMPLES = 41;
/**
 * Pause of the pointer, ms, after which the whole page is updated. During a drag only verdict, strip and field are
 * updated.
 */
const REST_MS = 150;

/** State in the address. */
const state = { shift: 0, ...link.read() };
/** Last responses of the server: for the night, with its exposures in `rows`, and for the exposure (`answer`). */
let night = null;
let rows = [];
let answer;
/** Last response with points along the tracks, which the requests during a drag omit. */
let detailed = null;
/** Parameters of the last requests; responses to earlier ones are outdated. */
let question = null;
let domeQuestion = null;
/** Number of selections of an exposure; responses to requests of earlier ones are dropped. */
let choice = 0;
/** Number of the last selection whose response is shown. */
let shown = 0;
/** Number of targets that were entered; an earlier one does not replace a later one. */
let entries = 0;
/** True while an exposure is dragged. */
let isMoving = false;
/** Timer of the pause of a drag. */
let resting = 0;
/** True if the response to the last request has arrived, with all details. */
let isAnswered = false;
/** Timer that hides the message about copied text. */
let toasting = 0;
/** Error messages by request. */
const problems = new Map();

const nightChart = new Night($("night"), selectExposure);
const strip = new Strip($("strip"), moved);
const fieldChart = new Field($("field"), selectSatellite);
const domeChart = new Dome($("dome"));
const curveChart = new Curve($("curve"));
const tonight = new TonightPanel(state, { problem, failed, isNew });

const requestExposure = latest("/api/v1/exposure", answered, (error, parameters) => {
  failed(error, "exposure");
  // The last response is not valid for this start.
  if (parameters.choice === choice) nothing("unknown", "no response");
});
const requestSky = latest("/api/v1/dome", (document, parameters) => {
  if (parameters.choice === choice) showDome(document, parameters === domeQuestion);
}, (error, parameters) => {
  failed(error, "dome");
  if (parameters.choice === choice) showDome(null);
});

/** Verdicts of the night for another limiting magnitude. */
const requestVerdicts = latest("/api/v1/night", (document) => {
  if (document.night !== night.night || document.limit_mag !== limit()) return;
  problem("night", null);
  rows = rows.map((row, place) => ({ ...row, flag: document.flags[place] ?? null }));
  count();
  nightChart.show(night, rows);
  drawNight();
}, (error) => failed(error, "night"));

/** Adds the number of the selection to the parameters of a request, as a property that is not sent. */
const withChoice = (parameters) => Object.defineProperty(parameters, "choice", { value: choice });

function failed(error, what) {
  if (error instanceof TokenRequired) {
    $("unlock").hidden = false;
    $("main").hidden = true;
    $("token").focus();
  }
  problem(what, error.message);
}

function problem(what, text) {
  if (text) problems.set(what, text);
  else problems.delete(what);
  $("problem").hidden = !problems.size;
  $("problem").textContent = [...new Set(problems.values())].join(" ");
}

function showDome(dome, isLast = true) {
  if (dome) problem("dome", null);
  if (isLast) $("main").removeAttribute("data-sky-behind");
  domeChart.show(dome);
  drawDome();
}

/** Copies text, and shows whether that succeeded. */
async function copyAs(name, text) {
  $("copied").textContent = (await copy(text)) ? `${name} copied` : `${name} not copied: the browser does not permit it`;
  $("copied").hidden = false;
  clearTimeout(toasting);
  toasting = setTimeout(() => ($("copied").hidden = true), 1800);
}

/** Shows the night of a date, or the first one; `kind` is that of the entry in the browser's history (`link.write`). */
async function load(which, kind = null) {
  const entry = (entries += 1);
  const limits = { limit_mag: state.limit };
  try {
    let document = await send("/api/v1/night", limits);
    // A link to a night that is not in this schedule shows the first night.
    const isKnown = !which || document.nights.some((one) => one.night === which);
    // Without a schedule the night is that of the link, or else the present one.
    const other = which ? { night: which } : { time_utc: iso(Date.now()) };
    if (!document.nights.length) document = await send("/api/v1/night", { ...other, ...limits });
    else if (!isKnown) delete state.row;
    else if (which && which !== document.night) document = await send("/api/v1/night", { night: which, ...limits });
    if (entry !== entries) return;
    problem("night", null);
    problem("entry", null);
    begin(document);
  } catch (error) {
    return entry === entries && failed(error, "night");
  }
  if (state.target && state.start) {
    // The entry is shown in the form.
    $("target").value = state.target;
    $("start").value = state.start.replace("T", " ");
    $("length").value = state.length ?? $("length").value;
    if (await enter(state.target, state.start, Number($("length").value), true)) return;
  }
  const place = rows.findIndex((row) => row.row === state.row);
  const worst = rows.findIndex((row) => row.flag.verdict === "avoid");
  const first = rows.findIndex((row) => row.start != null);
  if (place >= 0) choose(place, true);
  else if (rows.length) choose(Math.max(worst, first, 0), false, kind);
  else {
    state.place = undefined;
    choice += 1;
    for (const id of ["strip", "before", "after", "reset"]) $(id).hidden = true;
    nothing("no exposure", "enter a target");
    drawNight();
  }
}

/** Shows a night; `entered` is an exposure that is not in the schedule. */
function begin(document, entered = null) {
  $("unlock").hidden = true;
  $("main").hidden = false;
  night = document;
  state.night = night.night;
  const scheduled = night.exposures.map((exposure, place) => ({ ...exposure, flag: night.flags[place] }));
  rows = [...scheduled, ...(entered ? [entered] : [])].map((row) => ({ ...row, start: row.start_utc ? moment(row.start_utc) : null }));
  answer = detailed = null;
  describe();
  nightChart.show(night, rows);
}

/** Shows an exposure of any target; returns whether the server accepts it. `isRestored` keeps the state from the address. */
async function enter(target, start_utc, duration_s, isRestored = false) {
  const entry = (entries += 1);
  setBusy(true);
  try {
    const document = await send("/api/v1/exposure", { target, start_utc, duration_s });
    const nights = await send("/api/v1/night", { time_utc: start_utc, limit_mag: state.limit });
    // Another target was entered meanwhile.
    if (entry !== entries) return true;
    // The exposure has no row in the schedule, and its verdict is not in the night chart.
    begin(nights, { ...document.exposures[0], start_utc, id: target, row: null, band: null, flag: null });
    Object.assign(state, { target, start: start_utc, length: duration_s });
    problem("entry", null);
    choose(rows.length - 1, isRestored);
    return true;
  } catch (error) {
    if (entry !== entries) return true;
    setBusy(choice !== shown);
    failed(error, "entry");
    return false;
  }
}

/** States that the shown exposure is not the selected one yet. The words appear after a moment (style sheet). */
function setBusy(isBusy) {
  $("exposure").setAttribute("aria-busy", String(isBusy));
  $("busy").hidden = !isBusy;
}

function describe() {
  const { site } = night;
  const rests = night.provenance;
  $("where").textContent = `${site.name}${site.mpc_code ? ` (${site.mpc_code})` : ""} · field ${size(night.field)} · ${rests.satellites} satellites${rests.shells ? " (simulated)" : ""} · ${night.band} (${night.mag_system})`;
  // The night of an entered exposure may have no exposure of the schedule.
  const listed = night.nights.some((one) => one.night === night.night) ? night.nights : [...night.nights, { night: night.night, exposures: 0 }];
  $("nights").replaceChildren(...listed.map((one) => new Option(`${one.night} (${one.exposures})`, one.night, false, one.night === night.night)));
  $("nights-label").hidden = !night.nights.length;
  // Without a schedule the form is the only way to an exposure.
  if (!night.nights.length) $("any").open = true;
  count();
  $("limit").value = state.limit ?? night.limit_mag ?? 14;
  showLimit();
  $("model").replaceChildren(...night.models.map((name) => new Option(name, name, false, name === (state.model ?? "starlink-v1.5"))));
  $("height").value = state.height ?? 550;
  $("sigma").checked = state.sigma === "1";
  showBackground();
  $("start-label").textContent = `Start, local time (${zones(night.utc_offsets)})`;
  const files = (rests.elements ?? []).map((file) => `${file.file.split("/").pop()} (sha256 ${file.sha256.slice(0, 12)}…, epochs to ${file.last_epoch_utc.slice(0, 10)})`);
  const shells = (rests.shells ?? []).map((shell) => `${shell.name} (simulated)`);
  const several = rests.mean_motion;
  const late = several ? ` · early or late by ${fixed(several.median_late_s, 1)} s (68 %, median), without the sets of other epochs by ${fixed(several.median_late_with_one_epoch_s, 1)} s` : "";
  $("rests").textContent = `streakcast ${rests.version} · ${[...files, ...shells].join(", ")}${late} · ${rests.frame}`;
  warn();
  legend($("scale"), $("bands"));
  // Without a schedule, panels of an exposure are collapsed until a target is entered.
  const isTonight = !night.nights.length;
  $("main").toggleAttribute("data-empty", !rows.length);
  tonight.begin(isTonight, !rows.length);
  showExamples(night.site);
}

/** Shows the night's numbers of verdicts. */
function count() {
  const of = (verdict) => rows.filter((row) => row.flag?.verdict === verdict).length;
  const words = ["clear", "streaked", "avoid", "unknown", "invalid"].map((verdict) => [of(verdict), verdict]).filter(([number]) => number).map((one) => one.join(" "));
  $("night-counts").textContent = words.join(" · ") || `${night.night}, no exposure of a schedule`;
}

/** Returns a text without its numbers. */
const wordsOf = (text) => text.replace(/[\d.]+/g, "");

/** Shows the first warning of night and exposure in one line that opens, and all in a list. Warnings that differ only in numbers are shown once. */
function warn() {
  const all = [...night.warnings, ...(answer?.warnings ?? [])];
  const warnings = all.filter((text, place) => all.findIndex((other) => wordsOf(other) === wordsOf(text)) === place);
  $("warnings").hidden = !warnings.length;
  const [summary, list] = $("warnings").children;
  // An open list is not replaced by the same one during a drag.
  if (list.children.length === warnings.length && warnings.every((text, place) => list.children[place].textContent === text)) return;
  summary.textContent = `${warnings.length} warning${warnings.length > 1 ? "s" : ""}: ${warnings[0]}`;
  list.replaceChildren(
    ...warnings.map((text) => {
      const line = document.createElement("li");
      line.textContent = text;
      return line;
    }),
  );
}

/** Selects an exposure after a click or key, and removes the error message about an entered exposure. */
function selectExposure(place) {
  problem("entry", null);
  choose(place);
}

/**
 * Selects an exposure of the night; `isRestored` keeps its state from the address. `kind` is that of the entry in the
 * browser's history.
 */
function choose(place, isRestored = false, kind = isRestored ? null : "exposure") {
  const row = rows[place];
  if (!row) return;
  state.place = place;
  choice += 1;
  $("strip").hidden = $("reset").hidden = false;
  $("before").hidden = $("after").hidden = rows.length < 2;
  state.row = row.row ?? undefined;
  if (row.row != null) for (const name of ["target", "start", "length"]) delete state[name];
  if (!isRestored) {
    state.shift = 0;
    delete state.duration;
    delete state.satellite;
  }
  $("before").disabled = place === 0;
  $("after").disabled = place === rows.length - 1;
  $("reset").textContent = row.row == null ? "As entered" : "As scheduled";
  if (row.start == null) {
    nothing("invalid", row.flag.reasons.join("; "));
    showDome(null);
    for (const what of ["exposure", "dome"]) problem(what, null);
    nightChart.draw(place);
    link.write(state, kind);
    return;
  }
  state.duration ??= row.duration_s;
  // Title and strip change with the response.
  setBusy(true);
  request();
  requestDome();
  link.write(state, kind);
}

function moved(shift, duration, isDone) {
  // The strip of a previous exposure cannot be moved.
  if (rows[state.place]?.start == null || choice !== shown) return;
  // A press without a move is not a drag yet.
  isMoving = !isDone && (shift !== state.shift || duration !== state.duration);
  state.shift = shift;
  state.duration = duration;
  clearTimeout(resting);
  if (isMoving) {
    for (const what of ["data-behind", "data-sky-behind"]) $("main").setAttribute(what, "");
    resting = setTimeout(rested, REST_MS);
  }
  request();
  if (!isDone) return;
  requestDome();
  link.write(state, "move");
}

/** Updates the whole page when the pointer pauses during a drag. */
function rested() {
  isMoving = false;
  // The night or the exposure may have changed meanwhile.
  if (rows[state.place]?.start == null) return;
  requestDome();
  // This request has the parameters that were omitted during the drag.
  request();
}

const limit = () => state.limit ?? night?.limit_mag ?? null;

/** Returns the shutter opening: the text of the schedule if it was not moved. */
function opening() {
  const row = rows[state.place];
  return state.shift ? iso(row.start + state.shift * 1e3) : row.start_utc;
}

function request() {
  const row = rows[state.place];
  if (row?.start == null) return;
  isAnswered = false;
  question = withChoice({
    start_utc: opening(),
    duration_s: state.duration,
    ra_deg: row.ra_deg,
    dec_deg: row.dec_deg,
    rotation_deg: row.rotation_deg,
    band: row.band,
    limit_mag: state.limit,
    // Omitted during a drag, for a faster response: tracks, and crossings that are on the strip already.
    samples: isMoving ? null : SAMPLES,
    around_s: isMoving && strip.isKnown() ? null : strip.span(state.duration),
  });
  requestExposure(question);
  if (!isMoving) showMove();
}

/** Shows the move in the night chart and in the address. */
function showMove() {
  drawNight();
  link.write(state);
}

function drawNight() {
  nightChart.draw(state.place, rows[state.place]?.start + state.shift * 1e3);
}

function requestDome() {
  if (rows[state.place]?.start == null) return;
  domeQuestion = withChoice({ start_utc: opening(), duration_s: state.duration, height_km: state.height, model: state.model });
  requestSky(domeQuestion);
}

function answered(document, parameters) {
  // Another exposure was selected meanwhile; its own response follows.
  if (parameters.choice !== choice) return;
  problem("exposure", null);
  const row = rows[state.place];
  if (shown !== choice) {
    showTitle();
    strip.show(row.start, state.shift, state.duration);
  }
  answer = document;
  if (parameters.samples) detailed = document;
  const flag = document.flags[0];
  // Times on the strip are relative to the scheduled opening.
  const shift = (moment(parameters.start_utc) - row.start) / 1e3;
  const around = document.around.map((one) => ({ enter: one.enter_s + shift, exit: one.exit_s + shift, name: one.name || one.norad_id, magnitude: one.magnitude_peak, exceeds: one.exceeds_limit }));
  const reach = parameters.around_s;
  const known = reach == null ? null : { from: shift - reach, to: shift + parameters.duration_s + reach };
  strip.answer(around, known, flag.delay_s ? flag.delay_s + shift : null);
  const streaks = flag.n_streaks == null ? "number of streaks unknown" : flag.n_streaks ? `${flag.n_streaks} streak${flag.n_streaks > 1 ? "s" : ""}, brightest ${fixed(flag.brightest_mag, 1)} mag` : "no streak";
  const then = flag.next_clear_start_utc;
  const start = (name, delay_s, utc) => (delay_s != null ? ` · next ${name} start ${delay(delay_s)} (${clock(moment(utc) + 49, 0, 1)} UTC)` : ` · no ${name} start in time`);
  const isSame = flag.acceptable_delay_s === flag.delay_s;
  const acceptable = flag.verdict === "avoid" && !isSame ? start("acceptable", flag.acceptable_delay_s, flag.next_acceptable_start_utc) : "";
  const next = flag.verdict === "clear" ? "" : `${acceptable}${start("clear", flag.delay_s, then)}`;
  const lacks = document.left_out_count ? `${document.left_out_count} of ${night.provenance.satellites} satellites left out: their crossings are unknown.` : "";
  const reasons = flag.reasons.map((reason) => named(reason, document)).join("; ");
  if (isUnjudged(flag)) showAnswer(flag.verdict, reasons, "", lacks);
  else showAnswer(flag.verdict, `${streaks}${next}`, [reasons, ageOf(flag)].filter(Boolean).join("; "), lacks);
  $("answer").dataset.nextClearStartUtc = then ?? "";
  $("answer").dataset.startUtc = parameters.start_utc;
  $("go").hidden = !(flag.delay_s > 0);
  $("go").dataset.delay = flag.delay_s ?? "";
  const [opens] = document.pointing;
  $("pointing").textContent = `opens ${clock(moment(opens.utc))} UTC, ${clock(moment(opens.utc), offsetAt(night.utc_offsets, moment(opens.utc)))} local · ${fixed(state.duration, 1)} s · ${hours(row.ra_deg)} ${sexagesimal(row.dec_deg)} · altitude ${fixed(opens.altitude_deg, 0)}°, azimuth ${fixed(opens.azimuth_deg, 0)}° · Sun ${fixed(opens.sun_altitude_deg, 1)}°`;
  const isThere = document.passes.some((pass) => pass.norad_id === state.satellite);
  if (!isThere) state.satellite = brightest(document.passes)?.norad_id;
  isAnswered = parameters === question && parameters.samples != null;
  drawField();
  warn();
  // The response to a request during a drag is incomplete.
  if (!isMoving && parameters.samples) {
    drawDetails();
    link.write(state);
  }
}

/** Shows the title of the selected exposure, with its results. */
function showTitle() {
  shown = choice;
  setBusy(false);
  $("exposure-title").textContent = rows[state.place] ? `Exposure ${rows[state.place].id}` : "Exposure";
}

/** Returns a reason with the name of its satellite before the catalogue number. */
function named(reason, { passes, around }) {
  const norad = /^(\d+): /.exec(reason)?.[1];
  const name = norad && [...passes, ...around].find((pass) => pass.norad_id === Number(norad))?.name;
  return name ? reason.replace(norad, `${name} (${norad})`) : reason;
}

/** Clears the page of an exposure without a result. */
function nothing(verdict, words) {
  showTitle();
  answer = detailed = null;
  isAnswered = true;
  showAnswer(verdict, words);
  delete $("answer").dataset.nextClearStartUtc;
  delete $("answer").dataset.startUtc;
  $("go").hidden = true;
  $("pointing").textContent = "";
  strip.forget();
  strip.answer([], null, null);
  drawAnswer();
}

const brightest = (passes) => passes.reduce((best, pass) => ((pass.magnitude_peak ?? 99) < (best?.magnitude_peak ?? 100) ? pass : best), null);

function showAnswer(verdict, words, why = "", lacks = "") {
  const strong = document.createElement("strong");
  strong.className = verdict;
  strong.textContent = verdict;
  const small = document.createElement("span");
  small.className = "why";
  small.textContent = why;
  const missing = document.createElement("span");
  missing.className = "lacks";
  missing.textContent = lacks;
  $("answer").replaceChildren(strong, document.createTextNode(`: ${words}`), small, missing);
}

function selectSatellite(norad) {
  state.satellite = norad;
  drawAnswer();
  link.write(state, "satellite");
}

function drawAnswer() {
  if (answer === undefined) return;
  drawField();
  drawDetails();
}

/** Returns true for an exposure that cannot be judged: it is invalid, or the elements are too old. */
const isUnjudged = (flag) => flag.verdict === "invalid" || flag.verdict === "unknown";

/** Returns age and lateness of the elements of the satellites that decide a verdict. */
function ageOf(flag) {
  if (flag.elements_age_days == null) return "";
  const late = flag.late_s == null ? "lateness unknown" : `early or late by ${fixed(flag.late_s, 1)} s (68 %)`;
  return `elements ${fixed(flag.elements_age_days, 1)} days old, ${late}`;
}

/** Returns the passes of a response; undefined without a response, and for an exposure that cannot be judged. */
const passesOf = (document) => (document && !isUnjudged(document.flags[0]) ? document.passes : undefined);

function drawField() {
  fieldChart.draw(night.field, answer?.exposures[0] ?? rows[state.place], passesOf(answer), { selected: state.satellite, corridors: state.sigma === "1" });
}

function drawDetails() {
  if (isAnswered) $("main").removeAttribute("data-behind");
  // During a drag these are the last complete results, shown as outdated.
  const passes = detailed?.passes ?? [];
  const chosen = passes.find((pass) => pass.norad_id === state.satellite) ?? brightest(passes);
  // Empty panels are collapsed.
  $("light-curve").hidden = !chosen;
  if (chosen) curveChart.draw(chosen, limit());
  $("curve-words").textContent = chosen ? `${chosen.name} · ${chosen.mag_source ?? "no model"} · elements ${fixed(chosen.element_age_days, 1)} d old` : "";
  crossings.rows($("crossings"), passesOf(detailed), chosen?.norad_id, selectSatellite);
  showScroll();
  drawDome();
}

/** Returns whether a warning differs from those of night and exposure, apart from numbers. */
function isNew(warning) {
  return ![...night.warnings, ...(answer?.warnings ?? [])].some((known) => wordsOf(known) === wordsOf(warning));
}

function drawDome() {
  domeChart.draw({ pointing: answer?.pointing[0], selected: state.satellite, passes: detailed?.passes, limit: limit(), background: state.map === "1" });
  const dome = domeChart.dome;
  if (!dome) {
    $("dome-words").textContent = "";
    return;
  }
  const bright = dome.satellites.filter((one) => one.magnitude != null && limit() != null && one.magnitude < limit()).length;
  const few = limit() == null ? "" : `, ${bright} with a mean magnitude brighter than ${fixed(limit(), 1)}`;
  const tracks = limit() == null ? "" : " (tracks; the others are dots)";
  const behind = state.map === "1" ? ` Behind them ${dome.map.model} at ${dome.map.height_km} km; dashed: edge of the Earth's shadow there.` : "";
  $("dome-words").textContent = `${dome.satellites.length} sunlit satellites up${few}${tracks}.${behind} Sun at azimuth ${fixed(dome.sun.azimuth_deg, 0)}° (⊙).`;
  $("dome-words").textContent += dome.warnings.filter(isNew).map((text) => ` Warning: ${text}.`).join("");
}

/** Shows whether the table of crossings is wider than the window. */
function showScroll() {
  const table = document.querySelector(".scroll");
  $("scrolls").hidden = table.scrollWidth <= table.clientWidth;
}

function drawAll() {
  if (!night) return;
  tonight.draw();
  showScroll();
  legend($("scale"), $("bands"));
  drawNight();
  strip.draw();
  drawAnswer();
}

$("limit").addEventListener("input", (event) => {
  state.limit = Number(event.target.value);
  showLimit();
  request();
});
// The verdicts of a whole night take longer than that of an exposure, so they follow when the slider is released.
$("limit").addEventListener("change", () => {
  requestVerdicts({ night: night.night, limit_mag: state.limit });
  link.write(state, "limit");
});
function showLimit() {
  $("limit-out").textContent = limit() == null ? "none" : `${fixed(limit(), 1)} mag`;
}
$("nights").addEventListener("change", async (event) => {
  state.shift = 0;
  for (const name of ["row", "duration", "satellite", "target", "start", "length"]) delete state[name];
  await load(event.target.value, "exposure");
});
$("before").addEventListener("click", () => selectExposure(state.place - 1));
$("after").addEventListener("click", () => selectExposure(state.place + 1));
$("reset").addEventListener("click", () => selectExposure(state.place));
$("go").addEventListener("click", () => {
  // Rounded to whole milliseconds, as in the response of the server, so that the start is clear.
  state.shift = Math.round((state.shift + Number($("go").dataset.delay)) * 1e3) / 1e3;
  strip.show(rows[state.place].start, state.shift, state.duration);
  request();
  requestDome();
  link.write(state, "move");
  $("answer").focus({ preventScroll: true });
});
/** Shows whether the sky has a background, and the settings of it. */
function showBackground() {
  $("map").checked = state.map === "1";
  $("map-settings").hidden = state.map !== "1";
}
$("map").addEventListener("change", (event) => {
  state.map = event.target.checked ? "1" : undefined;
  showBackground();
  drawDome();
  link.write(state, "sky");
});
$("height").addEventListener("change", (event) => {
  const height = Number(event.target.value);
  if (!event.target.checkValidity() || !height) return problem("dome", "Height: 160 to 40000 km, whole tens.");
  state.height = height;
  requestDome();
  link.write(state, "sky");
});
$("model").addEventListener("change", (event) => {
  state.model = event.target.value;
  requestDome();
  link.write(state, "sky");
});
$("sigma").addEventListener("change", (event) => {
  state.sigma = event.target.checked ? "1" : undefined;
  drawAnswer();
  link.write(state);
});
function showLight() {
  light(state.light === "red");
  $("red").setAttribute("aria-pressed", String(state.light === "red"));
}
$("red").addEventListener("click", () => {
  state.light = state.light === "red" ? undefined : "red";
  showLight();
  drawAll();
  link.write(state);
});
$("link").addEventListener("click", async () => {
  await copyAs("Link", location.href.replace(/#.*$/, "") + link.text(state));
});
$("csv").addEventListener("click", async () => {
  await copyAs("Crossings", crossings.csv(detailed?.passes ?? []));
});
$("entry").addEventListener("submit", (event) => {
  event.preventDefault();
  enterTyped();
});
async function enterTyped() {
  const entry = (entries += 1);
  const [target, text, length] = [$("target").value.trim(), $("start").value.trim(), Number($("length").value)];
  // In whole seconds, as `--start now` of the command line.
  if (text === "now") return enter(target, iso(Math.floor(Date.now() / 1e3) * 1e3), length);
  const isUtc = /[Zz]$/.test(text);
  const ms = typed(text.replace(/[Zz]$/, "").replace("T", " ").trim(), night.night);
  if (Number.isNaN(ms)) return problem("entry", `Invalid start '${text}'; allowed: now, a local time such as 23:30 or 2026-08-14 23:30, or UTC with Z at its end.`);
  if (isUtc) return enter(target, iso(ms), length);
  try {
    // The clocks may differ between this night and the shown one.
    const other = await send("/api/v1/night", { time_utc: iso(ms - night.utc_offset_h * 3600e3) });
    if (entry === entries) await enter(target, iso(fromLocal(other.utc_offsets, ms)), length);
  } catch (error) {
    failed(error, "entry");
  }
}
$("unlock").addEventListener("submit", (event) => {
  event.preventDefault();
  unlock($("token").value.trim());
  load(state.night);
});
// Back and forward in the browser, and an edited address.
window.addEventListener("popstate", () => {
  link.forget();
  for (const name of Object.keys(state)) delete state[name];
  Object.assign(state, { shift: 0, ...link.read() });
  showLight();
  load(state.night);
});
// Charts are drawn again after a change of their size.
const redraw = () => requestAnimationFrame(drawAll);
const sizes = new ResizeObserver(redraw);
for (const canvas of document.querySelectorAll("canvas")) sizes.observe(canvas);
// Charts are also drawn again after a change of the pixel ratio (zoom, another screen). The ratio is compared regularly,
// because no event is reliable: in one of 40 changes Chromium sent neither that of a media query nor of an observer of
// device pixels.
const RATIO_MS = 500;
let ratio = devicePixelRatio;
setInterval(() => {
  if (ratio === devicePixelRatio) return;
  ratio = devicePixelRatio;
  redraw();
}, RATIO_MS);

onScheme(() => drawAll());
showLight();
crossings.heads($("columns"));
for (const element of document.querySelectorAll("[data-hover]")) hover(element, () => element.dataset.hover);
load(state.night);

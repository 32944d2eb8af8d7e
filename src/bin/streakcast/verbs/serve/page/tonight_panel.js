// Panel of tonight's passes: its requests, texts and controls, and examples of targets.

import { latest } from "./api.js";
import * as link from "./link.js";
import { Tonight, examples } from "./tonight.js";
import { fixed, hour, iso, moment, offsetAt, zones } from "./words.js";

const $ = (id) => document.getElementById(id);
/** Default magnitude limit of the passes, and points along each pass. */
const BRIGHT_MAG = 4;
const PASS_SAMPLES = 25;
/** Passes are requested for whole intervals of this length, ms, so that the server computes them once. */
const STEP_MS = 600e3;
/** Number of examples of targets. */
const EXAMPLES = 5;

/** Returns the present time of requests. */
const present = () => iso(Math.floor(Date.now() / STEP_MS) * STEP_MS);

export class TonightPanel {
  /**
   * `state` is that of the address. Of the page, `problem` and `failed` show errors, and `isNew` returns whether a warning
   * is not shown yet.
   */
  constructor(state, page) {
    this.state = state;
    this.page = page;
    this.list = new Tonight($("passes"), $("more"));
    /** Parameters of the last request; responses to earlier ones are outdated. Null after an error. */
    this.question = null;
    /** Time of the last error, ms. */
    this.failedAt = NaN;
    this.send = latest("/api/v1/forecast", (document, parameters) => {
      if (parameters === this.question) this.show(document);
    }, (error, parameters) => {
      if (parameters === this.question) this.fail(error);
    });
    this.listen();
  }

  listen() {
    const { state, list } = this;
    $("bright").addEventListener("change", (event) => {
      if (!event.target.checkValidity() || event.target.value === "") return this.page.problem("tonight", "Brighter than: -5 to 10 mag.");
      state.bright = Number(event.target.value);
      this.request();
      link.write(state, "tonight");
    });
    $("order").addEventListener("change", (event) => {
      state.order = event.target.value || undefined;
      list.sort(state.order);
      link.write(state, "tonight");
    });
    $("calendar").addEventListener("click", () => list.download(list.calendar, `passes-${list.night}`));
    $("tonight").addEventListener("toggle", () => list.draw());
    setInterval(() => {
      list.tick();
      // After the night, its list is replaced by that of the next one. For the server, the next night begins at sunrise.
      // After an error, the request is sent again.
      const isDue = this.question
        ? Date.now() > list.until && this.question.time_utc !== present()
        : Date.now() > this.failedAt + STEP_MS;
      if (!$("tonight").hidden && isDue) this.request();
    }, 1000);
  }

  /** Shows the panel or hides it. */
  begin(isShown, isOpen) {
    $("tonight").hidden = !isShown;
    $("tonight").open = isShown && isOpen;
    if (isShown) this.request();
  }

  /** Requests tonight's passes; the shown ones stay if nothing has changed. */
  request() {
    const { state, list } = this;
    const parameters = { time_utc: present(), max_mag: state.bright ?? BRIGHT_MAG, samples: PASS_SAMPLES };
    $("bright").value = parameters.max_mag;
    $("order").value = state.order ?? "";
    list.order = state.order;
    if (JSON.stringify(parameters) === JSON.stringify(this.question)) return list.sort(state.order);
    this.question = parameters;
    this.setBusy(true);
    this.send(parameters);
  }

  setBusy(isBusy) {
    $("tonight").setAttribute("aria-busy", String(isBusy));
    $("tonight-busy").hidden = !isBusy;
  }

  fail(error) {
    this.setBusy(false);
    // The list is not that of the question, which may be sent again.
    this.question = null;
    this.failedAt = Date.now();
    this.list.show({ passes: [], calendar: null });
    $("calendar").hidden = true;
    $("tonight-title").textContent = "Tonight: unknown";
    $("tonight-words").textContent = "";
    this.page.failed(error, "tonight");
  }

  show(forecast) {
    this.setBusy(false);
    this.page.problem("tonight", null);
    this.list.show(forecast);
    const of = forecast.night;
    const at = (utc) => hour(moment(utc), offsetAt(forecast.utc_offsets, moment(utc)));
    const number = this.list.passes.length;
    const dark = of.dark_from_utc ? ` The Sun is below ${fixed(of.sun_altitude_limit_deg, 0)}° from ${at(of.dark_from_utc)} to ${at(of.dark_until_utc)}.` : "";
    const found = number ? `${number} pass${number > 1 ? "es" : ""} probably brighter than mag ${this.question.max_mag}` : `${forecast.may_have_passes ? "passes unknown" : "no visible pass"}: ${of.why_empty}`;
    const warnings = forecast.warnings.filter(this.page.isNew).map((text) => ` Warning: ${text}.`).join("");
    const isUnknown = !number && forecast.may_have_passes;
    $("tonight-title").textContent = isUnknown ? "Tonight: unknown" : `Tonight: ${number} visible pass${number === 1 ? "" : "es"}`;
    $("tonight-words").textContent = `Night of ${forecast.date}, local time (${zones(forecast.utc_offsets)}): ${found}.${dark}${warnings}`;
    $("calendar").hidden = !number;
    $("order-label").hidden = number < 2;
  }

  draw() {
    this.list.draw();
  }
}

/** Shows well-known objects that are high now, as examples of targets. */
export function showExamples(site) {
  $("examples").replaceChildren(
    "High now: ",
    ...examples(site, Date.now(), EXAMPLES).map((name) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.addEventListener("click", () => {
        $("target").value = name;
        $("entry").requestSubmit();
      });
      return button;
    }),
  );
}

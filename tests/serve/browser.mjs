// Tests of the web page in a browser: its numbers equal those of the command line, it sends requests only to its
// server, and it can be used at both widths.
// `node browser.mjs URL STREAKCAST [FOLDER]` writes screenshots to the folder, if one is given.
// All waits are for conditions, with the limit LIMIT_MS. Times are printed.

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const [url, streakcast, pictures] = process.argv.slice(2);
const shared = ["--shells", "starlink-gen1", "--mpc", "X05", "--fov", "3.5deg", "--telescope", "rubin", "--quiet", "--format", "json"];
const LIMIT_MS = 120_000;
const scratch = mkdtempSync(join(tmpdir(), "streakcast-serve-"));

/** Output of the command line, including exit code 1 (nothing found). */
function command(...args) {
  try {
    return JSON.parse(execFileSync(streakcast, [...args, ...shared], { maxBuffer: 1 << 26 }));
  } catch (error) {
    if (error.status === 1) return JSON.parse(error.stdout);
    throw error;
  }
}

/** Pointing of the first exposure of the example schedule. */
const FIRST = { ra_deg: 198.9, dec_deg: 7.7 };

/** The flag of one exposure from the command line. */
function flag(start, duration, limit = 7, { ra_deg, dec_deg } = FIRST) {
  const path = join(scratch, "one.csv");
  writeFileSync(path, `exposure_id,start_utc,duration_s,ra_deg,dec_deg\n1,${start},${duration},${ra_deg},${dec_deg}\n`);
  return command("flag", "--schedule", path, "--limit-mag", String(limit)).flags[0];
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-dev-shm-usage", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"],
});
const faults = [];
/** Pages with requests that are rejected on purpose: the browser logs each rejection. */
const refusing = new WeakSet();
const requests = new Set();

async function newPage(options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  context.setDefaultTimeout(LIMIT_MS);
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  return context.newPage();
}

async function open(hash = "", options = {}, server = url) {
  const page = await newPage(options);
  await page.addInitScript(() => {
    document.addEventListener("securitypolicyviolation", (event) => console.error(`CSP: ${event.violatedDirective} ${event.blockedURI}`));
  });
  await page.addInitScript(countPending);
  page.on("console", (message) => {
    const isRefusal = refusing.has(page) && message.text().includes("400");
    if (message.type() === "error" && !isRefusal) faults.push(message.text());
  });
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("request", (request) => requests.add(request.url()));
  await page.goto(server + hash);
  await settled(page);
  return page;
}

/** In the page, before its scripts: counts requests, frames and short timers that are pending, and can hold the timers back. */
function countPending() {
  const { fetch, setTimeout, clearTimeout, requestAnimationFrame } = window;
  const timers = new Map();
  let count = 0;
  let isHeld = false;
  /** Longer timers only hide messages. They do not run, because on a slow machine a message could be hidden before it is read. */
  const SHORT_MS = 1000;
  const run = (id) => {
    const timer = timers.get(id);
    timer.isDue = true;
    if (isHeld && timer.ms > 0) return;
    try {
      timer.work();
    } finally {
      timers.delete(id);
    }
  };
  window.setTimeout = (work, ms = 0, ...more) => {
    if (ms >= SHORT_MS) return 0;
    const id = setTimeout(() => run(id), ms);
    timers.set(id, { ms, work: () => work(...more) });
    return id;
  };
  window.clearTimeout = (id) => {
    timers.delete(id);
    clearTimeout(id);
  };
  window.requestAnimationFrame = (work) => {
    count += 1;
    return requestAnimationFrame((now) => {
      count -= 1;
      work(now);
    });
  };
  window.fetch = async (...request) => {
    count += 1;
    // One task later, when the processing of the response has begun.
    const done = () => setTimeout(() => (count -= 1));
    try {
      const response = await fetch(...request);
      if (!(response.headers.get("Content-Type") ?? "").includes("json")) done();
      const json = response.json.bind(response);
      response.json = () => json().finally(done);
      return response;
    } catch (error) {
      done();
      throw error;
    }
  };
  window.holdTimers = (held) => {
    isHeld = held;
    if (!held) for (const [id, timer] of [...timers]) if (timer.isDue) run(id);
  };
  window.isSettled = async () => {
    // Two frames, so that observers of the page's size and resolution are called in between.
    for (let frame = 0; frame < 2; frame += 1) await new Promise((resolve) => requestAnimationFrame(resolve));
    return Boolean(document.querySelector("#answer")?.textContent) && count === 0 && timers.size === 0;
  };
}

/** Waits until nothing is pending in the page. */
const settled = (page) => eventually(async () => assert.ok(await page.evaluate(() => window.isSettled()), "the page does not settle"));

/** Repeats a check until it passes; after the limit its error is that of the step. */
async function eventually(check) {
  for (const end = Date.now() + LIMIT_MS; ; ) {
    try {
      return await check();
    } catch (error) {
      if (Date.now() > end) throw error;
    }
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

const seen = (page) =>
  page.evaluate(() => ({
    text: document.querySelector("#answer").textContent,
    start: document.querySelector("#answer").dataset.startUtc,
    next: document.querySelector("#answer").dataset.nextClearStartUtc,
    duration: Number(document.querySelector("#stretch").getAttribute("aria-valuenow")),
    norads: [...document.querySelectorAll("#crossings tr[data-norad]")].map((row) => Number(row.dataset.norad)),
    magnitudes: [...document.querySelectorAll("#crossings tr[data-norad]")].map((row) => row.children[2].textContent),
    hash: location.hash,
  }));

/** Checks that the page shows the same about an exposure as the command line. */
async function agrees(page, limit = 7, pointing = FIRST) {
  const { text, start, next, duration, norads, magnitudes } = await seen(page);
  const expected = flag(start, duration, limit, pointing);
  assert.ok(text.startsWith(`${expected.verdict}:`), `${text} against ${JSON.stringify(expected)}`);
  assert.equal(next, expected.next_clear_start_utc ?? "");
  if (expected.delay_s > 0) assert.ok(text.includes(`next clear start +${(Math.ceil(expected.delay_s * 10 - 1e-6) / 10).toFixed(1)} s`), text);
  const { passes } = command("passes", "--start", start, "--exposure", `${duration}s`, "--ra", String(pointing.ra_deg), `--dec=${pointing.dec_deg}`);
  assert.deepEqual(norads, passes.map((pass) => pass.norad_id));
  const shown = passes.map((pass) => `${pass.magnitude_peak.toFixed(2)} ± ${pass.magnitude_sigma.toFixed(2)}`);
  assert.deepEqual(magnitudes, shown);
  return expected;
}

/** Number of moves of a timed drag. */
const MOVES = 60;

/** Moves the pointer there and back; returns the times from each move's event to the redrawn result, ms. */
async function follow(page, x, y) {
  await page.evaluate(() => {
    let moved = null;
    addEventListener("pointermove", (event) => (moved ??= event.timeStamp), { capture: true });
    new MutationObserver(() => {
      if (moved === null) return;
      const from = moved;
      moved = null;
      // The result is drawn in the next frame; the task after that frame reports the time.
      requestAnimationFrame(() => setTimeout(() => window.drawn?.(performance.now() - from)));
    }).observe(document.querySelector("#answer"), { childList: true, characterData: true, subtree: true });
    window.wasBehind = false;
    new MutationObserver(() => (window.wasBehind = true)).observe(document.querySelector("#main"), { attributeFilter: ["data-behind"] });
    window.arm = () => {
      moved = null;
      window.next = new Promise((resolve) => {
        window.drawn = resolve;
      });
    };
    // On a slow machine the page would detect the end of the movement between two moves.
    window.holdTimers?.(true);
  });
  const taken = [];
  for (let k = 1; k <= MOVES; k += 1) {
    await page.evaluate(() => window.arm());
    // The page requests whole seconds, so a smaller move has no effect.
    await page.mouse.move(x + 6 * (k <= MOVES / 2 ? k : MOVES + 5 - k), y);
    taken.push(await within(page.evaluate(() => window.next), `move ${k} of ${MOVES} was not answered`));
  }
  await page.evaluate(() => window.holdTimers?.(false));
  return taken.sort((a, b) => a - b);
}

/** Returns the result of a promise; after the limit an error with this message. */
function within(promise, message) {
  let timer;
  const late = new Promise((_, reject) => (timer = setTimeout(() => reject(new Error(message)), LIMIT_MS)));
  return Promise.race([promise, late]).finally(() => clearTimeout(timer));
}

/** Runs `work` with a page that only sends these requests, one per move, and writes one word of each response. */
async function withMinimalPage(urls, work) {
  const page = await newPage();
  const body = `
    const urls = ${JSON.stringify(urls)};
    let sent = 0;
    document.querySelector("#main").hidden = false;
    addEventListener("pointermove", async () => {
      const response = await fetch(urls[sent % urls.length], { cache: "no-store" });
      const body = await response.json();
      sent += 1;
      document.querySelector("#answer").textContent = body.flags[0].verdict + " " + sent;
    });`;
  await page.route("**/main.js", (route) => route.fulfill({ contentType: "text/javascript", body }));
  await page.goto(url);
  await page.waitForFunction(() => !document.querySelector("#main").hidden);
  const found = await work(page);
  await page.close();
  return found;
}

function times(sorted) {
  const at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))].toFixed(1);
  return `median ${at(0.5)} ms, 95th percentile ${at(0.95)} ms, longest ${at(1)} ms`;
}

/** Shows an exposure of any target. */
async function enter(page, target, start, length) {
  if (!(await page.isVisible("#entry"))) await page.click("#any summary");
  await page.fill("#target", target);
  await page.fill("#start", start);
  await page.fill("#length", String(length));
  await page.click("#entry button");
  await settled(page);
}

/** Moves the mouse over an element until the text at the pointer matches, and returns that text. */
async function hovered(page, selector, pattern) {
  await page.locator(selector).scrollIntoViewIfNeeded();
  const box = await page.locator(selector).boundingBox();
  const found = new Set();
  for (const height of [0.5, 0.3, 0.7]) {
    for (let x = 2; x < box.width; x += 4) {
      await page.mouse.move(box.x + x, box.y + height * box.height);
      const text = await page.evaluate(() => (document.querySelector("#hover").hidden ? "" : document.querySelector("#hover").textContent));
      if (pattern.test(text)) return text;
      found.add(text);
    }
  }
  assert.fail(`no ${pattern} over ${selector}: ${[...found].join(" | ")}`);
}

const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Checks a page with all rules of axe (WCAG 2 A and AA, and best practices). */
async function isAccessible(page, name) {
  await page.evaluate(AXE);
  const { violations } = await page.evaluate(() => window.axe.run());
  const found = violations.map((one) => `${name}: ${one.id}: ${one.nodes.map((node) => `${node.target} ${node.failureSummary}`).join("; ")}`);
  assert.deepEqual(found, []);
}

/** Number of pixels of the sky that differ from its background. */
const painted = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector("#dome");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let at = 0; at < data.length; at += 4) if (data[at + 3] > 32 && data[at + 1] > 60) count += 1;
    return count;
  });

const steps = [];
async function step(name, work) {
  await work();
  steps.push(name);
  console.log(`ok  ${name}`);
}

/** Number of colours of each canvas, and number of pixels that are not red. */
const colours = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll("canvas")].map((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      const found = new Set();
      let cold = 0;
      for (let at = 0; at < data.length; at += 4) {
        // Colours of almost transparent pixels are rounded arbitrarily.
        if (data[at + 3] < 32) continue;
        found.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
        if (Math.max(data[at + 1], data[at + 2]) > 30 + 0.75 * data[at]) cold += 1;
      }
      return { id: canvas.id, colours: found.size, cold };
    }),
  );

/** Part of the screen of a phone that its browser leaves to a page. */
const SMALL = { width: 390, height: 664 };

/** Checks that the verdict ends above the bottom of the unscrolled window. */
async function isAboveTheFold(page) {
  await page.evaluate(() => scrollTo(0, 0));
  const { y } = await page.locator("#answer .why").boundingBox();
  assert.ok(y > 0 && y <= SMALL.height, `the verdict ends at ${y} px`);
}

/** A second server, without a schedule. */
const bare = spawn(streakcast, ["serve", "--bind", "127.0.0.1:0", "--rate", "100000", "--shells", "starlink-gen1", "--mpc", "X05", "--fov", "2x1.5deg", "--limit-mag", "7", "--quiet"], { stdio: ["ignore", "pipe", "inherit"] });

try {
  const [address] = await once(bare.stdout, "data");
  const bareUrl = String(address).trim();
  await step("the night and its first exposure equal the command line", async () => {
    const page = await open();
    const { flags } = command("flag", "--schedule", "examples/night.csv", "--limit-mag", "7");
    const count = (verdict) => flags.filter((one) => one.verdict === verdict).length;
    assert.equal(await page.textContent("#night-counts"), `${count("clear")} clear · ${count("streaked")} streaked · ${count("avoid")} avoid`);
    const expected = await agrees(page);
    assert.equal(expected.verdict, "avoid");
    // Warnings of the command line are shown at the top.
    assert.match(await page.textContent("#warnings summary"), /^1 warning: simulated constellation starlink-gen1: .* \(4,408 satellites\)/);
    assert.ok(await page.isVisible("#warnings"));
    assert.equal(await page.getAttribute("#night", "aria-valuetext"), "night-01, 1 of 21, avoid, 23:29 UTC");
    await page.close();
  });

  await step("after dragging and stretching the result equals the command line", async () => {
    const page = await open();
    const before = await seen(page);
    const box = await page.locator("#bar").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 20, y, { steps: 4 });
    await page.mouse.move(x + 37, y, { steps: 4 });
    await page.mouse.up();
    await settled(page);
    const dragged = await seen(page);
    assert.notEqual(dragged.start, before.start);
    assert.notEqual(dragged.text, before.text);
    await agrees(page);
    const handle = await page.locator("#stretch").boundingBox();
    await page.mouse.move(handle.x + handle.width / 2, handle.y + 30);
    await page.mouse.down();
    await page.mouse.move(handle.x + handle.width / 2 + 60, handle.y + 30, { steps: 6 });
    await page.mouse.up();
    await settled(page);
    assert.ok((await seen(page)).duration > dragged.duration);
    await agrees(page);
    await page.click("#reset");
    await settled(page);
    assert.equal((await seen(page)).text, before.text);
    await page.click("#go");
    await settled(page);
    assert.equal((await agrees(page)).verdict, "clear");
    await page.close();
  });

  // Times are printed, not asserted, with those of a minimal page for comparison.
  await step("time from a drag to the redrawn result", async () => {
    for (const name of ["drag", "stretch"]) {
      const page = await open();
      const box = await page.locator(name === "drag" ? "#bar" : "#stretch").boundingBox();
      const place = [box.x + box.width / 2, box.y + box.height / 2];
      await page.mouse.move(...place);
      await page.mouse.down();
      await settled(page);
      const urls = [];
      page.on("request", (request) => request.url().includes("/exposure?") && urls.push(request.url()));
      const ours = await follow(page, ...place);
      assert.ok(await page.evaluate(() => window.wasBehind), "outdated parts are marked during a drag");
      // When the pointer rests, held or not, all other parts are updated, the sky with a separate request.
      await page.waitForFunction(() => !document.querySelector("#main").matches("[data-behind], [data-sky-behind]"));
      await settled(page);
      const { start } = await agrees(page).then(() => seen(page));
      assert.ok([...requests].some((url) => url.includes("/dome?") && decodeURIComponent(url).includes(start)), `no sky of ${start}`);
      await page.mouse.up();
      await settled(page);
      await page.close();
      // During a move only the result is requested; the strip is requested when the pointer rests.
      const few = urls.filter((url) => !url.includes("samples="));
      assert.ok(few.length >= MOVES - 1 && urls.at(-1).includes("samples="), `${few.length} of ${urls.length} requests without samples`);
      const again = few.filter((url) => url.includes("around_s="));
      assert.ok(again.length < MOVES / 4, `${again.length} of ${few.length} moves requested the whole strip`);
      const least = await withMinimalPage(urls, (page) => follow(page, ...place));
      console.log(`    ${name}, ${MOVES} moves: ${times(ours)} from the pointer's event to the redrawn result (target: 50 ms); minimal page: ${times(least)}`);
    }
  });

  await step("a window that was very small is drawn correctly again", async () => {
    const page = await open();
    const before = await colours(page);
    await page.setViewportSize({ width: 40, height: 300 });
    await page.waitForFunction(() => document.querySelector("#night").width < 100);
    await settled(page);
    await page.setViewportSize({ width: 1280, height: 900 });
    await eventually(async () => assert.deepEqual(await colours(page), before));
    // On a screen with a higher resolution the canvases have more pixels.
    const client = await page.context().newCDPSession(page);
    await client.send("Emulation.setDeviceMetricsOverride", { width: 1280, height: 900, deviceScaleFactor: 2, mobile: false });
    const pixels = () => page.evaluate(() => [...document.querySelectorAll("section > canvas, #strip canvas")].map((canvas) => canvas.width / Math.round(canvas.getBoundingClientRect().width)));
    await eventually(async () => assert.deepEqual(await pixels(), [2, 2, 2, 2, 2]));
    await page.close();
  });

  await step("a start between whole seconds is moved by whole seconds", async () => {
    const page = await open();
    await page.click("#go");
    await settled(page);
    const before = await seen(page);
    assert.ok(Date.parse(before.start) % 1000, before.start);
    const box = await page.locator("#bar").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 2 + 1, box.y + box.height / 2);
    await page.mouse.up();
    await settled(page);
    assert.equal((await seen(page)).start, before.start);
    await page.close();
  });

  await step("a finger drags as well", async () => {
    const page = await open("", { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
    const before = await seen(page);
    await page.locator("#bar").scrollIntoViewIfNeeded();
    const box = await page.locator("#bar").boundingBox();
    const client = await page.context().newCDPSession(page);
    const touch = (type, x) => client.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x, y: box.y + box.height / 2 }] });
    const x = box.x + box.width / 2;
    await touch("touchStart", x);
    for (const move of [8, 16, 24, 32]) await touch("touchMove", x + move);
    await touch("touchEnd", x);
    await settled(page);
    assert.notEqual((await seen(page)).start, before.start);
    await agrees(page);
    await page.close();
  });

  await step("keys move the exposure by 1 s and 10 s, and select exposures", async () => {
    const page = await open();
    const start = Date.parse((await seen(page)).start);
    await page.focus("#bar");
    for (const key of ["ArrowRight", "ArrowRight", "ArrowRight", "ArrowLeft", "Shift+ArrowRight"]) await page.keyboard.press(key);
    await settled(page);
    assert.equal(Date.parse((await seen(page)).start) - start, 12_000);
    await agrees(page);
    await page.keyboard.press("Tab");
    assert.equal(await page.evaluate(() => document.activeElement.id), "stretch");
    await page.keyboard.press("Shift+ArrowRight");
    await page.keyboard.press("ArrowLeft");
    await settled(page);
    assert.equal((await seen(page)).duration, 39);
    await agrees(page);
    await page.focus("#night");
    await page.keyboard.press("ArrowRight");
    await settled(page);
    assert.ok((await page.textContent("#exposure-title")).endsWith("night-02"));
    assert.ok((await seen(page)).text.startsWith("clear"));
    assert.equal(await page.getAttribute("#answer", "aria-live"), "polite");
    // All controls have accessible names.
    const nameless = await page.evaluate(() =>
      [...document.querySelectorAll("button, input, select, [role=slider]")]
        .filter((one) => !(one.getAttribute("aria-label") || one.labels?.length || one.textContent.trim()))
        .map((one) => one.outerHTML),
    );
    assert.deepEqual(nameless, []);
    await page.close();
  });

  await step("the limit is that of the policy", async () => {
    const page = await open("#row=0&limit=6.62");
    await agrees(page, 6.62);
    // The verdicts of the whole night also use the limit of the slider.
    for (const [limit, verdict] of [[5, "streaked"], [9, "avoid"]]) {
      await page.fill("#limit", String(limit));
      await settled(page);
      assert.equal((await agrees(page, limit)).verdict, verdict);
      const { flags } = command("flag", "--schedule", "examples/night.csv", "--limit-mag", String(limit));
      const counts = ["clear", "streaked", "avoid"].map((kind) => [flags.filter((one) => one.verdict === kind).length, kind]);
      assert.equal(await page.textContent("#night-counts"), counts.filter(([number]) => number).map((one) => one.join(" ")).join(" · "));
      assert.equal(await page.getAttribute("#night", "aria-valuetext"), `night-01, 1 of 21, ${verdict}, 23:29 UTC`);
    }
    await page.close();
  });

  await step("any target is shown with the results of the command line", async () => {
    const page = await open();
    // By coordinates, with the result of the schedule; by name, with a start of its own.
    const before = await seen(page);
    await enter(page, "198.9 +7.7", "2026-08-14 23:29:05Z", 30);
    await agrees(page);
    assert.equal((await seen(page)).text, before.text);
    assert.equal(await page.textContent("#exposure-title"), "Exposure 198.9 +7.7");
    await enter(page, "m 104", "2026-08-14T23:35:20Z", 45);
    const pointing = command("passes", "--start", "2026-08-14T23:35:20Z", "--exposure", "45s", "--target", "M104").exposures[0];
    await agrees(page, 7, pointing);
    assert.equal(await page.getAttribute("#night", "aria-valuetext"), "m 104, 22 of 22, 23:35 UTC");
    await page.focus("#bar");
    await page.keyboard.press("Shift+ArrowRight");
    await settled(page);
    await agrees(page, 7, pointing);
    const moved = await seen(page);
    const again = await open(moved.hash);
    assert.deepEqual(await seen(again), moved);
    assert.equal(await again.inputValue("#target"), "m 104");
    // An exposure on another night, and back to the schedule.
    await enter(page, "M104", "2026-08-15 18:35:20", 45);
    assert.deepEqual(await page.$eval("#nights", (list) => [list.value, list.length]), ["2026-08-15", 2]);
    assert.equal(await page.textContent("#night-counts"), "2026-08-15, no exposure of a schedule");
    await page.selectOption("#nights", "2026-08-14");
    await settled(page);
    assert.equal((await seen(page)).text, before.text);
    assert.ok(!(await seen(page)).hash.includes("target"));
    // A rejected target does not change the result.
    refusing.add(page);
    for (const target of ["M111", "12,5 30"]) {
      await enter(page, target, "now", 30);
      assert.match(await page.textContent("#problem"), new RegExp(`^invalid target '${target}'; allowed: a Messier or Caldwell object`));
    }
    assert.equal((await seen(page)).text, before.text);
    await page.click("#after");
    await settled(page);
    assert.ok(await page.isHidden("#problem"));
    for (const one of [page, again]) await one.close();
  });

  await step("without a schedule the page shows any target now", async () => {
    const page = await open("", { viewport: SMALL }, bareUrl);
    assert.equal((await seen(page)).text, "no exposure: enter a target");
    assert.ok(await page.isHidden("#nights"));
    assert.match(await page.textContent("#where"), /· field 2° × 1\.5° ·/);
    const now = () => Math.floor(Date.now() / 1e3) * 1e3;
    const began = now();
    // 47 Tucanae is always above the horizon of Rubin Observatory.
    await enter(page, "NGC 104", "now", 60);
    const { text, start, duration } = await seen(page);
    assert.ok(began <= Date.parse(start) && Date.parse(start) <= now(), start);
    assert.equal(duration, 60);
    const answer = await (await fetch(`${bareUrl}api/v1/exposure?target=NGC104&start_utc=${start}&duration_s=60`)).json();
    assert.notEqual(answer.flags[0].verdict, "invalid");
    assert.ok(text.startsWith(`${answer.flags[0].verdict}:`), text);
    assert.match(await page.textContent("#pointing"), /00h24m0\ds −72°0\d′/);
    await isAboveTheFold(page);
    if (pictures) await page.screenshot({ path: join(pictures, "serve-any.png") });
    // A target below the horizon is invalid, with the reason.
    await enter(page, "0 +89", "now", 60);
    assert.match((await seen(page)).text, /^invalid: the pointing is below the horizon \(altitude -/);
    await page.close();
  });

  await step("without a schedule the page opens on tonight's visible passes", async () => {
    // Simulated Starlinks are rarely brighter than the default limit.
    const page = await open("#bright=6", { viewport: { width: 1440, height: 900 }, acceptDownloads: true }, bareUrl);
    const asked = [...requests].findLast((request) => request.includes("/api/v1/forecast?") && request.includes("max_mag=6"));
    const { date, night, passes, calendar } = await (await fetch(asked)).json();
    assert.ok(passes.length > 12, `${passes.length} passes`);
    assert.equal(await page.textContent("#tonight-title"), `Tonight: ${passes.length} visible passes`);
    const names = () => page.$$eval("#passes h3", (list) => list.map((one) => one.textContent));
    assert.deepEqual(await names(), passes.slice(0, 12).map((pass) => pass.name));
    assert.ok(passes.every((pass, place) => !place || pass.p_brighter <= passes[place - 1].p_brighter));
    // Each pass has a chart, local times (5 h behind UTC) and the magnitude.
    const drawn = await colours(page);
    assert.equal(drawn.filter((one) => one.id === "" && one.colours > 6).length >= 12, true);
    const local = (utc) => new Date(Date.parse(utc) - 5 * 3600e3).toISOString().slice(11, 16);
    const first = await page.textContent("#passes li");
    assert.ok(first.includes(`${local(passes[0].begin_utc)}:`) && first.includes(`mag ${passes[0].peak_magnitude.toFixed(1)} ± `), first);
    // Panels of an exposure are collapsed.
    for (const id of ["exposure", "night", "field", "dome", "light-curve", "crossings"]) assert.ok(await page.isHidden(`#${id}`), id);
    await isAccessible(page, "tonight");
    if (pictures) await page.screenshot({ path: join(pictures, "serve-tonight.png"), fullPage: true });
    // Countdown to the beginning, and to the end.
    const [begin, end] = [passes[0].begin_utc, passes[0].end_utc].map(Date.parse);
    for (const [now, words] of [[begin - 5000e3, /^in 1 h 2[34] min$/], [begin - 245e3, /^in 4 min 0\d s$/], [end - 9.5e3, /^now, for \d+ s$/], [end + 1e3, /^over$/]]) {
      await page.evaluate((now) => (Date.now = () => now), now);
      await eventually(async () => assert.match(await page.textContent("#passes li strong"), words));
    }
    const saved = async (selector) => {
      const [download] = await Promise.all([page.waitForEvent("download"), page.click(selector)]);
      return [download.suggestedFilename(), readFileSync(await download.path(), "utf8")];
    };
    const [name, one] = await saved("#passes li button");
    assert.match(name, new RegExp(`^pass-${passes[0].norad_id}-\\d{8}T\\d{4}Z\\.ics$`));
    assert.ok(one.startsWith("BEGIN:VCALENDAR\r\n") && one.endsWith("END:VEVENT\r\nEND:VCALENDAR\r\n") && one.split("BEGIN:VEVENT").length === 2, one);
    assert.ok(one.includes(`UID:${passes[0].norad_id}-`));
    assert.deepEqual(await saved("#calendar"), [`passes-${date}.ics`, calendar]);
    await page.click("#more");
    assert.deepEqual(await names(), passes.slice(0, 24).map((pass) => pass.name));
    await page.selectOption("#order", "time");
    assert.deepEqual(await names(), passes.toSorted((a, b) => Date.parse(a.begin_utc) - Date.parse(b.begin_utc)).slice(0, 24).map((pass) => pass.name));
    await settled(page);
    // After the night, the list is that of the next one.
    const next = new Date(Date.parse(date) + 86400e3).toISOString().slice(0, 10);
    await page.evaluate((now) => (Date.now = () => now), Date.parse(night.dark_until_utc) + 6 * 3600e3);
    await eventually(async () => assert.match(await page.textContent("#tonight-words"), new RegExp(`^Night of ${next},`)));
    // With a limit that no pass exceeds, the reason is stated.
    await page.fill("#bright", "-4");
    await page.keyboard.press("Tab");
    await settled(page);
    assert.match(await page.textContent("#tonight-words"), /no visible pass: .*\d+ passes are brighter than mag -4 with a probability below 50 %/);
    assert.ok((await page.isHidden("#calendar")) && (await names()).length === 0);
    await page.close();
  });

  await step("tonight's passes are requested again after an error", async () => {
    const page = await open("#bright=6", { viewport: SMALL }, bareUrl);
    refusing.add(page);
    const path = /\/api\/v1\/forecast/;
    await page.route(path, (route) => route.fulfill({ status: 400, contentType: "application/problem+json", body: '{"detail":"no positions"}' }));
    await page.fill("#bright", "5");
    await page.keyboard.press("Tab");
    await eventually(async () => assert.equal(await page.textContent("#tonight-title"), "Tonight: unknown"));
    await page.unroute(path);
    await page.evaluate((later) => (Date.now = () => later), Date.now() + 11 * 60e3);
    await eventually(async () => assert.match(await page.textContent("#tonight-title"), /^Tonight: \d+ visible pass/));
    await page.close();
  });

  await step("an example of a target is above the horizon", async () => {
    const page = await open("", { viewport: SMALL }, bareUrl);
    const example = page.locator("#examples button").first();
    const name = await example.textContent();
    await example.click();
    await settled(page);
    assert.equal(await page.textContent("#exposure-title"), `Exposure ${name}`);
    assert.ok(Number(/altitude (\d+)°/.exec(await page.textContent("#pointing"))?.[1]) > 20);
    // The passes are closed, so that the verdict is visible, and open again after going back.
    assert.ok((await page.isHidden("#passes")) && (await page.isVisible("#answer")));
    await page.goBack();
    await settled(page);
    assert.ok((await page.isVisible("#tonight-words")) && (await page.isHidden("#answer")));
    await page.close();
  });

  await step("the verdict is visible without scrolling at 390 px", async () => {
    const page = await open("", { viewport: SMALL });
    await isAboveTheFold(page);
    if (pictures) await page.screenshot({ path: join(pictures, "serve-fold.png") });
    await page.close();
  });

  await step("warnings are in one line that opens", async () => {
    const page = await newPage({ viewport: SMALL });
    await page.addInitScript(countPending);
    const long = [1, 2, 3].map((number) => `${"abc".charAt(number - 1)}: ${"a long warning ".repeat(20)}`);
    await page.route(/\/api\/v1\/night/, async (route) => {
      const response = await route.fetch();
      await route.fulfill({ response, json: { ...(await response.json()), warnings: long } });
    });
    await page.goto(url);
    await settled(page);
    const lines = () => page.$eval("#warnings summary", (one) => one.getBoundingClientRect().height / parseFloat(getComputedStyle(one).lineHeight));
    assert.ok((await lines()) < 1.5, `${await lines()} lines`);
    assert.match(await page.textContent("#warnings summary"), /^4 warnings: a: a long warning/);
    assert.ok(await page.isHidden("#warnings li"));
    await page.click("#warnings summary");
    const shown = await page.$$eval("#warnings li", (list) => list.filter((one) => one.checkVisibility()).map((one) => one.textContent));
    assert.deepEqual(shown.slice(0, 3), long);
    assert.match(shown[3], /^simulated constellation/);
    await page.close();
  });

  await step("text at the pointer describes what is drawn there", async () => {
    const page = await open();
    await hovered(page, "#night", /^night-01: avoid, 6\.\d mag, 23:29:05 UTC$/);
    await hovered(page, "#night", /^\d\d:\d\d UTC, \d\d:\d\d local, Sun −\d+°$/);
    await hovered(page, "#strip", /^.+: 6\.\d mag, 23:\d\d:\d\d\.\d to 23:\d\d:\d\d\.\d UTC, exceeds the limit$/);
    await hovered(page, "#strip", /^23:\d\d:\d\d UTC$/);
    await hovered(page, "#field", /^.+: 6\.\d ± 0\.\d mag, 23:29:\d\d\.\d to 23:29:\d\d\.\d UTC$/);
    await hovered(page, "#dome", /^.+: \d+\.\d ± \d\.\d mag, altitude \d+°, azimuth \d+°$/);
    await hovered(page, "#curve", /^23:29:\d\d\.\d UTC: 6\.\d\d ± 0\.\d\d mag$/);
    await hovered(page, "#columns th:nth-child(3)", /^Brightest magnitude inside the field, with one sigma$/);
    await hovered(page, "#link", /^Copies the address of this view$/);
    if (pictures) {
      await hovered(page, "#strip", /exceeds the limit$/);
      await page.screenshot({ path: join(pictures, "serve-hover.png") });
    }
    await page.mouse.move(0, 0);
    assert.ok(await page.isHidden("#hover"));
    // With a limit that no crossing exceeds, the strip says so.
    await page.fill("#limit", "2");
    await settled(page);
    await hovered(page, "#strip", /^.+: 6\.\d mag, .*, within the limit$/);
    assert.deepEqual(await page.$$eval("[title]", (list) => list.map((one) => one.outerHTML)), []);
    await page.close();
  });

  await step("a copy is confirmed only if it succeeded", async () => {
    const page = await open();
    for (const [isPermitted, words] of [[false, "Crossings not copied: the browser does not permit it"], [true, "Crossings copied"]]) {
      await page.evaluate((isPermitted) => {
        navigator.clipboard.writeText = () => Promise.reject(new Error("not permitted"));
        document.execCommand = () => isPermitted;
      }, isPermitted);
      await page.click("#csv");
      await page.waitForFunction((words) => document.querySelector("#copied").checkVisibility() && document.querySelector("#copied").textContent === words, words);
    }
    await page.close();
  });

  await step("the light curve is drawn throughout a drag", async () => {
    const page = await open();
    const names = () => page.evaluate(() => window.curveNames);
    await page.evaluate(() => {
      const curve = document.querySelector("#curve");
      window.curveNames = [curve.getAttribute("aria-label")];
      new MutationObserver(() => window.curveNames.push(curve.getAttribute("aria-label"))).observe(curve, { attributeFilter: ["aria-label"] });
      // The page must not detect a rest of the pointer during the drag.
      window.holdTimers(true);
    });
    const box = await page.locator("#bar").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    // The first crossings leave the exposure, and others enter it.
    for (const [move, width] of [[-20, 1270], [-40, 1260], [30, 1250], [300, 1240], [320, 1280]]) {
      const before = (await names()).length;
      const { text } = await seen(page);
      await page.mouse.move(x + move, y);
      await page.waitForFunction((text) => document.querySelector("#answer").textContent !== text || document.querySelector("#main").matches("[data-behind]"), text);
      // A new size draws all charts again, also the outdated ones.
      await page.setViewportSize({ width, height: 900 });
      await eventually(async () => assert.ok((await names()).length > before, "the curve is not drawn again"));
    }
    await page.mouse.up();
    await page.evaluate(() => window.holdTimers(false));
    await settled(page);
    const before = (await names()).filter((name) => !/^Light curve of ./.test(name));
    // It is possible that no satellite crosses at the end of the drag.
    const isEmpty = (await seen(page)).norads.length === 0;
    assert.deepEqual(before.filter((name) => !(isEmpty && name === "Light curve: no track selected")), []);
    await page.close();
  });

  await step("a link restores the view", async () => {
    const page = await open();
    await page.focus("#bar");
    await page.keyboard.press("Shift+ArrowRight");
    await page.click("#red");
    await page.check("#sigma");
    await page.check("#map");
    await page.fill("#height", "1200");
    await page.keyboard.press("Enter");
    await page.selectOption("#model", "oneweb");
    await page.click("#crossings tr:last-child button");
    await settled(page);
    const before = await seen(page);
    await page.click("#link");
    await page.waitForFunction(() => document.querySelector("#copied").textContent === "Link copied");
    const link = await page.evaluate(() => navigator.clipboard.readText());
    assert.equal(new URL(link).hash, before.hash);
    const again = await open(before.hash);
    const after = await seen(again);
    assert.deepEqual(after, before);
    const chosen = (one) => one.evaluate(() => [document.querySelector("tr[data-chosen=true]").dataset.norad, document.documentElement.dataset.light, document.querySelector("#height").value, document.querySelector("#model").value, document.querySelector("#sigma").checked, document.querySelector("#dome-words").textContent]);
    assert.deepEqual(await chosen(again), await chosen(page));
    await page.click("#csv");
    await page.waitForFunction(() => document.querySelector("#copied").textContent === "Crossings copied");
    const csv = await page.evaluate(() => navigator.clipboard.readText());
    assert.equal(csv.trim().split("\n").length, 1 + before.norads.length);
    assert.ok(csv.startsWith("name,norad_id,") && csv.includes("apparent_magnitude_uncert"));
    // An invalid address shows the night.
    const broken = await open("#night=1999-01-01&row=x&shift=NaN&model=%3Cscript%3E");
    assert.ok((await seen(broken)).text.includes("avoid"));
    for (const one of [page, again, broken]) await one.close();
  });

  await step("a slow response of one target never stands under the name of another", async () => {
    const page = await open("", {}, bareUrl);
    await enter(page, "1h -85d", "now", 60);
    // All pairs of title and coordinates that the page shows.
    await page.evaluate(() => {
      window.pairs = new Set();
      const add = () => window.pairs.add(`${document.querySelector("#exposure-title").textContent} = ${/\d\dh\d\dm/.exec(document.querySelector("#pointing").textContent)}`);
      add();
      for (const id of ["exposure-title", "pointing", "answer"]) new MutationObserver(add).observe(document.querySelector(`#${id}`), { childList: true, characterData: true, subtree: true });
    });
    const before = await seen(page);
    const titleOf = () => page.textContent("#exposure-title");
    let release;
    const held = new Promise((resolve) => (release = resolve));
    await page.route(/\/api\/v1\/exposure.*samples/, async (route) => {
      await held;
      await route.continue();
    });
    for (const target of ["7h -85d", "13h -85d"]) {
      const sent = page.waitForRequest((request) => request.url().includes("/night?time_utc"));
      await page.fill("#target", target);
      await page.click("#entry button");
      await sent;
      // The previous exposure is shown with its name, and as outdated.
      await page.waitForSelector("#exposure[aria-busy=true]");
      assert.ok(await page.isVisible("#busy"));
      assert.deepEqual([await titleOf(), (await seen(page)).text], ["Exposure 1h -85d", before.text]);
    }
    release();
    await settled(page);
    assert.deepEqual([await titleOf(), await page.getAttribute("#exposure", "aria-busy"), await page.isHidden("#busy")], ["Exposure 13h -85d", "false", true]);
    const pairs = await page.evaluate(() => [...window.pairs]);
    assert.ok(pairs.length >= 2 && pairs.every((pair) => /Exposure (\d+)h -85d = (\d\d)h00m/.exec(pair)?.slice(1).map(Number).reduce((a, b) => a === b)), pairs.join("; "));
    await page.close();
  });

  await step("a start is typed in local time, and times have no milliseconds", async () => {
    const page = await open();
    // Without a time zone the clocks of the site are those of its longitude, 5 h behind UTC.
    assert.match(await page.textContent("#start-label"), /local time \(UTC−5\)/);
    for (const [text, utc] of [
      ["18:35:20", "2026-08-14T23:35:20Z"],
      ["2:10", "2026-08-15T07:10:00Z"],
      ["2026-08-13 22:30", "2026-08-14T03:30:00Z"],
      ["2026-08-14 23:35:20Z", "2026-08-14T23:35:20Z"],
      ["2026-08-14 23:35:20z", "2026-08-14T23:35:20Z"],
    ]) {
      await enter(page, "M104", text, 45);
      const { start, hash } = await seen(page);
      assert.equal(start ?? new URLSearchParams(hash.slice(1)).get("start"), utc, text);
    }
    refusing.add(page);
    const title = await page.textContent("#exposure-title");
    for (const text of ["25:00", "18", "yesterday", "2026-02-30 23:30"]) {
      await enter(page, "M31", text, 45);
      assert.ok((await page.textContent("#problem")).startsWith(`Invalid start '${text}'; allowed: now, a local time`), text);
      assert.equal(await page.textContent("#exposure-title"), title);
    }
    await page.close();
    const night = await open();
    const shown = await night.textContent("#exposure");
    assert.ok(/opens 23:29:05 UTC, 18:29:05 local/.test(shown) && !/\d\.\d{3}|\d ms/.test(shown), shown);
    await night.close();
  });

  await step("local times follow a change of the clocks", async () => {
    const page = await open();
    const found = await page.evaluate(async () => {
      const { fromLocal, iso, offsetAt, typed, zones } = await import("/words.js");
      const offsets = (change, before, after) => [["T11:00:00Z", before], [change, after]].map(([time, hours], place) => ({ from_utc: place ? time : `2026-01-01${time}`, utc_offset_h: hours }));
      const [autumn, spring] = [offsets("2026-10-25T01:00:00Z", 2, 1), offsets("2026-03-29T01:00:00Z", 1, 2)];
      const utc = (of, evening, text) => iso(fromLocal(of, typed(text, evening)));
      return [
        zones(autumn), offsetAt(autumn, Date.parse("2026-10-25T00:59:59Z")), offsetAt(autumn, Date.parse("2026-10-25T01:00:00Z")),
        ...["23:00", "2:30", "3:30"].map((text) => utc(autumn, "2026-10-24", text)),
        ...["23:00", "2:30", "3:30"].map((text) => utc(spring, "2026-03-28", text)),
      ];
    });
    assert.deepEqual(found, [
      "UTC+2, then UTC+1", 2, 1,
      "2026-10-24T21:00:00Z", "2026-10-25T00:30:00Z", "2026-10-25T02:30:00Z",
      "2026-03-28T22:00:00Z", "2026-03-29T01:30:00Z", "2026-03-29T01:30:00Z",
    ]);
    await page.close();
  });

  await step("reasons name the satellites", async () => {
    const page = await open();
    const why = await page.textContent("#answer .why");
    const { reasons, norad_ids } = flag((await seen(page)).start, 30);
    assert.ok(reasons.length > 0 && norad_ids.every((norad) => why.includes(` (${norad}): `)), why);
    assert.match(why, /^STARLINK-GEN1-/);
    await page.close();
  });

  await step("back and forward restore targets, times and views", async () => {
    const page = await open();
    const title = () => page.textContent("#exposure-title");
    const views = [];
    const record = async () => {
      await settled(page);
      views.push([await title(), (await seen(page)).text, (await seen(page)).hash, await page.isChecked("#map")]);
    };
    await record();
    await page.click("#after");
    await record();
    await enter(page, "M104", "18:35:20", 45);
    await record();
    // Several moves are one entry.
    await page.focus("#bar");
    await page.keyboard.press("ArrowRight");
    await settled(page);
    await page.keyboard.press("Shift+ArrowRight");
    await record();
    await page.check("#map");
    await record();
    assert.equal(new Set(views.map(String)).size, views.length);
    for (let place = views.length - 2; place >= 0; place -= 1) {
      await page.goBack();
      await settled(page);
      assert.deepEqual([await title(), (await seen(page)).text, (await seen(page)).hash, await page.isChecked("#map")], views[place]);
    }
    await page.goForward();
    await page.goForward();
    await settled(page);
    assert.deepEqual([await title(), (await seen(page)).text, (await seen(page)).hash, await page.isChecked("#map")], views[2]);
    await page.close();
  });

  await step("the sky has tracks of bright satellites, dots of the others, and no background by default", async () => {
    const page = await open();
    const without = (await colours(page)).find((one) => one.id === "dome").colours;
    assert.ok(await page.isHidden("#height"));
    const counts = [];
    for (const limit of ["0", "14"]) {
      await page.fill("#limit", limit);
      await settled(page);
      counts.push(await painted(page));
    }
    assert.ok(counts[0] < counts[1] / 3, counts.join(" and "));
    await page.check("#map");
    await settled(page);
    assert.ok((await colours(page)).find((one) => one.id === "dome").colours > 2 * without);
    assert.ok(await page.isVisible("#height"));
    assert.match(await page.textContent("#dome-words"), /Behind them starlink-v1\.5 at 550 km/);
    await page.close();
  });

  await step("the table of crossings fits 1440 px, or states that it scrolls", async () => {
    const page = await open("", { viewport: { width: 1440, height: 900 } });
    const width = () => page.$eval(".scroll", (one) => one.scrollWidth - one.clientWidth);
    assert.deepEqual([await width(), await page.isHidden("#scrolls")], [0, true]);
    const headings = await page.$$eval("#columns th", (list) => list.map((one) => one.textContent));
    assert.deepEqual(headings.filter((one) => /[_σ]|\b(P|mag|d|s)$/.test(one.replace(/, (s|°\/s)$/, ""))), []);
    await page.setViewportSize({ width: 390, height: 844 });
    await page.waitForSelector("#scrolls", { state: "visible" });
    assert.ok((await width()) > 0);
    await page.close();
  });

  await step("print and the colours of the system", async () => {
    const page = await open();
    const ground = () => page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);
    const dark = await colours(page);
    await page.emulateMedia({ media: "print" });
    await settled(page);
    assert.equal(await ground(), "rgb(255, 255, 255)");
    assert.ok((await page.isHidden("#go")) && (await page.isHidden("#entry")) && (await page.isVisible("#answer")));
    assert.notDeepEqual(await colours(page), dark);
    await isAccessible(page, "print");
    if (pictures) await page.screenshot({ path: join(pictures, "serve-print.png"), fullPage: true });
    await page.emulateMedia({ media: "screen" });
    await settled(page);
    assert.deepEqual(await colours(page), dark);
    await page.emulateMedia({ forcedColors: "active" });
    await settled(page);
    await isAccessible(page, "forced colours");
    // Lines and texts of the charts have the colours of the system.
    const text = await page.evaluate(() => getComputedStyle(document.body).color.match(/\d+/g).map(Number));
    const has = await page.evaluate(([red, green, blue]) => {
      const canvas = document.querySelector("#field");
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      return data.some((_, at) => at % 4 === 0 && data[at] === red && data[at + 1] === green && data[at + 2] === blue && data[at + 3] === 255);
    }, text);
    assert.ok(has, `the field has no pixel of ${text}`);
    if (pictures) await page.screenshot({ path: join(pictures, "serve-forced.png"), fullPage: true });
    await page.close();
  });

  await step("a rejected exposure leaves no results of the previous one", async () => {
    const page = await open();
    refusing.add(page);
    const paths = /\/api\/v1\/(exposure|dome)/;
    await page.route(paths, (route) => route.fulfill({ status: 400, contentType: "application/problem+json", body: '{"detail":"no positions"}' }));
    await page.click("#after");
    await settled(page);
    assert.equal(await page.textContent("#problem"), "no positions");
    const refused = await seen(page);
    assert.equal(refused.text, "unknown: no response");
    assert.deepEqual([refused.norads, refused.start, refused.next], [[], undefined, undefined]);
    assert.deepEqual([await page.textContent("#dome-words"), await page.textContent("#crossings")], ["", "No result for this exposure."]);
    assert.ok((await page.isHidden("#go")) && (await page.evaluate(() => document.activeElement.id)) === "after");
    await page.unroute(paths);
    await page.click("#before");
    await settled(page);
    assert.ok(await page.isHidden("#problem"));
    await agrees(page);
    await page.close();
  });

  await step("warnings of the sky only are shown below it, once", async () => {
    const page = await open();
    const before = await page.textContent("#dome-words");
    assert.ok(!before.includes("Warning"), before);
    await page.route(/\/api\/v1\/dome/, async (route) => {
      const response = await route.fetch();
      const json = await response.json();
      json.warnings = [...json.warnings.map((text) => text.replace("4,408", "4,407")), "3 of 4408 satellites left out"];
      await route.fulfill({ response, json });
    });
    await page.click("#after");
    await settled(page);
    const words = await page.textContent("#dome-words");
    assert.equal(words.split("Warning: ").length, 2, words);
    assert.ok(words.endsWith(" Warning: 3 of 4408 satellites left out."), words);
    await page.close();
  });

  await step("names with markup are shown as text", async () => {
    const MARKUP = '<img src="x" onerror="console.error(1)"><b>name</b>';
    const page = await open();
    let named = 0;
    await page.route(/\/api\/v1\/(exposure|dome)/, async (route) => {
      const response = await route.fetch();
      const text = (await response.text()).replace(/"name":\s*"[^"]*"/g, () => {
        named += 1;
        return `"name":${JSON.stringify(MARKUP)}`;
      });
      await route.fulfill({ response, body: text });
    });
    // The third exposure has a streak.
    await page.click("#after");
    await settled(page);
    await page.click("#after");
    await settled(page);
    const crossings = await page.textContent("#crossings");
    assert.ok(named > 0 && crossings.includes(MARKUP), `${named}: ${crossings}`);
    assert.equal(await page.locator('img[src="x"]').count(), 0);
    await page.close();
  });

  for (const [width, height] of [[1280, 900], [390, 844]]) {
    for (const light of ["dark", "red"]) {
      await step(`${width} px, ${light}: drawn, and no wider than the screen`, async () => {
        const page = await open(light === "red" ? "#light=red" : "", { viewport: { width, height }, reducedMotion: "reduce" });
        assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width, "the page scrolls sideways");
        for (const { id, colours: count, cold } of await colours(page)) {
          assert.ok(count > 6, `${id || "the scale"} has ${count} colours`);
          if (light === "red") assert.equal(cold, 0, `${id} shines in other light than red`);
          else if (id === "dome") assert.ok(cold > 1000, "the count of other light counts nothing");
        }
        assert.match(await page.evaluate(() => getComputedStyle(document.querySelector("button")).transitionDuration), /^0s/);
        // Each landmark is unique, and texts have the contrast of WCAG AA, also under red light.
        await isAccessible(page, `${width} px, ${light}`);
        if (pictures) await page.screenshot({ path: join(pictures, `serve-${width}-${light}.png`), fullPage: true });
        await page.close();
      });
    }
  }

  await step("no other server was contacted, and there were no errors", async () => {
    const foreign = [...requests].filter((one) => !one.startsWith(url) && !one.startsWith(bareUrl));
    assert.deepEqual(foreign, []);
    assert.ok(requests.size > 20);
    assert.deepEqual(faults, []);
  });
  console.log(`browser: ${steps.length} steps passed`);
} finally {
  bare.kill();
  await browser.close();
  rmSync(scratch, { recursive: true, force: true });
}

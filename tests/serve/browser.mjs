// Tests of the web page in a browser: its numbers equal those of the command line, it sends requests only to its
// server, and it can be used at both widths.
// `node browser.mjs URL STREAKCAST [FOLDER]` writes screenshots to the folder, if one is given.
// All waits are for conditions, with the limit LIMIT_MS. Times are printed.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
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

/** The flag of one exposure from the command line. */
function flag(start, duration, limit = 7) {
  const path = join(scratch, "one.csv");
  writeFileSync(path, `exposure_id,start_utc,duration_s,ra_deg,dec_deg\n1,${start},${duration},198.9,7.7\n`);
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

async function open(hash = "", options = {}) {
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
  await page.goto(url + hash);
  await settled(page);
  return page;
}

/** In the page, before its scripts: counts requests, frames and short timers that are pending, and can hold the timers back. */
function countPending() {
  const { fetch, setTimeout, clearTimeout, requestAnimationFrame } = window;
  const timers = new Map();
  let count = 0;
  let isHeld = false;
  /** Longer timers only hide messages. */
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
    if (ms >= SHORT_MS) return setTimeout(work, ms, ...more);
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
async function agrees(page, limit = 7) {
  const { text, start, next, duration, norads, magnitudes } = await seen(page);
  const expected = flag(start, duration, limit);
  assert.ok(text.startsWith(`${expected.verdict}:`), `${text} against ${JSON.stringify(expected)}`);
  assert.equal(next, expected.next_clear_start_utc ?? "");
  if (expected.delay_s > 0) assert.ok(text.includes(`next clear start +${(Math.ceil(expected.delay_s * 10 - 1e-6) / 10).toFixed(1)} s`), text);
  const { passes } = command("passes", "--start", start, "--exposure", `${duration}s`, "--ra", "198.9", "--dec=7.7");
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

try {
  await step("the night and its first exposure equal the command line", async () => {
    const page = await open();
    const { flags } = command("flag", "--schedule", "examples/night.csv", "--limit-mag", "7");
    const count = (verdict) => flags.filter((one) => one.verdict === verdict).length;
    assert.equal(await page.textContent("#night-counts"), `${count("clear")} clear · ${count("streaked")} streaked · ${count("avoid")} avoid`);
    const expected = await agrees(page);
    assert.equal(expected.verdict, "avoid");
    // Warnings of the command line are shown at the top.
    assert.match(await page.textContent("#warnings li"), /^Warning: simulated constellation starlink-gen1: .* \(4,408 satellites\)/);
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
    const page = await open("#limit=6.62");
    await agrees(page, 6.62);
    await page.fill("#limit", "5");
    await settled(page);
    assert.equal((await agrees(page, 5)).verdict, "streaked");
    await page.close();
  });

  await step("a link restores the view", async () => {
    const page = await open();
    await page.focus("#bar");
    await page.keyboard.press("Shift+ArrowRight");
    await page.click("#red");
    await page.check("#sigma");
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

  await step("a rejected exposure leaves no results of the previous one", async () => {
    const page = await open();
    refusing.add(page);
    const paths = /\/api\/v1\/(exposure|dome)/;
    await page.route(paths, (route) => route.fulfill({ status: 400, contentType: "application/problem+json", body: '{"detail":"no positions"}' }));
    await page.click("#after");
    await settled(page);
    assert.equal(await page.textContent("#problem"), "no positions");
    const refused = await seen(page);
    assert.equal(refused.text, "unknown: no answer");
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
        if (pictures) await page.screenshot({ path: join(pictures, `serve-${width}-${light}.png`), fullPage: true });
        await page.close();
      });
    }
  }

  await step("no other server was contacted, and there were no errors", async () => {
    const foreign = [...requests].filter((one) => !one.startsWith(url));
    assert.deepEqual(foreign, []);
    assert.ok(requests.size > 20);
    assert.deepEqual(faults, []);
  });
  console.log(`browser: ${steps.length} steps passed`);
} finally {
  await browser.close();
  rmSync(scratch, { recursive: true, force: true });
}

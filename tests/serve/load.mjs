// Constant load: `node load.mjs URL PID SECONDS [PER_SECOND]` sends requests at this rate over 200 persistent
// connections, while other clients send heads slowly, end connections early, send garbage, or name another host.
// Other responses than 200 and growing memory are errors. Requests rejected by a busy server (503) are sent again,
// because they depend on the machine.

import { readFileSync } from "node:fs";
import http from "node:http";
import net from "node:net";

const [url, pid, seconds, perSecond = "1000"] = process.argv.slice(2);
const agent = new http.Agent({ keepAlive: true, maxSockets: 200 });
const rate = Number(perSecond);
const total = Math.round(rate * Number(seconds));

/** Resident memory of the server, MB; 0 if the system does not provide it. */
function memory() {
  try {
    return Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1024;
  } catch {
    return 0;
  }
}

/** Typical requests of a page: mostly dragged exposures, and files, night, dome, health. One in fifty is not cached. */
function target(number) {
  if (number % 50 === 0) return `api/v1/exposure?start_utc=2026-08-14T23:${String(10 + (number % 40)).padStart(2, "0")}:00.${String(number % 1000).padStart(3, "0")}Z&duration_s=30&ra_deg=198.9&dec_deg=7.7&samples=41&around_s=300`;
  if (number % 100 === 1) return "api/v1/night";
  if (number % 100 === 3) return "api/v1/dome?start_utc=2026-08-14T23:29:05Z&duration_s=30";
  if (number % 40 === 9) return `fov/satellite-passes/?site=rubin&start_time_jd=${(2461267.4 + (number % 400) / 4000).toFixed(6)}&duration=30&ra=${number % 360}&dec=${(number % 160) - 80}&fov_radius=2&group_by=${number % 80 === 9 ? "satellite" : "time"}`;
  if (number % 100 === 19) return `fov/satellites-above-horizon/?latitude=${(number % 170) - 85}&longitude=${number % 360}&elevation=100&julian_date=2461267.478530&min_altitude=20`;
  if (number % 10 === 5) return "health";
  if (number % 10 === 7) return ["", "main.js", "page.css"][number % 3];
  return `api/v1/exposure?start_utc=2026-08-14T23:29:${String(number % 60).padStart(2, "0")}Z&duration_s=30&ra_deg=198.9&dec_deg=7.7&samples=41&around_s=300`;
}

/** Number of clients that send one byte of their request in 200 ms, and time between two broken requests, ms. */
const SLOW_CLIENTS = 20;
const BROKEN_EVERY_MS = 20;
const BROKEN = [
  "GET /health HTTP/1.1\r\nHost: 127",
  "GET /api/v1/night HTTP/1.1\r\nHost: elsewhere.example\r\n\r\n",
  "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
  `GET /${"a".repeat(70000)} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n`,
  "POST /api/v1/night HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 99999999999\r\n\r\n{",
];
let hostile = 0;

/** Starts clients that a server must survive; returns a function that ends them. */
function startHostileClients() {
  const { hostname, port } = new URL(url);
  const connect = () => {
    const socket = net.connect(Number(port), hostname);
    hostile += 1;
    // The server may end the connection at any time.
    socket.on("error", () => {});
    return socket;
  };
  const slowText = `GET /health HTTP/1.1\r\nHost: ${hostname}\r\n${"X-Slow: 1\r\n".repeat(100)}`;
  const slow = Array.from({ length: SLOW_CLIENTS }, () => {
    let socket = connect();
    let sent = 0;
    return setInterval(() => {
      if (socket.destroyed) {
        socket = connect();
        sent = 0;
      }
      socket.write(slowText[sent % slowText.length]);
      sent += 1;
    }, 200);
  });
  const broken = setInterval(() => {
    const socket = connect();
    socket.write(BROKEN[hostile % BROKEN.length], "latin1");
    setTimeout(() => socket.destroy(), 5 * BROKEN_EVERY_MS);
  }, BROKEN_EVERY_MS);
  return () => [broken, ...slow].forEach(clearInterval);
}

const statuses = new Map();
const times = [];
let open = 0;
let busy = 0;

function send(number, began = performance.now()) {
  open += 1;
  const done = (status) => {
    open -= 1;
    statuses.set(status, (statuses.get(status) ?? 0) + 1);
    times.push(performance.now() - began);
  };
  const request = http.get(url + target(number), { agent }, (response) => {
    response.resume();
    response.on("end", () => {
      if (response.statusCode !== 503) return done(response.statusCode);
      busy += 1;
      setTimeout(() => {
        open -= 1;
        send(number, began);
      }, 1e3 * Number(response.headers["retry-after"]));
    });
    response.on("error", () => done("cut"));
  });
  request.on("error", (error) => done(error.code ?? "error"));
}

const until = (time) => new Promise((resolve) => setTimeout(resolve, Math.max(0, time - performance.now())));

// One second fills the caches; the growth of memory is measured afterwards.
for (let number = 0; number < rate; number += 1) {
  send(number);
  if (number % 20 === 0) await until(0);
}
while (open) await until(performance.now() + 20);
statuses.clear();
times.length = 0;
const endHostileClients = startHostileClients();
const before = memory();
const began = performance.now();
let half = 0;
for (let number = 0; number < total; ) {
  const due = Math.min(total, Math.floor(((performance.now() - began) / 1e3) * rate));
  for (; number < due; number += 1) send(rate + number);
  if (!half && number > total / 2) half = memory();
  await until(performance.now() + 2);
}
while (open) await until(performance.now() + 20);
endHostileClients();
const took = (performance.now() - began) / 1e3;
const after = memory();
times.sort((a, b) => a - b);
const quantile = (share) => times[Math.min(times.length - 1, Math.floor(share * times.length))].toFixed(1);
console.log(`load: ${times.length} responses in ${took.toFixed(1)} s (${(times.length / took).toFixed(0)} per second), statuses ${JSON.stringify(Object.fromEntries(statuses))}`);
console.log(`load: 200 connections, and ${hostile} of slow and broken clients meanwhile`);
console.log(`load: median ${quantile(0.5)} ms, 99 % ${quantile(0.99)} ms, longest ${quantile(1)} ms; ${busy} times busy; memory ${before.toFixed(1)} MB, half way ${half.toFixed(1)} MB, at the end ${after.toFixed(1)} MB`);
if (statuses.size !== 1 || !statuses.has(200)) throw new Error("responses other than 200");
// The response cache has at most 16 MB.
if (after - before > 24) throw new Error("memory grows");
agent.destroy();
// Slow clients may still be connected.
process.exit(0);

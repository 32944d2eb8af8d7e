// The scan of SatIdentifier (github.com/exoplanet5/SatIdentifier, MIT), run in node as in its tests.
//
// usage: node peer_satidentifier.cjs CHECKOUT ELEMENTS EXPOSURES.json FOV_DEG
//
// EXPOSURES.json is written by compare.py: [{id, t0_ms, duration_s, ra_deg, dec_deg, dut1_s}], with pointings moved by
// the Earth's velocity over c, because the scan uses geometric directions only (v_sat / c, 5 arcsec, remains).
// No code of SatIdentifier is part of this project: CHECKOUT is a separate clone.
'use strict';
const fs = require('fs');
const path = require('path');
const [checkout, elements, exposuresFile, fov] = process.argv.slice(2);
const app = path.resolve(checkout, 'app', 'js');
global.satellite = require(path.join(app, 'vendor', 'satellite.min.js'));
const scan = require(path.join(app, 'worker', 'scan-worker.js'));

const site = { latDeg: -30.244639, lonDeg: -70.749417, altM: 2663 };
const seconds = () => Number(process.hrtime.bigint()) / 1e9;

(async () => {
  const exposures = JSON.parse(fs.readFileSync(exposuresFile, 'utf8'));
  const start = seconds();
  const lines = fs.readFileSync(elements, 'utf8').split(/\r?\n/);
  const objects = [];
  for (let i = 0; i + 1 < lines.length; i++) {
    if (lines[i].startsWith('1 ') && lines[i + 1].startsWith('2 ')) {
      const norad = parseInt(lines[i].slice(2, 7), 10);
      objects.push({ id: 'o' + i, norad, name: '', intl: '', l1: lines[i], l2: lines[i + 1], rcs: null, stdMag: null });
    }
  }
  scan.loadObjs(objects);
  const ready = seconds();
  const crossings = [];
  for (const exposure of exposures) {
    const result = await scan.runScan({
      t0Ms: exposure.t0_ms,
      spanMin: exposure.duration_s / 60,
      site,
      pointing: { track: 'sky', mode: 'radec', raDeg: exposure.ra_deg, decDeg: exposure.dec_deg, refract: false },
      fov: { shape: 'circ', rDeg: Number(fov) / 2, wDeg: 0, hDeg: 0, rotDeg: 0 },
      filters: { minElDeg: 0 },
      // Defaults of SatIdentifier (app/js/state.js), except that the step is not longer than the exposure.
      steps: { coarseStepS: Math.min(30, exposure.duration_s), fineStepS: 1.0, marginDeg: 0 },
      dut1S: exposure.dut1_s,
    });
    for (const crossing of result.crossings) crossings.push([exposure.id, crossing.norad]);
  }
  const end = seconds();
  process.stdout.write(JSON.stringify({
    name: 'SatIdentifier scan-worker, node ' + process.version,
    exposures: exposures.length,
    timings: { read_s: ready - start, crossings_s: end - ready, total_s: end - start },
    crossings,
  }));
})();

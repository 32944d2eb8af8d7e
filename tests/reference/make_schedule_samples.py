"""Writes schedules in the formats of common tools, for tests/cli/annotate_formats.rs.

    python make_schedule_samples.py ../data/schedules      (astropy 8)

Columns, types and units follow the published schemas; the values are invented:
- ConsDB: lsst/sdm_schemas, cdb_lsstcam.yaml, table visit1 (obs_start_mjd: "MJD ... TAI").
- ObsPlan: IVOA ObsLocTAP 1.0, section 3 (t_planning, t_exptime, s_ra, s_dec, s_fov, target_name, instrument_name), as
  used by the IAU CPS to read the Rubin feed.
"""
import json
import sys
from pathlib import Path

import numpy as np
from astropy import units as u
from astropy.table import MaskedColumn, Table
from astropy.time import Time

folder = Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
rows = 12
start = Time("2024-08-14T23:05:37", scale="tai") + np.arange(rows) * 45 * u.s
consdb = Table(
    {
        "visit_id": 2024081400000 + np.arange(rows, dtype=np.int64),
        "day_obs": np.full(rows, 20240814, dtype=np.int32),
        "physical_filter": [f"r_{57 + n % 2}" for n in range(rows)],
        "band": ["r"] * rows,
        "s_ra": 200.0 + 1.5 * np.arange(rows) + 1 / 3,
        "s_dec": -50.0 + np.arange(rows) * 0.7,
        "sky_rotation": np.linspace(0.1, 340.7, rows),
        "obs_start_mjd": start.tai.mjd,
        "exp_time": np.full(rows, 30.0),
        "airmass": MaskedColumn(np.linspace(1, 2, rows), mask=[n % 5 == 0 for n in range(rows)]),
        "observation_reason": MaskedColumn(["fbs, \"main\"" if n % 2 else "x & y <z>" for n in range(rows)], mask=[n == 3 for n in range(rows)]),
    }
)
for name, unit in {"s_ra": "deg", "s_dec": "deg", "sky_rotation": "deg", "obs_start_mjd": "d", "exp_time": "s"}.items():
    consdb[name].unit = unit
consdb["s_ra"].description = "Central Spatial Position in ICRS; Right ascension of boresight. A description that is long enough to be folded by YAML"
consdb.meta["query"] = "select * from cdb_lsstcam.visit1"
consdb.meta["comments"] = ["made by hand", "two: lines"]
consdb.write(folder / "consdb.csv", format="ascii.csv", overwrite=True)
consdb.write(folder / "consdb.ecsv", format="ascii.ecsv", overwrite=True)
consdb.write(folder / "consdb_comma.ecsv", format="ascii.ecsv", delimiter=",", overwrite=True)
consdb.write(folder / "consdb.vot", format="votable", overwrite=True)
plan = [
    {
        "t_planning": float(start.utc.mjd[n]),
        "target_name": f"lowdust é {n}",
        "obs_collection": "LSST",
        "s_ra": float(consdb["s_ra"][n]),
        "s_dec": float(consdb["s_dec"][n]),
        "s_fov": 3.0,
        "t_exptime": 30.0,
        "t_plan_exptime": 30,
        "instrument_name": "LSSTCam",
        "em_min": 5.5e-07,
        "priority": 0,
        "category": "Fixed",
        "execution_status": None,
    }
    for n in range(rows)
]
(folder / "obsplan.json").write_text(json.dumps(plan, indent=1, ensure_ascii=False) + "\n")
(folder / "obsplan_object.json").write_text(json.dumps({"note": {"b": [1, 2]}, "exposures": plan, "last": 1.0}) + "\n")

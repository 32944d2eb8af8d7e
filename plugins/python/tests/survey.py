"""A year of visits, made from thirteen nights of a simulated survey."""

import sqlite3

import numpy as np

#: Daily increase of local sidereal time, degrees.
NIGHTLY_DEG = 360.0 / 365.2422


def baseline(data):
    """Reads the visits of `baseline_10klines_2.0.db`. The start is an MJD (UTC)."""
    with sqlite3.connect(data / "schedules" / "baseline_10klines_2.0.db") as database:
        rows = database.execute(
            "SELECT observationStartMJD, fieldRA, fieldDec, visitExposureTime, rotSkyPos, filter FROM observations ORDER BY 1"
        ).fetchall()
    start, ra, dec, exposure, rotation, band = zip(*rows)
    numbers = (np.array(column, dtype=float) for column in (start, ra, dec, exposure, rotation))
    return dict(zip(("start", "ra_deg", "dec_deg", "exposure_s", "rotation_deg"), numbers)) | {"band": np.array(band)}


def year(data, nights=365, seed=1):
    """Repeats the nights for a year. Fields keep their hour angles, and are moved by up to half a degree."""
    source = baseline(data)
    # Noon at Cerro Pachón is 16:43 UTC.
    night = np.floor(source["start"] - 0.697).astype(int)
    source_nights = np.unique(night)
    generator = np.random.default_rng(seed)
    parts = []
    for number in range(nights):
        source_night = source_nights[number % len(source_nights)]
        rows = night == source_night
        days = source_nights[0] + number - source_night
        part = {name: column[rows] for name, column in source.items()}
        count = rows.sum()
        part["start"] = part["start"] + days
        part["ra_deg"] = (part["ra_deg"] + NIGHTLY_DEG * days + generator.uniform(-0.5, 0.5, count)) % 360.0
        part["dec_deg"] = np.clip(part["dec_deg"] + generator.uniform(-0.5, 0.5, count), -90.0, 90.0)
        parts.append(part)
    return {name: np.concatenate([part[name] for part in parts]) for name in source}

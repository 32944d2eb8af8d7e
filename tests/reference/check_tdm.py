"""Reads tracking data messages of `forecast` with ccsds-ndm and compares them with the table of passes.

    tests/independent.sh, or
    venv/bin/python tests/reference/check_tdm.py target/debug/streakcast

Every pass must be a segment with its satellite, time scale and angles. Begin, highest point, end and peak magnitude
must equal those of the table. Right ascensions and declinations along the passes must agree with azimuths and altitudes
of the table, which astropy converts for the time of emission (the latter are geometric, the former astrometric). Prints
the largest differences, and fails if one exceeds its limit.
"""

import json
import subprocess
import sys
import tempfile
from datetime import datetime
from pathlib import Path

import numpy as np
from astropy import units as u
from astropy.coordinates import AltAz, EarthLocation, SkyCoord
from astropy.time import Time
from astropy.utils import iers
from ccsds_ndm.models.ndmxml4 import AngleTypeType, Tdm
from ccsds_ndm.ndm_io import NdmIo

ARGUMENTS = ["forecast", "--shells", "starlink-gen1", "--mpc", "X05", "--night", "2024-08-14", "--no-atmosphere", "--quiet", "--max-mag"]
#: Magnitude limits of the passes compared at their ends and peaks, and of those compared along the whole pass.
MANY, FEW = "5", "4.8"
#: Half of the last digit of the table: angles in 0.001 deg, magnitudes in 0.001 mag; times to the microsecond.
ANGLE_DEG, MAGNITUDE, TIME_S = 6e-4, 6e-4, 2e-6
#: Points along a pass: azimuths and altitudes in 1e-4 deg, times to the millisecond at up to a degree a second. Without
#: the light time it would be 1.5e-3.
PLACE_DEG = 6e-4
SAMPLES = 201
LIGHT_KM_S = 299_792.458
iers.conf.auto_download = False
SITE = EarthLocation.from_geodetic(lon=-70.74942, lat=-30.24463, height=2663.0)


def moment(text):
    return datetime.fromisoformat(text.rstrip("Z"))


def apart_deg(a, b):
    return abs((a - b + 180.0) % 360.0 - 180.0)


def by_time(segment):
    """Returns the data of each time: first angle, second angle, magnitude."""
    observations = {}
    for one in segment.data.observation:
        at = observations.setdefault(moment(one.epoch), {})
        for name in ("angle_1", "angle_2", "mag"):
            value = getattr(one, name)
            if value is not None:
                at[name] = float(getattr(value, "value", value))
    return observations


def nearest(observations, text):
    at = moment(text)
    key = min(observations, key=lambda other: abs((other - at).total_seconds()))
    assert abs((key - at).total_seconds()) <= TIME_S, f"no observation at {text}: {sorted(observations)}"
    return observations[key]


def apart_on_sky_deg(samples, observations):
    """Largest separation between astropy's ICRS, one light time earlier, and the message, and the number of points."""
    column = lambda name: np.array([point[name] for point in samples])
    azimuths, altitudes = np.radians(column("azimuth_deg")), np.radians(column("altitude_deg"))
    towards = np.array([np.cos(altitudes) * np.cos(azimuths), np.cos(altitudes) * np.sin(azimuths), np.sin(altitudes)])
    times = Time(column("utc"), scale="utc")
    left = towards - np.gradient(towards, (times - times[0]).sec, axis=1) * column("range_km") / LIGHT_KM_S
    azimuths, altitudes = np.arctan2(left[1], left[0]), np.arctan2(left[2], np.hypot(left[0], left[1]))
    seen = SkyCoord(azimuths * u.rad, altitudes * u.rad, frame=AltAz(obstime=times, location=SITE)).icrs
    moments = [moment(point["utc"]) for point in samples]
    of_message = [(k, observations[when]) for k, when in enumerate(moments) if when in observations]
    places = SkyCoord([(at["angle_1"], at["angle_2"]) for _, at in of_message], unit="deg")
    return float(seen[[k for k, _ in of_message]].separation(places).deg.max()), len(of_message)


def main():
    binary = sys.argv[1]
    compared = 0
    worst = {"angle": 0.0, "magnitude": 0.0, "place": 0.0}
    with tempfile.TemporaryDirectory() as folder:
        def write(name, max_mag, *more):
            path = Path(folder) / name
            subprocess.run([binary, *ARGUMENTS, max_mag, *more, "--output", str(path)], check=True)
            return path

        passes = json.loads(write("passes.json", MANY, "--format", "json").read_text())["passes"]
        assert passes, "no passes to compare"
        for angles, expected in (("radec", AngleTypeType.RADEC), ("azel", AngleTypeType.AZEL)):
            message = NdmIo().from_path(write(f"{angles}.tdm", MANY, "--format", "tdm", "--angle-type", angles))
            assert isinstance(message, Tdm) and message.version == "2.0", message.version
            assert len(message.body.segment) == len(passes), f"{len(message.body.segment)} segments of {len(passes)} passes"
            for segment, row in zip(message.body.segment, passes):
                about = segment.metadata
                assert (about.participant_1, about.participant_2) == ("X05", str(row["norad_id"])), about
                assert about.time_system == "UTC" and about.angle_type == expected, about
                observations = by_time(segment)
                assert all(0 <= at["angle_1"] < 360 and -90 <= at["angle_2"] <= 90 for at in observations.values())
                # A peak or highest point at the border of the pass may be some 10 ms beyond it (separate root finding);
                # the message has the border.
                inside = [when for when in ("begin", "highest", "peak", "end") if row["begin_utc"] <= row[f"{when}_utc"] <= row["end_utc"]]
                compared += len(inside)
                if "peak" in inside:
                    worst["magnitude"] = max(worst["magnitude"], abs(nearest(observations, row["peak_utc"])["mag"] - row["peak_magnitude"]))
                for when in inside:
                    at = nearest(observations, row[f"{when}_utc"])
                    if angles == "azel":
                        # Near the zenith the azimuth is less accurate than its digits.
                        pairs = ((at["angle_1"], row[f"{when}_azimuth_deg"]), (at["angle_2"], row[f"{when}_altitude_deg"]))
                        worst["angle"] = max(worst["angle"], *(apart_deg(a, b) for a, b in pairs))
        sampled = [FEW, "--samples", str(SAMPLES), "--format"]
        message = NdmIo().from_path(write("sampled.tdm", *sampled, "tdm", "--angle-type", "radec"))
        bright = json.loads(write("sampled.json", *sampled, "json").read_text())["passes"]
        assert 0 < len(message.body.segment) == len(bright), f"{len(message.body.segment)} segments of {len(bright)} passes"
        places = 0
        for segment, row in zip(message.body.segment, bright):
            apart_deg_of_pass, count = apart_on_sky_deg(row["samples"], by_time(segment))
            worst["place"], places = max(worst["place"], apart_deg_of_pass), places + count
        assert places > 0.1 * SAMPLES * len(bright), f"{places} points of {SAMPLES * len(bright)}"
    # Most points: excluded are peaks at the border of the shadow.
    assert compared > 0.9 * 8 * len(passes), f"{compared} of {8 * len(passes)}"
    print(f"{len(passes)} passes, {compared} moments and {places} places along them, read by ccsds-ndm: angles within {worst['angle']:.1e} deg, places within {worst['place']:.1e} deg of astropy's, magnitudes within {worst['magnitude']:.1e} mag")
    assert worst["angle"] <= ANGLE_DEG and worst["place"] <= PLACE_DEG and worst["magnitude"] <= MAGNITUDE


main()

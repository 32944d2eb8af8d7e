"""Tracking data messages of `forecast`, read by a program that is not ours (ccsds-ndm) and held against the table of the same passes.

    tests/independent.sh, or
    venv/bin/python tests/reference/check_tdm.py target/debug/streakcast

Every pass must be a segment with its satellite, its scale of time and its angles; begin, highest and end and the peak's magnitude must be those of the
table; right ascensions and declinations, along the passes, those that astropy makes of the table's azimuths and altitudes when the light left (these are
where the satellite is, those where it is seen). Prints the greatest differences; ends with an
error where one is more than it may be.
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

ASKED = ["forecast", "--shells", "starlink-gen1", "--mpc", "X05", "--night", "2024-08-14", "--quiet", "--max-mag"]
#: Passes that are looked at in their ends and peaks, and brighter ones that are looked at all along.
MANY, FEW = "5.6", "4.5"
#: Half of the last digit that the table has: angles in 0.001 deg, magnitudes in 0.001 mag; times to the microsecond.
ANGLE_DEG, MAGNITUDE, TIME_S = 6e-4, 6e-4, 2e-6
#: Points along a pass: azimuths and altitudes in 1e-4 deg, times to the millisecond at up to a degree a second. Without the light time it would be 1.5e-3.
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
    """What is told of each moment: first angle, second angle, magnitude."""
    told = {}
    for one in segment.data.observation:
        at = told.setdefault(moment(one.epoch), {})
        for name in ("angle_1", "angle_2", "mag"):
            value = getattr(one, name)
            if value is not None:
                at[name] = float(getattr(value, "value", value))
    return told


def nearest(told, text):
    at = moment(text)
    key = min(told, key=lambda other: abs((other - at).total_seconds()))
    assert abs((key - at).total_seconds()) <= TIME_S, f"no observation at {text}: {sorted(told)}"
    return told[key]


def apart_on_sky_deg(samples, told):
    """Between points of a pass in astropy's ICRS, one light time earlier, and those of the message; and how many there are of these."""
    column = lambda name: np.array([point[name] for point in samples])
    azimuths, altitudes = np.radians(column("azimuth_deg")), np.radians(column("altitude_deg"))
    towards = np.array([np.cos(altitudes) * np.cos(azimuths), np.cos(altitudes) * np.sin(azimuths), np.sin(altitudes)])
    times = Time(column("utc"), scale="utc")
    left = towards - np.gradient(towards, (times - times[0]).sec, axis=1) * column("range_km") / LIGHT_KM_S
    azimuths, altitudes = np.arctan2(left[1], left[0]), np.arctan2(left[2], np.hypot(left[0], left[1]))
    seen = SkyCoord(azimuths * u.rad, altitudes * u.rad, frame=AltAz(obstime=times, location=SITE)).icrs
    moments = [moment(point["utc"]) for point in samples]
    of_message = [(k, told[when]) for k, when in enumerate(moments) if when in told]
    places = SkyCoord([(at["angle_1"], at["angle_2"]) for _, at in of_message], unit="deg")
    return float(seen[[k for k, _ in of_message]].separation(places).deg.max()), len(of_message)


def main():
    binary = sys.argv[1]
    compared = 0
    worst = {"angle": 0.0, "magnitude": 0.0, "place": 0.0}
    with tempfile.TemporaryDirectory() as folder:
        def write(name, max_mag, *more):
            path = Path(folder) / name
            subprocess.run([binary, *ASKED, max_mag, *more, "--output", str(path)], check=True)
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
                told = by_time(segment)
                assert all(0 <= at["angle_1"] < 360 and -90 <= at["angle_2"] <= 90 for at in told.values())
                # A peak or a highest moment that is the pass's own border may lie some 10 ms beyond it, as they are closed in on apart; the message has the border.
                inside = [when for when in ("begin", "highest", "peak", "end") if row["begin_utc"] <= row[f"{when}_utc"] <= row["end_utc"]]
                compared += len(inside)
                if "peak" in inside:
                    worst["magnitude"] = max(worst["magnitude"], abs(nearest(told, row["peak_utc"])["mag"] - row["peak_magnitude"]))
                for when in inside:
                    at = nearest(told, row[f"{when}_utc"])
                    if angles == "azel":
                        # Near the zenith an azimuth is worth less than its digits.
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
    # Most: what is left out are peaks on the border of a shadow.
    assert compared > 0.9 * 8 * len(passes), f"{compared} of {8 * len(passes)}"
    print(f"{len(passes)} passes, {compared} moments and {places} places along them, read by ccsds-ndm: angles within {worst['angle']:.1e} deg, places within {worst['place']:.1e} deg of astropy's, magnitudes within {worst['magnitude']:.1e} mag")
    assert worst["angle"] <= ANGLE_DEG and worst["place"] <= PLACE_DEG and worst["magnitude"] <= MAGNITUDE


main()

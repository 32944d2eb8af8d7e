"""Reads HEALPix maps with healpy and astropy, and compares them with tables of the same maps.

    python3 -m venv venv && venv/bin/pip install numpy astropy healpy
    venv/bin/python tests/reference/check_healpix_maps.py target/release/streakcast
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import healpy
import numpy as np
from astropy.table import Table

NSIDE = 64
HALF_A_DIGIT = 0.5001e-4  # magnitudes in tables have four decimals
HALF_A_DEGREE_DIGIT = 0.5001e-6


def main(streakcast):
    with tempfile.TemporaryDirectory() as folder:
        for verb, arguments, coordinates, frame in [
            ("sky", ["--sun-altitude-deg", "-16"], ("azimuth_deg", "altitude_deg"), "HORIZON"),
            ("body", ["--sun-latitude-deg", "-14"], ("observer_longitude_deg", "observer_latitude_deg"), "BODY"),
        ]:
            arguments = [streakcast, "map", verb, "--model", "starlink-v1.5", "--quiet", "--nside", str(NSIDE), *arguments]
            path = Path(folder) / f"{verb}.fits"
            subprocess.run([*arguments, "-o", path], check=True)
            text = subprocess.run([*arguments, "--format", "ecsv"], check=True, capture_output=True, text=True).stdout
            rows = Table.read(text.splitlines(), format="ascii.ecsv")
            table = Table.read(path)
            assert table.meta["ORDERING"] == "RING" and table.meta["NSIDE"] == NSIDE and table.meta["COORDSYS"] == frame
            names = [name for name in rows.colnames if name in table.colnames]
            maps = np.atleast_2d(healpy.read_map(path, field=None, dtype=np.float64))
            assert maps.shape == (len(table.colnames), 12 * NSIDE**2)
            longitude, latitude = healpy.pix2ang(NSIDE, rows["healpix_cell"].data, lonlat=True)
            for name, expected in zip(coordinates, (longitude, latitude)):
                assert np.abs(rows[name].data - expected).max() < HALF_A_DEGREE_DIGIT, name
            outside = np.setdiff1d(np.arange(12 * NSIDE**2), rows["healpix_cell"].data)
            for name in names:
                column = maps[table.colnames.index(name)]
                assert np.array_equal(column, table[name].data) and str(table[name].unit) == str(rows[name].unit)
                assert (column[outside] == healpy.UNSEEN).all()
                values, mask = np.ma.getdata(rows[name]), np.ma.getmaskarray(rows[name].data)
                cells = rows["healpix_cell"].data
                assert (column[cells[mask]] == healpy.UNSEEN).all() and mask.sum() < len(rows)
                tolerance = HALF_A_DIGIT if name != "range_km" else 10 * HALF_A_DIGIT
                assert np.abs(column[cells[~mask]] - values[~mask]).max() < tolerance, name
                print(f"{verb} {name}: {(~mask).sum()} cells agree, {mask.sum()} without a value, {len(outside)} of the other half")


if __name__ == "__main__":
    main(sys.argv[1])

"""Writes src/frames/data/earth_orientation.txt from a finals2000A.all file.

    python tests/reference/make_embedded_eop.py FINALS2000A.all src/frames/data/earth_orientation.txt

One row every STEP days from 2000-01-01, with UT1-TAI to 0.1 ms and polar motion to 0.1 mas. The last row is the last
day of the predictions. Prints the largest difference between the daily file and linear interpolation of the rows.
"""

import sys

STEP = 3
FIRST = 51544
LEAP = [(51179, 32), (53736, 33), (54832, 34), (56109, 35), (57204, 36), (57754, 37)]


def tai_minus_utc(mjd):
    return [value for start, value in LEAP if start <= mjd][-1]


def main(source, target):
    rows = []
    for line in open(source):
        if not line[58:68].strip() or not line[18:27].strip():
            continue
        mjd = int(float(line[7:15]))
        if mjd >= FIRST:
            ut1_tai = float(line[58:68]) - tai_minus_utc(mjd)
            rows.append((mjd, ut1_tai, float(line[18:27]), float(line[37:46]), line[57]))
    last = rows[-1][0]
    predicted_from = next(mjd for mjd, *_, flag in rows if flag == "P")
    chosen = [row for row in rows if (row[0] - FIRST) % STEP == 0 or row[0] == last]

    worst = {"ut1_s": 0.0, "pole_arcsec": 0.0}
    square = 0.0
    for left, right in zip(chosen, chosen[1:]):
        for mjd, *values, _ in rows[left[0] - FIRST : right[0] - FIRST + 1]:
            part = (mjd - left[0]) / (right[0] - left[0])
            line = [a + (b - a) * part for a, b in zip([round(v, 4) for v in left[1:4]], [round(v, 4) for v in right[1:4]])]
            worst["ut1_s"] = max(worst["ut1_s"], abs(line[0] - values[0]))
            worst["pole_arcsec"] = max(worst["pole_arcsec"], abs(line[1] - values[1]), abs(line[2] - values[2]))
            square += (line[0] - values[0]) ** 2
    print(f"rows {len(chosen)}, last {last}, predicted from {predicted_from}")
    print(f"largest error: UT1 {worst['ut1_s'] * 1e3:.2f} ms (rms {(square / len(rows)) ** 0.5 * 1e3:.2f}), pole {worst['pole_arcsec'] * 1e3:.2f} mas")

    with open(target, "w") as out:
        out.write("# Earth orientation: UT1-TAI in 0.1 ms, pole x and y in 0.1 mas (IERS Bulletin A, series of 2000A)\n")
        out.write("# Origin: finals2000A.all of IERS/USNO as in astropy-iers-data 0.2026.11.2; made by tests/reference/make_embedded_eop.py\n")
        out.write(
            f"# Linear interpolation between the rows differs from the daily series by at most {worst['ut1_s'] * 1e3:.1f} ms and {worst['pole_arcsec'] * 1e3:.1f} mas\n"
        )
        out.write(f"first_mjd {FIRST}\nstep_days {STEP}\npredicted_from_mjd {predicted_from}\nlast_mjd {last}\n")
        for _, ut1_tai, x, y, _ in chosen:
            out.write(f"{round(ut1_tai * 1e4)} {round(x * 1e4)} {round(y * 1e4)}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])

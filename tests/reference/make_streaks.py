"""Writes tests/data/streaks_golden.csv: streaks drawn by GalSim.

    pip install galsim==2.8.5
    python tests/reference/make_streaks.py > tests/data/streaks_golden.csv

Straight streaks of constant brightness are a thin box convolved with the profile by FFT at high accuracy. Curved
streaks and ramps are sums of points along the path (Gauss-Legendre rule of eight nodes in intervals of two pixels),
drawn in the same way. The defocused pupil is the difference of two disks; the body of the satellite is a disk. A pixel
value is the light in the pixel: GalSim integrates over pixels, so that it is also correct for narrow seeing. Non-square
pixels are GalSim's JacobianWCS; lengths of the blur are then in pixels of the mean scale, paths in pixels. The path is
x = x0 + vx t + ax t^2, and y in the same form, for t from 0 to 1; the brightness is r0 + r1 t.
"""

import datetime
import math

import galsim
import numpy as np

SIZE = 160
EXACT = galsim.GSParams(
    folding_threshold=2e-6, maxk_threshold=1e-6, kvalue_accuracy=1e-8, xvalue_accuracy=1e-8, maximum_fft_size=32768
)
# Reduced wings for the many points: the folded light is 1e-5 of the total.
POINTS = galsim.GSParams(
    folding_threshold=1e-5, maxk_threshold=1e-6, kvalue_accuracy=1e-8, xvalue_accuracy=1e-8, maximum_fft_size=32768
)


def profile(seeing, a, b, c, outer, inner, body, params):
    if seeing == "gaussian":
        psf = galsim.Gaussian(fwhm=a, gsparams=params)
    elif seeing == "moffat":
        psf = galsim.Moffat(beta=b, fwhm=a, gsparams=params)
    else:
        psf = galsim.Gaussian(fwhm=a, flux=1 - c, gsparams=params) + galsim.Gaussian(fwhm=b, flux=c, gsparams=params)
    parts = [psf]
    if outer > 0:
        area = outer**2 - inner**2
        ring = galsim.TopHat(outer, flux=outer**2 / area)
        if inner > 0:
            ring = ring - galsim.TopHat(inner, flux=inner**2 / area)
        parts.append(ring)
    if body > 0:
        parts.append(galsim.TopHat(body))
    return parts


def image_of(blur, path, aspect):
    wcs = galsim.JacobianWCS(math.sqrt(aspect), 0.0, 0.0, 1 / math.sqrt(aspect))
    x0, vx, ax, y0, vy, ay, r0, r1 = path
    image = galsim.ImageD(galsim.BoundsI(0, SIZE - 1, 0, SIZE - 1), init_value=0.0)
    wx, wy = vx * math.sqrt(aspect), vy / math.sqrt(aspect)
    length = math.hypot(wx, wy)
    if ax == ay == r1 == 0:
        parts = profile(*blur, EXACT)
        if length > 0:
            # A box much narrower than the profile represents a line.
            parts.append(galsim.Box(length, 1e-3).rotate(math.atan2(wy, wx) * galsim.radians))
        whole = galsim.Convolve(parts, gsparams=EXACT).withFlux(r0)
        whole.drawImage(image=image, wcs=wcs, center=galsim.PositionD(x0 + vx / 2, y0 + vy / 2), add_to_image=True)
        return image.array
    point = galsim.Convolve(profile(*blur, POINTS), gsparams=POINTS)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    # Intervals of two pixels, or of two widths if these are shorter.
    stretches = int(length / min(2.0, 2.0 * blur[1]))
    for stretch in range(stretches):
        for node, weight in zip(nodes, weights):
            t = (stretch + 0.5 * (1 + node)) / stretches
            light = 0.5 * weight / stretches * (r0 + r1 * t)
            at = galsim.PositionD(x0 + vx * t + ax * t * t, y0 + vy * t + ay * t * t)
            point.withFlux(light).drawImage(image=image, wcs=wcs, center=at, add_to_image=True)
    return image.array


def straight(angle_deg, length=62.0, centre=(79.31, 80.64), rate=1000.0):
    angle = math.radians(angle_deg)
    vx, vy = length * math.cos(angle), length * math.sin(angle)
    return (centre[0] - vx / 2, vx, 0.0, centre[1] - vy / 2, vy, 0.0, rate, 0.0)


def cases():
    gauss = ("gaussian", 3.5, 0.0, 0.0, 0.0, 0.0, 0.0)
    moffat = ("moffat", 3.5, 3.5, 0.0, 0.0, 0.0, 0.0)
    double = ("double", 3.0, 8.0, 0.2, 0.0, 0.0, 0.0)
    ring = ("gaussian", 3.5, 0.0, 0.0, 8.0, 4.9, 1.0)
    wide = ("moffat", 3.5, 4.765, 0.0, 12.0, 7.34, 2.5)
    small = ("gaussian", 2.5, 0.0, 0.0, 1.2, 0.4, 0.3)
    for angle in [0.0, 17.0, 45.0, 73.0, 90.0]:
        yield f"gaussian {angle:.0f}", gauss, straight(angle)
    for name, blur in [("moffat", moffat), ("double", double), ("ring", ring), ("wide ring", wide), ("small ring", small)]:
        for angle in [17.0, 135.0]:
            yield f"{name} {angle:.0f}", blur, straight(angle)
    yield "gaussian of 2 pixels", ("gaussian", 2.0, 0.0, 0.0, 0.0, 0.0, 0.0), straight(17.0)
    yield "gaussian of 1.2 pixels", ("gaussian", 1.2, 0.0, 0.0, 0.0, 0.0, 0.0), straight(17.0)
    yield "moffat of 1 pixel", ("moffat", 1.0, 3.0, 0.0, 0.0, 0.0, 0.0), straight(30.0)
    for offset in [0.0, 0.25, 0.5]:
        yield f"offset {offset}", gauss, straight(0.0, centre=(80.0 + offset, 80.0 + offset))
    yield "short", gauss, straight(29.0, length=2.3)
    yield "point", gauss, (79.31, 0.0, 0.0, 80.64, 0.0, 0.0, 1000.0, 0.0)
    yield "point of a ring", ring, (79.31, 0.0, 0.0, 80.64, 0.0, 0.0, 1000.0, 0.0)
    # Curvatures of about 1/2000, 1/300 and 1/40 per pixel.
    for name, bend in [("slightly", 0.9), ("much", 6.0), ("sharply", 45.0)]:
        yield f"{name} curved", gauss, (50.3, 60.0, 0.0, 70.2, 10.0 - bend, bend, 1000.0, 0.0)
    yield "curved ring", ring, (50.3, 60.0, 0.0, 70.2, 4.0, 6.0, 1000.0, 0.0)
    yield "ramp", gauss, (50.3, 55.0, 0.0, 70.2, 20.0, 0.0, 300.0, 1400.0)
    yield "curved ramp, speeding up", moffat, (50.3, 40.0, 15.0, 70.2, 4.0, 6.0, 1500.0, -900.0)
    # Seeing narrower than a pixel.
    for fwhm in [0.4, 0.55, 0.7, 0.9]:
        yield f"gaussian of {fwhm} pixels", ("gaussian", fwhm, 0.0, 0.0, 0.0, 0.0, 0.0), straight(17.0)
    yield "gaussian of 0.4 pixels along a row", ("gaussian", 0.4, 0.0, 0.0, 0.0, 0.0, 0.0), straight(0.0)
    yield "gaussian of 0.15 pixels", ("gaussian", 0.15, 0.0, 0.0, 0.0, 0.0, 0.0), straight(73.0, length=31.0)
    yield "moffat of 0.6 pixels", ("moffat", 0.6, 3.0, 0.0, 0.0, 0.0, 0.0), straight(30.0)
    yield "double of 0.5 pixels", ("double", 0.5, 1.5, 0.2, 0.0, 0.0, 0.0), straight(17.0)
    yield "ring under 0.6 pixels", ("gaussian", 0.6, 0.0, 0.0, 3.0, 1.8, 0.4), straight(17.0)
    yield "point of 0.5 pixels", ("gaussian", 0.5, 0.0, 0.0, 0.0, 0.0, 0.0), (79.31, 0.0, 0.0, 80.64, 0.0, 0.0, 1000.0, 0.0)
    yield "curved ramp of 0.7 pixels", ("gaussian", 0.7, 0.0, 0.0, 0.0, 0.0, 0.0), (50.3, 60.0, 0.0, 70.2, 4.0, 6.0, 300.0, 1400.0)
    # Non-square pixels: 1.5 and 2 times as wide as high, and higher than wide.
    yield "gaussian on oblong pixels", gauss, straight(35.0), 1.5
    yield "ring on oblong pixels", ring, straight(120.0), 2.0
    yield "moffat on high pixels", ("moffat", 2.0, 3.5, 0.0, 0.0, 0.0, 0.0), straight(17.0), 0.5
    yield "gaussian of 0.8 pixels on oblong pixels", ("gaussian", 0.8, 0.0, 0.0, 0.0, 0.0, 0.0), straight(60.0), 1.25


def chosen(path):
    """Returns the rows and columns that are written: both middle lines, and squares around both ends."""
    x0, vx, ax, y0, vy, ay = path[:6]
    found = {(80, column) for column in range(31, 130, 3)} | {(row, 80) for row in range(31, 130, 3)}
    for x, y in [(x0, y0), (x0 + vx + ax, y0 + vy + ay)]:
        found |= {(round(y) + dy, round(x) + dx) for dy in range(-6, 7, 2) for dx in range(-6, 7, 2)}
    return sorted(found)


def main():
    today = datetime.date.today().isoformat()
    print(f"# GalSim {galsim.__version__}, tests/reference/make_streaks.py, {today}; frames of {SIZE} x {SIZE} pixels")
    print("# case: name, seeing, fwhm or narrow fwhm, beta or wide fwhm, wide share, outer, inner and body radius, x0, vx, ax, y0, vy, ay, r0, r1, peak, sum, width of pixels in their height where that is not 1")
    print("# other lines: row, column, light")
    for name, blur, path, *aspect in cases():
        image = image_of(blur, path, *(aspect or [1.0]))
        numbers = ",".join(f"{number!r}" for number in [*blur[1:], *path])
        print(f"case,{name.replace(',', '')},{blur[0]},{numbers},{image.max():.8g},{image.sum():.8g}{''.join(f',{ratio}' for ratio in aspect)}")
        for row, column in chosen(path):
            print(f"{row},{column},{image[row, column]:.6g}")


main()

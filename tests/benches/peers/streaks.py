"""Compares streaks of 500 to 4000 pixels with GalSim (FFT) and NumPy (error functions), in a 4096 x 4096 frame.

    venv/bin/pip install -r tests/benches/peers/requirements-streaks.txt
    cargo bench --bench streaks --no-run
    venv/bin/python tests/benches/peers/streaks.py [--rounds 3]

Runs are interleaved because the speed of the machine varies, with one thread each. GalSim has its default accuracy.
Prints times, ratios, and the difference between GalSim and streakcast for the shortest streak, relative to its peak.

SatSim has no licence and is therefore not a requirement. If it is installed (`pip install satsim` with TensorFlow, 3
GB), it is included: points along the longest streak on a frame without oversampling, and convolution of the frame.
"""
import argparse
import math
import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import time
from importlib.metadata import version

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
import galsim  # noqa: E402
import numpy as np  # noqa: E402
from scipy.special import erf  # noqa: E402

ROOT = pathlib.Path(__file__).parents[3]
SIZE, ANGLE = 4096, 0.7
CENTRE = (2047.8, 2047.4)
LENGTHS = [500, 1000, 2000, 4000]


def streakcast(pixels):
    out = subprocess.run(["cargo", "bench", "-q", "--bench", "streaks", "--", "--rounds", "9", "--pixels", pixels], cwd=ROOT, check=True,
                         capture_output=True, text=True).stdout
    return {(name, int(length)): float(ms) for name, length, ms in re.findall(r"^([\w.]+) (\d+): ([\d.]+) ms", out, re.M)}


def of_galsim(psf, length, image):
    params = galsim.GSParams(maximum_fft_size=32768)
    began = time.perf_counter()
    box = galsim.Box(length, 1e-3, gsparams=params).rotate(ANGLE * galsim.radians)
    streak = galsim.Convolve([box, psf.withGSParams(params)], gsparams=params).withFlux(length)
    streak.drawImage(image=image, scale=1.0, center=galsim.PositionD(*CENTRE), add_to_image=True)
    return (time.perf_counter() - began) * 1e3


def of_numpy(length, frame):
    """Draws a streak in its bounding box, without integration over pixels."""
    sigma = 3.5 / math.sqrt(8 * math.log(2))
    began = time.perf_counter()
    (x, y), (c, s) = CENTRE, (math.cos(ANGLE), math.sin(ANGLE))
    half_x, half_y = 0.5 * length * c + 8, 0.5 * length * s + 8
    rows = slice(max(0, int(y - half_y)), min(SIZE, int(y + half_y) + 1))
    columns = slice(max(0, int(x - half_x)), min(SIZE, int(x + half_x) + 1))
    dy = (np.arange(SIZE, dtype=np.float32)[rows] - y)[:, None]
    dx = (np.arange(SIZE, dtype=np.float32)[columns] - x)[None, :]
    along, across = dx * c + dy * s, dy * c - dx * s
    k = math.sqrt(0.5) / sigma
    light = 0.5 * (erf((along + 0.5 * length) * k) - erf((along - 0.5 * length) * k))
    frame[rows, columns] += light * np.exp(-0.5 * (across / sigma) ** 2) / (sigma * math.sqrt(2 * math.pi))
    return (time.perf_counter() - began) * 1e3


def satsim():
    """Returns the times of one streak and of the convolution of the frame, ms; `None` if SatSim is not installed."""
    try:
        import tensorflow as tf
        from satsim.geometry.draw import gen_line_from_endpoints
        from satsim.image.fpa import add_counts
        from satsim.image.psf import gen_gaussian
        from satsim.math import fftconv2p
    except ImportError:
        return None
    tf.config.threading.set_intra_op_parallelism_threads(1)
    tf.config.threading.set_inter_op_parallelism_threads(1)
    psf = gen_gaussian(SIZE, SIZE, 3.5 / math.sqrt(8 * math.log(2)))

    def drawn():
        length = LENGTHS[-1]
        frame = tf.zeros((SIZE, SIZE), tf.float32)
        half_x, half_y = 0.5 * length * math.cos(ANGLE), 0.5 * length * math.sin(ANGLE)
        began = time.perf_counter()
        rows, columns, counts, _ = gen_line_from_endpoints(CENTRE[1] - half_y, CENTRE[0] - half_x, CENTRE[1] + half_y, CENTRE[0] + half_x, length, 0.0, 1.0)
        lit = add_counts(frame, rows, columns, counts)
        float(lit[0, 0])
        between = time.perf_counter()
        float(fftconv2p(lit, psf, pad=1)[0, 0])
        return (between - began) * 1e3, (time.perf_counter() - between) * 1e3

    drawn()
    return drawn


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=3)
    rounds = parser.parse_args().rounds
    profiles = {"gaussian": galsim.Gaussian(fwhm=3.5), "moffat3.5": galsim.Moffat(beta=3.5, fwhm=3.5)}
    found = {}
    of_satsim, in_satsim = satsim(), []
    frame = np.zeros((SIZE, SIZE), np.float32)
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds):
            mine = streakcast(f"{folder}/pixels")
            for length in LENGTHS:
                for name, psf in profiles.items():
                    image = galsim.ImageF(frame, xmin=0, ymin=0)
                    found.setdefault((name, length), []).append((mine[name, length], of_galsim(psf, length, image)))
                found.setdefault(("numpy", length), []).append((mine["gaussian", length], of_numpy(length, frame)))
            if of_satsim:
                in_satsim.append((mine["gaussian", LENGTHS[-1]], *of_satsim()))
        for (name, length), times in sorted(found.items()):
            own, peer = (statistics.median(column) for column in zip(*times))
            print("%-10s %4d px: streakcast %7.3f ms, %s %8.1f ms, ratio %7.0f" % (name, length, own, "numpy " if name == "numpy" else "galsim", peer, peer / own))
        if in_satsim:
            own, points, convolution = (statistics.median(column) for column in zip(*in_satsim))
            print("satsim     %4d px: streakcast %7.3f ms, satsim %8.1f ms for the points, ratio %7.0f; and %.0f ms for the frame (SatSim %s, TensorFlow %s)" % (
                LENGTHS[-1], own, points, points / own, convolution, version("satsim"), version("tensorflow")))
        else:
            print("satsim is not installed and takes no part")
        image = galsim.ImageF(SIZE, SIZE, xmin=0, ymin=0)
        of_galsim(profiles["gaussian"], 500, image)
        light = np.fromfile(f"{folder}/pixels", "<f4").reshape(SIZE, SIZE)
        print("greatest difference from GalSim %.1e of the peak, sums %.7f and %.7f" % (
            np.abs(light - image.array).max() / image.array.max(), light.sum(dtype=float), image.array.sum(dtype=float)))


if __name__ == "__main__":
    main()

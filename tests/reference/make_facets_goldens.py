"""Writes tests/data/facets_golden.csv: reflectances of rough mirrors rendered by Mitsuba 3.

    pip install mitsuba==3.9.1
    python tests/reference/make_facets_goldens.py > tests/data/facets_golden.csv

The mirrors are Mitsuba's `roughconductor` with Beckmann's distribution and the material `none` (all light is
reflected). Its alpha is sqrt(2) times the rms slope along one axis. Its masking is Walter et al.'s rational fit (their
eq. 27, error 0.35 %) and not the error function.
"""

import datetime
import math

import mitsuba as mi

mi.set_variant("scalar_rgb")


def direction(zenith_deg, azimuth_deg):
    zenith, azimuth = math.radians(zenith_deg), math.radians(azimuth_deg)
    return [math.sin(zenith) * math.cos(azimuth), math.sin(zenith) * math.sin(azimuth), math.cos(zenith)]


def main():
    today = datetime.date.today().isoformat()
    print(f"# roughconductor (Beckmann) of Mitsuba {mi.__version__}, scalar_rgb, tests/reference/make_facets_goldens.py, {today}")
    print("slope,in_zenith_deg,out_zenith_deg,out_azimuth_deg,per_sr")
    for slope in [0.05, 0.1, 0.25, 0.5]:
        bsdf = mi.load_dict(
            {"type": "roughconductor", "material": "none", "distribution": "beckmann", "alpha": math.sqrt(2.0) * slope}
        )
        for zenith_in in [0.0, 25.0, 50.0, 70.0, 85.0]:
            for zenith_out in [5.0, 30.0, 55.0, 75.0, 86.0]:
                for azimuth in [180.0, 165.0, 120.0, 10.0]:
                    si = mi.SurfaceInteraction3f()
                    si.wi = direction(zenith_in, 0.0)
                    value = bsdf.eval(mi.BSDFContext(), si, direction(zenith_out, azimuth))[0]
                    per_sr = float(value) / math.cos(math.radians(zenith_out))
                    # The far wings are below the resolution of single precision.
                    if per_sr > 1e-6:
                        print(f"{slope},{zenith_in},{zenith_out},{azimuth},{per_sr:.6e}")


main()

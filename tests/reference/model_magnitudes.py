"""Computes magnitudes of bundled models in numpy, and residuals of public photometry.

Geometry is on a spherical Earth. Slingshot rows have Sun, satellite and azimuth. MMT-9 rows have time, range and phase
angle, from which the body-frame angles follow for a circular orbit at the height of the shell, except for a mirror
image, which is equivalent for the models. Pomenis rows have time, height, altitude and azimuth; their rays to the Sun
are tested with the ellipsoid. Only points whose sunlight passes at least 100 km above the ground are used, without
earthshine.

    venv/bin/pip install numpy scipy astropy
    venv/bin/python tests/reference/model_magnitudes.py DATA_FOLDER

Prints number, mean, RMS and core of the residuals of the bundled models, used by tests/fitting/model_validation.rs.
"""
import csv
import gzip
import json
import pathlib
import sys

import numpy as np
from astropy import units
from astropy.coordinates import ITRS, EarthLocation, get_sun
from astropy.time import Time
from scipy.special import erf

MODELS = pathlib.Path(__file__).parents[2] / "src/photometry/models"
M_SUN = -26.76
D2 = 1e12
EARTH_KM = 6378.137


def overlap(reach, flat, slope, height):
    """Returns the integral of clamp(reach - slope v, 0, flat) over 0..height."""
    slope = np.maximum(slope, 1e-12)
    full = np.clip((reach - flat) / slope, 0, height)
    end = np.clip(reach / slope, full, height)
    last = np.maximum(reach - slope * end, 0)
    return flat * full + 0.5 * (flat + last) * (end - full)


def basis(shape, ds, a, do):
    """Returns the geometry of the five terms: cosines times unblocked areas, and cosines of the mirror angles."""
    l_sail, w_sail, l_base, w_base = shape
    sun = np.stack([np.cos(ds), 0 * ds, np.sin(ds)])
    obs = np.stack([np.cos(do) * np.cos(a), np.cos(do) * np.sin(a), np.sin(do)])
    narrow = min(w_sail, w_base)

    def cast(d):
        on = (d[2] < 0) & (d[0] > 0)
        h = np.where(on, np.minimum(l_base * -d[2] / np.where(on, d[0], 1), l_sail), 0)
        return h, np.where(on, np.abs(d[1] / np.where(on, d[2], 1)), 0)

    hs, _ = cast(sun)
    hv, shear = cast(obs)
    view = overlap(0.5 * (w_sail + w_base), narrow, shear, hv)
    both = overlap(0.5 * (narrow + w_base), narrow, shear, np.minimum(hs, hv))
    area = l_sail * w_sail
    bf, bf_sun = (narrow * hs + view - both) / area, narrow * hs / area
    ci, co = sun[0], obs[0]
    sail = np.maximum(ci, 0) * np.maximum(co, 0) * area * (1 - bf)
    back = np.maximum(ci, 0) * np.maximum(-co, 0) * area * (1 - bf_sun)
    bi, bo = -sun[2], -obs[2]
    base = np.maximum(bi, 0) * np.maximum(bo, 0) * l_base * w_base
    dot = (sun * obs).sum(0)
    return sail, back, base, np.maximum(2 * ci * co - dot, 0), np.maximum(2 * bi * bo - dot, 0)


def columns(g, n_sail, n_base):
    sail, back, base, ms, mb = g
    return np.stack([
        (n_sail + 2) / (2 * np.pi) * ms**n_sail * sail, sail / np.pi, back / np.pi,
        (n_base + 2) / (2 * np.pi) * mb**n_base * base, base / np.pi,
    ])


def magnitude(g, p):
    b = np.asarray(p[:5]) @ columns(g, p[5], p[6])
    return -2.5 * np.log10(np.maximum(b, 1e-9) / D2) + M_SUN


def facets(weight, slope, cos_in, cos_out, dot):
    """Returns Beckmann's rough mirror, sr^-1: Walter et al. (2007), eqs. 20 and 23 to 26, alpha = sqrt(2) slope."""
    alpha = np.sqrt(2) * slope
    ci, co = np.clip(cos_in, 1e-9, 1), np.clip(cos_out, 1e-9, 1)
    tilt = np.arccos(np.clip((ci + co) / np.sqrt(2 + 2 * dot), -1, 1))
    density = np.exp(-((np.tan(tilt) / alpha) ** 2)) / (np.pi * alpha**2 * np.cos(tilt) ** 4)

    def masking(cosine):
        x = 1 / (alpha * np.tan(np.arccos(np.minimum(cosine, 1 - 1e-12))))
        return 2 / (1 + erf(x) + np.exp(-(x**2)) / (x * np.sqrt(np.pi)))

    return weight * density * masking(ci) * masking(co) / (4 * ci * co)


def law(spec, number, cos_in, cos_out, mirror, dot):
    """Returns the reflectance of one law, sr^-1."""
    of = lambda key: number(spec[key])
    lobe = lambda cosine: of("weight") * (of("exponent") + 2) / (2 * np.pi) * np.maximum(cosine, 0) ** of("exponent")
    return {
        "lambert": lambda: of("albedo") / np.pi,
        "phong": lambda: lobe(mirror),
        "straight": lambda: lobe(-dot),
        "retro": lambda: lobe(dot),
        "facets": lambda: facets(of("weight"), of("slope"), cos_in, cos_out, dot),
    }[spec["law"]]()


def panels_light(spec, ds, a, do):
    """Returns the light, m^2 / sr, of a nadir face, an optional sail that follows the Sun's azimuth, and spheres."""
    values = {p["name"]: p["value"] for p in spec["parameters"]}
    number = lambda given: values[given] if isinstance(given, str) else given
    by = {p["name"]: p for p in spec["panels"]}
    base, sail = by.pop("base"), by.pop("sail", None)
    assert not by and base["attitude"] == {"law": "nadir"} and not base["back"] and not base["through"]
    length = lambda panel, side: panel[side][1] - panel[side][0]
    if sail:
        assert sail["attitude"] == {"law": "sun_azimuth", "offset_deg": 0} and not sail["back"]
        assert spec["blocking"] == [{"panel": "sail", "by": "base"}]
    shape = [length(panel, side) for panel in (sail or base, base) for side in ("v_m", "u_m")]
    front, back, below, mirror_sail, mirror_base = basis(shape, ds, a, do)
    dot = np.cos(ds) * np.cos(do) * np.cos(a) + np.sin(ds) * np.sin(do)
    below_laws = [law(one, number, -np.sin(ds), -np.sin(do), mirror_base, dot) for one in base["front"]]
    light = sum(below_laws) * below
    if sail:
        ci, co = np.cos(ds), np.cos(do) * np.cos(a)
        for laws, open_m2 in ((sail["front"], front), (sail["through"], back)):
            light = light + sum((law(one, number, ci, np.abs(co), mirror_sail, dot) for one in laws), 0.0) * open_m2
    phase = np.arccos(np.clip(dot, -1, 1))
    for sphere in spec["spheres"]:
        per_m2 = {"isotropic": 1 / (4 * np.pi), "lambert": 2 / (3 * np.pi**2) * (np.sin(phase) + (np.pi - phase) * np.cos(phase))}
        light = light + number(sphere["albedo"]) * sphere["area_m2"] * per_m2[sphere["phase"]]
    return light


def bundled_magnitude(name, ds, a, do):
    """Returns the magnitude of a bundled model; NaN where no lit surface is visible."""
    m = json.load(open(MODELS / f"{name}.json"))
    if "mean_mag" in m:
        return np.full_like(ds, m["mean_mag"])
    if "phase_function" in m:
        f = m["phase_function"]
        phase = np.degrees(np.arccos(np.clip(np.cos(ds) * np.cos(do) * np.cos(a) + np.sin(ds) * np.sin(do), -1, 1)))
        return np.polyval(f["coefficients"][::-1], np.clip(phase, f["min_phase_deg"], f["max_phase_deg"]))
    if m["kind"] == "two_panel":
        c, s = m["coefficients"], m["shape"]
        g = basis([s[k] for k in ("sail_length_m", "sail_width_m", "base_length_m", "base_width_m")], ds, a, do)
        light = np.asarray([c[f"c{k}"] for k in range(1, 6)]) @ columns(g, c["n_sail"], c["n_base"])
    else:
        light = panels_light(m["panels"], ds, a, do)
    return np.where(light > 1e-9, -2.5 * np.log10(np.maximum(light, 1e-9) / D2) + M_SUN, np.nan)


def sunlit(radius_km, ds):
    """Returns whether the ray to the Sun (lowest point R cos d_sun) passes at least 100 km above a spherical Earth."""
    return (ds >= 0) | (radius_km * np.cos(ds) - EARTH_KM >= 100)


def between(s, o, z):
    """Returns the Sun's latitude and the observer's longitude and latitude, from unit vectors to these and zenith."""
    ds, do = np.arcsin((s * z).sum(0)), np.arcsin((o * z).sum(0))
    return ds, np.arccos(np.clip(((s * o).sum(0) - np.sin(ds) * np.sin(do)) / np.cos(ds) / np.cos(do), -1, 1)), do


def slingshot(data):
    rows = list(csv.DictReader(open(f"{data}/photometry/slingshot_v2/Observations_in_field.csv")))
    col = lambda k: np.array([float(r[k]) for r in rows])
    sun, alt, h, m, az = np.radians(col("sun altitude")), np.radians(col("sat altitude")), col("sat height") / 1e3, col("measured_ab"), np.radians(col("az diff"))
    site = np.array([6371.0, 0, 0])[:, None]
    sight = np.stack([np.sin(alt), np.cos(alt) * np.cos(az), np.cos(alt) * np.sin(az)])
    d = -site[0] * sight[0] + np.sqrt((site[0] * sight[0]) ** 2 + (6371 + h) ** 2 - 6371**2)
    sat = site + d * sight
    s = np.stack([np.sin(sun), np.cos(sun), 0 * sun])
    z = sat / np.linalg.norm(sat, axis=0)
    ds, a, do = between(s, -sight, z)
    keep = sunlit(6371 + h, ds)
    return tuple(x[keep] for x in (m - 5 * np.log10(d / 1000), ds, a, do))


def pomenis(data):
    rows = list(csv.DictReader(x for x in open(f"{data}/photometry/pomenis/pomenis_observations.csv") if x.strip() and x[0] != "#"))
    col = lambda k: np.array([float(r[k]) for r in rows])
    m, h = col("ab_magnitude"), col("satellite_height")
    alt, az = np.radians(col("satellite_altitude")), np.radians(col("satellite_azimuth"))
    t = Time([r["observation_time"] for r in rows])
    place = EarthLocation.from_geodetic(-110.7881, 32.4434, 2790)
    site = np.array([x.to_value("km") for x in place.geocentric])[:, None]
    lon, lat = np.radians([-110.7881, 32.4434])
    east, north = np.array([-np.sin(lon), np.cos(lon), 0]), np.array([-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)])
    sight = np.outer(east, np.cos(alt) * np.sin(az)) + np.outer(north, np.cos(alt) * np.cos(az)) + np.outer(np.cross(east, north), np.sin(alt))
    rise, near = (site * sight).sum(0), np.linalg.norm(site)
    d = -rise + np.sqrt(rise**2 + (near + h) ** 2 - near**2)
    # Heights are converted from the sphere to the ellipsoid, to which the recorded heights refer.
    height = lambda xyz: EarthLocation.from_geocentric(*xyz, unit=units.km).height.to_value("km")
    for _ in range(5):
        sat = site + d * sight
        d = d + (h - height(sat)) / ((sat * sight).sum(0) / np.linalg.norm(sat, axis=0))
    sat = site + d * sight
    s = get_sun(t).transform_to(ITRS(obstime=t)).cartesian.xyz.to_value("km") - sat
    s /= np.linalg.norm(s, axis=0)
    # Lowest geodetic height of the ray, within 300 km of the point nearest to the Earth's centre.
    way = -(sat * s).sum(0) + np.linspace(-300, 300, 121)[:, None]
    ray = sat[:, None] + s[:, None] * way
    lowest = height(ray).min(0)
    ds, a, do = between(s, -sight, sat / np.linalg.norm(sat, axis=0))
    keep = ((sat * s).sum(0) >= 0) | (lowest >= 100)
    return tuple(x[keep] for x in (m - 5 * np.log10(d / 1000), ds, a, do))


def mmt(data, file, radius_km):
    rows = [r for r in csv.DictReader(gzip.open(f"{data}/derived/{file}", "rt")) if r["Filter"] == "Clear" and r["Penumbra"] == "0"]
    col = lambda k: np.array([float(r[k]) for r in rows])
    t = Time([r["Date"] for r in rows])
    site = EarthLocation.from_geodetic(41.431472, 43.649861, 2030)
    rho = site.get_gcrs(t).cartesian.xyz.to_value("km")
    s = get_sun(t).cartesian.xyz
    s = (s / np.linalg.norm(s, axis=0)).value
    d, phi, mag = col("Distance"), np.radians(col("Phase")), col("Mag")
    # sin d_obs = -(R^2 + d^2 - rho^2)/(2 R d), sin d_sun = (rho . s - d cos phi)/R
    sin_o = -(radius_km**2 + d**2 - (rho**2).sum(0)) / (2 * radius_km * d)
    sin_s = ((rho * s).sum(0) - d * np.cos(phi)) / radius_km
    do, ds = np.arcsin(np.clip(sin_o, -1, 1)), np.arcsin(np.clip(sin_s, -1, 1))
    cos_a = (np.cos(phi) - np.sin(ds) * np.sin(do)) / (np.cos(ds) * np.cos(do))
    keep = (np.abs(cos_a) < 1.05) & (do > np.radians(-85)) & (np.abs(sin_o) < 1) & sunlit(radius_km, ds)
    a = np.arccos(np.clip(cos_a, -1, 1))
    return tuple(x[keep] for x in (mag - 5 * np.log10(d / 1000), ds, a, do))


def residuals(name, m, ds, a, do):
    """Returns measured minus computed magnitudes of a bundled model."""
    r = m - bundled_magnitude(name, ds, a, do)
    r = r[np.isfinite(r)]
    core = 1.4826 * np.median(np.abs(r - np.median(r)))
    print(f"{name}: n {len(r)} mean {r.mean():+.3f} rms {np.sqrt(np.mean(r**2)):.3f} core {core:.3f}")


if __name__ == "__main__":
    data = sys.argv[1]
    for name in ("starlink-v1.5", "starlink-v1.5-facets", "starlink-v1.5-phase"):
        residuals(name, *pomenis(data))
    for name in ("v2mini-panels", "v2mini"):
        residuals(name, *slingshot(data))
    for names, file, height_km in (
        (("visorsat-panels", "visorsat"), "mmt9_starlink_visorsat.csv.gz", 540),
        (("oneweb-panels", "oneweb"), "mmt9_oneweb.csv.gz", 1200),
        (("iridium-next",), "mmt9_iridium2.csv.gz", 780),
    ):
        for name in names:
            residuals(name, *mmt(data, file, EARTH_KM + height_km))

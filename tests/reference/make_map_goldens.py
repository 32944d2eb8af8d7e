"""Writes golden data of sky maps: intersection of lines of sight with a sphere, illumination and brightness.

Independent of the library: site and horizon are computed by astropy (ERFA), intersections by numpy's roots of the
quadratic, body angles by the arccos formulas of Lu (2024), eqs. 9-12, the lit fraction by 4000 rays to the disk of the
Sun past the sphere or ellipsoid, and the light by the numpy model of make_photometry_goldens.py.

    python3 -m venv venv && venv/bin/pip install numpy shapely astropy
    venv/bin/python tests/reference/make_map_goldens.py > tests/data/map_goldens.csv
"""
import astropy
import astropy.units as u
import numpy as np
from astropy.coordinates import EarthLocation

from make_photometry_goldens import M_SUN, model

A, F = 6378.137, 1 / 298.257223563
AU, SUN = 149597870.7, 695700.0
SHAPE = (8.1, 2.8, 1.3, 2.8)
COEFFICIENTS = (0.05, 0.0279, 0.0053, 0.1097, 0.0844, 5.0, 22.0)


def lit(satellite, sun, flattening):
    """Returns the fraction of sunlight that passes the Earth, by rays; limb darkening P5(mu), Neckel (2005), 550 nm."""
    to = sun - satellite
    axis = to / np.linalg.norm(to)
    side = np.cross(axis, [0, 0, 1.0])
    side /= np.linalg.norm(side)
    up = np.cross(axis, side)
    n = 4000
    k = np.arange(n) + 0.5
    r, t = SUN * np.sqrt(k / n), np.pi * (1 + 5**0.5) * k  # sunflower pattern: equal areas
    rays = to + np.outer(r * np.cos(t), side) + np.outer(r * np.sin(t), up)
    stretch = np.array([1, 1, 1 / (1 - flattening)])
    p, d = satellite * stretch, rays * stretch
    a, b, c = (d * d).sum(1), 2 * d @ p, p @ p - A * A
    hit = (b * b - 4 * a * c > 0) & (b < 0)
    mu = np.sqrt(1 - k / n)
    light = np.polynomial.polynomial.polyval(mu, [0.26980, 1.34025, -1.64288, 2.08224, -1.47353, 0.42412])
    return 1 - light[hit].sum() / light.sum()


def main():
    rng = np.random.default_rng(20261121)
    print(f"# directions of a site's sky: range, lit fraction, V (Vega); numpy {np.__version__}, astropy {astropy.__version__}; "
          "tests/reference/make_map_goldens.py; 2026-11-21")
    print("# two panels " + " ".join(map(str, SHAPE)) + " m, coefficients c1..c5 n_sail n_base " +
          " ".join(map(str, COEFFICIENTS)) + "; empty site: sphere of 6378.137 km")
    print("latitude_deg,longitude_deg,site_height_m,height_km,sun_azimuth_deg,sun_altitude_deg,azimuth_deg,altitude_deg,"
          "range_km,lit_fraction,magnitude")
    for i in range(300):
        height = float(rng.choice([340.0, 550.0, 1200.0, rng.uniform(200, 2000)]))
        sun_az, sun_alt = rng.uniform(0, 360), rng.uniform(-45, 5)
        az, alt = rng.uniform(0, 360), np.degrees(np.arcsin(rng.uniform(0, 1)))
        if i % 2:
            lat, lon, site_m = rng.uniform(-89, 89), rng.uniform(-180, 180), rng.uniform(0, 5000)
            observer = EarthLocation.from_geodetic(lon, lat, site_m * u.m)
            observer = np.array([q.to_value(u.km) for q in (observer.x, observer.y, observer.z)])
            site, flattening = [lat, lon, site_m], F
        else:
            lat, lon, site, flattening = 0.0, 0.0, ["", "", ""], 0.0
            observer = np.array([A, 0, 0])
        p, q = np.radians(lat), np.radians(lon)
        zenith = np.array([np.cos(p) * np.cos(q), np.cos(p) * np.sin(q), np.sin(p)])
        east = np.array([-np.sin(q), np.cos(q), 0])
        north = np.cross(zenith, east)

        def towards(azimuth, altitude):
            z, h = np.radians(azimuth), np.radians(altitude)
            return np.cos(h) * np.cos(z) * north + np.cos(h) * np.sin(z) * east + np.sin(h) * zenith

        sight = towards(az, alt)
        roots = np.roots([1.0, 2 * observer @ sight, observer @ observer - (A + height) ** 2])
        distance = max(roots.real)
        satellite, sun = observer + distance * sight, AU * towards(sun_az, sun_alt)
        fraction = lit(satellite, sun, flattening)
        # Lu (2024), eqs. 9-12
        up = satellite / np.linalg.norm(satellite)
        s = (sun - satellite) / np.linalg.norm(sun - satellite)
        o = (observer - satellite) / np.linalg.norm(observer - satellite)
        ds, do = np.pi / 2 - np.arccos(up @ s), np.pi / 2 - np.arccos(up @ o)
        us, uo = np.cross(up, s), np.cross(up, o)
        alpha = np.arccos(np.clip(us @ uo / np.linalg.norm(us) / np.linalg.norm(uo), -1, 1))
        alpha = alpha if np.cross(s, o) @ up >= 0 else 2 * np.pi - alpha
        _, _, terms, standard = model(SHAPE, 0.0, COEFFICIENTS, ds, alpha, do)
        magnitude = ""
        if standard is not None and fraction > 0 and sum(terms) > 1e-12:
            magnitude = repr(float(standard + 5 * np.log10(distance / 1000) - 2.5 * np.log10(fraction)))
        row = [*site, height, sun_az, sun_alt, az, alt, float(distance), float(fraction)]
        print(",".join("" if x == "" else repr(float(x)) for x in row) + "," + magnitude)


if __name__ == "__main__":
    main()

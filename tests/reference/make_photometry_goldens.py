"""Writes golden data of the two-panel model: terms by numpy, blocking by exact unions of polygons (shapely, GEOS).

Independent of the library: the corners of the chassis are projected along the light onto the plane of the sail (the
library projects from the sail to the chassis), and blocked areas are unions of polygons (the library integrates lengths
of intervals).

    python3 -m venv venv && venv/bin/pip install numpy shapely
    venv/bin/python tests/reference/make_photometry_goldens.py > tests/data/photometry_goldens.csv
"""
import numpy as np
import shapely
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

M_SUN = -26.76
RANGE_M = 1e6


def unit(longitude, latitude):
    return np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])


def stopped(direction, normal, up, l_base, w_base, sail):
    """Returns the polygon on the sail (u, v) from which rays towards `direction` hit the chassis."""
    facing = normal @ direction
    if direction[2] >= 0 or facing <= 0:
        return Polygon()
    corners = []
    for x, y in ((0, -w_base / 2), (0, w_base / 2), (l_base, w_base / 2), (l_base, -w_base / 2)):
        q = np.array([x, y, 0.0])
        p = q - (normal @ q) / facing * direction  # projected onto the plane of the sail, away from the light
        corners.append((p[1], p @ up))
    return Polygon(corners).intersection(sail)


def model(shape, poa, c, ds, a, do):
    l_sail, w_sail, l_base, w_base = shape
    c1, c2, c3, c4, c5, n_sail, n_base = c
    sun, obs = unit(0.0, ds), unit(a, do)
    normal, up = np.array([np.cos(poa), 0, np.sin(poa)]), np.array([-np.sin(poa), 0, np.cos(poa)])
    sail = box(-w_sail / 2, 0, w_sail / 2, l_sail)
    shade = stopped(sun, normal, up, l_base, w_base, sail)
    view = stopped(obs, normal, up, l_base, w_base, sail)
    bf = unary_union([shade, view]).area / sail.area
    bf_sun = shade.area / sail.area

    def lobe(n, face):
        mirror = 2 * (face @ sun) * face - sun
        return max(mirror @ obs, 0.0) ** n * (n + 2) / (2 * np.pi)

    def front(face):
        return max(face @ sun, 0) * max(face @ obs, 0)

    base = np.array([0, 0, -1.0])
    area_sail, area_base = l_sail * w_sail, l_base * w_base
    terms = [
        c1 * lobe(n_sail, normal) * front(normal) * area_sail * (1 - bf),
        c2 / np.pi * front(normal) * area_sail * (1 - bf),
        c3 / np.pi * max(normal @ sun, 0) * max(-(normal @ obs), 0) * area_sail * (1 - bf_sun),
        c4 * lobe(n_base, base) * front(base) * area_base,
        c5 / np.pi * front(base) * area_base,
    ]
    total = sum(terms)
    magnitude = -2.5 * np.log10(total / RANGE_M**2) + M_SUN if total > 0 else None
    return bf, bf_sun, terms, magnitude


def main():
    rng = np.random.default_rng(20240310)
    print(f"# five-term model of Lu (2024), eq. 17 mended; numpy {np.__version__}, shapely {shapely.__version__} "
          f"(GEOS {shapely.geos_version_string}); tests/reference/make_photometry_goldens.py; 2026-11-21")
    print("# lengths m, angles rad, terms m2/sr, magnitude V Vega at 1000 km (empty: nothing seen)")
    print("sail_length_m,sail_width_m,base_length_m,base_width_m,panel_offset_rad,c1,c2,c3,c4,c5,n_sail,n_base,"
          "sun_latitude_rad,observer_longitude_rad,observer_latitude_rad,bf,bf_sun,"
          "sail_glossy,sail_diffuse,sail_back,base_glossy,base_diffuse,standard_magnitude")
    paper = (8.1, 2.8, 1.3, 2.8)
    shipped = (0.0, 0.0279, 0.0053, 0.1097, 0.0844, 5.0, 22.0)
    for i in range(600):
        # A third each: the bundled model in its range, the shape of the paper with other offsets, any shape and
        # direction.
        if i < 200:
            shape, poa, c = paper, 0.0, shipped
        elif i < 400:
            shape, poa = paper, np.radians(rng.choice([-3.0, 5.0, 0.0, -12.0, 25.0]))
            c = (*rng.uniform(0, 0.5, 5), rng.uniform(0.5, 60), rng.uniform(0.5, 200))
        else:
            shape = tuple(rng.uniform(0.5, 15, 4))
            poa = np.radians(rng.uniform(-50, 50))
            c = (*rng.uniform(0, 0.5, 5), rng.uniform(0, 60), rng.uniform(0, 200))
        if i < 400:
            ds, do = np.radians(rng.uniform(-25, 2)), np.radians(rng.uniform(-90, -20))
        else:
            ds, do = np.radians(rng.uniform(-80, 80)), np.arcsin(rng.uniform(-1, 1))
        # Half of the observers are in front of the sail, where most of it is hidden.
        a = rng.uniform(0, 2 * np.pi) if i % 2 else rng.uniform(-1.5, 1.5) % (2 * np.pi)
        bf, bf_sun, terms, magnitude = model(shape, poa, c, ds, a, do)
        row = [*shape, poa, *c, ds, a, do, bf, bf_sun, *terms]
        print(",".join(repr(float(x)) for x in row) + "," + ("" if magnitude is None else repr(float(magnitude))))


if __name__ == "__main__":
    main()

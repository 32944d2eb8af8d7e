"""Makes tests/data/atmosphere_golden.csv: fraction of sunlight at satellites behind the atmosphere, by traced rays.

Usage:
    python tests/reference/make_atmosphere_goldens.py tests/data/atmosphere_golden.csv

Independent of src/geometry/shadow in method: each ray from the satellite is traced step by step with the equation of a
ray, d/ds (n dr/ds) = grad n (Runge-Kutta of fourth order, steps of 2 km), with the optical depth summed along it. The
light is the sum over the solid angle of the image that the satellite sees: the surface brightness of the Sun is the
same along a ray except for extinction, so no formula for spreading or focusing is needed. The pressure of the air is
integrated through the layers of the standard atmosphere, and the density follows from the gas law.

The constants are those of the sources named in src/geometry/shadow/atmosphere.rs and penumbra.rs: they are the model, which
this script does not test. The Earth is a sphere of 6378.137 km, the Sun a sphere of 695700 km at 1 au.

Python 3 without packages; takes some minutes.
"""

import math
import sys

GROUND = 6378.137
SUN, AU = 695_700.0, 149_597_870.7
TOP = 130.0
REFRACTIVITY = 2.7784e-4
LAPSE = [(0.0, -6.5), (11.0, 0.0), (20.0, 1.0), (32.0, 2.8), (47.0, 0.0), (51.0, -2.8), (71.0, -2.0), (84.852, 0.0)]
DARKENING = [0.26980, 1.34025, -1.64288, 2.08224, -1.47353, 0.42412]


def air():
    """Density relative to the ground in steps of 10 m of geopotential height, from the hydrostatic equation."""
    step, temperature, pressure, out, layer = 0.01, 288.15, 1.0, [], 0
    while len(out) * step < TOP:
        height = len(out) * step
        if layer + 1 < len(LAPSE) and height >= LAPSE[layer + 1][0] - 1e-9:
            layer += 1
        out.append(pressure / temperature * 288.15)
        middle = temperature + 0.5 * step * LAPSE[layer][1]
        temperature += step * LAPSE[layer][1]
        pressure *= math.exp(-34.163195 / middle * step)
    return out


AIR = air()


def density(height):
    place = height * 6356.766 / (6356.766 + height) / 0.01
    below = int(place)
    if below + 1 >= len(AIR):
        return 0.0
    a, b = AIR[below], AIR[below + 1]
    return a * (b / a) ** (place - below)


def extinction(height, rho):
    def layer(total, centre, width):
        e = math.exp((height - centre) / width)
        return total * (1 + math.exp(-centre / width)) * e / (width * (1 + e) ** 2)

    return (
        0.0973 * rho / 8.4345
        + layer(0.0266, 20.0, 5.0)
        + layer(0.0057, 18.0, 3.0)
        + 0.13 * math.exp(-height / 2.0) / 2.0
    )


def trace(impact):
    """Bending (radians) and optical depth of a ray from infinity; None if it hits the ground."""
    edge = GROUND + TOP
    x, y = -math.sqrt(edge * edge - impact * impact), impact
    vx, vy = 1.0, 0.0
    depth, step = 0.0, 2.0

    def slope(x, y, tx, ty):
        r = math.hypot(x, y)
        h = r - GROUND
        if h < 0:
            return None
        rho = density(h)
        change = (density(h + 0.02) - density(max(h - 0.02, 0.0))) / (0.02 + min(h, 0.02))
        n, pull = 1 + REFRACTIVITY * rho, REFRACTIVITY * change / r
        return tx / n, ty / n, pull * x, pull * y, extinction(h, rho)

    while math.hypot(x, y) <= edge + 1e-9:
        k1 = slope(x, y, vx, vy)
        k2 = k1 and slope(x + step / 2 * k1[0], y + step / 2 * k1[1], vx + step / 2 * k1[2], vy + step / 2 * k1[3])
        k3 = k2 and slope(x + step / 2 * k2[0], y + step / 2 * k2[1], vx + step / 2 * k2[2], vy + step / 2 * k2[3])
        k4 = k3 and slope(x + step * k3[0], y + step * k3[1], vx + step * k3[2], vy + step * k3[3])
        if not k4:
            return None
        dx, dy, dvx, dvy, dd = (step / 6 * (a + 2 * b + 2 * c + d) for a, b, c, d in zip(k1, k2, k3, k4))
        x, y, vx, vy, depth = x + dx, y + dy, vx + dvx, vy + dvy, depth + dd
    return -math.atan2(vy, vx), depth


def brightness(r):
    mu = math.sqrt(max(0.0, 1 - r * r))
    return sum(a * mu**k for k, a in enumerate(DARKENING))


DP = 0.1


def rays():
    """Bending and transmission for impact parameters GROUND + k DP; the first that misses the ground begins."""
    out = []
    for k in range(int(TOP / DP)):
        found = trace(GROUND + k * DP)
        out.append(found and (found[0], math.exp(-found[1])))
    return out


def lit(table, radius, separation, sun_rad):
    """Sum over the image, in rings about the Earth's centre of a fiftieth of the Sun's radius or 20 m of height."""

    def ray(arrival):
        place = (radius * math.sin(arrival) - GROUND) / DP
        if place >= len(table) - 1:
            return 0.0, 1.0
        below = math.floor(place)
        if below < 0 or table[below] is None:
            return None
        (b0, t0), (b1, t1) = table[below], table[below + 1]
        share = place - below
        return b0 + share * (b1 - b0), t0 + share * (t1 - t0)

    total = 2 * math.pi * sum(brightness((k + 0.5) / 2000) * (k + 0.5) / 2000**2 for k in range(2000)) * sun_rad**2
    low = math.asin(GROUND / radius)
    high = max(min(separation + 1.05 * sun_rad, math.pi / 2), math.asin((GROUND + TOP) / radius))
    step = min(sun_rad / 50, 0.02 / math.sqrt(radius**2 - GROUND**2))
    light, arrival = 0.0, low + step / 2
    while arrival < high:
        found = ray(arrival)
        if found:
            origin = arrival - found[0]
            # cos d = cos θ cos σ + sin θ sin σ cos φ: the ring is on the Sun for |φ| < edge.
            cosine = (math.cos(sun_rad) - math.cos(origin) * math.cos(separation)) / (
                math.sin(origin) * math.sin(separation)
            )
            if cosine < 1:
                edge = math.acos(max(-1.0, cosine))
                for k in range(24):
                    turn = edge * math.sin(math.pi / 2 * (k + 0.5) / 24)
                    weight = edge * math.cos(math.pi / 2 * (k + 0.5) / 24) * math.pi / 2 / 24
                    d = math.acos(
                        min(
                            1.0,
                            math.cos(origin) * math.cos(separation)
                            + math.sin(origin) * math.sin(separation) * math.cos(turn),
                        )
                    )
                    light += 2 * weight * brightness(d / sun_rad) * found[1] * math.sin(arrival) * step
        arrival += step
    return light / total


def main(path):
    table = rays()
    with open(path, "w", encoding="utf-8") as out:
        out.write("# rays traced through the standard atmosphere; python tests/reference/make_atmosphere_goldens.py; 2026-11-25\n")
        out.write("radius_km,height_km,lit_fraction\n")
        for radius in (6578.0, 6928.0, 7578.0, 26_560.0, 42_164.0):
            reach = math.sqrt(radius**2 - GROUND**2)
            for place in (-8.0, 0.0, 10.0, 20.0, 27.0, 35.0, 45.0, 60.0, 80.0):
                # Height of the line to the Sun's centre; the disk is wider seen from afar.
                height = place if radius < 10_000 else 27.0 + (place - 27.0) * 0.00465 * reach / 20.0
                angle = math.asin((GROUND + height) / radius)
                # At the satellite, Earth's centre to Sun: the angle at the Sun is (r sin) / au.
                x, y = -radius * math.cos(angle), radius * math.sin(angle)
                to_sun = (AU - x, -y)
                distance = math.hypot(*to_sun)
                separation = math.acos(-(x * to_sun[0] + y * to_sun[1]) / (radius * distance))
                fraction = lit(table, radius, separation, math.asin(SUN / distance))
                out.write(f"{radius:.0f},{height:.4f},{fraction:.6f}\n")
                print(radius, height, fraction, flush=True)


if __name__ == "__main__":
    main(sys.argv[1])

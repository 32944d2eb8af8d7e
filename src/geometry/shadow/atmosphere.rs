//! Refraction, spreading, scattering and absorption of sunlight that grazes the Earth.
//!
//! For a ray whose lowest point is h above the ground, the bending angle β(h) and the optical depth τ(h) in V are
//! integrated once along the bent ray, and tabulated in steps of 1 km. The atmosphere has these components:
//!
//! - density: seven layers, 1.225 kg/m³ at the ground (U.S. Standard Atmosphere 1976)
//! - refractivity at the ground at 550 nm: 2.7784·10⁻⁴ at 288.15 K, 1013.25 hPa (Ciddor 1996, Applied Optics 35, 1566)
//! - Rayleigh scattering, vertical: τ = 0.008569 λ⁻⁴ (1 + 0.0113 λ⁻² + 0.00013 λ⁻⁴), λ in µm: 0.0973 at 550 nm (Hansen
//!   & Travis 1974, Space Sci. Rev. 16, 527, eq. 2.30)
//! - ozone column above h: 0.30 cm · (1 + e^(-20/5)) / (1 + e^((h-20)/5)) (form of Lacis & Hansen 1974, J. Atmos. Sci.
//!   31, 118, eq. 17; 300 Dobson units are assumed)
//! - ozone absorption: cross section 3.3·10⁻²¹ cm² at 550 nm and 233 K, times 300 · 2.687·10¹⁶ cm⁻²: τ = 0.0266
//!   vertical (Serdyuchenko et al. 2014, Atmos. Meas. Tech. 7, 625; bins of 10 nm in Bruneton 2017, Precomputed
//!   Atmospheric Scattering: 3.09 below and 3.50 above 550 nm)
//! - tropospheric aerosol: τ = 0.13 vertical (Remer et al. 2008, J. Geophys. Res. 113, D14S07, abstract: MODIS Aqua,
//!   mean over oceans; 0.19 over land); scale height 2 km (assumed; rays this low carry hardly any light in any case)
//! - stratospheric aerosol: τ = 0.0057 vertical: the mean of 2006-2015, 0.008, without the 40 % that eruptions had
//!   added to the background (Friberg et al. 2018, Atmos. Chem. Phys. 18, 11149, abstract); logistic layer centred at
//!   18 km, 3 km wide (assumed)
//!
//! Neglected effects: clouds, which block most of the light below some 8 km (where a thousandth of the Sun's light is
//! left); the dependence on wavelength within V; volcanic years, which raise the height of half light by several
//! kilometres; weather, season and latitude, which shift this height by one or two kilometres; and light that the
//! twilight sky scatters into the satellite's shadow.

use std::sync::LazyLock;

use super::penumbra::strip;
use crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
use crate::math::quadrature::gauss_legendre;

/// Height above which bending and dimming are below 10⁻⁵, km.
pub(super) const TOP_KM: f64 = 100.0;
/// Height of the line from the satellite to the lower limb of the Sun above which more than 99 % of the Sun's light
/// arrives, km: 46 km for a satellite at 200 km, less for higher ones.
pub(super) const CLEAR_KM: f64 = 50.0;
/// Distance from the Earth's centre beyond which the shadow is no longer wide compared with the Sun, so that rays from
/// all sides of the Earth overlap; km.
pub(super) const FARTHEST_KM: f64 = 400_000.0;

const REFRACTIVITY: f64 = 2.7784e-4;
const RAYLEIGH_VERTICAL: f64 = 0.0973;
const OZONE_VERTICAL: f64 = 0.0266;
const AEROSOL_VERTICAL: f64 = 0.13;
const AEROSOL_HEIGHT_KM: f64 = 2.0;
const STRATOSPHERE_VERTICAL: f64 = 0.0057;

/// Layers of the U.S. Standard Atmosphere: lower boundary (geopotential km), temperature there (K), its gradient
/// (K/km).
const LAYERS: [(f64, f64, f64); 8] = [
    (0.0, 288.15, -6.5),
    (11.0, 216.65, 0.0),
    (20.0, 216.65, 1.0),
    (32.0, 228.65, 2.8),
    (47.0, 270.65, 0.0),
    (51.0, 270.65, -2.8),
    (71.0, 214.65, -2.0),
    (84.852, 186.946, 0.0),
];
/// The constant g₀ M / R of the standard atmosphere, K/km.
const HYDROSTATIC_K_KM: f64 = 34.163_195;
/// The Earth's radius in the standard atmosphere, km.
const STANDARD_RADIUS_KM: f64 = 6356.766;
/// Column of air above the ground as a length of air at ground density, km: p₀ / (g₀ ρ₀).
const COLUMN_KM: f64 = 8.434_5;

/// Density at the bottom of each layer, relative to the density at the ground.
static LAYER_DENSITY: LazyLock<[f64; 8]> = LazyLock::new(|| {
    let mut densities = [1.0; 8];
    for layer in 1..8 {
        densities[layer] = densities[layer - 1] * relative_density(layer - 1, LAYERS[layer].0);
    }
    densities
});

/// Density at a geopotential height (km) within a layer, relative to the density at the bottom of the layer.
fn relative_density(layer: usize, geopotential_km: f64) -> f64 {
    let (base_km, base_k, gradient) = LAYERS[layer];
    let above_km = geopotential_km - base_km;
    if gradient == 0.0 {
        (-HYDROSTATIC_K_KM * above_km / base_k).exp()
    } else {
        // ρ/ρ_b = (T/T_b)^-(1 + g₀M/(R L))
        (1.0 + gradient * above_km / base_k).powf(-1.0 - HYDROSTATIC_K_KM / gradient)
    }
}

/// Returns the density relative to that at the ground, and its derivative per km of height.
fn density(height_km: f64) -> (f64, f64) {
    let scale = STANDARD_RADIUS_KM / (STANDARD_RADIUS_KM + height_km);
    let geopotential_km = height_km * scale;
    let layer = LAYERS.iter().rposition(|(base_km, ..)| geopotential_km >= *base_km).unwrap_or(0);
    let (base_km, base_k, gradient) = LAYERS[layer];
    let temperature_k = base_k + gradient * (geopotential_km - base_km);
    let density = LAYER_DENSITY[layer] * relative_density(layer, geopotential_km);
    (density, -density * (HYDROSTATIC_K_KM + gradient) / temperature_k * scale * scale)
}

/// Returns the extinction coefficient in V, per km.
fn extinction_km(height_km: f64, density: f64) -> f64 {
    let logistic = |centre_km: f64, width_km: f64| {
        let e = ((height_km - centre_km) / width_km).exp();
        (1.0 + (-centre_km / width_km).exp()) * e / (width_km * (1.0 + e).powi(2))
    };
    RAYLEIGH_VERTICAL * density / COLUMN_KM
        + OZONE_VERTICAL * logistic(20.0, 5.0)
        + STRATOSPHERE_VERTICAL * logistic(18.0, 3.0)
        + AEROSOL_VERTICAL * (-height_km / AEROSOL_HEIGHT_KM).exp() / AEROSOL_HEIGHT_KM
}

/// Returns the bending (radians) and the optical depth of the ray whose lowest point has this height (km).
///
/// β = -2 p ∫ (dn/dr)/n dr / √(n²r² - p²),  τ = 2 ∫ k n r dr / √(n²r² - p²),  p = n(r₀) r₀;
/// the substitution r = r₀ + s² removes the root at r₀.
fn ray(height_km: f64) -> (f64, f64) {
    const STEPS: usize = 150;
    let radius = EARTH_EQUATORIAL_RADIUS_KM;
    let index = |density: f64| 1.0 + REFRACTIVITY * density;
    let lowest = radius + height_km;
    let p = index(density(height_km).0) * lowest;
    let longest = (TOP_KM + 30.0 - height_km).sqrt();
    let (mut bending, mut depth) = (0.0, 0.0);
    for step in 0..STEPS {
        let s = longest * (step as f64 + 0.5) / STEPS as f64;
        let z = height_km + s * s;
        let (density, change) = density(z);
        let (n, r) = (index(density), radius + z);
        let root = ((n * r - p) * (n * r + p)).sqrt();
        let dr = 2.0 * s * longest / STEPS as f64;
        bending -= 2.0 * p * REFRACTIVITY * change / n * dr / root;
        depth += 2.0 * extinction_km(z, density) * n * r * dr / root;
    }
    (bending, depth)
}

/// Logarithms of bending and optical depth at heights of 0, 1, ... km up to 100 km, and at two more nodes above for the
/// interpolation.
static TABLE: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    (0..=TOP_KM as usize + 2)
        .map(|height_km| {
            let (bending, depth) = ray(height_km as f64);
            [bending.ln(), depth.ln()]
        })
        .collect()
});

/// Returns the bending (radians) and the optical depth in V of a ray whose lowest point is 0 to 100 km high, by cubic
/// interpolation.
fn bending_and_depth(height_km: f64) -> (f64, f64) {
    let table = &*TABLE;
    let first = ((height_km - 1.0).max(0.0) as usize).min(table.len() - 4);
    let a = height_km - first as f64;
    let (b, c, d) = (a - 1.0, a - 2.0, a - 3.0);
    let weights = [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0];
    let sum = |column: usize| -> f64 { (0..4).map(|node| weights[node] * table[first + node][column]).sum() };
    (sum(0).exp(), sum(1).exp())
}

/// Ray past the Earth, as seen by satellites.
#[derive(Copy, Clone)]
struct Ray {
    /// Distance of the straight part of the ray from the Earth's centre, km: p = n(r₀) r₀.
    impact_km: f64,
    /// Its change with the lowest height, dp/dh.
    impact_per_km: f64,
    bending_rad: f64,
    /// Fraction of the light in V that is neither scattered nor absorbed.
    transmission: f64,
}

/// Step of [`RAYS`], km. The linear interpolation is accurate to 3·10⁻⁶ of the Sun's light.
const RAY_STEP_KM: f64 = 0.05;

/// Rays with lowest heights from 0 to 100 km.
static RAYS: LazyLock<Vec<Ray>> = LazyLock::new(|| {
    (0..=(TOP_KM / RAY_STEP_KM) as usize)
        .map(|step| {
            let height_km = step as f64 * RAY_STEP_KM;
            let ((density, change), lowest_km) = (density(height_km), EARTH_EQUATORIAL_RADIUS_KM + height_km);
            let (bending_rad, depth) = bending_and_depth(height_km);
            Ray {
                impact_km: (1.0 + REFRACTIVITY * density) * lowest_km,
                // dp/dh = n + (R + h) dn/dh
                impact_per_km: 1.0 + REFRACTIVITY * (density + lowest_km * change),
                bending_rad,
                transmission: (-depth).exp(),
            }
        })
        .collect()
});

/// Returns the ray with this lowest height, 0 to 100 km.
fn ray_at(rays: &[Ray], height_km: f64) -> Ray {
    let step = (height_km / RAY_STEP_KM).max(0.0);
    let below = (step as usize).min(rays.len() - 2);
    let (a, b, share) = (&rays[below], &rays[below + 1], step - below as f64);
    let between = |a: f64, b: f64| a + share * (b - a);
    Ray {
        impact_km: between(a.impact_km, b.impact_km),
        impact_per_km: between(a.impact_per_km, b.impact_per_km),
        bending_rad: between(a.bending_rad, b.bending_rad),
        transmission: between(a.transmission, b.transmission),
    }
}

/// Quadrature rule for an interval of heights: share of the interval and weight. Heights are low + (high - low)
/// sin²(πs/2), which removes the roots at the ends of the disk.
static AIR_RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| {
    gauss_legendre(20)
        .into_iter()
        .map(|(s, weight)| {
            let (sin, cos) = (std::f64::consts::FRAC_PI_2 * s).sin_cos();
            (sin * sin, std::f64::consts::PI * sin * cos * weight)
        })
        .collect()
});
static FREE_RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(10));

/// Returns the fraction of the Sun's light in V that passes the Earth and its atmosphere, [0, 1].
///
/// `radius_km` (r) is the satellite's distance from the Earth's centre (on the sphere), `separation_rad` (σ) the angle
/// at the satellite between the centres of Earth and Sun, `sun_rad` (α) the Sun's angular radius. A ray with lowest
/// height h meets the satellite at the angle θ' = asin(p/r) from the Earth's centre and comes from the part of the Sun
/// at θ = θ' - β(h). The satellite sees an image with the surface brightness of the Sun, less extinction, flattened by
/// dθ'/dθ (spreading by refraction) and stretched sideways by sin θ'/sin θ (focusing):
///
/// F = ∫ w((θ - σ)/α) e^-τ sin θ' / √(sin θ sin σ) dθ'/α
///
/// with w the light of a strip of the disk. Strips are approximated by arcs about the Earth's centre, corrected by
/// √(sin θ/sin σ); the error is (α/8 sin σ)².
pub(super) fn lit_fraction(radius_km: f64, separation_rad: f64, sun_rad: f64) -> f64 {
    let rays = RAYS.as_slice();
    // For a satellite inside the atmosphere, no ray has its lowest point above the satellite.
    let top_km = TOP_KM.min(radius_km - EARTH_EQUATORIAL_RADIUS_KM - 1e-3);
    let sine_separation = separation_rad.sin().max(1e-6);
    let mut lit = 0.0;
    // Position on the Sun's disk, from -1 to 1, from which the highest ray comes.
    let mut edge = -1.0_f64;
    if top_km > 0.0 {
        let highest = ray_at(rays, top_km);
        let arrival_rad = (highest.impact_km / radius_km).min(1.0).asin();
        edge = ((arrival_rad - highest.bending_rad - separation_rad) / sun_rad).clamp(-1.0, 1.0);
        let [low, high] =
            [-sun_rad, sun_rad].map(|limb_rad| height_from(rays, radius_km, separation_rad + limb_rad, top_km));
        if high > low {
            for &(share, weight) in AIR_RULE.iter() {
                let height_km = low + (high - low) * share;
                let dh = (high - low) * weight;
                let ray = ray_at(rays, height_km);
                let sine_arrival = (ray.impact_km / radius_km).min(1.0);
                let cosine_arrival = (1.0 - sine_arrival * sine_arrival).max(1e-16).sqrt();
                // dθ' = dp / (r cos θ')
                let darrival = ray.impact_per_km * dh / (radius_km * cosine_arrival);
                // sin(θ' - β), with β at most 0.02
                let bending = ray.bending_rad;
                let sine = sine_arrival * (1.0 - bending * bending / 2.0)
                    - cosine_arrival * bending * (1.0 - bending * bending / 6.0);
                lit +=
                    strip((sine_arrival.asin() - bending - separation_rad) / sun_rad) * ray.transmission * sine_arrival
                        / sine.max(1e-6).sqrt()
                        * darrival;
            }
            lit /= sun_rad * sine_separation.sqrt();
        }
    }
    // Light of the part of the disk that is seen above the atmosphere.
    let turn = edge.acos();
    if turn > 0.0 {
        for &(s, weight) in FREE_RULE.iter() {
            let (sin, cos) = (turn * s).sin_cos();
            let sine = (separation_rad + cos * sun_rad).sin().max(1e-6);
            lit += strip(cos) * (sine / sine_separation).sqrt() * sin * turn * weight;
        }
    }
    lit.clamp(0.0, 1.0)
}

/// Returns the lowest height, km, of the ray whose origin is at the angle θ from the Earth's centre, or the nearer end
/// of the interval [0, `top_km`].
///
/// The ray fulfils θ' - β = θ, therefore p = r sin(θ + β), with β at most 0.02. For θ + β below 90°, which is the case
/// for all satellites from 100 km on, the difference of the two sides increases with the height. It is taken as linear
/// between two rays of the table.
fn height_from(rays: &[Ray], radius_km: f64, origin_rad: f64, top_km: f64) -> f64 {
    let (sin, cos) = origin_rad.sin_cos();
    let excess_km = |ray: &Ray| {
        let bending = ray.bending_rad;
        let sine = sin * (1.0 - bending * bending / 2.0) + cos * bending * (1.0 - bending * bending / 6.0);
        ray.impact_km - radius_km * sine
    };
    let above = rays.partition_point(|ray| excess_km(ray) < 0.0);
    if above == 0 {
        return 0.0;
    }
    let Some(upper) = rays.get(above) else { return top_km };
    let (low, high) = (excess_km(&rays[above - 1]), excess_km(upper));
    ((above as f64 - high / (high - low)) * RAY_STEP_KM).min(top_km)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::constants::{AU_KM, SUN_RADIUS_KM};
    use crate::frames::{Gcrs, Position};
    use crate::geometry::{Illumination, ShadowModel};

    /// Densities printed in the standard itself: height (km), density against 1.225 kg/m³.
    #[test]
    fn valid_densities_against_the_standard() {
        for (height_km, expected) in [
            (0.0, 1.0),
            (5.0, 0.7364 / 1.225),
            (10.0, 0.4135 / 1.225),
            (20.0, 0.088_91 / 1.225),
            (30.0, 0.018_41 / 1.225),
        ]
        .into_iter()
        .chain([(50.0, 1.027e-3 / 1.225), (70.0, 8.283e-5 / 1.225), (80.0, 1.846e-5 / 1.225)])
        {
            let (found, change) = density(height_km);
            assert!((found / expected - 1.0).abs() < 1e-3, "{height_km}: {found} {expected}");
            let slope = (density(height_km + 0.01).0 - density((height_km - 0.01_f64).max(0.0)).0)
                / (0.01 + 0.01_f64.min(height_km));
            assert!((change / slope - 1.0).abs() < 2e-3, "{height_km}: {change} {slope}");
        }
    }

    /// The constants computed from the formulas of the cited papers.
    #[test]
    fn valid_constants_against_their_formulas() {
        let wavenumber2 = 0.55_f64.powi(-2);
        // Ciddor (1996), eq. 1, 450 ppm of CO₂: (n - 1) 10⁸
        let refractivity = 1e-8 * (5_792_105.0 / (238.0185 - wavenumber2) + 167_917.0 / (57.362 - wavenumber2));
        assert!((REFRACTIVITY / refractivity - 1.0).abs() < 2e-5, "{refractivity}");
        let rayleigh = 0.008_569 * wavenumber2.powi(2) * (1.0 + 0.0113 * wavenumber2 + 0.000_13 * wavenumber2.powi(2));
        assert!((RAYLEIGH_VERTICAL / rayleigh - 1.0).abs() < 5e-4, "{rayleigh}");
        let ozone = 3.3e-21 * 300.0 * 2.687e16;
        assert!((OZONE_VERTICAL / ozone - 1.0).abs() < 2e-3, "{ozone}");
        assert!((STRATOSPHERE_VERTICAL - 0.008 / 1.4).abs() < 5e-5);
        // p₀ / (g₀ ρ₀)
        assert!((COLUMN_KM - 101.325 / (9.806_65 * 1.225)).abs() < 2e-4);
    }

    /// A grazing ray is bent by twice the horizontal refraction, 34' to 35' for the standard atmosphere; half of the
    /// air lies above 5.5 km.
    #[test]
    fn valid_bending_against_refraction_at_the_horizon() {
        let minutes = |height_km: f64| ray(height_km).0.to_degrees() * 60.0;
        assert!((66.0..70.0).contains(&minutes(0.0)), "{}", minutes(0.0));
        // Without the curvature of the ray itself: β ≈ ν √(2πR/H), for an exponential atmosphere of the local scale
        // height (6.34 km at 216.65 K).
        let density_15 = density(15.0).0;
        let expected = REFRACTIVITY * density_15 * (2.0 * PI * 6393.0 / 6.37).sqrt();
        assert!((ray(15.0).0 / expected - 1.0).abs() < 0.02, "{} {expected}", ray(15.0).0);
        // The airmass at the horizon is some 38, twice that along the whole grazing path: Rayleigh scattering alone
        // gives an optical depth of 7, with 0.0973 vertical.
        let rayleigh = 0.0973 * 2.0 * 38.0;
        assert!(ray(0.0).1 > rayleigh && ray(0.0).1 < 40.0, "{}", ray(0.0).1);
        for height_km in [0.4, 3.3, 11.5, 20.2, 33.3, 47.5, 72.9, 99.5] {
            let (exact, table) = (ray(height_km), bending_and_depth(height_km));
            assert!((table.0 / exact.0 - 1.0).abs() < 0.01 && (table.1 / exact.1 - 1.0).abs() < 0.01, "{height_km}");
        }
    }

    /// Returns the height from 0 to 100 km at which an increasing function reaches a value between those at the ends.
    fn bisected_km(function: &impl Fn(f64) -> f64, value: f64) -> f64 {
        let (mut low, mut high) = (0.0, TOP_KM);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if function(middle) < value { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// Sums over patches of the Sun's disk: the ray of each patch is found by bisection, its flattening by differences.
    #[test]
    fn verif_against_rays_from_every_part_of_the_disk() {
        const TOLERANCE: f64 = 4e-5;
        let sun_rad = 0.004_65;
        for radius_km in [6480.0_f64, 6728.0, 6928.0, 7578.0, 26_560.0, 42_164.0, 399_000.0] {
            let limb_rad = (EARTH_EQUATORIAL_RADIUS_KM / radius_km).asin();
            let air_rad = 60.0 / (radius_km.powi(2) - 6378.0_f64.powi(2)).sqrt();
            for step in 0..10 {
                let separation_rad = limb_rad - 0.008 + (0.016 + air_rad) * f64::from(step) / 10.0;
                let found = lit_fraction(radius_km, separation_rad, sun_rad);
                let arrival = |height_km: f64| {
                    let impact_km =
                        (1.0 + REFRACTIVITY * density(height_km).0) * (EARTH_EQUATORIAL_RADIUS_KM + height_km);
                    (impact_km / radius_km).asin()
                };
                let origin = |height_km: f64| arrival(height_km) - bending_and_depth(height_km).0;
                let cells = 1500;
                let mut sum = 0.0;
                for cell in 0..cells {
                    let turn = PI * (f64::from(cell) + 0.5) / f64::from(cells);
                    let u = -turn.cos();
                    let theta = separation_rad + u * sun_rad;
                    // A strip around the Earth's centre is longer than a straight one on the far side.
                    let bent = (theta.sin() / separation_rad.sin()).sqrt();
                    let weight = bent * strip(u) * turn.sin() * PI / f64::from(cells);
                    if theta <= origin(0.0) {
                        continue;
                    }
                    if theta >= origin(TOP_KM) {
                        sum += weight;
                        continue;
                    }
                    let height_km = bisected_km(&origin, theta);
                    let d = 0.01_f64.min(height_km);
                    let flattening = (arrival(height_km + 0.01) - arrival(height_km - d))
                        / (origin(height_km + 0.01) - origin(height_km - d));
                    let focusing = arrival(height_km).sin() / theta.sin();
                    sum += weight * (-bending_and_depth(height_km).1).exp() * flattening * focusing;
                }
                assert!((found - sum).abs() < TOLERANCE, "{radius_km} {step}: {found} {sum}");
            }
        }
    }

    fn lit(model: ShadowModel, angle_from_antisun_rad: f64, radius_km: f64) -> f64 {
        let sun = Position::<Gcrs>::new(AU_KM, 0.0, 0.0);
        let (sin, cos) = angle_from_antisun_rad.sin_cos();
        model.illumination(&Position::new(-radius_km * cos, radius_km * sin, 0.0), &sun).lit_fraction()
    }

    /// The computed light, without the limits of 1 % and 99 %.
    fn computed(angle_from_antisun_rad: f64, radius_km: f64) -> f64 {
        let (sin, cos) = angle_from_antisun_rad.sin_cos();
        let to_sun = [AU_KM + radius_km * cos, -radius_km * sin];
        let distance_km = to_sun[0].hypot(to_sun[1]);
        let separation_rad = ((to_sun[0] * cos - to_sun[1] * sin) / distance_km).acos();
        lit_fraction(radius_km, separation_rad, (SUN_RADIUS_KM / distance_km).asin())
    }

    /// Continuity, slope and monotony, from full light to none.
    #[test]
    fn fading_is_smooth_and_one_way() {
        // 0.1 mmag at the upper end of the air, where the light is taken as full, and 0.001 mmag between neighbours:
        // far below the third decimal of magnitudes. The sums over rays differ by about 3·10⁻⁵ from finer ones.
        const MISSING: f64 = 1e-4;
        const RISE: f64 = 1e-6;
        for radius_km in [6728.0, 6928.0, 7578.0, 26_560.0, 42_164.0] {
            let limb = (EARTH_EQUATORIAL_RADIUS_KM / radius_km).asin();
            // The air reaches up to 100 km, some degrees for a low orbit.
            let from = ((EARTH_EQUATORIAL_RADIUS_KM + 110.0) / radius_km).asin() + 0.006;
            let to = limb - 0.035;
            let steps = 8000;
            let values: Vec<f64> = (0..=steps)
                .map(|step| computed(from + (to - from) * f64::from(step) / f64::from(steps), radius_km))
                .collect();
            assert!(values[0] > 1.0 - MISSING && values[steps as usize] < 1e-6);
            let step_rad = (from - to) / f64::from(steps);
            let steepest = disk_slope(&values);
            // Slopes are not steeper than without air and change smoothly.
            assert!(steepest < 0.8 / 0.00465 * step_rad, "{radius_km}: {steepest}");
            for (number, triple) in values.windows(3).enumerate() {
                assert!(triple[1] <= triple[0] + RISE, "{radius_km} {number}: {triple:?}");
                let bend = (triple[0] - 2.0 * triple[1] + triple[2]).abs();
                assert!(bend < 40.0 * (step_rad / 0.00465).powi(2) + 3e-6, "{radius_km} {number}: {bend}");
            }
        }
    }

    fn disk_slope(values: &[f64]) -> f64 {
        values.windows(2).map(|pair| pair[0] - pair[1]).fold(0.0, f64::max)
    }

    /// Returns the height above the ground of the line to the Sun's centre where this share of the light remains, km.
    fn ray_height_km(share: f64, radius_km: f64, model: ShadowModel) -> f64 {
        let (mut dark, mut bright) = (0.9, 1.5);
        if radius_km > 20_000.0 {
            (dark, bright) = (0.1, 0.4);
        }
        for _ in 0..50 {
            let middle = 0.5 * (dark + bright);
            if lit(model, middle, radius_km) < share { dark = middle } else { bright = middle }
        }
        // Lowest point of the line from the Sun's centre.
        radius_km * dark.sin() - EARTH_EQUATORIAL_RADIUS_KM
    }

    /// Observed shadow entries of satellites fit a dark atmosphere of 15 to 20 km (Molczan and Matson, SeeSat-L,
    /// January 1997).
    #[test]
    fn valid_half_light_against_the_height_that_observers_found() {
        for radius_km in [6728.0, 6928.0, 7578.0] {
            let [half, tenth, ninth] =
                [0.5, 0.1, 0.9].map(|share| ray_height_km(share, radius_km, ShadowModel::Atmosphere));
            let solid = ray_height_km(0.5, radius_km, ShadowModel::Geometric);
            assert!(solid.abs() < 0.2, "{solid}");
            // Visual observers report the entry between half and a tenth of the light.
            assert!(tenth < 15.0 && half > 20.0 && half < 30.0 && ninth < 60.0, "{tenth} {half} {ninth}");
        }
    }

    /// Little light in the outer geometric umbra, and none deep inside.
    #[test]
    fn light_is_bent_into_the_umbra() {
        let sun_rad = SUN_RADIUS_KM / AU_KM;
        let limb = (EARTH_EQUATORIAL_RADIUS_KM / 6928.0_f64).asin();
        assert_eq!(lit(ShadowModel::Geometric, limb - 1.01 * sun_rad, 6928.0), 0.0);
        let inside = computed(limb - 1.01 * sun_rad, 6928.0);
        assert!(inside > 1e-4 && inside < 0.05, "{inside}");
        assert_eq!(lit(ShadowModel::Atmosphere, limb - 0.05, 6928.0), 0.0);
        let sun = Position::<Gcrs>::new(AU_KM, 0.0, 0.0);
        // Inside the atmosphere and beyond the Moon the shadow is geometric.
        let near = Position::new(-100.0, 6400.0, 0.0);
        assert_eq!(ShadowModel::Atmosphere.illumination(&near, &sun), ShadowModel::Geometric.illumination(&near, &sun));
        assert_eq!(ShadowModel::Atmosphere.illumination(&Position::new(-6928.0, 0.0, 0.0), &sun), Illumination::Umbra);
    }
}

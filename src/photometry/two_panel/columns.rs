//! Magnitudes of two-panel models for many geometries, which are given as columns.

use crate::math::elementary::{fused, greater, sin_cos};
use crate::math::vectors::{Kernel, widest_fused};

use super::equations::{Directions, magnitudes};
use super::satellite::SatelliteModel;

/// Directions of Sun and observer in the body frame, as columns in radians. The shortest column determines their
/// number.
#[derive(Copy, Clone, Debug)]
pub struct BodyAngles<'a> {
    /// Latitude of the Sun above the chassis plane.
    pub sun_latitude_rad: &'a [f64],
    /// Longitude of the observer from the Sun's azimuth.
    pub observer_longitude_rad: &'a [f64],
    /// Latitude of the observer above the chassis plane.
    pub observer_latitude_rad: &'a [f64],
}

/// Positions of satellites as columns, km, in the same geocentric axes as observer and Sun. The shortest column
/// determines their number.
#[derive(Copy, Clone, Debug)]
pub struct SatellitePositions<'a> {
    /// First coordinate of each satellite.
    pub x_km: &'a [f64],
    /// Second coordinate of each satellite.
    pub y_km: &'a [f64],
    /// Third coordinate of each satellite.
    pub z_km: &'a [f64],
    /// Position of the observer.
    pub observer_km: [f64; 3],
    /// Position of the Sun.
    pub sun_km: [f64; 3],
}

/// Columns from which directions in the body frame are computed.
#[derive(Copy, Clone)]
pub(in crate::photometry) enum Columns<'a> {
    Angles(&'a BodyAngles<'a>),
    Positions(&'a SatellitePositions<'a>),
}

/// Number of geometries evaluated together. Their intermediate values, some 7 kB, fit into the first-level cache.
const BLOCK: usize = 32;

/// Smallest light for which a magnitude is computed, m² sr⁻¹.
const LEAST_M2_SR: f64 = 1e-300;

/// Writes magnitudes at 1000 km into `out`; NaN where no lit surface is visible. `zero_mag` is the magnitude for a
/// reflection of 1 m² sr⁻¹.
pub(in crate::photometry) fn standard_magnitudes(
    model: &SatelliteModel,
    zero_mag: f64,
    columns: Columns,
    out: &mut [f64],
) {
    widest_fused(StandardMagnitudes { model: *model, zero_mag, columns, out });
}

struct StandardMagnitudes<'a> {
    model: SatelliteModel,
    zero_mag: f64,
    columns: Columns<'a>,
    out: &'a mut [f64],
}

impl Kernel for StandardMagnitudes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const F: bool>(self) {
        let three = match self.columns {
            Columns::Angles(angles) => {
                [angles.sun_latitude_rad, angles.observer_longitude_rad, angles.observer_latitude_rad]
            }
            Columns::Positions(positions) => [positions.x_km, positions.y_km, positions.z_km],
        };
        let count = three.iter().map(|column| column.len()).min().unwrap_or(0).min(self.out.len());
        let exponents = self.model.exponents();
        for start in (0..count).step_by(BLOCK) {
            let span = start..(start + BLOCK).min(count);
            let mut block = [[0.0; BLOCK]; 3];
            for (block, column) in block.iter_mut().zip(three) {
                block[..span.len()].copy_from_slice(&column[span.clone()]);
            }
            let directions = match self.columns {
                Columns::Angles(_) => of_angles::<F>(&block),
                Columns::Positions(positions) => of_positions::<F>(&block, positions.observer_km, positions.sun_km),
            };
            let panels = &self.model.panels;
            let open = panels.open_sail::<F, BLOCK>(&directions);
            let lit = panels.lit::<F, BLOCK>(&directions, &open, [exponents[0].is_some(), exponents[1].is_some()]);
            let light = lit.light::<F>(&self.model.c, exponents);
            let mut magnitudes = magnitudes::<F, BLOCK>(&light, LEAST_M2_SR, self.zero_mag);
            for lane in 0..BLOCK {
                magnitudes[lane] = if light[lane] > 0.0 { magnitudes[lane] } else { f64::NAN };
            }
            self.out[span.clone()].copy_from_slice(&magnitudes[..span.len()]);
        }
    }
}

/// Computes directions from the latitude of the Sun and the longitude and latitude of the observer.
#[inline(always)]
fn of_angles<const F: bool>(angles: &[[f64; BLOCK]; 3]) -> Directions<BLOCK> {
    let [mut sun_x, mut sun_z, mut eye_x, mut eye_y, mut eye_z] = [[0.0; BLOCK]; 5];
    for lane in 0..BLOCK {
        (sun_z[lane], sun_x[lane]) = sin_cos::<F>(angles[0][lane]);
    }
    for lane in 0..BLOCK {
        (eye_y[lane], eye_x[lane]) = sin_cos::<F>(angles[1][lane]);
    }
    for lane in 0..BLOCK {
        let (sin, cos) = sin_cos::<F>(angles[2][lane]);
        eye_x[lane] *= cos;
        eye_y[lane] *= cos;
        eye_z[lane] = sin;
    }
    Directions { sun: [sun_x, sun_z], observer: [eye_x, eye_y, eye_z] }
}

/// Computes directions from positions of satellites, as [`crate::geometry::ViewingGeometry::new`] does.
#[inline(always)]
fn of_positions<const F: bool>(positions: &[[f64; BLOCK]; 3], observer: [f64; 3], sun: [f64; 3]) -> Directions<BLOCK> {
    let [mut sun_x, mut sun_z, mut eye_x, mut eye_y, mut eye_z] = [[0.0; BLOCK]; 5];
    for lane in 0..BLOCK {
        let p = [positions[0][lane], positions[1][lane], positions[2][lane]];
        let s = [sun[0] - p[0], sun[1] - p[1], sun[2] - p[2]];
        let e = [observer[0] - p[0], observer[1] - p[1], observer[2] - p[2]];
        // z = p/|p| to the zenith, y = p × s/|p × s|, x = y × z to the Sun's foot on the plane of the chassis
        //                                                                 Lu (2024), eqs. 8, 9
        let across = cross(p, s);
        let across_km2 = norm::<F>(across);
        let per_radius_km = 1.0 / norm::<F>(p);
        let per_radius_sun = per_radius_km / norm::<F>(s);
        let per_eye_km = 1.0 / norm::<F>(e);
        // If the Sun is in the zenith, azimuths are undefined; the observer is then placed at an azimuth of 90°.
        let per_across_eye = per_eye_km / greater(across_km2, f64::MIN_POSITIVE);
        sun_x[lane] = across_km2 * per_radius_sun;
        sun_z[lane] = dot::<F>(p, s) * per_radius_sun;
        // x · e = (p × s) · (p × e) / (|p| |p × s| |e|)
        eye_x[lane] = dot::<F>(across, cross(p, e)) * (per_radius_km * per_across_eye);
        eye_y[lane] = dot::<F>(across, e) * per_across_eye;
        eye_z[lane] = dot::<F>(p, e) * (per_radius_km * per_eye_km);
    }
    Directions { sun: [sun_x, sun_z], observer: [eye_x, eye_y, eye_z] }
}

#[inline(always)]
fn dot<const F: bool>(a: [f64; 3], b: [f64; 3]) -> f64 {
    fused::<F>(a[0], b[0], fused::<F>(a[1], b[1], a[2] * b[2]))
}

#[inline(always)]
fn norm<const F: bool>(a: [f64; 3]) -> f64 {
    dot::<F>(a, a).sqrt()
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

//! Layers of the Sun's latitude, cells of the observer's direction, and the densest magnitude of each: Lu (2024), section 3.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::math::healpix::{MOST_NSIDE, ring_cell};
use crate::math::quantile::quantile;

use super::density_mode::{DensityMode, interquartile_range};
use super::error::MeasuredError;
use super::measurement::Measurement;

/// How measurements are reduced.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ReduceOptions {
    /// Width of a layer of the Sun's latitude, radians.
    pub layer_width_rad: f64,
    /// Division of the sphere of the observer's longitude and latitude into 12 N² cells.
    pub nside: u32,
    /// Fold the observer's longitude to [0, π]: satellites are symmetric about the Sun's plane.
    pub fold: bool,
    /// How the densest magnitude is found.
    pub mode: DensityMode,
    /// Cells of fewer points are not kept.
    pub least_count: u32,
    /// Cells of fewer tracks (or what else points were grouped by) are not kept. The points of one track cannot show that it was booked
    /// under another satellite, nor how far satellites differ: its spread is small, so it even weighs much.
    pub least_tracks: u32,
    /// Cells of wider spread are not kept, mag.
    pub most_iqr_mag: f64,
}

impl Default for ReduceOptions {
    /// 1°, nside 32, folded, half-sample mode, 80 points of any number of tracks, 0.4 mag: Lu (2024), section 3.
    fn default() -> Self {
        Self {
            layer_width_rad: 1_f64.to_radians(),
            nside: 32,
            fold: true,
            mode: DensityMode::HalfSample,
            least_count: 80,
            least_tracks: 1,
            most_iqr_mag: 0.4,
        }
    }
}

/// One cell of a layer after reduction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Pixel {
    /// Mean of its points, radians: the middle of a layer would be up to half a degree off where the points lie on one side.
    pub sun_latitude_rad: f64,
    /// Longitude of the mean direction of its points, radians; folded where that was asked for.
    pub observer_longitude_rad: f64,
    /// Latitude of the mean direction of its points, radians.
    pub observer_latitude_rad: f64,
    /// Mean of its points, km.
    pub height_km: f64,
    /// Densest magnitude at 1000 km.
    pub mode_mag: f64,
    /// Median magnitude at 1000 km.
    pub median_mag: f64,
    /// Interquartile range: the error of the mode in fits, mag.
    pub iqr_mag: f64,
    /// Number of points.
    pub count: u32,
    /// Number of tracks they are of.
    pub tracks: u32,
    /// ⌊δ_sun / width⌋.
    pub layer: i32,
    /// HEALPix cell in RING order.
    pub cell: u64,
}

/// All cells that hold a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// By layer, then by cell.
    pub pixels: Vec<Pixel>,
    /// How they came about.
    pub options: ReduceOptions,
    /// Points in them.
    pub points: u64,
}

impl Reduction {
    /// True of a pixel with enough points and tracks and little spread.
    pub fn keeps(&self, pixel: &Pixel) -> bool {
        let options = &self.options;
        pixel.count >= options.least_count
            && pixel.tracks >= options.least_tracks
            && pixel.iqr_mag <= options.most_iqr_mag
    }

    /// Pixels to be fitted.
    pub fn kept(&self) -> impl Iterator<Item = &Pixel> {
        self.pixels.iter().filter(|pixel| self.keeps(pixel))
    }
}

#[derive(Copy, Clone, Default)]
struct Sums {
    sun_latitude_rad: f64,
    to_observer: Vector3<f64>,
    height_km: f64,
}

/// A point: slot, magnitude (rounding to an f32 is 5e-7 mag), group.
type Slotted = (u32, f32, u32);

/// Collects measurements, chunk by chunk: 12 bytes a point, some 100 a cell.
pub struct Reducer {
    options: ReduceOptions,
    slot_of: HashMap<(i32, u64), u32>,
    cells: Vec<(i32, u64, Sums)>,
    points: Vec<Slotted>,
}

impl Reducer {
    /// Ready for points.
    ///
    /// # Errors
    /// [`MeasuredError::Setting`]: a layer's width outside of 0.01° to 180°, an nside outside of 1 to 1024, a spread that is not positive.
    pub fn new(options: ReduceOptions) -> Result<Self, MeasuredError> {
        let setting = |name, given: String, allowed| Err(MeasuredError::Setting { name, given, allowed });
        let width_deg = options.layer_width_rad.to_degrees();
        if !(0.01..=180.0).contains(&width_deg) {
            return setting("layer width", format!("{width_deg} deg"), "0.01 to 180 deg");
        }
        if !(1..=MOST_NSIDE).contains(&options.nside) {
            return setting("nside", options.nside.to_string(), "1 to 1024");
        }
        if options.most_iqr_mag.is_nan() || options.most_iqr_mag <= 0.0 {
            return setting("greatest spread", format!("{} mag", options.most_iqr_mag), "more than 0 mag");
        }
        Ok(Self { options, slot_of: HashMap::new(), cells: Vec::new(), points: Vec::new() })
    }

    /// Takes points up.
    pub fn add(&mut self, points: &[Measurement]) {
        let options = self.options;
        let placed: Vec<Option<(i32, u64, Sums, f32)>> =
            points.par_iter().map(|point| placed(point, &options)).collect();
        for (placed, point) in placed.into_iter().zip(points) {
            let Some((layer, cell, one, magnitude)) = placed else { continue };
            let next = self.cells.len() as u32;
            let slot = *self.slot_of.entry((layer, cell)).or_insert(next);
            if slot == next {
                self.cells.push((layer, cell, Sums::default()));
            }
            let sums = &mut self.cells[slot as usize].2;
            sums.sun_latitude_rad += one.sun_latitude_rad;
            sums.to_observer += one.to_observer;
            sums.height_km += one.height_km;
            self.points.push((slot, magnitude, point.group));
        }
    }

    /// The pixels: the same for the same points in the same order, at any number of threads.
    pub fn finish(mut self) -> Reduction {
        self.points.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let runs: Vec<&[Slotted]> = self.points.chunk_by(|a, b| a.0 == b.0).collect();
        let pixel = |run: &&[Slotted]| {
            let (layer, cell, sums) = self.cells[run[0].0 as usize];
            let sorted: Vec<f64> = run.iter().map(|point| f64::from(point.1)).collect();
            let n = sorted.len() as f64;
            let mut tracks: Vec<u32> = run.iter().map(|point| point.2).collect();
            tracks.sort_unstable();
            tracks.dedup();
            Pixel {
                sun_latitude_rad: sums.sun_latitude_rad / n,
                observer_longitude_rad: sums.to_observer.y.atan2(sums.to_observer.x).rem_euclid(std::f64::consts::TAU),
                observer_latitude_rad: sums.to_observer.z.atan2(sums.to_observer.x.hypot(sums.to_observer.y)),
                height_km: sums.height_km / n,
                mode_mag: self.options.mode.of(&sorted),
                median_mag: quantile(&sorted, 0.5),
                iqr_mag: interquartile_range(&sorted),
                count: u32::try_from(sorted.len()).unwrap_or(u32::MAX),
                tracks: u32::try_from(tracks.len()).unwrap_or(u32::MAX),
                layer,
                cell,
            }
        };
        let mut pixels: Vec<Pixel> = runs.par_iter().map(pixel).collect();
        pixels.par_sort_unstable_by_key(|pixel| (pixel.layer, pixel.cell));
        Reduction { pixels, options: self.options, points: self.points.len() as u64 }
    }
}

/// Layer, cell and what is summed; `None` of a magnitude or angle that is not a number.
fn placed(point: &Measurement, options: &ReduceOptions) -> Option<(i32, u64, Sums, f32)> {
    let geometry = if options.fold { point.geometry.folded() } else { point.geometry };
    let magnitude = point.magnitude.0;
    let (sun, latitude) = (geometry.sun_latitude_rad, geometry.observer_latitude_rad);
    let is_sound = magnitude.is_finite() && sun.abs() <= FRAC_PI_2 && latitude.abs() <= FRAC_PI_2;
    if !is_sound {
        return None;
    }
    let cell = ring_cell(options.nside, geometry.observer_longitude_rad, latitude)?;
    let layer = (sun / options.layer_width_rad).floor() as i32;
    let sums =
        Sums { sun_latitude_rad: sun, to_observer: *geometry.to_observer().vector(), height_km: geometry.height_km };
    Some((layer, cell, sums, magnitude as f32))
}

/// Reduces points that are in memory; see [`Reducer`] for more than fit there.
///
/// # Errors
/// Those of [`Reducer::new`].
pub fn reduce(points: &[Measurement], options: ReduceOptions) -> Result<Reduction, MeasuredError> {
    let mut reducer = Reducer::new(options)?;
    reducer.add(points);
    Ok(reducer.finish())
}

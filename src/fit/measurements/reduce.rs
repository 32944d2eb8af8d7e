//! Reduction of measurements to pixels of viewing geometry (Lu 2024, section 3). A pixel is a HEALPix pixel of the
//! observer's direction within a layer of the Sun's latitude; its value is the mode of the magnitudes in it.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::density_mode::{DensityMode, interquartile_range};
use super::measure::{HEIGHT, LATITUDE, LONGITUDE, Measurement, SUN};
use crate::error::Error;
use crate::math::healpix::{MOST_NSIDE, ring_cell};
use crate::math::quantile::quantile;
use crate::output::{Column, Kind, Table};

const PIXELS: [Column; 12] = [
    Column::new("layer", Kind::Integer, "Layer of the Sun's latitude: latitude over width, rounded down."),
    Column::new("healpix_cell", Kind::Integer, "Cell of the observer's direction, HEALPix in RING order."),
    SUN,
    LONGITUDE,
    LATITUDE,
    HEIGHT,
    Column::real("mode_mag", "mag", 4, "Mode of the magnitude at 1000 km."),
    Column::real("median_mag", "mag", 4, "Median magnitude at 1000 km."),
    Column::real("iqr_mag", "mag", 4, "Interquartile range."),
    Column::new("count", Kind::Integer, "Number of points in the cell."),
    Column::new("tracks", Kind::Integer, "Number of tracks (or satellites, nights, files) of these points."),
    Column::new(
        "kept",
        Kind::Boolean,
        "True if the numbers of points and tracks and the spread are within the limits.",
    ),
];

/// Options of a reduction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ReduceOptions {
    /// Width of a layer of the Sun's latitude, radians.
    pub layer_width_rad: f64,
    /// HEALPix nside of the observer's direction; the sphere has 12 nside² pixels.
    pub nside: u32,
    /// If true, the observer's longitude is folded to [0, π], because satellites are symmetric about the plane that
    /// contains the Sun.
    pub fold: bool,
    /// Estimator of the mode.
    pub mode: DensityMode,
    /// Smallest number of points with which a pixel is kept.
    pub least_count: u32,
    /// Smallest number of tracks (or other groups) with which a pixel is kept. The points of a single track do not
    /// reveal a misidentification or the differences between satellites. Their spread is small, so that the pixel would
    /// have a large weight.
    pub least_tracks: u32,
    /// Largest interquartile range with which a pixel is kept, mag.
    pub most_iqr_mag: f64,
}

impl Default for ReduceOptions {
    /// Returns 1°, nside 32, folded, half-sample mode, 80 points of any number of tracks, and 0.4 mag (Lu 2024, section
    /// 3).
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

/// Reduced pixel of viewing geometry.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Pixel {
    /// Mean of the Sun's latitude over the points, radians. The middle of the layer could differ from it by half a
    /// degree.
    pub sun_latitude_rad: f64,
    /// Longitude of the mean direction of the points, radians; folded if [`ReduceOptions::fold`] is set.
    pub observer_longitude_rad: f64,
    /// Latitude of the mean direction of the points, radians.
    pub observer_latitude_rad: f64,
    /// Mean height of the satellites above 6378.137 km, km.
    pub height_km: f64,
    /// Mode of the magnitude at 1000 km.
    pub mode_mag: f64,
    /// Median magnitude at 1000 km.
    pub median_mag: f64,
    /// Interquartile range of the magnitudes, mag; fits use it as the error of the mode.
    pub iqr_mag: f64,
    /// Number of points.
    pub count: u32,
    /// Number of tracks to which these points belong.
    pub tracks: u32,
    /// Number of the layer, ⌊δ_sun / width⌋.
    pub layer: i32,
    /// Number of the HEALPix pixel in RING order.
    pub cell: u64,
}

/// All pixels with at least one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Pixels in order of layer, then of HEALPix number.
    pub pixels: Vec<Pixel>,
    /// Options of the reduction.
    pub options: ReduceOptions,
    /// Number of points in all pixels.
    pub points: u64,
}

impl Reduction {
    /// Returns true if a pixel is within the limits of the options.
    pub fn keeps(&self, pixel: &Pixel) -> bool {
        let options = &self.options;
        pixel.count >= options.least_count
            && pixel.tracks >= options.least_tracks
            && pixel.iqr_mag <= options.most_iqr_mag
    }

    /// Returns the pixels that are within the limits of the options and are to be fitted.
    pub fn kept(&self) -> impl Iterator<Item = &Pixel> {
        self.pixels.iter().filter(|pixel| self.keeps(pixel))
    }

    /// Returns a table with one row per pixel.
    pub fn table(&self) -> Table {
        let row = |pixel: &Pixel| {
            vec![
                i64::from(pixel.layer).into(),
                (pixel.cell as i64).into(),
                pixel.sun_latitude_rad.to_degrees().into(),
                pixel.observer_longitude_rad.to_degrees().into(),
                pixel.observer_latitude_rad.to_degrees().into(),
                pixel.height_km.into(),
                pixel.mode_mag.into(),
                pixel.median_mag.into(),
                pixel.iqr_mag.into(),
                i64::from(pixel.count).into(),
                i64::from(pixel.tracks).into(),
                self.keeps(pixel).into(),
            ]
        };
        Table { columns: PIXELS.to_vec(), rows: self.pixels.iter().map(row).collect() }
    }
}

#[derive(Copy, Clone, Default)]
struct Sums {
    sun_latitude_rad: f64,
    to_observer: Vector3<f64>,
    height_km: f64,
}

/// A point: index of its pixel, magnitude (rounded to f32, 5e-7 mag), group.
type Slotted = (u32, f32, u32);

/// Collects measurements chunk by chunk. It needs 12 bytes per point and some 100 bytes per pixel.
pub struct Reducer {
    options: ReduceOptions,
    slot_of: HashMap<(i32, u64), u32>,
    cells: Vec<(i32, u64, Sums)>,
    points: Vec<Slotted>,
}

impl Reducer {
    /// Creates an empty reducer.
    ///
    /// # Errors
    /// A layer width outside 0.01° to 180°, an nside outside 1 to 1024, or a limit of the spread that is not positive.
    pub fn new(options: ReduceOptions) -> Result<Self, Error> {
        let setting = |name, given: String, allowed| Err(Error::invalid(name, given, allowed));
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

    /// Adds points.
    pub fn add(&mut self, points: &[Measurement]) {
        let options = self.options;
        let placed: Vec<Option<(i32, u64, Sums, f32)>> =
            points.par_iter().map(|point| placed(point, &options)).collect();
        for (placed, point) in placed.into_iter().zip(points) {
            let Some((layer, cell, added, magnitude)) = placed else { continue };
            let next = self.cells.len() as u32;
            let slot = *self.slot_of.entry((layer, cell)).or_insert(next);
            if slot == next {
                self.cells.push((layer, cell, Sums::default()));
            }
            let sums = &mut self.cells[slot as usize].2;
            sums.sun_latitude_rad += added.sun_latitude_rad;
            sums.to_observer += added.to_observer;
            sums.height_km += added.height_km;
            self.points.push((slot, magnitude, point.group));
        }
    }

    /// Returns the pixels; they do not depend on the number of threads.
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
                mode_mag: self.options.mode.mode_of(&sorted),
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

/// Returns layer, HEALPix number, terms of the sums and magnitude of a point; `None` for an invalid magnitude or angle.
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

/// Reduces points in memory. For larger sets use [`Reducer`].
///
/// # Errors
/// The errors of [`Reducer::new`].
pub fn reduce(points: &[Measurement], options: ReduceOptions) -> Result<Reduction, Error> {
    let mut reducer = Reducer::new(options)?;
    reducer.add(points);
    Ok(reducer.finish())
}

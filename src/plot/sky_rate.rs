//! Maps of expected streaks per exposure, over the sky of a site and in right ascension and declination.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::error;
use super::numbers::{fixed, many};
use super::picture::Picture;
use super::scale::{ColourScale, Quantity};
use super::sky_disk::{AZIMUTHS, Disk, DiskContent, DiskSheet};
use super::statistics::check;
use crate::error::Error;
use crate::math::healpix::{MOST_NSIDE, cell_count, ring_cell};

const SKY_RADIUS: usize = 270;

/// Expected streaks per exposure, by horizontal direction.
#[derive(Clone, Debug)]
pub struct SkyRate<'a> {
    /// Title.
    pub title: &'a str,
    /// Subtitle above the disk, which states the position of the Sun.
    pub subtitle: &'a str,
    /// Caption below the disk.
    pub caption: &'a str,
    /// HEALPix nside, 1 to 1024; the 12 nside² pixels are in RING order.
    pub nside: u32,
    /// Numbers of HEALPix pixels, each once, with azimuth (from north through east) as longitude and altitude as
    /// latitude; shape `(n_cell)`.
    pub cells: &'a [u64],
    /// Expected streaks per exposure, 0 or more; shape `(n_cell)`.
    pub rate: &'a [f64],
    /// Azimuth of the mark of the Sun, degrees from north through east.
    pub sun_azimuth_deg: f64,
}

/// Draws the sky as seen from below, north up and east left, with the zenith in the middle and the horizon at the rim.
/// Directions that were not computed are grey.
///
/// # Errors
/// There is no pixel; columns differ in length; nside or a pixel number is invalid; or a rate is negative or not
/// finite.
pub fn sky_rate(input: &SkyRate<'_>) -> Result<Picture, Error> {
    if !input.sun_azimuth_deg.is_finite() {
        let what = "the Sun's azimuth".to_owned();
        let given = input.sun_azimuth_deg.to_string();
        return Err(Error::invalid(what, given, "a number of degrees"));
    }
    let by_cell = rates_by_cell(input.nside, input.cells, input.rate)?;
    let nside = input.nside;
    let content = move |azimuth_rad: f64, from_zenith_rad: f64| {
        let cell = ring_cell(nside, azimuth_rad, std::f64::consts::FRAC_PI_2 - from_zenith_rad);
        cell.and_then(|cell| by_cell[cell as usize]).map_or(DiskContent::Empty, DiskContent::Value)
    };
    let disk = Disk {
        title: input.subtitle.to_owned(),
        quantity: Quantity::Rate,
        is_half: false,
        content: Box::new(content),
        scaled_within_rad: std::f64::consts::FRAC_PI_2,
        sun_longitude_rad: Some(input.sun_azimuth_deg.to_radians()),
        rim: AZIMUTHS.to_vec(),
        circles: vec![(30.0, "60°".to_owned()), (60.0, "30°".to_owned())],
        limb_rad: None,
    };
    let scale = ColourScale::from_values(Quantity::Rate, input.rate.iter().copied());
    let caption = format!(
        "Zenith in the middle, horizon at the rim, east left. {}{}",
        input.caption,
        clipping(&scale, input.rate)
    );
    let sheet = DiskSheet {
        title: input.title.to_owned(),
        caption,
        disks: vec![disk],
        radius: SKY_RADIUS,
        disks_per_row: 1,
        contour_mag: None,
        nothing: "not computed",
        scale: Some(scale),
    };
    Ok(sheet.picture())
}

/// Returns the sentence for a caption on cells above the end of the colour scale; empty if there is none.
fn clipping(scale: &ColourScale, rates: &[f64]) -> String {
    let above = rates.iter().filter(|rate| **rate > scale.greatest).count();
    let highest = rates.iter().copied().fold(0.0, f64::max);
    match above {
        0 => String::new(),
        _ => format!(
            " The colours end at 5 medians of the cells with streaks; {} above, up to {} streaks.",
            many(above, "cell is", "cells are"),
            fixed(highest, 2)
        ),
    }
}

/// Returns the rate of each pixel of the sphere, by its number; `None` for a pixel without a rate.
pub(super) fn rates_by_cell(nside: u32, cells: &[u64], rate: &[f64]) -> Result<Vec<Option<f64>>, Error> {
    let out = |what: &str, given: String, allowed| Err(Error::invalid(what, given, allowed));
    check("rates", rate)?;
    if cells.len() != rate.len() {
        return Err(error::length("cells", cells.len(), rate.len()));
    }
    if !(1..=MOST_NSIDE).contains(&nside) {
        return out("nside", nside.to_string(), "1 to 1024");
    }
    if let Some(rate) = rate.iter().find(|rate| **rate < 0.0) {
        return out("a rate", rate.to_string(), "0 streaks per exposure or more");
    }
    let mut by_cell = vec![None; cell_count(nside) as usize];
    for (&cell, &rate) in cells.iter().zip(rate) {
        match by_cell.get_mut(cell as usize) {
            Some(position @ None) => *position = Some(rate),
            Some(Some(_)) => return out("a cell", cell.to_string(), "each once"),
            None => return out("a cell", cell.to_string(), "0 to 12 nside² − 1"),
        }
    }
    Ok(by_cell)
}

const EQUATORIAL_RADIUS: usize = 230;

/// Expected streaks per exposure, by equatorial direction.
#[derive(Clone, Debug)]
pub struct EquatorialRate<'a> {
    /// Title.
    pub title: &'a str,
    /// Caption below the disks.
    pub caption: &'a str,
    /// HEALPix nside, 1 to 1024; the 12 nside² pixels are in RING order.
    pub nside: u32,
    /// Numbers of HEALPix pixels, each once, with right ascension as longitude and declination as latitude (ICRS);
    /// shape `(n_cell)`.
    pub cells: &'a [u64],
    /// Expected streaks per exposure, 0 or more; shape `(n_cell)`.
    pub rate: &'a [f64],
}

/// Draws both hemispheres as seen from within, with the poles in the middle, the equator at the rims and right
/// ascension 0h up. Directions that were not computed are grey.
///
/// # Errors
/// The errors of [`super::sky_rate()`].
pub fn equatorial_rate(input: &EquatorialRate<'_>) -> Result<Picture, Error> {
    let nside = input.nside;
    let by_cell = rates_by_cell(nside, input.cells, input.rate)?;
    let by_cell = &by_cell;
    // Seen from within, right ascension increases anticlockwise around the north pole and clockwise around the south
    // pole.
    let half = |pole: f64, title: &str| {
        let content = move |angle_rad: f64, from_pole_rad: f64| {
            let right_ascension_rad = (pole * angle_rad).rem_euclid(TAU);
            let cell = ring_cell(nside, right_ascension_rad, pole * (FRAC_PI_2 - from_pole_rad));
            cell.and_then(|cell| by_cell[cell as usize]).map_or(DiskContent::Empty, DiskContent::Value)
        };
        let sign = if pole > 0.0 { "+" } else { "−" };
        Disk {
            title: title.to_owned(),
            quantity: Quantity::Rate,
            is_half: false,
            content: Box::new(content),
            scaled_within_rad: FRAC_PI_2,
            sun_longitude_rad: None,
            rim: [(0.0, "0h"), (90.0, "6h"), (180.0, "12h"), (270.0, "18h")]
                .map(|(angle_deg, hour)| (pole * angle_deg, hour))
                .to_vec(),
            circles: vec![(30.0, format!("{sign}60°")), (60.0, format!("{sign}30°"))],
            limb_rad: None,
        }
    };
    let scale = ColourScale::from_values(Quantity::Rate, input.rate.iter().copied());
    let sheet = DiskSheet {
        title: input.title.to_owned(),
        caption: format!(
            "ICRS; the poles in the middle, the equator at the rims, as seen from within. {}{}",
            input.caption,
            clipping(&scale, input.rate)
        ),
        disks: vec![half(1.0, "North of the equator"), half(-1.0, "South of the equator")],
        radius: EQUATORIAL_RADIUS,
        disks_per_row: 2,
        contour_mag: None,
        nothing: "not computed",
        scale: Some(scale),
    };
    Ok(sheet.picture())
}

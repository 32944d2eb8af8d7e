//! How many streaks an exposure has to expect, over right ascension and declination: means over nights.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::math::healpix::ring_cell;

use super::disc::{Disc, Seen};
use super::disc_sheet::DiscSheet;
use super::error::PlotError;
use super::picture::Picture;
use super::scale::Quantity;
use super::sky_rate::rates_by_cell;

const RADIUS: usize = 230;

/// Streaks an exposure, by place among the stars.
#[derive(Clone, Debug)]
pub struct EquatorialRate<'a> {
    /// Above all.
    pub title: &'a str,
    /// Below.
    pub caption: &'a str,
    /// Division of the sphere into 12 N² cells in RING order, 1 to 1024.
    pub nside: u32,
    /// `(n_cell)` RING cells of right ascension (as longitude) and declination (as latitude), ICRS, each once.
    pub cells: &'a [u64],
    /// `(n_cell)` expected streaks an exposure, 0 or more.
    pub rate: &'a [f64],
}

/// Draws both halves of the sky as one sees them from within, the poles in the middle, right ascension 0h up, the equator at the rims; grey where nothing was
/// asked.
///
/// # Errors
/// As of [`super::sky_rate()`].
pub fn equatorial_rate(input: &EquatorialRate<'_>) -> Result<Picture, PlotError> {
    let nside = input.nside;
    let by_cell = rates_by_cell(nside, input.cells, input.rate)?;
    let by_cell = &by_cell;
    // From within, right ascension grows against the clock about the north pole and with it about the south pole.
    let half = |pole: f64, title: &str| {
        let seen = move |angle_rad: f64, from_pole_rad: f64| {
            let right_ascension_rad = (pole * angle_rad).rem_euclid(TAU);
            let cell = ring_cell(nside, right_ascension_rad, pole * (FRAC_PI_2 - from_pole_rad));
            cell.and_then(|cell| by_cell[cell as usize]).map_or(Seen::Nothing, Seen::Value)
        };
        let sign = if pole > 0.0 { "+" } else { "−" };
        Disc {
            title: title.to_owned(),
            quantity: Quantity::Rate,
            is_half: false,
            seen: Box::new(seen),
            scaled_within_rad: FRAC_PI_2,
            sun_longitude_rad: None,
            rim: [(0.0, "0h"), (90.0, "6h"), (180.0, "12h"), (270.0, "18h")]
                .map(|(angle_deg, hour)| (pole * angle_deg, hour))
                .to_vec(),
            circles: vec![(30.0, format!("{sign}60°")), (60.0, format!("{sign}30°"))],
            limb_rad: None,
        }
    };
    let sheet = DiscSheet {
        title: input.title.to_owned(),
        caption: format!(
            "ICRS; the poles in the middle, the equator at the rims, as seen from within. {}",
            input.caption
        ),
        discs: vec![half(1.0, "North of the equator"), half(-1.0, "South of the equator")],
        radius: RADIUS,
        in_a_row: 2,
        contour_mag: None,
        nothing: "not asked",
    };
    Ok(sheet.picture())
}

//! HEALPix cells over a satellite's own sky, panel by panel: the slices of figures 2 and 4 of Lu (2024).

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use crate::math::healpix::{MOST_NSIDE, cell_count, ring_cell};

use super::disc::{Disc, Seen};
use super::disc_sheet::DiscSheet;
use super::error::PlotError;
use super::picture::Picture;
use super::scale::Quantity;

/// Panels of one picture.
const MOST_PANELS: usize = 12;

/// Cells of a satellite's sky, as pictures show them.
#[derive(Clone, Debug)]
pub struct Layers<'a> {
    /// Above all.
    pub title: &'a str,
    /// Below all; what is needed to read the picture is said after it.
    pub caption: &'a str,
    /// Division of the sphere into 12 N² cells in RING order, 1 to 1024.
    pub nside: u32,
    /// Cells are those of longitudes folded to 0 to 180°: half discs are drawn.
    pub is_folded: bool,
    /// 1 to 12, in rows of four half discs or three discs.
    pub panels: Vec<LayerPanel<'a>>,
}

/// One disc: a layer of the Sun's latitude, or one quantity of it.
#[derive(Clone, Debug)]
pub struct LayerPanel<'a> {
    /// Above it: `(a) Sun at latitude −14°`.
    pub title: &'a str,
    /// What the values are, and with it their colours.
    pub quantity: Quantity,
    /// RING cell of the observer's direction (longitude from the Sun's azimuth, latitude above the plane of the chassis) and its value, finite;
    /// counts are 1 or more. Cells above the plane are not seen.
    pub cells: &'a [(u64, f64)],
}

/// Draws every panel as the maps of a satellite's own sky are drawn: nadir in the middle, the plane of the chassis at the rim, the Sun marked at
/// longitude 0. Panels of one quantity have one scale; grey is where there is no cell.
///
/// # Errors
/// No panel or more than 12, none of them with a cell, a division that is not offered, a cell that there is not or that comes twice in a panel,
/// a value that is not finite, a count below 1.
pub fn layers(input: &Layers<'_>) -> Result<Picture, PlotError> {
    let out = |what: &str, given: String, allowed| Err(PlotError::OutOfRange { what: what.to_owned(), given, allowed });
    if !(1..=MOST_PANELS).contains(&input.panels.len()) {
        return out("the number of panels", input.panels.len().to_string(), "1 to 12");
    }
    if !(1..=MOST_NSIDE).contains(&input.nside) {
        return out("nside", input.nside.to_string(), "1 to 1024");
    }
    if input.panels.iter().all(|panel| panel.cells.is_empty()) {
        return Err(PlotError::Empty { what: "cells in any panel".to_owned() });
    }
    let discs = input.panels.iter().map(|panel| disc(input, panel)).collect::<Result<Vec<_>, _>>()?;
    let is_mixed = input.panels.iter().any(|panel| panel.quantity != input.panels[0].quantity);
    let in_a_row = if input.is_folded { 4 } else { 3 };
    let meaning = match input.panels.iter().any(|panel| panel.quantity == Quantity::Residual) {
        true => " O−C above 0 (red): observed fainter than computed.",
        false => "",
    };
    let fold = if input.is_folded { ", folded to 0–180°" } else { "" };
    let caption = format!(
        "{} Nadir in the middle, plane of the chassis at the rim; longitudes from the Sun{fold}. HEALPix cells, nside {}.{meaning}",
        input.caption, input.nside
    );
    let columns = in_a_row.min(discs.len());
    let sheet = DiscSheet {
        title: input.title.to_owned(),
        caption: caption.trim().to_owned(),
        radius: radius(columns, discs.len().div_ceil(columns), input.is_folded, is_mixed),
        discs,
        in_a_row,
        contour_mag: None,
        nothing: "no cell",
    };
    Ok(sheet.picture())
}

/// The largest radius, in pixels, with which discs stay within 1600 pixels on both sides.
fn radius(columns: usize, rows: usize, is_folded: bool, is_mixed: bool) -> usize {
    let bars = if is_mixed { columns } else { 1 };
    let across = (1600 - 120 * bars).saturating_sub(132 * columns) / columns / if is_folded { 1 } else { 2 };
    let down = (1600_usize - 190).saturating_sub(164 * rows) / rows / 2;
    across.min(down).min(270)
}

fn disc<'a>(input: &Layers<'_>, panel: &LayerPanel<'a>) -> Result<Disc<'a>, PlotError> {
    let mut value_of = HashMap::with_capacity(panel.cells.len());
    for (index, &(cell, value)) in panel.cells.iter().enumerate() {
        let what = || format!("cell {cell} of panel {}", panel.title);
        if cell >= cell_count(input.nside) {
            let what = format!("cell {index} (counted from 0) of panel {}", panel.title);
            return Err(PlotError::OutOfRange { what, given: cell.to_string(), allowed: "below 12 nside²" });
        }
        if !value.is_finite() {
            return Err(PlotError::NotFinite { what: format!("cells of panel {}", panel.title), index, value });
        }
        if panel.quantity == Quantity::Count && value < 1.0 {
            return Err(PlotError::OutOfRange { what: what(), given: value.to_string(), allowed: "1 sample or more" });
        }
        if value_of.insert(cell, value).is_some() {
            return Err(PlotError::OutOfRange { what: what(), given: "twice".to_owned(), allowed: "once" });
        }
    }
    let nside = input.nside;
    let mut rim = vec![(0.0, "0°"), (90.0, "90°"), (180.0, "180°")];
    if !input.is_folded {
        rim.push((270.0, "270°"));
    }
    Ok(Disc {
        title: panel.title.to_owned(),
        quantity: panel.quantity,
        is_half: input.is_folded,
        seen: Box::new(move |longitude, from_nadir| {
            let cell = ring_cell(nside, longitude, from_nadir - FRAC_PI_2);
            cell.and_then(|cell| value_of.get(&cell)).map_or(Seen::Nothing, |value| Seen::Value(*value))
        }),
        scaled_within_rad: FRAC_PI_2,
        sun_longitude_rad: Some(0.0),
        rim,
        circles: vec![(30.0, "−60°".to_owned()), (60.0, "−30°".to_owned())],
        limb_rad: None,
    })
}

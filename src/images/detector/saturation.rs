//! Full wells, and where the charge goes that they cannot hold.

use serde::Deserialize;

use crate::images::Plane;

use super::error::DetectorError;

/// How much a pixel holds.
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saturation {
    /// Greatest charge of a pixel, electrons, \[1, 1e9\].
    pub full_well_e: f64,
    /// What happens to the rest.
    #[serde(default)]
    pub bleeding: Bleeding,
}

/// Where charge goes that its pixel cannot hold.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bleeding {
    /// Into the pixels above and below, half each way, on to the next with room; what comes to the frame's edge leaves it.
    #[default]
    Columns,
    /// The same to the left and right: detectors read along their rows.
    Rows,
    /// Nowhere: it is lost (drains against blooming, most CMOS detectors).
    Off,
}

/// What saturated.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Saturated {
    /// Pixels that got more charge than they hold from light alone, before bleeding.
    pub pixels: usize,
    /// Charge that left the frame at its edges or was drained, electrons.
    pub lost_e: f64,
}

impl Saturation {
    pub(super) fn validate(&self) -> Result<(), DetectorError> {
        DetectorError::hold("saturation.full_well_e", self.full_well_e, 1.0, 1e9)
    }

    /// Cuts all pixels to what they hold and lets the rest bleed.
    ///
    /// `room` is what is left of each pixel's well where the charge comes on top of what a frame shows already, 0 or more. It has the shape of the charge;
    /// left out, wells are empty.
    pub(super) fn apply(&self, charge: &mut Plane, room: Option<&Plane>) -> Saturated {
        let (rows, columns) = (charge.rows(), charge.columns());
        let full = self.full_well_e as f32;
        let room_to = |row: usize, column: usize| room.map_or(full, |room| room.row(row)[column]);
        let mut saturated = Saturated::default();
        let mut excess: Vec<(usize, usize, f32)> = Vec::new();
        for row in 0..rows {
            for (column, value) in charge.row_mut(row).iter_mut().enumerate() {
                let most = room_to(row, column);
                if *value > most {
                    excess.push((row, column, *value - most));
                    *value = most;
                }
            }
        }
        saturated.pixels = excess.len();
        let all = |excess: &[(usize, usize, f32)]| excess.iter().map(|(_, _, e)| f64::from(*e)).sum::<f64>();
        let is_along_rows = match self.bleeding {
            Bleeding::Columns => false,
            Bleeding::Rows => true,
            Bleeding::Off => {
                saturated.lost_e = all(&excess);
                return saturated;
            }
        };
        // Lines of pixels that charge moves along, and places on them.
        let placed = |(row, column, e): (usize, usize, f32)| {
            let (line, place) = if is_along_rows { (row, column) } else { (column, row) };
            (line, place, f64::from(e))
        };
        let mut excess: Vec<(usize, usize, f64)> = excess.into_iter().map(placed).collect();
        excess.sort_by_key(|(line, place, _)| (*line, *place));
        let length = if is_along_rows { columns } else { rows };
        for line in excess.chunk_by(|a, b| a.0 == b.0) {
            let mut pour = |place: usize, carried: f64| -> f64 {
                let (row, column) = if is_along_rows { (line[0].0, place) } else { (place, line[0].0) };
                let room = f64::from(room_to(row, column));
                let pixel = &mut charge.row_mut(row)[column];
                let poured = carried.min((room - f64::from(*pixel)).max(0.0));
                *pixel = (f64::from(*pixel) + poured) as f32;
                carried - poured
            };
            saturated.lost_e += run(line.iter().map(|(_, place, e)| (*place, *e)), 0..length, &mut pour);
            saturated.lost_e += run(line.iter().rev().map(|(_, place, e)| (*place, *e)), (0..length).rev(), &mut pour);
        }
        saturated
    }
}

/// Carries half of every excess on, place after place in the given order, and gives back what is left at the end.
fn run(
    excess: impl Iterator<Item = (usize, f64)>,
    places: impl Iterator<Item = usize>,
    pour: &mut impl FnMut(usize, f64) -> f64,
) -> f64 {
    let mut waiting = excess.peekable();
    let mut carried = 0.0;
    for place in places {
        if carried > 0.0 {
            carried = pour(place, carried);
        }
        if let Some((_, e)) = waiting.next_if(|(source, _)| *source == place) {
            carried += 0.5 * e;
        }
    }
    carried
}

//! A path's light in a frame, drawn in bands of rows: each when it is first looked at, by whoever looks.
//!
//! A frame that is copied with streaks in it is written from its first row on: what is below is drawn while what is above is on its way.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::draw::Strokes;
use super::path::StreakPath;
use crate::camera::{LightArea, LightRows, Patch, PatchRows, PatchSpan, Plane, RadialProfile};

/// Rows of a band: few enough that threads which write a frame seldom meet in one.
const BAND_ROWS: usize = 32;

/// The light of a path on the lit area of a frame, as of [`draw`](super::draw()).
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Which pixels it has.
    outline: PatchRows,
    bands: Vec<OnceLock<Patch>>,
    band_rows: usize,
    /// What bands are drawn from; none where they are there.
    unfinished: Option<Arc<Unfinished>>,
}

#[derive(Debug)]
struct Unfinished {
    strokes: Strokes,
    profile: Arc<RadialProfile>,
    area: LightArea,
    rows: usize,
    columns: usize,
}

impl Drawing {
    /// Prepares the light of a path on the lit area of a frame of `rows` by `columns`, and draws none of it.
    pub fn of(path: &StreakPath, profile: Arc<RadialProfile>, rows: usize, columns: usize, area: &LightArea) -> Self {
        let parts = profile.parts();
        let strokes = Strokes::of_parts(path, &profile, rows, columns);
        let mut outline = PatchRows::new(rows, columns);
        for (row, run) in strokes.extents() {
            outline.add(row / parts.y, run.start / parts.x..run.end.div_ceil(parts.x));
        }
        let outline = outline.within(area);
        let bands = vec![OnceLock::new(); outline.row_count().div_ceil(BAND_ROWS)];
        let unfinished = Unfinished { strokes, profile, area: area.clone(), rows, columns };
        Self { outline, bands, band_rows: BAND_ROWS, unfinished: Some(Arc::new(unfinished)) }
    }

    /// True where no pixel is touched.
    pub fn is_empty(&self) -> bool {
        self.outline.is_empty()
    }

    /// Draws what is not there yet, on all threads.
    pub fn finish(&self) {
        (0..self.bands.len()).into_par_iter().for_each(|number| {
            self.band(number);
        });
    }

    /// All rows that have pixels, from the first.
    pub fn iter(&self) -> impl Iterator<Item = PatchSpan<'_>> {
        (0..self.bands.len()).flat_map(|number| self.band(number).iter())
    }

    /// Sum of all light on the area.
    pub fn sum(&self) -> f64 {
        self.finish();
        (0..self.bands.len()).map(|number| self.band(number).sum()).sum()
    }

    /// Adds it to a plane; what lies outside of the plane is left out. Bands that were not looked at before are drawn and not kept: there is never more than one in memory.
    pub fn add_to(&self, plane: &mut Plane) {
        for (number, band) in self.bands.iter().enumerate() {
            match band.get() {
                Some(patch) => patch.add_to(plane),
                None => self.drawn(number).add_to(plane),
            }
        }
    }

    /// All of it in one patch, times a factor.
    pub fn scaled(&self, factor: f32) -> Patch {
        self.finish();
        let mut patch = self.outline.clone().into_patch();
        patch.fill(|row, _, values| {
            for (value, light) in values.iter_mut().zip(self.row(row).values) {
                *value = factor * light;
            }
        });
        patch
    }

    fn band(&self, number: usize) -> &Patch {
        self.bands[number].get_or_init(|| self.drawn(number))
    }

    fn drawn(&self, number: usize) -> Patch {
        let first = self.outline.first_row() + number * self.band_rows;
        match &self.unfinished {
            Some(unfinished) => unfinished.draw(first..first + self.band_rows),
            None => PatchRows::new(0, 0).into_patch(),
        }
    }
}

impl Unfinished {
    fn draw(&self, rows: Range<usize>) -> Patch {
        self.strokes.draw_parts(&self.profile, rows, self.rows, self.columns).within(&self.area)
    }
}

impl From<Patch> for Drawing {
    fn from(patch: Patch) -> Self {
        let outline = patch.outline();
        let band_rows = outline.row_count().max(1);
        let bands = if outline.is_empty() { Vec::new() } else { vec![OnceLock::from(patch)] };
        Self { outline, bands, band_rows, unfinished: None }
    }
}

impl LightRows for Drawing {
    fn outline(&self) -> &PatchRows {
        &self.outline
    }

    fn row(&self, row: usize) -> PatchSpan<'_> {
        let number = row.checked_sub(self.outline.first_row()).map(|below| below / self.band_rows);
        match number.filter(|number| *number < self.bands.len()) {
            Some(number) => self.band(number).row(row),
            None => PatchSpan { row, first_column: 0, values: &[] },
        }
    }
}

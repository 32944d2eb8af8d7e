//! Pixels around one streak, arranged along its track.

use super::corridor::Corridor;
use crate::images::{LightArea, Patch, PixelPosition, Plane};

/// Band of pixels around a line along the track: for each pixel of the major axis, the pixels within a distance along
/// the minor axis. Pixels are those of the frame, without interpolation.
#[derive(Clone, Debug)]
pub struct Band {
    is_along_rows: bool,
    first: usize,
    /// Minor coordinate of the first pixel of each column of the band.
    lowest: Vec<isize>,
    /// Number of pixels in a column of the band, odd.
    pub height: usize,
    /// Counts; NaN outside the illuminated pixels of the frame.
    pub values: Vec<f32>,
    /// Cosine of the angle between the track and the major axis.
    pub cos: f64,
}

impl Band {
    /// Reads the band of `half` pixels on both sides of a line, which is given by its distance from the corridor's
    /// track along the minor axis and the change of this distance per pixel.
    pub fn read(
        plane: &Plane,
        light_area: &LightArea,
        corridor: &Corridor,
        [minor_pix, slope]: [f64; 2],
        half: usize,
    ) -> Self {
        let height = 2 * half + 1;
        let middle = 0.5 * corridor.len() as f64;
        let lowest: Vec<isize> = corridor
            .centre
            .iter()
            .enumerate()
            .map(|(index, centre)| {
                let line = centre + minor_pix + slope * (index as f64 - middle);
                line.round() as isize - half as isize
            })
            .collect();
        let mut values = vec![f32::NAN; lowest.len() * height];
        let (lit_major, lit_minor) = if corridor.is_along_rows {
            (light_area.columns.clone(), light_area.rows.clone())
        } else {
            (light_area.rows.clone(), light_area.columns.clone())
        };
        for (index, (lowest, column)) in lowest.iter().zip(values.chunks_exact_mut(height)).enumerate() {
            let major = corridor.first + index;
            if !lit_major.contains(&major) {
                continue;
            }
            for (offset, value) in column.iter_mut().enumerate() {
                let Ok(minor) = usize::try_from(lowest + offset as isize) else { continue };
                if lit_minor.contains(&minor) {
                    let (row, column) = if corridor.is_along_rows { (minor, major) } else { (major, minor) };
                    *value = plane.values()[row * plane.columns() + column];
                }
            }
        }
        let (is_along_rows, first) = (corridor.is_along_rows, corridor.first);
        Self { is_along_rows, first, lowest, height, values, cos: corridor.cos() }
    }

    /// Returns the number of columns of the band.
    pub fn len(&self) -> usize {
        self.lowest.len()
    }

    /// Returns the number of pixels on each side of the line.
    pub fn half(&self) -> usize {
        self.height / 2
    }

    /// Returns the light of a patch in the pixels of the band.
    pub fn template(&self, patch: &Patch) -> Vec<f32> {
        let mut template = vec![0.0; self.values.len()];
        for span in patch.iter() {
            for (column, value) in (span.first_column..).zip(span.values) {
                let (major, minor) = if self.is_along_rows { (column, span.row) } else { (span.row, column) };
                let Some(index) = major.checked_sub(self.first).filter(|index| *index < self.len()) else { continue };
                let offset = minor as isize - self.lowest[index];
                if offset >= 0 && (offset as usize) < self.height {
                    template[index * self.height + offset as usize] = *value;
                }
            }
        }
        template
    }

    /// Returns the difference of the first minor coordinates of two neighbouring columns.
    pub fn step(&self, from: usize, to: usize) -> isize {
        self.lowest[to] - self.lowest[from]
    }

    /// Returns the position in the frame of a pixel of the band.
    pub fn pixel(&self, index: usize, offset: usize) -> PixelPosition {
        let (major, minor) = ((self.first + index) as f64, (self.lowest[index] + offset as isize) as f64);
        if self.is_along_rows { PixelPosition { x: major, y: minor } } else { PixelPosition { x: minor, y: major } }
    }
}

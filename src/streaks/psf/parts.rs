//! Pixels cut into finer ones, on which the drawing is done.

use crate::images::PixelPosition;

/// Oblong pixels are taken for squares up to this difference of their sides; what is drawn is as much wider or narrower at most.
const SQUARE_WITHIN: f64 = 0.01;
/// Most parts of a side.
const MOST: usize = 20;

/// Into how many parts a pixel is cut: seeing narrower than a pixel is drawn on finer ones, oblong pixels are cut into squares.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Along a row.
    pub x: usize,
    /// Along a column.
    pub y: usize,
}

impl Parts {
    /// The fewest parts for seeing of a full width at half maximum, pixels of the mean scale, and pixels `aspect` times as wide as high.
    pub(super) fn of(fwhm_pix: f64, aspect: f64) -> Self {
        let candidates = (1..=MOST).flat_map(|x| (1..=MOST).map(move |y| Self { x, y }));
        let is_fine = |parts: &Self| fwhm_pix * parts.mean() >= 1.0;
        // Fewest among those that are square enough, else the squarest.
        let cost = |parts: &Self| {
            let off = (parts.x as f64 / parts.y as f64 / aspect).ln().abs();
            (off.max(SQUARE_WITHIN), parts.x * parts.y)
        };
        let best = candidates.filter(is_fine).min_by(|a, b| {
            let ((a_off, a_count), (b_off, b_count)) = (cost(a), cost(b));
            a_off.total_cmp(&b_off).then(a_count.cmp(&b_count))
        });
        best.unwrap_or(Self { x: MOST, y: MOST })
    }

    /// Parts in a length of a mean pixel.
    pub fn mean(&self) -> f64 {
        ((self.x * self.y) as f64).sqrt()
    }

    /// True where a pixel stays whole.
    pub fn is_whole(&self) -> bool {
        self.x == 1 && self.y == 1
    }

    /// A place in parts.
    pub fn place(&self, at: PixelPosition) -> PixelPosition {
        let part = |pix: f64, count: usize| (pix + 0.5) * count as f64 - 0.5;
        PixelPosition { x: part(at.x, self.x), y: part(at.y, self.y) }
    }

    /// Where the parts of a pixel lie about its centre, in parts.
    pub(super) fn offsets(&self) -> impl Iterator<Item = [f64; 2]> {
        let Self { x, y } = *self;
        let offset = |number: usize, count: usize| number as f64 - 0.5 * (count as f64 - 1.0);
        (0..y).flat_map(move |row| (0..x).map(move |column| [offset(column, x), offset(row, y)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_as_few_parts_as_do() {
        for (fwhm_pix, aspect, x, y) in [
            (3.5, 1.0, 1, 1),
            (1.0, 1.003, 1, 1),
            (0.99, 1.0, 2, 2),
            (0.4, 1.0, 3, 3),
            (0.1, 1.0, 10, 10),
            (3.5, 2.0, 2, 1),
            (3.5, 0.5, 1, 2),
            (0.5, 1.5, 3, 2),
            (3.5, 1.1, 11, 10),
        ] {
            assert_eq!(Parts::of(fwhm_pix, aspect), Parts { x, y }, "{fwhm_pix} {aspect}");
        }
        // Any ratio to a hundredth, near the ends of the range to three.
        for i in 0..1000 {
            let aspect = 0.4 * 6.25f64.powf(f64::from(i) / 999.0);
            let parts = Parts::of(3.0, aspect);
            assert!((parts.x as f64 / parts.y as f64 / aspect - 1.0).abs() < 0.03, "{aspect} {parts:?}");
        }
    }
}

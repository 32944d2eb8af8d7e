//! Light that is to be added to an image, kept until the image is written.

use std::ops::Range;

/// Pixels in a block.
const BLOCK_PIXELS: usize = 16;

/// Sums over the touched pixels of an image, physical values, by the pixels' numbers row after row.
#[derive(Debug)]
pub(super) struct Deltas {
    pixels: usize,
    /// For each block one more than its number among those touched, 0 where it is not touched.
    slots: Vec<u32>,
    sums: Vec<f64>,
}

impl Deltas {
    pub(super) fn new(pixels: usize) -> Self {
        Self { pixels, slots: vec![0; pixels.div_ceil(BLOCK_PIXELS)], sums: Vec::new() }
    }

    /// Adds to pixels from a number on.
    pub(super) fn add(&mut self, start: usize, values: &[f32]) {
        let mut rest = values;
        let mut pixel = start;
        while !rest.is_empty() {
            let (block, within) = (pixel / BLOCK_PIXELS, pixel % BLOCK_PIXELS);
            let (part, more) = rest.split_at(rest.len().min(BLOCK_PIXELS - within));
            if self.slots[block] == 0 {
                self.sums.resize(self.sums.len() + BLOCK_PIXELS, 0.0);
                self.slots[block] = (self.sums.len() / BLOCK_PIXELS) as u32;
            }
            let place = (self.slots[block] as usize - 1) * BLOCK_PIXELS + within;
            for (sum, value) in self.sums[place..].iter_mut().zip(part) {
                *sum += f64::from(*value);
            }
            pixel += part.len();
            rest = more;
        }
    }

    /// Hands out the sums that are not zero among pixels of a range, in order.
    pub(super) fn each(&self, range: Range<usize>, mut each: impl FnMut(usize, f64)) {
        let range = range.start..range.end.min(self.pixels);
        for block in range.start / BLOCK_PIXELS..range.end.div_ceil(BLOCK_PIXELS) {
            if self.slots[block] == 0 {
                continue;
            }
            let place = (self.slots[block] as usize - 1) * BLOCK_PIXELS;
            for (pixel, sum) in (block * BLOCK_PIXELS..).zip(&self.sums[place..place + BLOCK_PIXELS]) {
                if *sum != 0.0 && range.contains(&pixel) {
                    each(pixel, *sum);
                }
            }
        }
    }

    /// Hands out the sums as [`each`](Deltas::each) does, and forgets them.
    pub(super) fn take(&mut self, range: Range<usize>, mut each: impl FnMut(usize, f64)) {
        let mut taken = Vec::new();
        self.each(range, |pixel, sum| {
            each(pixel, sum);
            taken.push(pixel);
        });
        for pixel in taken {
            let place = (self.slots[pixel / BLOCK_PIXELS] as usize - 1) * BLOCK_PIXELS + pixel % BLOCK_PIXELS;
            self.sums[place] = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_sums_are_handed_out_once() {
        let mut deltas = Deltas::new(100);
        deltas.add(10, &[1.0; 20]);
        deltas.add(15, &[0.5, 0.0]);
        deltas.add(99, &[2.0]);
        let mut all = Vec::new();
        deltas.take(12..40, |pixel, sum| all.push((pixel, sum)));
        assert_eq!(all.len(), 18);
        assert_eq!((all[0], all[3], all[4]), ((12, 1.0), (15, 1.5), (16, 1.0)));
        all.clear();
        deltas.take(0..100, |pixel, sum| all.push((pixel, sum)));
        assert_eq!(all, [(10, 1.0), (11, 1.0), (99, 2.0)]);
    }
}

//! Light to be added to pixels, and the counts of pixels that changed.

use std::borrow::Cow;
use std::ops::Range;

/// What is added to the pixels of an image, physical values, by the pixels' numbers row after row.
#[derive(Debug, Default)]
pub(super) struct Deltas<'a> {
    /// Stretches of neighbouring pixels.
    stretches: Vec<Stretch<'a>>,
    /// Pixels of the longest.
    longest: usize,
}

#[derive(Debug)]
struct Stretch<'a> {
    start: usize,
    values: Cow<'a, [f32]>,
}

impl Stretch<'_> {
    fn end(&self) -> usize {
        self.start + self.values.len()
    }

    /// Adds it to sums of pixels from `start` on.
    fn sum_up(&self, start: usize, sums: &mut Vec<f64>) {
        let before = start.saturating_sub(self.start);
        let values = &self.values[before..];
        let place = self.start + before - start;
        if sums.len() < place + values.len() {
            sums.resize(place + values.len(), 0.0);
        }
        for (sum, value) in sums[place..].iter_mut().zip(values) {
            *sum += f64::from(*value);
        }
    }
}

impl<'a> Deltas<'a> {
    /// Adds to pixels from a number on.
    pub(super) fn add(&mut self, start: usize, values: Cow<'a, [f32]>) {
        self.longest = self.longest.max(values.len());
        self.stretches.push(Stretch { start, values });
    }

    /// Sorts what was added by its first pixel; [`each`](Deltas::each) needs that.
    pub(super) fn sort(&mut self) {
        // The stretches of one streak are in order: merging a few such runs is quick.
        self.stretches.sort_by_key(|stretch| stretch.start);
    }

    /// Calls a function with each pixel of a range whose sum is not zero, in order.
    pub(super) fn each(&self, range: Range<usize>, mut each: impl FnMut(usize, f64)) {
        let mut sums: Vec<f64> = Vec::new();
        let mut rest = self.within(&range).peekable();
        while let Some(first) = rest.next() {
            let (start, mut end) = (first.start.max(range.start), first.end());
            sums.clear();
            first.sum_up(start, &mut sums);
            while let Some(next) = rest.next_if(|next| next.start < end) {
                end = end.max(next.end());
                next.sum_up(start, &mut sums);
            }
            for (pixel, sum) in (start..end.min(range.end)).zip(&sums) {
                if *sum != 0.0 {
                    each(pixel, *sum);
                }
            }
        }
    }

    /// Stretches that have pixels in a range.
    fn within(&self, range: &Range<usize>) -> impl Iterator<Item = &Stretch<'a>> {
        let (first, last) = self.reaching(range);
        let start = range.start;
        self.stretches[first..last].iter().filter(move |stretch| stretch.end() > start)
    }

    /// Among which stretches those are that have pixels in a range.
    fn reaching(&self, range: &Range<usize>) -> (usize, usize) {
        let first = self.stretches.partition_point(|stretch| stretch.start + self.longest <= range.start);
        let last = self.stretches.partition_point(|stretch| stretch.start < range.end);
        (first.min(last), last)
    }
}

/// Counts of pixels that were to be changed.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Changed {
    /// Pixels whose stored number is another now.
    pub pixels: usize,
    /// Pixels that would have left the range of their type and are at its end.
    pub clipped: usize,
    /// Pixels without a value (NaN, BLANK), which stayed so.
    pub without_value: usize,
}

impl std::ops::AddAssign for Changed {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.clipped += other.clipped;
        self.without_value += other.without_value;
    }
}

/// What became of one pixel that was set.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Outcome {
    /// Its stored number is another one.
    pub is_other: bool,
    /// It was held within the range.
    pub is_clipped: bool,
}

impl Changed {
    /// Stores a new physical value in place of an old one, where there was one and the new one is another that is finite.
    pub(super) fn set(&mut self, old: f64, new: f64, store: impl FnOnce(f64) -> Outcome) {
        if old.is_nan() {
            self.without_value += 1;
        } else if new != old && new.is_finite() {
            let outcome = store(new);
            self.pixels += usize::from(outcome.is_other);
            self.clipped += usize::from(outcome.is_clipped);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn verif_sums_are_those_of_a_plain_plane(
            added in prop::collection::vec((0usize..300, prop::collection::vec(-4i8..4, 1..40)), 0..40),
            cuts in prop::collection::vec(0usize..360, 0..6),
        ) {
            let mut plane = vec![0.0; 400];
            let mut deltas = Deltas::default();
            for (start, values) in &added {
                let values: Vec<f32> = values.iter().map(|value| f32::from(*value)).collect();
                plane[*start..].iter_mut().zip(&values).for_each(|(pixel, value)| *pixel += f64::from(*value));
                deltas.add(*start, Cow::Owned(values));
            }
            let mut handed = Vec::new();
            deltas.sort();
            let mut cuts = cuts;
            cuts.extend([0, 400]);
            cuts.sort_unstable();
            for pair in cuts.windows(2) {
                deltas.each(pair[0]..pair[1], |pixel, sum| handed.push((pixel, sum)));
            }
            let expected: Vec<(usize, f64)> = plane.into_iter().enumerate().filter(|(_, sum)| *sum != 0.0).collect();
            prop_assert_eq!(handed, expected);
        }
    }
}

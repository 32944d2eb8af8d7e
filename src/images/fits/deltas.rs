//! Light to be added to the pixels of an image, and the numbers of pixels that changed.

use std::borrow::Cow;
use std::ops::Range;

/// Physical values to be added to the pixels of an image. Pixels are indexed row by row.
#[derive(Debug, Default)]
pub(super) struct Deltas<'a> {
    /// Spans of adjacent pixels.
    spans: Vec<Span<'a>>,
    /// Length of the longest span, pixels.
    longest: usize,
}

#[derive(Debug)]
struct Span<'a> {
    start: usize,
    values: Cow<'a, [f32]>,
}

impl Span<'_> {
    fn end(&self) -> usize {
        self.start + self.values.len()
    }

    /// Adds the values of the span to `sums`, whose first element is the pixel `start`.
    fn sum_up(&self, start: usize, sums: &mut Vec<f64>) {
        let before = start.saturating_sub(self.start);
        let values = &self.values[before..];
        let index = self.start + before - start;
        if sums.len() < index + values.len() {
            sums.resize(index + values.len(), 0.0);
        }
        for (sum, value) in sums[index..].iter_mut().zip(values) {
            *sum += f64::from(*value);
        }
    }
}

impl<'a> Deltas<'a> {
    /// Adds values to adjacent pixels, beginning at the index `start`.
    pub(super) fn add(&mut self, start: usize, values: Cow<'a, [f32]>) {
        self.longest = self.longest.max(values.len());
        self.spans.push(Span { start, values });
    }

    /// Sorts the spans by their first pixel, as [`each`](Deltas::each) requires.
    pub(super) fn sort(&mut self) {
        // The spans of one streak are already in order, so that only few ordered runs must be merged.
        self.spans.sort_by_key(|span| span.start);
    }

    /// Calls a function, in order, for each pixel of a range whose sum is not zero.
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

    /// Returns the spans that have pixels in a range.
    fn within(&self, range: &Range<usize>) -> impl Iterator<Item = &Span<'a>> {
        let (first, last) = self.reaching(range);
        let start = range.start;
        self.spans[first..last].iter().filter(move |span| span.end() > start)
    }

    /// Returns the index range of the spans that may have pixels in a range of pixels.
    fn reaching(&self, range: &Range<usize>) -> (usize, usize) {
        let first = self.spans.partition_point(|span| span.start + self.longest <= range.start);
        let last = self.spans.partition_point(|span| span.start < range.end);
        (first.min(last), last)
    }
}

/// Numbers of pixels to which light was added.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Changed {
    /// Pixels whose stored number has changed.
    pub pixels: usize,
    /// Pixels limited to the largest or smallest number of their type.
    pub clipped: usize,
    /// Pixels without a value (NaN, BLANK); they were not changed.
    pub without_value: usize,
}

impl std::ops::AddAssign for Changed {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.clipped += other.clipped;
        self.without_value += other.without_value;
    }
}

/// Result of storing one pixel.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Outcome {
    /// True if the stored number has changed.
    pub is_other: bool,
    /// True if the value was limited to the range of the type.
    pub is_clipped: bool,
}

impl Changed {
    /// Stores a new physical value if the old value is not NaN and the new value is finite and different.
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

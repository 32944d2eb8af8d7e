//! Light that is to be added to an image, kept until the image is written.

use std::borrow::Cow;
use std::ops::Range;

/// What is added to the pixels of an image, physical values, by the pixels' numbers row after row.
#[derive(Debug, Default)]
pub(super) struct Deltas<'a> {
    /// Stretches of neighbouring pixels; by their first pixels once they are [settled](Deltas::settle).
    stretches: Vec<Stretch<'a>>,
    /// Pixels of the longest.
    longest: usize,
    is_settled: bool,
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
        self.is_settled = false;
    }

    /// Brings what was added into the order of the pixels; [`each`](Deltas::each) wants it.
    pub(super) fn settle(&mut self) {
        if !self.is_settled {
            // Those of one streak are in order: merging a few such runs is quick.
            self.stretches.sort_by_key(|stretch| stretch.start);
            self.is_settled = true;
        }
    }

    /// Hands out the sums that are not zero among pixels of a range, in order.
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

    /// Hands out the sums as [`each`](Deltas::each) does, and forgets them.
    pub(super) fn take(&mut self, range: Range<usize>, each: impl FnMut(usize, f64)) {
        self.settle();
        self.each(range.clone(), each);
        let (first, last) = self.reaching(&range);
        for stretch in &mut self.stretches[first..last] {
            let (from, to) = (stretch.start.max(range.start), stretch.end().min(range.end));
            if from < to {
                stretch.values.to_mut()[from - stretch.start..to - stretch.start].fill(0.0);
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn verif_sums_are_handed_out_once() {
        let mut deltas = Deltas::default();
        deltas.add(10, Cow::Borrowed(&[1.0; 20]));
        deltas.add(15, Cow::Borrowed(&[0.5, 0.0]));
        deltas.add(99, Cow::Borrowed(&[2.0]));
        let mut all = Vec::new();
        deltas.take(12..40, |pixel, sum| all.push((pixel, sum)));
        assert_eq!(all.len(), 18);
        assert_eq!((all[0], all[3], all[4]), ((12, 1.0), (15, 1.5), (16, 1.0)));
        all.clear();
        deltas.take(0..100, |pixel, sum| all.push((pixel, sum)));
        assert_eq!(all, [(10, 1.0), (11, 1.0), (99, 2.0)]);
    }

    proptest! {
        #[test]
        fn verif_sums_are_those_of_a_plain_plane(
            added in prop::collection::vec((0usize..300, prop::collection::vec(-4i8..4, 1..40)), 0..40),
            cuts in prop::collection::vec(0usize..360, 0..6),
            taken in (0usize..340, 0usize..60),
        ) {
            let mut plane = vec![0.0; 400];
            let mut deltas = Deltas::default();
            for (start, values) in &added {
                let values: Vec<f32> = values.iter().map(|value| f32::from(*value)).collect();
                plane[*start..].iter_mut().zip(&values).for_each(|(pixel, value)| *pixel += f64::from(*value));
                deltas.add(*start, Cow::Owned(values));
            }
            let mut handed = Vec::new();
            deltas.take(taken.0..taken.0 + taken.1, |pixel, sum| handed.push((pixel, sum)));
            let mut cuts = cuts;
            cuts.extend([0, 400]);
            cuts.sort_unstable();
            for pair in cuts.windows(2) {
                deltas.each(pair[0]..pair[1], |pixel, sum| handed.push((pixel, sum)));
            }
            handed.sort_by_key(|(pixel, _)| *pixel);
            let expected: Vec<(usize, f64)> = plane.into_iter().enumerate().filter(|(_, sum)| *sum != 0.0).collect();
            prop_assert_eq!(handed, expected);
        }
    }
}

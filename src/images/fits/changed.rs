//! What a change did to pixels.

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

//! Which colour a magnitude has: viridis, the bright end for bright satellites.

/// Magnitudes from the bright to the faint end of the colours.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MagnitudeScale {
    /// Shown in yellow, as is everything brighter.
    pub brightest_mag: f64,
    /// Shown in dark violet, as is everything fainter.
    pub faintest_mag: f64,
    /// True where something brighter is shown.
    pub has_brighter: bool,
    /// True where something fainter is shown.
    pub has_fainter: bool,
}

/// Share of the magnitudes that may lie beyond each end.
const BEYOND: f64 = 0.01;

/// The ends lie on multiples of this, mag.
const ROUND_MAG: f64 = 0.5;

impl MagnitudeScale {
    /// For magnitudes as they come: 98 in 100 of them lie within, and the ends on half magnitudes.
    ///
    /// `None` where there is no magnitude.
    pub fn of(magnitudes: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut all: Vec<f64> = magnitudes.into_iter().filter(|magnitude| magnitude.is_finite()).collect();
        all.sort_unstable_by(f64::total_cmp);
        let (first, last) = (*all.first()?, *all.last()?);
        let beyond = (BEYOND * all.len() as f64) as usize;
        let brightest_mag = (all[beyond] / ROUND_MAG).floor() * ROUND_MAG;
        // One value alone has a bar of half a magnitude.
        let faintest_mag =
            ((all[all.len() - 1 - beyond] / ROUND_MAG).ceil() * ROUND_MAG).max(brightest_mag + ROUND_MAG);
        Some(Self {
            brightest_mag,
            faintest_mag,
            has_brighter: first < brightest_mag,
            has_fainter: last > faintest_mag,
        })
    }

    /// 0 at the faint end, 1 at the bright end.
    pub fn brightness(&self, magnitude: f64) -> f64 {
        ((self.faintest_mag - magnitude) / (self.faintest_mag - self.brightest_mag)).clamp(0.0, 1.0)
    }

    /// Red, green, blue.
    pub fn colour(&self, magnitude: f64) -> [u8; 3] {
        let colour = colorous::VIRIDIS.eval_continuous(self.brightness(magnitude));
        [colour.r, colour.g, colour.b]
    }

    /// Whole magnitudes on the bar; halves where it is short.
    pub(super) fn ticks(&self) -> Vec<f64> {
        let step = if self.faintest_mag - self.brightest_mag > 3.0 { 1.0 } else { ROUND_MAG };
        let first = (self.brightest_mag / step).ceil() as i64;
        let last = (self.faintest_mag / step).floor() as i64;
        (first..=last).map(|count| count as f64 * step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_a_scale_holds_nearly_all_and_says_what_it_leaves_out() {
        let scale = MagnitudeScale::of((0..1000).map(|n| 5.2 + 0.003 * f64::from(n))).unwrap();
        assert_eq!((scale.brightest_mag, scale.faintest_mag), (5.0, 8.5));
        assert!(!scale.has_brighter && !scale.has_fainter);
        let outlier = MagnitudeScale::of((0..1000).map(|n| if n == 0 { 1.0 } else { 6.2 })).unwrap();
        assert_eq!((outlier.brightest_mag, outlier.faintest_mag, outlier.has_brighter), (6.0, 6.5, true));
        assert_eq!(MagnitudeScale::of([f64::NAN]), None);
    }

    #[test]
    fn verif_bright_satellites_have_bright_colours() {
        let scale = MagnitudeScale { brightest_mag: 4.0, faintest_mag: 9.0, has_brighter: false, has_fainter: false };
        // Luma of sRGB.
        let luma = |magnitude: f64| {
            let [red, green, blue] = scale.colour(magnitude).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let lumas: Vec<f64> = (0..=50).map(|n| luma(4.0 + 0.1 * f64::from(n))).collect();
        assert!(lumas.windows(2).all(|pair| pair[0] > pair[1]), "{lumas:?}");
        assert_eq!(scale.colour(3.0), scale.colour(4.0));
        assert_eq!(scale.ticks(), [4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    }
}

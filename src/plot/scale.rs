//! Colour scales and the labels of their bars. All scales are readable with colour blindness.

use colorous::{CIVIDIS, RED_BLUE, VIRIDIS};

/// Quantity shown by colours.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// Magnitudes, in viridis, with bright colours for bright satellites.
    Magnitude,
    /// Numbers of samples, 1 or more, in viridis on a logarithmic scale.
    Count,
    /// Interquartile ranges of magnitudes, mag, in cividis, from 0.
    Spread,
    /// Observed minus computed magnitudes, mag: blue below 0, red above 0, symmetric about 0.
    Residual,
    /// Streaks per exposure, 0 or more, in viridis, from 0.
    Rate,
}

/// Colour scale of a quantity.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ColourScale {
    /// Quantity shown.
    pub quantity: Quantity,
    /// Value at the lower end of the scale; smaller values get its colour.
    pub least: f64,
    /// Value at the upper end of the scale; larger values get its colour.
    pub greatest: f64,
    /// True if the picture shows values below the lower end.
    pub has_lower: bool,
    /// True if the picture shows values above the upper end.
    pub has_higher: bool,
}

/// Length of a bar, mag, above which ticks are at whole instead of half magnitudes.
const LONG_MAG: f64 = 3.0;

/// Fraction of the values that may lie beyond each end of the scale.
const BEYOND: f64 = 0.01;

/// Largest upper end of a scale of rates, in medians of the rates above 0. A few directions with far higher rates, such
/// as the geostationary belt, do not set the scale.
const MOST_MEDIANS: f64 = 5.0;

impl Quantity {
    /// Returns the short label of the quantity.
    fn label(self) -> &'static str {
        match self {
            Self::Magnitude => "mag",
            Self::Count => "samples",
            Self::Spread => "IQR, mag",
            Self::Residual => "O−C, mag",
            Self::Rate => "streaks",
        }
    }

    /// Returns the step to multiples of which the ends of a bar are rounded.
    fn round(self) -> f64 {
        match self {
            Self::Magnitude => 0.5,
            Self::Count => 1.0,
            Self::Spread | Self::Residual | Self::Rate => 0.1,
        }
    }

    /// Returns the ends of the scale for a picture without values.
    fn usual(self) -> [f64; 2] {
        match self {
            Self::Magnitude => [4.0, 9.0],
            Self::Count => [1.0, 100.0],
            Self::Spread => [0.0, 1.0],
            Self::Residual => [-0.5, 0.5],
            Self::Rate => [0.0, 1.0],
        }
    }
}

impl ColourScale {
    /// Creates a scale with round ends that contains 98 % of the values. Values that are not finite are ignored. A
    /// scale of rates ends at the highest rate, or, if that is less, at five times the median of the rates above 0.
    pub fn from_values(quantity: Quantity, values: impl IntoIterator<Item = f64>) -> Self {
        let mut all: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        all.sort_unstable_by(f64::total_cmp);
        let (Some(first), Some(last)) = (all.first().copied(), all.last().copied()) else {
            let [least, greatest] = quantity.usual();
            return Self { quantity, least, greatest, has_lower: false, has_higher: false };
        };
        let beyond = (BEYOND * all.len() as f64) as usize;
        let (low, high) = (all[beyond], all[all.len() - 1 - beyond]);
        let round = quantity.round();
        let (least, greatest) = match quantity {
            Quantity::Magnitude => {
                let ends = |round: f64| ((low / round).floor() * round, (high / round).ceil() * round);
                let (least, greatest) = ends(round);
                // Both ends have labels, so both must be multiples of the step of the ticks.
                if greatest - least > LONG_MAG { ends(1.0) } else { (least, greatest) }
            }
            Quantity::Count => {
                let least = round_count(low, f64::floor);
                // A factor of 4 or more contains at least three of the values 1, 2 and 5 times powers of ten.
                (least, round_count(high, f64::ceil).max(round_count(4.0 * least, f64::ceil)))
            }
            Quantity::Spread => (0.0, (high / round).ceil() * round),
            Quantity::Rate => {
                let positive = &all[all.partition_point(|rate| *rate <= 0.0)..];
                let median = positive.get(positive.len() / 2).copied().unwrap_or(0.0);
                (0.0, round_rate(last.min(MOST_MEDIANS * median)))
            }
            Quantity::Residual => {
                let end = (low.abs().max(high.abs()) / round).ceil().max(1.0) * round;
                (-end, end)
            }
        };
        // If there is only one value, the scale is widened.
        let greatest = if greatest > least { greatest } else { least + round };
        Self { quantity, least, greatest, has_lower: first < least, has_higher: last > greatest }
    }

    /// Returns the same scale for a picture that also shows `values`: the ends beyond which some of the values lie are
    /// marked.
    pub fn showing(self, values: impl IntoIterator<Item = f64>) -> Self {
        values.into_iter().fold(self, |scale, value| Self {
            has_lower: scale.has_lower || value < scale.least,
            has_higher: scale.has_higher || value > scale.greatest,
            ..scale
        })
    }

    /// Returns the height of a value on the bar, 0 at the lower end and 1 at the upper end. At the top are bright
    /// satellites, many samples, a wide spread, and residuals observed fainter than computed.
    pub fn share(&self, value: f64) -> f64 {
        let share = match self.quantity {
            Quantity::Magnitude => (self.greatest - value) / (self.greatest - self.least),
            Quantity::Count => (value / self.least).ln() / (self.greatest / self.least).ln(),
            Quantity::Spread | Quantity::Residual | Quantity::Rate => {
                (value - self.least) / (self.greatest - self.least)
            }
        };
        share.clamp(0.0, 1.0)
    }

    /// Returns the short label that is drawn above the bar.
    pub(super) fn label(&self) -> String {
        let is_clipped = self.quantity == Quantity::Rate && self.has_higher;
        format!("{}{}", self.quantity.label(), if is_clipped { ", clipped" } else { "" })
    }

    /// Returns the colour of a value as red, green and blue.
    pub fn colour(&self, value: f64) -> [u8; 3] {
        self.colour_at(self.share(value))
    }

    /// Returns the colour at a height of the bar between 0 and 1 as red, green and blue.
    pub(super) fn colour_at(&self, share: f64) -> [u8; 3] {
        let colour = match self.quantity {
            Quantity::Magnitude | Quantity::Count | Quantity::Rate => VIRIDIS.eval_continuous(share),
            Quantity::Spread => CIVIDIS.eval_continuous(share),
            Quantity::Residual => RED_BLUE.eval_continuous(1.0 - share),
        };
        [colour.r, colour.g, colour.b]
    }

    /// Returns round values with their labels. An end of the bar beyond which values lie is marked.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let span = self.greatest - self.least;
        let values = match self.quantity {
            // Both ends are multiples of 1 for long bars and of 0.5 for others.
            Quantity::Magnitude => {
                let step = if span > LONG_MAG {
                    1.0
                } else if span >= 1.0 {
                    0.5
                } else {
                    0.1
                };
                multiples(step, self.least, self.greatest)
            }
            Quantity::Count => counts(self.least, self.greatest),
            Quantity::Rate => (0..=4).map(|part| f64::from(part) * self.greatest / 4.0).collect(),
            Quantity::Spread | Quantity::Residual => {
                let steps = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0];
                let step = steps.into_iter().find(|step| span / step <= 8.0).unwrap_or(span / 4.0);
                let mut values = multiples(step, self.least, self.greatest);
                // The ends have ticks of their own; other ticks near an end are omitted.
                for end in [self.least, self.greatest] {
                    values.retain(|value| *value == end || (value - end).abs() > 0.6 * step);
                    if !values.contains(&end) {
                        values.push(end);
                    }
                }
                values
            }
        };
        // All labels of a bar have the decimals that the steps need.
        let is_whole = |value: f64| (value - value.round()).abs() <= 1e-6;
        let decimals =
            |value: f64| (0..12).find(|places| is_whole(value * 10_f64.powi(*places))).unwrap_or(12) as usize;
        let places = values.iter().map(|value| decimals(*value)).max().unwrap_or(0);
        let label = |value: f64| {
            let beyond = if self.has_lower && value <= self.least {
                "≤ "
            } else if self.has_higher && value >= self.greatest {
                "≥ "
            } else {
                ""
            };
            // Zero is written without a sign.
            let number = format!("{:.places$}", if value.abs() < 1e-9 { 0.0 } else { value });
            (value, format!("{beyond}{}", number.replace('-', "−")))
        };
        values.into_iter().map(label).collect()
    }
}

/// Returns the multiples of a step between two values.
fn multiples(step: f64, least: f64, greatest: f64) -> Vec<f64> {
    let (first, last) = ((least / step - 1e-9).ceil() as i64, (greatest / step + 1e-9).floor() as i64);
    (first..=last).map(|count| count as f64 * step).collect()
}

/// Returns the next larger 1, 2, 4 or 8 times a power of ten, of which a quarter is a round number.
fn round_rate(value: f64) -> f64 {
    if value <= 0.0 {
        return Quantity::Rate.usual()[1];
    }
    let decade = 10_f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 4.0, 8.0, 10.0].map(|step| step * decade);
    steps.into_iter().find(|step| *step >= value * (1.0 - 1e-9)).unwrap_or(10.0 * decade)
}

/// Returns the next 1, 2 or 5 times a power of ten, at least 1, in the direction given by `end`.
fn round_count(value: f64, end: fn(f64) -> f64) -> f64 {
    let value = value.max(1.0);
    let is_up = end(0.5) > 0.0;
    let decade = 10_f64.powf(value.log10().floor());
    let mut steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade).into_iter();
    let found = if is_up { steps.find(|step| *step >= value) } else { steps.rfind(|step| *step <= value) };
    found.unwrap_or(value)
}

/// Returns the values 1, 2 and 5 times powers of ten between two values, or only the powers of ten if there are many.
fn counts(least: f64, greatest: f64) -> Vec<f64> {
    let (first, last) = (least.log10().floor() as i32, greatest.log10().ceil() as i32);
    let steps: &[f64] = if last - first > 2 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let all = (first..=last).flat_map(|decade| steps.iter().map(move |step| step * 10_f64.powi(decade)));
    let mut values: Vec<f64> = all.filter(|value| (least..=greatest).contains(value)).collect();
    for end in [least, greatest] {
        if !values.contains(&end) {
            values.push(end);
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_a_scale_contains_nearly_all_values_and_marks_the_others() {
        let scale = ColourScale::from_values(Quantity::Magnitude, (0..1000).map(|n| 5.2 + 0.003 * f64::from(n)));
        assert_eq!((scale.least, scale.greatest), (5.0, 9.0));
        assert!(!scale.has_lower && !scale.has_higher);
        let outlier = ColourScale::from_values(Quantity::Magnitude, (0..1000).map(|n| if n == 0 { 1.0 } else { 6.2 }));
        assert_eq!((outlier.least, outlier.greatest, outlier.has_lower), (6.0, 6.5, true));
        assert_eq!(outlier.ticks()[0], (6.0, "≤ 6.0".to_owned()));
        assert_eq!(ColourScale::from_values(Quantity::Magnitude, [f64::NAN]).least, 4.0);
        let more = scale.showing([6.0, 9.5]);
        assert_eq!((more.has_lower, more.has_higher, more.greatest), (false, true, 9.0));
    }

    /// One geostationary direction in a hundred has a rate sixty times that of the others.
    #[test]
    fn verif_a_few_high_rates_do_not_set_the_scale() {
        let rates = |high: f64| (0..300).map(move |n| if n % 100 == 7 { high } else { f64::from(n % 4) * 0.05 });
        let scale = ColourScale::from_values(Quantity::Rate, rates(6.0));
        // Five times the median 0.1 is 0.5, and the next round end is 0.8.
        assert_eq!((scale.least, scale.greatest, scale.has_higher), (0.0, 0.8, true));
        let ticks: Vec<String> = scale.ticks().into_iter().map(|tick| tick.1).collect();
        assert_eq!(ticks, ["0.0", "0.2", "0.4", "0.6", "≥ 0.8"]);
        let even = ColourScale::from_values(Quantity::Rate, rates(0.15));
        assert_eq!((even.greatest, even.has_higher), (0.2, false));
        assert_eq!(ColourScale::from_values(Quantity::Rate, [0.0, 0.0]).greatest, 1.0);
        // Only geostationary satellites are lit: they set the scale.
        assert_eq!(ColourScale::from_values(Quantity::Rate, [0.0, 0.0, 0.0, 6.0, 7.0]).greatest, 8.0);
    }

    #[test]
    fn verif_every_bar_has_three_ticks_with_equal_decimals() {
        let mut least = usize::MAX;
        for quantity in [Quantity::Magnitude, Quantity::Count, Quantity::Spread, Quantity::Residual, Quantity::Rate] {
            for low in [1.0, 1.3, 2.2, 4.9, 8.2] {
                for span in [0.0, 0.04, 0.3, 0.7, 1.2, 2.9, 3.3, 8.0, 700.0] {
                    let scale = ColourScale::from_values(quantity, [low, low + span]);
                    let ticks = scale.ticks();
                    least = least.min(ticks.len());
                    let decimals = |label: &str| label.split_once('.').map_or(0, |(_, digits)| digits.len());
                    assert!(
                        ticks.iter().all(|(_, label)| decimals(label) == decimals(&ticks[0].1)),
                        "{quantity:?} {low} {span}: {ticks:?}"
                    );
                    assert!(ticks.len() >= 3, "{quantity:?} {low} {span}: {ticks:?}");
                }
            }
        }
        assert!(least < 5, "{least}");
    }

    /// Values beyond a bar are marked at its end, so both ends have labels, wherever the values begin and end.
    #[test]
    fn verif_both_ends_of_a_bar_have_labels() {
        for (low, high) in [(4.6, 8.4), (4.4, 8.6), (5.1, 8.4), (5.1, 5.9), (4.5, 7.5), (4.5, 7.6), (3.9, 12.2)] {
            // One in two hundred is beyond each end.
            let values = (0..1000).map(|n| match n {
                0..5 => low - 3.0,
                5..10 => high + 3.0,
                _ => low + (high - low) * f64::from(n - 10) / 989.0,
            });
            let scale = ColourScale::from_values(Quantity::Magnitude, values);
            let ticks = scale.ticks();
            let label = |end: f64| &ticks.iter().find(|(value, _)| (value - end).abs() < 1e-9).unwrap().1;
            assert!(label(scale.least).starts_with("≤ "), "{low} {high}: {ticks:?}");
            assert!(label(scale.greatest).starts_with("≥ "), "{low} {high}: {ticks:?}");
        }
    }

    #[test]
    fn verif_bright_satellites_and_many_samples_have_bright_colours() {
        // Luma of sRGB.
        let luma = |scale: &ColourScale, value: f64| {
            let [red, green, blue] = scale.colour(value).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let scale = ColourScale::from_values(Quantity::Magnitude, [4.0, 9.0]);
        let lumas: Vec<f64> = (0..=50).map(|n| luma(&scale, 4.0 + 0.1 * f64::from(n))).collect();
        assert!(lumas.windows(2).all(|pair| pair[0] > pair[1]), "{lumas:?}");
        assert_eq!(scale.colour(3.0), scale.colour(4.0));
        let ticks: Vec<f64> = scale.ticks().iter().map(|tick| tick.0).collect();
        assert_eq!(ticks, [4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        let counts = ColourScale::from_values(Quantity::Count, [3.0, 700.0]);
        assert_eq!((counts.least, counts.greatest), (2.0, 1000.0));
        assert!((counts.share(2000_f64.sqrt()) - 0.5).abs() < 1e-12);
        assert!(luma(&counts, 900.0) > luma(&counts, 9.0));
        let labels: Vec<String> = counts.ticks().into_iter().map(|tick| tick.1).collect();
        assert_eq!(labels, ["10", "100", "1000", "2"]);
    }

    #[test]
    fn verif_residuals_are_white_at_zero_and_as_far_on_both_sides() {
        let scale = ColourScale::from_values(Quantity::Residual, [-0.12, 0.33]);
        assert!((scale.least + 0.4).abs() < 1e-12 && (scale.greatest - 0.4).abs() < 1e-12);
        assert!(scale.colour(0.0).iter().all(|channel| *channel > 235));
        let ([red, _, blue], [less_red, _, more_blue]) = (scale.colour(0.4), scale.colour(-0.4));
        assert!(red > blue && more_blue > less_red);
        assert!(scale.ticks().iter().any(|tick| tick.1 == "−0.4"));
        assert_eq!(ColourScale::from_values(Quantity::Residual, [0.0]).greatest, 0.1);
    }
}

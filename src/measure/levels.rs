//! Levels of the pixels of a chip: the values at which its pixels are cut off, its sky and its noise.
//!
//! Noise and stars have ever fewer pixels towards the largest and the smallest value of a frame. Pixels that pile up
//! exactly there are cut off: by saturation, or because a difference below 0 is no value of a frame of unsigned
//! integers.

use super::background::median_and_sigma;
use crate::images::{LightArea, Plane};
use crate::streaks::TargetChip;

/// Smallest number of pixels at the largest value, and its smallest ratio to the number of pixels just below, for which
/// this value is that of saturation.
const LEAST_FULL: usize = 10;
const LEAST_RATIO: usize = 4;
/// Pixels are just below if they differ from the largest value by less than this fraction of its distance from the sky,
/// or have the next value.
const NEAR_SHARE: f32 = 0.01;
/// Smallest share of pixels at the smallest value for which the sky is cut off there. With less, the sky is higher by
/// less than 0.01 sigma of a pixel.
const LEAST_EMPTY_SHARE: f64 = 0.02;
/// Smallest ratio of these pixels to those with the next value.
const LEAST_EMPTY_RATIO: usize = 2;
/// Smallest number of ends of runs of these pixels along the rows, relative to that of pixels at random positions.
/// Empty borders of a frame have few runs.
const LEAST_RUNS: f64 = 0.2;
/// Largest distance of the median sky from these pixels, in its sigma.
const LARGEST_CUT: f64 = 3.0;
/// Approximate number of pixels from which sky and noise are computed.
const SAMPLE: usize = 100_000;
/// Largest ratio of the variance of the sky to that of its photons by the gain for which the gain is that of other
/// pixels.
const LEAST_VARIANCE: f64 = 0.01;

/// Levels of the illuminated pixels of a chip.
#[derive(Copy, Clone, Debug)]
pub struct PixelLevels {
    /// Value at which pixels are saturated, as far as the pixels show it, and the number of pixels with this value.
    pub full: Option<(f64, usize)>,
    /// Value at which the sky is cut off, and the share of the pixels with this value.
    pub empty: Option<(f64, f64)>,
    /// Smallest and largest value.
    range: [f64; 2],
    sky: f64,
    noise: f64,
}

impl PixelLevels {
    /// Measures the levels; `None` without pixels that have a value. `greatest` is the largest value that a frame of
    /// integers can hold.
    pub fn new(plane: &Plane, light_area: &LightArea, greatest: Option<f64>) -> Option<Self> {
        let rows = || light_area.rows.clone().map(|row| &plane.row(row)[light_area.columns.clone()]);
        let values = || rows().flatten().copied().filter(|value| value.is_finite());
        // Two smallest and two largest values.
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for value in values() {
            if value < low[0] {
                low = [value, low[0]];
            } else if value > low[0] && value < low[1] {
                low[1] = value;
            }
            if value > high[0] {
                high = [value, high[0]];
            } else if value < high[0] && value > high[1] {
                high[1] = value;
            }
        }
        let count = values().count();
        if count == 0 {
            return None;
        }
        let sample: Vec<f64> = values().step_by(count.div_ceil(SAMPLE)).map(f64::from).collect();
        let (sky, noise) = median_and_sigma(&sample);
        let near = high[1].min(high[0] - NEAR_SHARE * (high[0] - sky as f32));
        let (mut full, mut below, mut empty, mut above) = (0, 0, 0, 0);
        for value in values() {
            full += usize::from(value == high[0]);
            below += usize::from(value < high[0] && value >= near);
            empty += usize::from(value == low[0]);
            above += usize::from(value == low[1]);
        }
        let most = f64::from(high[0]);
        // A constant column at the edge of a detector is not saturated.
        let at_most = rows().enumerate().flat_map(move |(row, values)| {
            let columns = values.iter().enumerate().filter(move |(_, value)| **value == high[0]);
            columns.map(move |(column, _)| [row, column])
        });
        let first = at_most.clone().next().unwrap_or_default();
        let is_line = [0, 1].iter().any(|axis| at_most.clone().all(|at| at[*axis] == first[*axis]));
        let is_full = greatest.is_some_and(|greatest| most >= greatest)
            || (full >= LEAST_FULL && full >= LEAST_RATIO * below && most > sky && !is_line);
        let ends = |row: &[f32]| row.windows(2).filter(|pair| pair[0] == low[0] && pair[1] > low[0]).count();
        let share = empty as f64 / count as f64;
        let expected = share * (1.0 - share) * count as f64;
        let is_empty = share >= LEAST_EMPTY_SHARE
            && empty >= LEAST_EMPTY_RATIO * above
            // Single photons: most of the other pixels have the next value.
            && 2 * above < count - empty
            // Filled pixels far below the sky, such as dead ones.
            && sky - f64::from(low[0]) <= LARGEST_CUT * noise
            && expected > 0.0
            && rows().map(ends).sum::<usize>() as f64 >= LEAST_RUNS * expected;
        Some(Self {
            full: is_full.then_some((most, full)),
            empty: is_empty.then_some((f64::from(low[0]), share)),
            range: [f64::from(low[0]), most],
            sky,
            noise,
        })
    }

    /// Returns sentences about levels of which the header says nothing, or something else.
    pub fn remarks(&self, target: &TargetChip) -> Vec<String> {
        let hdu = target.chip.hdu;
        let full = self.full.filter(|_| target.saturation.is_none()).map(|(level, count)| {
            format!(
                "HDU {hdu}: the header has no saturation: {count} pixels with the largest value, {level}, are taken as \
                 saturated; specify --saturation"
            )
        });
        let empty = self.empty.map(|(level, share)| {
            format!(
                "HDU {hdu}: the sky is cut off: {:.0} % of the pixels have the smallest value, {level}; light of streaks is \
                 lost (flag clipped); add a constant to the frame before the dark is subtracted",
                100.0 * share
            )
        });
        let gain = target.electrons_per_unit.filter(|gain| self.contradict_gain(*gain)).map(|gain| {
            format!(
                "HDU {hdu}: the gain of {gain} electrons is not that of these pixels, which are from 0 to 1: errors do not \
                 contain the photon noise of the streaks; specify --gain, the gain of the counts multiplied by their \
                 number at 1"
            )
        });
        full.into_iter().chain(empty).chain(gain).collect()
    }

    /// Returns true if the gain is that of the counts before a program divided them by the largest one: all values are
    /// from 0 to 1, and the sky has far less noise than that of its photons, √(sky / gain).
    pub fn contradict_gain(&self, electrons_per_unit: f64) -> bool {
        let [least, most] = self.range;
        least >= 0.0 && most <= 1.0 && self.noise.powi(2) < LEAST_VARIANCE * self.sky / electrons_per_unit
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    /// Levels of a frame of noise with ten stars, whose peaks are 30 to 3000 times the noise, after a change of its
    /// values.
    fn levels(sky: f64, sigma: f64, change: impl Fn(f64) -> f64) -> PixelLevels {
        const SIDE: usize = 300;
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let stars: Vec<[f64; 3]> = (0..10)
            .map(|star| {
                let [x, y] = [0.0; 2].map(|_| SIDE as f64 * random.random::<f64>());
                [x, y, 30.0 * sigma * 100f64.powf(f64::from(star) / 9.0)]
            })
            .collect();
        let mut plane = Plane::zeros(SIDE, SIDE);
        for (index, value) in plane.values_mut().iter_mut().enumerate() {
            let (row, column) = ((index / SIDE) as f64, (index % SIDE) as f64);
            let light = |[x, y, peak]: &[f64; 3]| peak * (-0.1 * ((x - column).powi(2) + (y - row).powi(2))).exp();
            let noise: f64 = random.sample(StandardNormal);
            *value = change(sky + sigma * noise + stars.iter().map(light).sum::<f64>()) as f32;
        }
        PixelLevels::new(&plane, &LightArea::whole(SIDE, SIDE), Some(65535.0)).unwrap()
    }

    #[test]
    fn pixels_that_pile_up_at_the_largest_value_are_saturated() {
        let full = |sky: f64, sigma: f64, cap: f64| levels(sky, sigma, |value| value.min(cap).round()).full;
        for cap in [4095.0, 16383.0, 65535.0] {
            let (level, count) = full(800.0, 30.0, cap).unwrap();
            assert!(level == cap && count >= 10, "{level} {count}");
        }
        // Noise and stars without saturation, also of few values.
        for sigma in [0.3, 1.0, 3.0, 15.0] {
            assert_eq!(full(800.0, sigma, 65535.0), None, "sigma {sigma}");
        }
        assert_eq!(levels(800.0, 15.0, |value| value).full, None);
        let mut plane = Plane::zeros(100, 100);
        for (index, value) in plane.values_mut().iter_mut().enumerate() {
            *value = if index % 100 == 99 { 5000.0 } else { (index * 37 % 3001) as f32 };
        }
        let of = |plane: &Plane| PixelLevels::new(plane, &LightArea::whole(100, 100), None).unwrap().full;
        assert_eq!(of(&plane), None);
        plane.values_mut()[0] = 5000.0;
        assert_eq!(of(&plane), Some((5000.0, 101)));
    }

    #[test]
    fn a_sky_that_is_cut_off_is_found() {
        for (sky, share) in [(0.0, 0.5), (-4.0, 0.77), (-12.0, 0.96), (9.0, 0.03)] {
            for is_whole in [true, false] {
                let change = |value: f64| if is_whole { value.max(0.0).round() } else { value.max(0.0) };
                let (level, found) = levels(sky, 5.0, change).empty.unwrap_or_else(|| panic!("sky {sky}"));
                assert!(level == 0.0 && (found - share).abs() < 0.05, "{sky}: {found}");
            }
        }
        // A sky far above 0, one of few values, and one that is not cut off.
        assert_eq!(levels(25.0, 5.0, |value| value.max(0.0).round()).empty, None);
        assert_eq!(levels(3.0, 0.7, |value| value.max(0.0).round()).empty, None);
        assert_eq!(levels(0.0, 5.0, |value| value).empty, None);
        // Dead pixels at 0 below a sky, and single photons.
        let mut number = 0;
        let mut dead = |value: f64| {
            number += 1;
            if number % 20 == 0 { 0.0 } else { value }
        };
        let mut plane = Plane::zeros(100, 100);
        plane
            .values_mut()
            .iter_mut()
            .enumerate()
            .for_each(|(index, value)| *value = dead(1000.0 + (index * 37 % 41) as f64) as f32);
        let of = |plane: &Plane| PixelLevels::new(plane, &LightArea::whole(100, 100), None).unwrap().empty;
        assert_eq!(of(&plane), None);
        plane
            .values_mut()
            .iter_mut()
            .enumerate()
            .for_each(|(index, value)| *value = if index * 7919 % 101 < 9 { 1.0 } else { 0.0 });
        assert_eq!(of(&plane), None);
    }

    #[test]
    fn the_gain_of_counts_does_not_belong_to_their_fractions() {
        // Noise of the photons of a sky of 1000 counts at 0.5 electrons per count.
        let fractions = levels(1000.0, 45.0, |value| value.clamp(0.0, 65535.0) / 65535.0);
        assert!(fractions.contradict_gain(0.5) && !fractions.contradict_gain(0.5 * 65535.0));
        assert!(!levels(1000.0, 45.0, |value| value).contradict_gain(0.5));
    }
}

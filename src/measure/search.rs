//! Search for a streak in the corridor of a prediction: a matched filter over offset, angle and lateness.

use std::f64::consts::FRAC_1_SQRT_2;

use super::background::{SIGMA_OF_MAD, median_and_sigma};
use super::corridor::Corridor;
use super::measurement::StreakImage;
use crate::streaks::RadialProfile;

/// Length of a block along the track in widths of the streak (FWHM), its smallest value in pixels, and the largest
/// number of blocks.
const WIDTHS_PER_BLOCK: f64 = 4.0;
const LEAST_BLOCK: f64 = 12.0;
const MOST_BLOCKS: usize = 128;
/// Offsets up to this distance beyond the corridor are evaluated to measure the noise, pixels.
const NOISE_PIX: f64 = 150.0;
/// Half length of the filter across the track, FWHM.
const FILTER_WIDTHS: f64 = 4.0;
/// Steps of angle and lateness move the end of the streak by this fraction of its width.
const STEP_WIDTHS: f64 = 0.5;
const MOST_ANGLES: usize = 101;
const MOST_DELAYS: usize = 201;
/// An offset is evaluated if its number of pixels along the track is at least this fraction of the largest number.
const LEAST_COVERAGE: f64 = 0.2;
/// Smallest number of offsets beside the streak from which the noise is measured.
const LEAST_OFFSETS: usize = 20;
/// Smallest number of pixels along the track.
const LEAST_PIXELS: f32 = 12.0;

/// The light of a block is clipped to this number of sigmas, so that a star, which lights one or two blocks,
/// contributes little. A streak whose blocks are all clipped keeps at least the significance `CLIPPED_SIGNIFICANCE`.
const BLOCK_SIGMAS: f64 = 2.0;
const CLIPPED_SIGNIFICANCE: f64 = 8.0;

/// Number of positions along the track whose pixels are read together.
const STRIP: usize = 64;

/// Extent of the search.
#[derive(Copy, Clone, Debug)]
pub struct Extent {
    /// Largest distance from the predicted track, pixels.
    pub across_pix: f64,
    /// Largest difference in angle, radians.
    pub tilt_rad: f64,
    /// Largest delay or advance, seconds.
    pub late_s: f64,
    /// Half of the distance to a neighbouring streak, pixels.
    pub to_neighbour_pix: f64,
    pub errors: PredictionErrors,
}

/// Errors (one sigma) of the prediction.
#[derive(Copy, Clone, Debug)]
pub struct PredictionErrors {
    /// Of the distance from the predicted track, pixels, and its change with the delay, pixels per second.
    pub across_pix: f64,
    pub drift_pix_s: f64,
    /// Of the angle, radians; infinite if it is not limited.
    pub tilt_rad: f64,
    /// Of the time, seconds.
    pub late_s: f64,
}

impl Extent {
    /// Returns the largest distance from the predicted track at a distance along the track from its middle, pixels.
    pub fn reach_pix(&self, along_pix: f64) -> f64 {
        (self.across_pix + self.tilt_rad * along_pix.abs()).min(self.to_neighbour_pix)
    }
}

/// Position in the corridor.
#[derive(Copy, Clone, Debug)]
pub struct Found {
    /// Distance from the predicted track, pixels along the minor axis.
    pub minor_pix: f64,
    /// Change of this distance per pixel of the major axis.
    pub slope: f64,
    /// Delay, seconds.
    pub late_s: f64,
    /// Signal divided by noise.
    pub significance: f64,
    /// Significance that noise exceeds anywhere in the corridor with the given probability.
    pub threshold: f64,
}

/// Result of a search.
#[derive(Copy, Clone, Debug)]
pub struct Search {
    /// Most probable position, by its light and its distance from the prediction.
    pub best: Found,
    /// Position with the most significant lack of light.
    pub darkest: Found,
}

/// Sums of pixels for each block and offset.
struct Sums {
    blocks: usize,
    offsets: usize,
    /// Light of each block, from index 1 on, for each offset, and the numbers of pixels. After `cumulated`: of all
    /// blocks before a block, and last of all blocks.
    light: Vec<f32>,
    pixels: Vec<f32>,
    /// Index of the middle of each block on the major axis, relative to the middle of the track.
    position: Vec<f64>,
    /// Smallest number of pixels along the track; that of the track if it is less, as of a short given streak.
    least: f32,
    time_s: Vec<f64>,
}

/// Returns the most probable position in the corridor, and that with the most significant lack of light; `None` if no
/// position has enough pixels in the frame.
pub fn search(
    image: &StreakImage<'_>,
    corridor: &Corridor,
    profile: &RadialProfile,
    extent: &Extent,
    false_alarm: f64,
) -> Option<Search> {
    let Grid { width_minor, reach, limit, slopes } = Grid::new(corridor, profile, extent);
    let half = limit + reach + (NOISE_PIX / corridor.cos()) as usize;
    let normalised = |row: usize, column: usize, value| image.background.normalised(row, column, value);
    let sums = Sums::new(image, corridor, half, width_minor, normalised);
    let filter = filter(profile, corridor, reach);

    let step_s = (STEP_WIDTHS * profile.fwhm_pix()).max(1.0) / corridor.speed_pix_s;
    let windows = sums.windows(&steps(extent.late_s, step_s, MOST_DELAYS), image.exposure_s);
    let [from, to] = windows.iter().find(|(late_s, _)| *late_s == 0.0)?.1;
    let sums = sums.clipped(BLOCK_SIGMAS.max(CLIPPED_SIGNIFICANCE / ((to - from) as f64).sqrt())).cumulated();

    let nominal = sums.significance(0.0, [from, to], &filter);
    let nominal_noise = noise(&nominal, half, reach);
    // The most probable position has the largest z² - Σ (x / σ)², with the significance z and the distances x from the
    // prediction. σ contains the rounding to a step of the search, step / √12.
    let of_step = |sigma: f64, step: f64| sigma.hypot(step / 12f64.sqrt());
    let PredictionErrors { across_pix, drift_pix_s, tilt_rad, late_s } = extent.errors;
    let tilt_step = STEP_WIDTHS * profile.fwhm_pix().max(1.0) / (0.5 * corridor.len() as f64);
    let tilt_sigma = of_step(tilt_rad, tilt_step);
    // Where the delay is searched, too, it explains a part of the distance.
    let is_late_searched = windows.len() > 1;
    let across_sigma = of_step(if is_late_searched { across_pix } else { across_pix.hypot(late_s * drift_pix_s) }, 1.0);
    let late_sigma = of_step(late_s, step_s);
    let cos = corridor.cos();
    let score = |found: &Found| {
        let z = found.significance / nominal_noise;
        let late_s = if is_late_searched { corridor.delay_s(found.late_s, found.minor_pix) } else { 0.0 };
        let across = (found.minor_pix * cos - late_s * drift_pix_s) / across_sigma;
        let (tilt, late) = (found.slope * cos * cos / tilt_sigma, late_s / late_sigma);
        z * z.abs() - across * across - tilt * tilt - late * late
    };
    let mut found: Option<Search> = None;
    for slope in &slopes {
        for (late_s, window) in &windows {
            let row = sums.significance(*slope, *window, &filter);
            for (index, z) in row.iter().enumerate().skip(half - limit).take(2 * limit + 1) {
                if !z.is_finite() {
                    continue;
                }
                let minor_pix = index as f64 - half as f64;
                let here = Found { minor_pix, slope: *slope, late_s: *late_s, significance: *z, threshold: 0.0 };
                let Search { best, darkest } = found.get_or_insert(Search { best: here, darkest: here });
                if score(&here) > score(best) {
                    *best = here;
                }
                if *z < darkest.significance {
                    *darkest = here;
                }
            }
        }
    }
    let trials = (2 * limit + 1) as f64 / width_minor
        * slopes.len() as f64
        * STEP_WIDTHS
        * if windows.len() > 1 { windows.len() as f64 * STEP_WIDTHS } else { 1.0 };
    found.map(|Search { best, darkest }| {
        let noise = noise(&nominal, (half as f64 + best.minor_pix) as usize, reach);
        let threshold = exceeded_with(false_alarm / trials.max(1.0));
        let relative = |found: Found| Found { significance: found.significance / noise, threshold, ..found };
        Search { best: relative(best), darkest: relative(darkest) }
    })
}

/// Returns the smallest share of a streak's light that falls on usable pixels, over all positions and angles in the
/// corridor; pixels outside of the illuminated area do not count.
pub fn least_usable_share(
    image: &StreakImage<'_>,
    corridor: &Corridor,
    profile: &RadialProfile,
    extent: &Extent,
) -> f64 {
    let Grid { width_minor, reach, limit, slopes } = Grid::new(corridor, profile, extent);
    let area = image.light_area;
    let is_usable = |row: usize, column: usize, value: f32| {
        if area.rows.contains(&row) && area.columns.contains(&column) {
            f32::from(u8::from(value.is_finite()))
        } else {
            f32::NAN
        }
    };
    let half = limit + reach;
    let sums = Sums::new(image, corridor, half, width_minor, is_usable).cumulated();
    let light = profile_across(profile, corridor, reach);
    let Some((_, window)) = sums.windows(&[0.0], image.exposure_s).first().copied() else { return 1.0 };
    let mut least = 1.0;
    for slope in slopes {
        let (shares, _) = sums.means(slope, window);
        for centre in half - limit..=half + limit {
            let (mut all, mut usable) = (0.0, 0.0);
            for (share, light) in shares[centre - reach..=centre + reach].iter().zip(&light) {
                if share.is_finite() {
                    all += light;
                    usable += share * light;
                }
            }
            if shares[centre].is_finite() && all > 0.0 {
                least = f64::from(usable / all).min(least);
            }
        }
    }
    least
}

/// Positions and angles of a search.
struct Grid {
    /// Width of the streak, pixels along the minor axis.
    width_minor: f64,
    /// Half length of the filter across the track, pixels along the minor axis.
    reach: usize,
    /// Largest distance from the track, pixels along the minor axis.
    limit: usize,
    /// Changes of the distance per pixel of the major axis.
    slopes: Vec<f64>,
}

impl Grid {
    fn new(corridor: &Corridor, profile: &RadialProfile, extent: &Extent) -> Self {
        let cos = corridor.cos();
        let width_minor = profile.fwhm_pix().max(1.0) / cos;
        let half_length = 0.5 * corridor.len() as f64;
        let step = STEP_WIDTHS * width_minor / half_length;
        let tilt = (extent.tilt_rad / (cos * cos)).max(step);
        Self {
            width_minor,
            reach: (FILTER_WIDTHS * width_minor).ceil() as usize,
            limit: ((extent.across_pix / cos).ceil() as usize).min(2 * corridor.minor_count).max(1),
            slopes: steps(tilt, step, MOST_ANGLES),
        }
    }
}

/// Returns values from `-extent` to `extent`, at most `most`, in steps of at most `step` if these are not more.
fn steps(extent: f64, step: f64, most: usize) -> Vec<f64> {
    let count = ((extent / step).ceil() as usize).min(most / 2);
    (0..=2 * count)
        .map(|index| (index as f64 - count as f64) * if count > 0 { extent / count as f64 } else { 0.0 })
        .collect()
}

/// Returns the scatter of the signal over the offsets, which includes the noise of unresolved stars. Offsets that the
/// light at `best` reaches are omitted, because in a small image a bright streak would dominate the scatter.
fn noise(signal: &[f64], best: usize, reach: usize) -> f64 {
    let finite = |is_used: &dyn Fn(usize) -> bool| -> Vec<f64> {
        let used = signal.iter().enumerate().filter(|(index, z)| z.is_finite() && is_used(*index));
        used.map(|(_, z)| *z).collect()
    };
    let beside = finite(&|index| index.abs_diff(best) > reach);
    let (_, noise) = median_and_sigma(&if beside.len() < LEAST_OFFSETS { finite(&|_| true) } else { beside });
    if noise > 0.0 { noise } else { 1.0 }
}

/// Returns the number of sigmas that a normal distribution exceeds with this probability.
pub fn exceeded_with(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 38.0);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if 0.5 * libm::erfc(middle * FRAC_1_SQRT_2) > probability { low = middle } else { high = middle }
    }
    low
}

/// Returns the profile of a line across the track, minus its mean.
fn filter(profile: &RadialProfile, corridor: &Corridor, reach: usize) -> Vec<f32> {
    let mut filter = profile_across(profile, corridor, reach);
    let mean = filter.iter().sum::<f32>() / filter.len() as f32;
    filter.iter_mut().for_each(|weight| *weight -= mean);
    filter
}

/// Returns the profile of a line across the track at whole pixels of the minor axis.
fn profile_across(profile: &RadialProfile, corridor: &Corridor, reach: usize) -> Vec<f32> {
    let light =
        |index: usize| profile.line((index as f64 - reach as f64) * corridor.cos(), corridor.angle_rad()) as f32;
    (0..=2 * reach).map(light).collect()
}

impl Sums {
    /// Sums `value(row, column, pixel)` over the pixels in the corridor for which it is not NaN.
    fn new(
        image: &StreakImage<'_>,
        corridor: &Corridor,
        half: usize,
        width_minor: f64,
        value: impl Fn(usize, usize, f32) -> f32,
    ) -> Self {
        let length = corridor.len();
        let blocks =
            ((length as f64 / (WIDTHS_PER_BLOCK * width_minor).max(LEAST_BLOCK)) as usize).clamp(1, MOST_BLOCKS);
        let offsets = 2 * half + 1;
        let block_of = |index: usize| index * blocks / length;
        let (mut light, mut pixels) = (vec![0.0f32; (blocks + 1) * offsets], vec![0.0f32; (blocks + 1) * offsets]);
        let plane = image.plane;
        let lowest: Vec<isize> = corridor.centre.iter().map(|centre| centre.round() as isize - half as isize).collect();
        let mut add = |index: usize, offset: usize, row: usize, column: usize| {
            let value = value(row, column, plane.row(row)[column]);
            if value.is_finite() {
                let at = (block_of(index) + 1) * offsets + offset;
                light[at] += value;
                pixels[at] += 1.0;
            }
        };
        // Pixels of neighbouring indices are read together, because they are neighbours in memory if the major axis is
        // along the rows.
        let minor_count = if corridor.is_along_rows { plane.rows() } else { plane.columns() } as isize;
        for (number, of_strip) in lowest.chunks(STRIP).enumerate() {
            let first = of_strip.iter().min().map_or(0, |lowest| *lowest).max(0);
            let end = of_strip.iter().max().map_or(0, |lowest| *lowest + offsets as isize).min(minor_count);
            for minor in first..end {
                for (index, lowest) in (number * STRIP..).zip(of_strip) {
                    let offset = minor - lowest;
                    if offset >= 0 && (offset as usize) < offsets {
                        let (major, minor) = (corridor.first + index, minor as usize);
                        let (row, column) = if corridor.is_along_rows { (minor, major) } else { (major, minor) };
                        add(index, offset as usize, row, column);
                    }
                }
            }
        }
        let middles: Vec<usize> = (0..blocks).map(|block| (2 * block + 1) * length / (2 * blocks)).collect();
        Self {
            blocks,
            offsets,
            least: LEAST_PIXELS.min(length as f32),
            light,
            pixels,
            position: middles.iter().map(|middle| *middle as f64 - 0.5 * length as f64).collect(),
            time_s: middles.iter().map(|middle| corridor.time_s[*middle]).collect(),
        }
    }

    /// Clips the light of each block and offset to a number of robust sigmas.
    fn clipped(mut self, sigmas: f64) -> Self {
        // Parts of a frame may be filled with a constant, whose sums are 0.
        let per_noise = self.light.iter().zip(&self.pixels).filter(|(light, pixels)| **pixels > 0.0 && **light != 0.0);
        let mut sizes: Vec<f32> = per_noise.map(|(light, pixels)| (light / pixels.sqrt()).abs()).collect();
        if !sizes.is_empty() {
            let middle = sizes.len() / 2;
            let usual = *sizes.select_nth_unstable_by(middle, f32::total_cmp).1;
            let most = (sigmas * SIGMA_OF_MAD) as f32 * usual;
            for (light, pixels) in self.light.iter_mut().zip(&self.pixels) {
                let most = most * pixels.sqrt();
                *light = light.clamp(-most, most);
            }
        }
        self
    }

    /// Sums over the blocks before each block.
    fn cumulated(mut self) -> Self {
        for at in self.offsets..self.light.len() {
            self.light[at] += self.light[at - self.offsets];
            self.pixels[at] += self.pixels[at - self.offsets];
        }
        self
    }

    /// Returns the blocks that are exposed at each delay, without repetition.
    fn windows(&self, delays_s: &[f64], exposure_s: f64) -> Vec<(f64, [usize; 2])> {
        let mut windows: Vec<(f64, [usize; 2])> = Vec::new();
        // Delays are in order of their absolute values, so that the smallest one is kept for equal windows.
        let mut ordered = delays_s.to_vec();
        ordered.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        for late_s in ordered {
            let exposed = |time_s: &f64| (0.0..=exposure_s).contains(&(time_s + late_s));
            let first = self.time_s.iter().position(exposed);
            let last = self.time_s.iter().rposition(exposed);
            let window = match first.zip(last) {
                Some((first, last)) => [first, last + 1],
                // The search needs the nominal window as a reference.
                None if late_s == 0.0 => [0, self.blocks],
                None => continue,
            };
            if windows.iter().all(|(_, known)| *known != window) {
                windows.push((late_s, window));
            }
        }
        windows
    }

    /// Returns the mean of the pixels along the track at each offset, NaN where too few pixels are in the frame, and
    /// their number.
    fn means(&self, slope: f64, [from, to]: [usize; 2]) -> (Vec<f32>, Vec<f32>) {
        let offsets = self.offsets;
        let (mut light, mut pixels) = (vec![0.0f32; offsets], vec![0.0f32; offsets]);
        // Neighbouring blocks with the same shift are added at once.
        let shift = |block: usize| (slope * self.position[block]).round() as isize;
        let mut block = from;
        while block < to {
            let mut end = block + 1;
            while end < to && shift(end) == shift(block) {
                end += 1;
            }
            let by = shift(block);
            let range = by.max(0) as usize..(offsets as isize + by.min(0)) as usize;
            for at in range {
                let target = (at as isize - by) as usize;
                light[target] += self.light[end * offsets + at] - self.light[block * offsets + at];
                pixels[target] += self.pixels[end * offsets + at] - self.pixels[block * offsets + at];
            }
            block = end;
        }
        let most = pixels.iter().copied().fold(0.0, f32::max);
        let least = (LEAST_COVERAGE as f32 * most).max(self.least);
        let mean: Vec<f32> = light
            .iter()
            .zip(&pixels)
            .map(|(light, pixels)| if *pixels >= least { light / pixels } else { f32::NAN })
            .collect();
        (mean, pixels)
    }

    /// Returns the filtered light at each offset, in units of the noise of a clipped pixel; NaN where too few pixels
    /// are in the frame. Near the edge of the frame, the filter is its part inside, minus its mean.
    fn significance(&self, slope: f64, window: [usize; 2], filter: &[f32]) -> Vec<f64> {
        let (mean, pixels) = self.means(slope, window);
        let norm = filter.iter().map(|weight| weight * weight).sum::<f32>().sqrt();
        let reach = filter.len() / 2;
        let mut row = vec![f64::NAN; self.offsets];
        for centre in (reach..self.offsets.saturating_sub(reach)).filter(|centre| mean[*centre].is_finite()) {
            let around = || mean[centre - reach..=centre + reach].iter().zip(filter);
            let sum: f32 = around().map(|(mean, weight)| mean * weight).sum();
            if sum.is_finite() {
                row[centre] = f64::from(sum * pixels[centre].sqrt() / norm);
                continue;
            }
            // Sums of 1, p, p², d, p d, with the filter p and the mean d.
            let mut sums = [0.0f32; 5];
            for (d, p) in around() {
                if d.is_finite() {
                    sums.iter_mut().zip([1.0, *p, p * p, *d, p * d]).for_each(|(sum, term)| *sum += term);
                }
            }
            let [n, p, pp, d, pd] = sums;
            if n as usize > reach {
                // Σ p' d / √(Σ p'²) with p' = p - mean(p)
                row[centre] = f64::from((pd - p * d / n) / (pp - p * p / n).sqrt() * pixels[centre].sqrt());
            }
        }
        row
    }
}

//! Covariance of a fit to pixels, computed by leaving out sets of tracks (delete-a-group jackknife).
//!
//! One track crosses many pixels and has the same offset in all of them. Pixels are therefore not independent, but
//! tracks are. Tracks are divided into G sets of similar size. Reduction and fit are repeated without each set in turn
//! (Efron and Stein 1981, Ann. Statist. 9, 586):
//!
//! ```text
//! Σ = (G-1)/G Σ_g (θ_g - θ̄)(θ_g - θ̄)ᵀ,    θ̄ = Σ_g θ_g / G
//! ```
//!
//! With G sets, sigmas have a relative error of 1/√(2(G-1)), which is 15 % for 24 sets. Errors that all tracks share
//! (photometric zero point, form of the model) are not included.
//!
//! Statistics that are not smooth require large sets (Shao and Wu 1989, Ann. Statist. 17, 1176). Modes are not smooth:
//! they jump if a few of many points are omitted. For pixels with points of many tracks the sigma is therefore too
//! large. In the tests below, with 70 points of as many tracks, it is too large by a factor of 1.4 to 1.8 (kernel mode)
//! and 1.8 to 2.4 (half-sample mode).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::error;
use super::form::Form;
use super::measurements::{Measurement, Measurements, ReduceOptions, Reducer, Reduction};
use super::point::points_of_pixels;
use super::solve::{Fit, FitSettings, Problem};
use crate::error::{Error, ErrorKind};

/// Seed of the random assignment of tracks to sets. It is random because adjacent tracks of a file share a night and
/// its geometry.
const SEED: u64 = 1;
/// Number of measurements per call of the reducer, so that not all measurements are copied for each set.
const CHUNK: usize = 1 << 16;

/// Returns the covariance of all parameters `(n_parameter, n_parameter)` of a fit to pixels, with 0 for parameters that
/// are held or at a bound.
///
/// `fit` is the fit of `form` with `settings` to `measurements` that were reduced with `options`; the descents start
/// from its solution. Each thread holds one more reduction, of some 10 bytes per measurement. The result does not
/// depend on the number of threads.
///
/// # Errors
/// * [`TooFewData`](ErrorKind::TooFewData) unless there are more sets than free parameters and at least as many groups
///   as sets;
/// * invalid options;
/// * a descent does not reach a finite cost;
/// * the errors of [`Problem::new`] if the remaining tracks give too few pixels.
pub fn jackknife(
    form: &dyn Form,
    measurements: &Measurements,
    options: ReduceOptions,
    fit: &Fit,
    settings: &FitSettings,
    sets: usize,
) -> Result<Vec<Vec<f64>>, Error> {
    let tracks = TrackSets::new(measurements, sets);
    if sets <= fit.free.len() || tracks.groups < sets {
        return Err(Error::new(
            ErrorKind::TooFewData,
            format!("number of sets is {sets} for {} groups of points (tracks, nights)", tracks.groups),
        )
        .allowing(format!("more than the {} free parameters, at most the number of groups", fit.free.len())));
    }
    let values = fit.values();
    let start: Vec<f64> = fit.free.iter().map(|&i| values[i]).collect();
    let without = |set: usize| {
        let pixels = tracks.reduced(options, |other| other != set)?;
        let problem = Problem::new(form, &points_of_pixels(&pixels), settings)?;
        let minimum = problem.descend(&start);
        if minimum.cost.is_finite() { Ok(minimum.x) } else { Err(error::no_minimum(1)) }
    };
    let replicas = (0..sets).into_par_iter().map(without).collect::<Result<Vec<Vec<f64>>, Error>>()?;

    let per_set = 1.0 / sets as f64;
    let mean = |k: usize| replicas.iter().map(|replica| replica[k]).sum::<f64>() * per_set;
    let means: Vec<f64> = (0..start.len()).map(mean).collect();
    let inner = |k: usize| !fit.uncertainty.at_bound.contains(&fit.free[k]);
    let mut covariance = vec![vec![0.0; values.len()]; values.len()];
    for r in (0..start.len()).filter(|&k| inner(k)) {
        for c in (0..start.len()).filter(|&k| inner(k)) {
            // Σ = (G-1)/G Σ_g (θ_g - θ̄)(θ_g - θ̄)ᵀ
            let products = replicas.iter().map(|replica| (replica[r] - means[r]) * (replica[c] - means[c]));
            covariance[fit.free[r]][fit.free[c]] = (1.0 - per_set) * products.sum::<f64>();
        }
    }
    Ok(covariance)
}

/// Measurements whose groups (tracks, nights) are divided into sets of similar size.
pub(super) struct TrackSets<'a> {
    measurements: &'a Measurements,
    /// Number of the set of each group, by the number of the group.
    set_of_group: Vec<usize>,
    /// Number of groups with at least one point.
    pub groups: usize,
}

impl<'a> TrackSets<'a> {
    /// Assigns the groups to sets, in the same way each time.
    pub fn new(measurements: &'a Measurements, sets: usize) -> Self {
        let mut groups: Vec<u32> = measurements.points.iter().map(|point| point.group).collect();
        groups.sort_unstable();
        groups.dedup();
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut drawn: Vec<(u64, u32)> = groups.iter().map(|&group| (random.next_u64(), group)).collect();
        drawn.sort_unstable();
        let mut set_of_group = vec![0; groups.last().map_or(0, |&last| last as usize + 1)];
        for (index, (_, group)) in drawn.into_iter().enumerate() {
            set_of_group[group as usize] = index % sets.max(1);
        }
        Self { measurements, set_of_group, groups: groups.len() }
    }

    /// Reduces the measurements of the sets that `selected` accepts.
    ///
    /// # Errors
    /// Invalid options.
    pub fn reduced(&self, options: ReduceOptions, selected: impl Fn(usize) -> bool) -> Result<Reduction, Error> {
        let mut reducer = Reducer::new(options)?;
        let is_selected = |point: &&Measurement| selected(self.set_of_group[point.group as usize]);
        for chunk in self.measurements.points.chunks(CHUNK) {
            reducer.add(&chunk.iter().filter(is_selected).copied().collect::<Vec<_>>());
        }
        Ok(reducer.finish())
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::StandardNormal;

    use super::super::measurements::{DensityMode, Measurement, reduce};
    use super::*;
    use crate::fit::{CovarianceKind, SphereForm};
    use crate::geometry::ViewingGeometry;
    use crate::photometry::{DiffuseSphere, StandardMagnitude};

    const SETS: usize = 24;
    const HALF_LIT_MAG: f64 = 6.0;
    /// One sigma from point to point, mag.
    const NOISE_MAG: f64 = 0.1;

    /// Options for pixels of some 70 points.
    fn coarse(mode: DensityMode) -> ReduceOptions {
        let paper = ReduceOptions::default();
        ReduceOptions { nside: 4, layer_width_rad: 0.2, least_count: 20, most_iqr_mag: 3.0, mode, ..paper }
    }

    /// Options for pixels of single points. The fit is then the mean of all points, which is a smooth statistic.
    fn fine() -> ReduceOptions {
        ReduceOptions { nside: 1024, least_count: 1, ..coarse(DensityMode::HalfSample) }
    }

    /// A diffuse sphere, seen in 240 groups of 10 points; each group has an offset.
    fn seen(seed: u64, offset_mag: f64) -> Measurements {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let sphere = DiffuseSphere { half_lit: StandardMagnitude(HALF_LIT_MAG) };
        let mut seen = Measurements::default();
        for group in 0..240 {
            seen.groups.push(group.to_string());
            let offset = offset_mag * random.sample::<f64, _>(StandardNormal);
            for _ in 0..10 {
                let between =
                    |least: f64, most: f64, random: &mut ChaCha8Rng| least + (most - least) * random.random::<f64>();
                let longitude = between(0.0, 1.0, &mut random);
                let latitude = between(-1.4, -0.6, &mut random);
                let geometry =
                    ViewingGeometry::from_angles(-0.3, longitude, latitude, 1000.0, 550.0).expect("a geometry");
                let noise = offset + NOISE_MAG * random.sample::<f64, _>(StandardNormal);
                let sphere_mag = sphere.standard_magnitude(geometry.phase_angle_rad()).expect("a magnitude").0;
                let magnitude = StandardMagnitude(sphere_mag + noise);
                seen.points.push(Measurement {
                    magnitude,
                    sigma_mag: None,
                    geometry,
                    group,
                    norad_id: None,
                    epoch: None,
                    grazing_height_km: None,
                    lit_fraction: 1.0,
                });
            }
        }
        seen
    }

    /// Value, variance by the curvature and variance by the jackknife.
    fn fitted(seed: u64, offset_mag: f64, options: ReduceOptions) -> (f64, f64, f64) {
        let (seen, settings) = (seen(seed, offset_mag), FitSettings::free(&["half_lit_mag"]));
        let points = points_of_pixels(&reduce(&seen.points, options).expect("pixels"));
        let fit = Problem::new(&SphereForm, &points, &settings).and_then(|problem| problem.solve()).expect("a fit");
        let by_sets = jackknife(&SphereForm, &seen, options, &fit, &settings, SETS).expect("a covariance");
        let own = fit.uncertainty.covariance.as_ref().expect("a covariance")[0][0];
        let known = fit.clone().with_covariance(by_sets.clone(), CovarianceKind::Jackknife);
        assert_eq!(known.uncertainty.sigma(0), Some(by_sets[0][0].sqrt()));
        (fit.parameters[0].value, own, by_sets[0][0])
    }

    /// Scatter of the value, and the mean sigmas from the curvature and from the jackknife.
    fn sigmas(offset_mag: f64, options: ReduceOptions) -> [f64; 3] {
        const SIMULATIONS: u64 = 48;
        let all: Vec<(f64, f64, f64)> = (1..=SIMULATIONS).map(|seed| fitted(seed, offset_mag, options)).collect();
        let n = SIMULATIONS as f64;
        let mean = all.iter().map(|fitted| fitted.0).sum::<f64>() / n;
        let scatter = all.iter().map(|fitted| (fitted.0 - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let own = all.iter().map(|fitted| fitted.1).sum::<f64>() / n;
        let by_sets = all.iter().map(|fitted| fitted.2).sum::<f64>() / n;
        [scatter.sqrt(), own.sqrt(), by_sets.sqrt()]
    }

    #[test]
    fn verif_sigma_is_the_scatter_where_groups_share_an_offset() {
        let [scatter, own, by_sets] = sigmas(0.3, fine());
        /// Relative tolerance; the scatter of 48 simulations has an error of 10 %.
        const TOLERANCE: f64 = 0.25;
        assert!((by_sets / scatter - 1.0).abs() < TOLERANCE, "{by_sets} {scatter}");
        // Pixels taken as independent give too small a sigma.
        assert!(own < 0.7 * scatter, "{own} {scatter}");
    }

    #[test]
    fn verif_sigma_is_that_of_the_curvature_where_points_are_independent() {
        let [scatter, own, by_sets] = sigmas(0.0, fine());
        /// Relative tolerance.
        const TOLERANCE: f64 = 0.3;
        assert!((by_sets / own - 1.0).abs() < TOLERANCE, "{by_sets} {own} {scatter}");
    }

    #[test]
    fn verif_sigma_of_modes_errs_on_the_safe_side() {
        /// Accepted ratios of sigma to scatter: modes jump when a few of many points are omitted.
        const TOLERANCE: [(DensityMode, std::ops::Range<f64>); 2] =
            [(DensityMode::Kernel, 0.75..2.0), (DensityMode::HalfSample, 0.75..3.0)];
        for (mode, alike) in TOLERANCE {
            for offset_mag in [0.0, 0.3] {
                let [scatter, _, by_sets] = sigmas(offset_mag, coarse(mode));
                assert!(alike.contains(&(by_sets / scatter)), "{by_sets} {scatter}");
            }
        }
    }

    #[test]
    fn verif_too_few_sets_or_groups_are_named() {
        let (seen, settings) = (seen(1, 0.1), FitSettings::free(&["half_lit_mag"]));
        let points = points_of_pixels(&reduce(&seen.points, coarse(DensityMode::Kernel)).expect("pixels"));
        let fit = Problem::new(&SphereForm, &points, &settings).and_then(|problem| problem.solve()).expect("a fit");
        for sets in [0, 1, 241] {
            let refused = jackknife(&SphereForm, &seen, coarse(DensityMode::Kernel), &fit, &settings, sets);
            let text = refused.unwrap_err().to_string();
            assert!(
                text.contains(" for 240 groups of points (tracks, nights); allowed: more than the 1 free"),
                "{sets}: {text}"
            );
        }
    }

    #[test]
    fn verif_held_parameters_have_no_covariance() {
        let seen = seen(1, 0.1);
        let form = crate::fit::PhaseForm { degree: 2 };
        let settings = FitSettings::free(&["a0", "a2"]);
        let points = points_of_pixels(&reduce(&seen.points, coarse(DensityMode::Kernel)).expect("pixels"));
        let fit = Problem::new(&form, &points, &settings).and_then(|problem| problem.solve()).expect("a fit");
        let covariance =
            jackknife(&form, &seen, coarse(DensityMode::Kernel), &fit, &settings, SETS).expect("a covariance");
        assert!(covariance[1].iter().all(|of_held| *of_held == 0.0));
        assert!(covariance[0][0] > 0.0 && covariance[2][2] > 0.0 && covariance[0][2] == covariance[2][0]);
    }
}

//! A whole catalogue asked for the satellite of a streak.

use rayon::prelude::*;

use super::compare::{Candidate, Reach, compare};
use super::error::IdentifyError;
use super::likelihood::{log_weight_of_unknown, share_out};
use super::near::delays_s;
use super::streak::MeasuredStreak;
use crate::orbit::LeftOut;
use crate::passes::{Exposure, ExposureInterval, Sky};
use crate::photometry::PhotometryOptions;

/// Candidates are looked for as far as so many sigmas, and at least so far.
const REACH_SIGMAS: f64 = 6.0;
const LEAST_REACH_S: f64 = 30.0;
const LEAST_REACH_RAD: f64 = 0.0175;
/// Mean distance of what is near enough to have a wide angle across its track, km: for the reach before the distance is known.
const NEAR_KM: f64 = 500.0;
/// Two delays of one satellite nearer to one another are the same passage, seconds.
const SAME_PASSAGE_S: f64 = 1.0;

/// What is wanted of the candidates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IdentifyOptions {
    /// Satellites in the Earth's shadow too.
    pub include_dark: bool,
    /// Band, system, extinction.
    pub photometry: PhotometryOptions,
}

/// The answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identified {
    /// Candidates, the most probable first.
    pub candidates: Vec<Candidate>,
    /// Probability that it is none of them, but a satellite of which no element set tells.
    pub unknown_probability: f64,
    /// Satellites without a position at that time, in catalogue order.
    pub left_out: Vec<LeftOut>,
}

/// All satellites of a sky that may have made a streak, on all threads of the current pool.
///
/// Looked at are those whose delay and distance from the streak are within six sigmas of their elements' age and the measurement (at least 30 s and 1°).
/// 20,000 satellites take some tens of milliseconds.
///
/// # Errors
/// [`IdentifyError::Sky`] where the sky has no answer at that time.
pub fn identify_streak(
    sky: &Sky,
    streak: &MeasuredStreak,
    options: &IdentifyOptions,
) -> Result<Identified, IdentifyError> {
    let exposure = Exposure {
        id: String::new(),
        start: streak.start(),
        duration_s: streak.duration_s(),
        pointing: streak.place(),
        rotation_rad: 0.0,
    };
    let interval = sky.exposure_interval(&exposure)?;
    let found: Vec<(Vec<Candidate>, Option<LeftOut>)> = (0..sky.elements().len())
        .into_par_iter()
        .with_min_len(64)
        .map(|element_index| one_satellite(&interval, element_index, streak, options))
        .collect();
    let mut left_out = sky.left_out().to_vec();
    let mut candidates = Vec::new();
    for (candidate, failed) in found {
        candidates.extend(candidate);
        left_out.extend(failed);
    }
    left_out.sort_by_key(|left_out| left_out.element_index);
    let log_unknown =
        log_weight_of_unknown(sky.elements().len(), streak.timing(), streak.duration_s(), streak.length_rad());
    let unknown_probability = share_out(&mut candidates, log_unknown);
    candidates.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight).then(a.element_index.cmp(&b.element_index)));
    Ok(Identified { candidates, unknown_probability, left_out })
}

/// The best passage of one satellite, at most one.
fn one_satellite(
    interval: &ExposureInterval<'_>,
    element_index: usize,
    streak: &MeasuredStreak,
    options: &IdentifyOptions,
) -> (Vec<Candidate>, Option<LeftOut>) {
    let Some(propagator) = interval.propagator(element_index) else { return (Vec::new(), None) };
    let mid_s = 0.5 * interval.duration_s();
    if let Err(reason) = interval.state(propagator, mid_s, 0.0) {
        return (Vec::new(), Some(LeftOut { norad_id: propagator.norad_id(), element_index, reason }));
    }
    let errors = interval.uncertainty(element_index, interval.element_age_days(propagator, mid_s));
    let along_s = REACH_SIGMAS * errors.along_track_s.hypot(streak.time_sigma_s());
    let across_rad = REACH_SIGMAS * (errors.cross_track_km / NEAR_KM).hypot(streak.place_sigma_rad());
    let reach = Reach {
        // Half a turn away is as late as early.
        along_track_s: (along_s.max(LEAST_REACH_S) + mid_s).min(0.5 * propagator.period_s()),
        cross_track_rad: across_rad.clamp(LEAST_REACH_RAD, 0.5),
    };
    let mut delays = delays_s(interval, element_index, streak, &reach);
    delays.sort_by(f64::total_cmp);
    delays.dedup_by(|a, b| (*a - *b).abs() < SAME_PASSAGE_S);
    let best = delays
        .into_iter()
        .filter_map(|guess_s| {
            compare(interval, element_index, streak, guess_s, &reach, &options.photometry, options.include_dark)
        })
        .max_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
    (best.into_iter().collect(), None)
}

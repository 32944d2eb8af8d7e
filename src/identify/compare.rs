//! Comparison of one satellite with a streak: delay of the satellite, distance of the streak from its track, and angle
//! between streak and track.
//!
//! 1. Newton's method on SGP4 gives the delay δ with which the satellite passes nearest to the middle of the streak at
//!    the time of the streak. For a streak at an unknown time within an exposure, the time with the smallest delay and
//!    distance (in sigmas) is used.
//! 2. The distances of both ends from the track with that delay are computed. Their mean is the cross-track offset, and
//!    their difference divided by the length is the angle. In this way a curved track is not approximated by a straight
//!    line. If the times of the ends are known, the delay is the mean of the two delays with which the satellite passes
//!    the ends at these times.
//! 3. The predicted length is compared with the measured one. If the streak may end at the edges of the frame, a
//!    measured length below the predicted one is not counted as a difference.
//!
//! Each sigma combines the error of the elements at their age ([`ExposureInterval::uncertainty`]) with the measurement
//! error:
//!
//! ```text
//! σ_δ² = σ_along² + σ_clock² + (σ_pos/ω)²/2     σ_x² = (σ_cross/ρ)² + σ_pos²/2
//! σ_θ² = (n σ_cross/(ω ρ))² + σ_angle²            σ_L² = 2 σ_pos² + 2 (ω σ_clock)² + (L σ_cross/ρ)²
//! ```
//!
//! for the delay δ, the cross-track offset x, the angle θ and the length L, with angular rate ω, range ρ and mean
//! motion n. An orbital plane that is tilted so that the cross-track error is σ_cross crosses the predicted plane at
//! the angle n σ_cross / v, with the orbital speed v.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use nalgebra::Vector3;

use super::likelihood::{Candidate, CandidateWeight, Offset, integrate_exposure, log_normal};
use super::streak::{MeasuredStreak, Timing};
use crate::frames::{Direction, Gcrs};
use crate::orbit::{Lateness, OrbitUncertainty, Propagator};
use crate::passes::{DelayedTrack, ExposureInterval, Sighting};
use crate::photometry::PhotometryOptions;

/// Tolerance of Newton's method, seconds; it corresponds to 0.1 m along the track.
const CLOSE_S: f64 = 1e-5;
/// Largest number of Newton steps. Three or four are usual.
const MOST_STEPS: usize = 40;
/// Largest number of corrections of the delay from the two ends; each reduces the remaining error to a tenth.
const MOST_CORRECTIONS: usize = 5;
/// Largest angle between streak and track, radians, for which the points of the track nearest to the ends are computed.
const LARGEST_TURN_RAD: f64 = 0.2;

/// Largest χ² of a candidate, 14 sigmas. The errors have longer tails than a normal distribution.
const MOST_CHI_SQUARE: f64 = 200.0;

/// Largest distances of a satellite from its prediction that are searched.
#[derive(Copy, Clone, Debug)]
pub(super) struct Reach {
    pub along_track_s: f64,
    pub cross_track_rad: f64,
}

/// Passage of a satellite nearest to the middle of the streak.
#[derive(Copy, Clone)]
struct NearestPassage {
    delay_s: f64,
    cross_track_rad: f64,
    sighting: Sighting,
}

/// Compares one satellite with a streak. Returns `None` if its delay or distance is too large, or if it is below the
/// horizon or, unless `include_dark`, in shadow.
pub(super) fn compare(
    interval: &ExposureInterval<'_>,
    element_index: usize,
    streak: &MeasuredStreak,
    guess_s: f64,
    reach: &Reach,
    photometry: &PhotometryOptions,
    include_dark: bool,
) -> Option<Candidate> {
    let propagator = interval.propagator(element_index)?;
    let mid_s = 0.5 * interval.duration_s();
    let middle = nearest_passage(interval, propagator, streak, mid_s, guess_s)?;
    let errors = interval.uncertainty(element_index, propagator, mid_s);
    let sigmas = Sigmas::new(&errors, &middle, propagator, streak);

    // Time at which the satellite passes the middle of the streak, and the density of delay and distance integrated
    // over the exposure.
    let (passage_s, met, within_exposure) = match streak.timing() {
        Timing::FirstToSecond | Timing::Whole => (mid_s, middle, None),
        Timing::Within => {
            let half_s = mid_s.max(streak.time_sigma_s().min(0.9 * DelayedTrack::MARGIN_S));
            let ends = [mid_s - half_s, mid_s + half_s]
                .map(|time_s| nearest_passage(interval, propagator, streak, time_s, middle.delay_s + time_s - mid_s));
            let [Some(before), Some(after)] = ends else { return None };
            let pulls = |met: &NearestPassage, sigma_s: f64| {
                [met.delay_s / sigma_s, met.cross_track_rad / sigmas.cross_track_rad]
            };
            // The satellite takes the time `crossing_s` to traverse a streak of known length; all of it must lie within
            // the exposure.
            let rate_rad_s = middle.sighting.own_rate.norm();
            let crossing_s = streak.length_rad().map_or(0.0, |length_rad| length_rad / rate_rad_s);
            let free = (1.0 - crossing_s / (2.0 * half_s)).clamp(0.0, 1.0);
            let integral = |sigma_s: f64| integrate_exposure(pulls(&before, sigma_s), pulls(&after, sigma_s), free);
            let passage_s = mid_s + half_s * integral(sigmas.delay_s).at;
            let met = nearest_passage(interval, propagator, streak, passage_s, middle.delay_s + passage_s - mid_s)?;
            // ∫ dt f(δ) N(x; σ_x): the density f is a sum of Gaussians; `integral` is that of one Gaussian over u in
            // [-1, 1].
            let log_density = log_sum(sigmas.lateness.parts().map(|(weight, sigma_s)| {
                weight.ln() + integral(sigma_s).log_integral + half_s.ln()
                    - (TAU * sigma_s * sigmas.cross_track_rad).ln()
            }));
            (passage_s, met, Some(log_density))
        }
    };
    if met.delay_s.abs() > reach.along_track_s || met.cross_track_rad.abs() > reach.cross_track_rad {
        return None;
    }

    let mut delay_s = met.delay_s;
    let mut track = interval.track(element_index, delay_s).ok()?;
    let mut line = Line::new(&track, passage_s, streak, met.cross_track_rad);
    for _ in 0..MOST_CORRECTIONS {
        // If the angular rate changes, the satellite is not at the middle of the track at half time. The mean of both
        // ends corrects this.
        let Some(early_s) = line.ends_early_s(streak).filter(|early_s| early_s.abs() > CLOSE_S) else { break };
        delay_s += early_s;
        track = interval.track(element_index, delay_s).ok()?;
        line = Line::new(&track, passage_s, streak, met.cross_track_rad);
    }
    let passage = track.point(passage_s, photometry)?;
    let is_lit = |time_s: f64| track.point(time_s, photometry).is_some_and(|point| point.illumination.is_lit());
    if !track.is_up(passage_s)
        || !(include_dark || photometry.band.is_thermal() || line.times_s.iter().any(|&time_s| is_lit(time_s)))
    {
        return None;
    }
    let length = line.length(&track, streak, &sigmas);
    let mut candidate = Candidate {
        norad_id: propagator.norad_id(),
        element_index,
        passage,
        along_track_s: Offset { value: delay_s, sigma: sigmas.delay_s },
        cross_track_rad: Offset { value: line.cross_track_rad, sigma: sigmas.cross_track_rad },
        angle_rad: Offset { value: line.turn_rad, sigma: sigmas.turn_rad },
        length_rad: length.map(|(offset, _)| offset),
        predicted_length_rad: length
            .map_or(line.rate_rad_s * interval.duration_s(), |(_, predicted_rad)| predicted_rad),
        position_angle_rad: line.position_angle_rad,
        angular_rate_rad_s: line.rate_rad_s,
        element_age_days: interval.element_age_days(propagator, passage_s),
        chi_square: 0.0,
        terms: 0,
        p_value: 0.0,
        probability: 0.0,
        log_weight: 0.0,
    };
    let log_density =
        within_exposure.unwrap_or_else(|| sigmas.lateness.log_density(delay_s) + log_normal(candidate.cross_track_rad));
    let delay_square = sigmas.lateness.equivalent_sigmas(delay_s).powi(2);
    CandidateWeight::new(&candidate, streak.timing(), delay_square, log_density).apply_to(&mut candidate);
    (candidate.chi_square <= MOST_CHI_SQUARE).then_some(candidate)
}

/// Standard deviations of the differences between streak and track.
struct Sigmas {
    /// Half width of the interval that contains 68.27 % of the distribution `lateness`, seconds.
    delay_s: f64,
    /// Distribution of the delay of the satellite, including the errors of the clock and of the measured position.
    lateness: Lateness,
    cross_track_rad: f64,
    turn_rad: f64,
    /// Relative error of the angular rate.
    rate_share: f64,
}

impl Sigmas {
    fn new(errors: &OrbitUncertainty, met: &NearestPassage, propagator: &Propagator, streak: &MeasuredStreak) -> Self {
        let rate_rad_s = met.sighting.own_rate.norm().max(1e-12);
        let across_rad = errors.cross_track_km / met.sighting.range_km;
        let position_rad = streak.position_sigma_rad();
        let mean_motion_rad_s = TAU / propagator.period_s();
        let lateness = errors.lateness.blurred(streak.time_sigma_s().hypot(FRAC_1_SQRT_2 * position_rad / rate_rad_s));
        Self {
            delay_s: lateness.one_sigma_s(),
            lateness,
            cross_track_rad: (across_rad.powi(2) + 0.5 * position_rad.powi(2)).sqrt(),
            turn_rad: (mean_motion_rad_s * across_rad / rate_rad_s).hypot(streak.angle_sigma_rad()),
            rate_share: across_rad,
        }
    }
}

/// Returns ln Σ exp(x), computed without overflow.
fn log_sum(logarithms: impl Iterator<Item = f64> + Clone) -> f64 {
    let greatest = logarithms.clone().fold(f64::NEG_INFINITY, f64::max);
    greatest + logarithms.map(|x| (x - greatest).exp()).sum::<f64>().ln()
}

/// Finds the delay with which a satellite passes nearest to the middle of the streak at a given time.
fn nearest_passage(
    interval: &ExposureInterval<'_>,
    propagator: &Propagator,
    streak: &MeasuredStreak,
    time_s: f64,
    guess_s: f64,
) -> Option<NearestPassage> {
    let middle = *streak.middle().vector();
    let longest_s = 0.1 * propagator.period_s();
    let mut delay_s = guess_s;
    for _ in 0..MOST_STEPS {
        let sighting = interval.sighting(propagator, time_s, delay_s).ok()?;
        let square = sighting.own_rate.norm_squared();
        if square == 0.0 {
            return None;
        }
        // Remaining distance along the motion divided by the speed. If the streak is ahead of the satellite, the delay
        // is smaller.
        let step_s = (middle.dot(&sighting.own_rate) / square).clamp(-longest_s, longest_s);
        delay_s -= step_s;
        if step_s.abs() < CLOSE_S {
            let axis = cross_track_axis(&sighting.direction, &sighting.own_rate);
            let cosine = middle.dot(sighting.direction.vector());
            let cross_track_rad = middle.dot(&axis).atan2(cosine);
            return (cosine > 0.0).then_some(NearestPassage { delay_s, cross_track_rad, sighting });
        }
    }
    None
}

/// Returns the unit vector perpendicular to the motion, at its position angle + 90°.
fn cross_track_axis(direction: &Direction<Gcrs>, rate: &Vector3<f64>) -> Vector3<f64> {
    // With PA from north through east, PA + 90° is motion × line of sight.
    rate.normalize().cross(direction.vector())
}

/// Geometry of a streak relative to a track.
struct Line {
    cross_track_rad: f64,
    turn_rad: f64,
    position_angle_rad: f64,
    rate_rad_s: f64,
    /// Times at which the track is nearest to the first end, the middle and the second end.
    times_s: [f64; 3],
}

impl Line {
    fn new(track: &DelayedTrack<'_>, passage_s: f64, streak: &MeasuredStreak, cross_track_rad: f64) -> Self {
        let (direction, rate) = track.direction(passage_s);
        let (east, north) = direction.east_north();
        let position_angle_rad = rate.dot(&east).atan2(rate.dot(&north)).rem_euclid(TAU);
        let rate_rad_s = rate.norm();
        // The great circle from the nearest point of the track to the middle of the streak is perpendicular to the
        // motion, so that the unit vector of the motion is the same at both.
        let motion = rate.normalize();
        let middle = streak.middle();
        let (east, north) = middle.east_north();
        let along = east * streak.position_angle_rad().sin() + north * streak.position_angle_rad().cos();
        let turn_rad = along.dot(&motion.cross(middle.vector())).atan2(along.dot(&motion));
        let is_backward = streak.timing() != Timing::FirstToSecond && turn_rad.abs() > 0.5 * PI;
        let turn_rad = if is_backward { turn_rad - PI * turn_rad.signum() } else { turn_rad };
        let mut line = Self { cross_track_rad, turn_rad, position_angle_rad, rate_rad_s, times_s: [passage_s; 3] };
        if let (Some(ends), Some(length_rad)) = (streak.ends(), streak.length_rad())
            && turn_rad.abs() < LARGEST_TURN_RAD
        {
            let sign = if is_backward { -1.0 } else { 1.0 };
            let half_s = sign * 0.5 * length_rad / rate_rad_s;
            let at = [(ends[0], passage_s - half_s), (ends[1], passage_s + half_s)].map(|(end, guess_s)| {
                let time_s = track.nearest_s(&end, guess_s);
                let (direction, rate) = track.direction(time_s);
                (time_s, end.vector().dot(&cross_track_axis(&direction, &rate)).clamp(-1.0, 1.0).asin())
            });
            line.times_s = [at[0].0, passage_s, at[1].0];
            if streak.is_by_ends() {
                line.cross_track_rad = 0.5 * (at[0].1 + at[1].1);
                line.turn_rad = sign * (at[1].1 - at[0].1) / length_rad;
            }
        }
        line
    }

    /// Returns the mean time by which the satellite passes the ends too early, seconds; `None` if the times of the ends
    /// are unknown.
    fn ends_early_s(&self, streak: &MeasuredStreak) -> Option<f64> {
        let is_timed = streak.timing() != Timing::Within && self.turn_rad.abs() < LARGEST_TURN_RAD;
        is_timed.then(|| 0.5 * (streak.duration_s() - self.times_s[0] - self.times_s[2]))
    }

    /// Returns the measured minus the predicted length with its sigma, and the predicted length, radians.
    fn length(&self, track: &DelayedTrack<'_>, streak: &MeasuredStreak, sigmas: &Sigmas) -> Option<(Offset, f64)> {
        let length_rad = streak.length_rad()?;
        let (is_whole, predicted_rad) = match streak.timing() {
            Timing::Within => (false, self.rate_rad_s * streak.duration_s()),
            _ => (true, track.direction(0.0).0.separation_rad(&track.direction(streak.duration_s()).0)),
        };
        let clock_rad = self.rate_rad_s * streak.time_sigma_s();
        let sigma = (2.0 * streak.position_sigma_rad().powi(2)
            + 2.0 * clock_rad.powi(2)
            + (predicted_rad * sigmas.rate_share).powi(2))
        .sqrt();
        let too_long_rad = length_rad - predicted_rad;
        let value = if is_whole { too_long_rad } else { too_long_rad.max(0.0) };
        Some((Offset { value, sigma }, predicted_rad))
    }
}

//! One satellite held against a streak: how late it would have to be, how far beside its path the streak lies, by how much it is turned.
//!
//! 1. The delay δ with which the satellite passes nearest to the middle of the streak at the streak's own time, by Newton's method on SGP4. Where the time
//!    is an exposure, the moment in it that wants the least of delay and distance (in sigmas) is taken.
//! 2. With that delay the whole track: the distances of both ends from it. Their mean is the offset across the track, their difference over the length the
//!    turn. So a curved track is held against the ends that it should meet, not against a straight line; and where the times of the ends are known, the delay is
//!    that with which it meets them at these times, in the mean.
//! 3. The length that the satellite makes in the time, against the one measured; where the ends may be those of the frame, a longer one alone counts.
//!
//! Sigmas are those of the elements' age ([`ExposureInterval::uncertainty`]) and of the measurement:
//!
//! ```text
//! σ_δ² = σ_along² + σ_clock² + (σ_place/ω)²/2     σ_x² = (σ_cross/ρ)² + σ_place²/2
//! σ_θ² = (n σ_cross/(ω ρ))² + σ_angle²            σ_L² = 2 σ_place² + 2 (ω σ_clock)² + (L σ_cross/ρ)²
//! ```
//!
//! with the rate ω on the sky, the distance ρ, and the satellite's mean motion n: an orbit tilted by σ_cross crosses its own prediction under n σ_cross / v.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::likelihood::{Weighed, within};
use super::streak::{MeasuredStreak, Timing};
use crate::elements::NoradId;
use crate::frames::{Direction, Gcrs};
use crate::orbit::{OrbitUncertainty, Propagator};
use crate::passes::{DelayedTrack, ExposureInterval, Sighting, TrackPoint};
use crate::photometry::PhotometryOptions;

/// Newton's method ends here, seconds: 0.1 m of way.
const CLOSE_S: f64 = 1e-5;
/// Its most steps; three or four are usual.
const MOST_STEPS: usize = 40;
/// The mean of both ends is closed in on in at most so many steps; each leaves a tenth of what was there.
const MOST_CORRECTIONS: usize = 5;
/// Beyond this turn the ends have no nearest points that mean anything, radians.
const LARGEST_TURN_RAD: f64 = 0.2;

/// Beyond this χ² a satellite that comes near is not the one, however heavy the tails of its errors: 14 sigmas.
const MOST_CHI_SQUARE: f64 = 200.0;

/// How far from its prediction a satellite is still looked for.
#[derive(Copy, Clone, Debug)]
pub(super) struct Reach {
    pub along_track_s: f64,
    pub cross_track_rad: f64,
}

/// A difference with its one-sigma error.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Offset {
    /// Measured less predicted.
    pub value: f64,
    /// One sigma of prediction and measurement together, above 0.
    pub sigma: f64,
}

impl Offset {
    /// In sigmas, squared.
    pub(super) fn square(self) -> f64 {
        (self.value / self.sigma).powi(2)
    }
}

/// A satellite that may have made the streak.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Who.
    pub norad_id: NoradId,
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Where it passes the middle of the streak, at the time at which it does if it is late by `along_track_s`.
    pub passage: TrackPoint,
    /// The satellite passes so many seconds later than predicted (negative: earlier).
    pub along_track_s: Offset,
    /// The streak lies so far beside the predicted path, radians; positive on the side of the position angle of motion + 90°.
    pub cross_track_rad: Offset,
    /// The streak's position angle less that of the motion, (-π/2, π/2], radians; (-π, π] where the streak's direction is known.
    pub angle_rad: Offset,
    /// Length measured less predicted, radians. Where the ends may be those of the frame, what it is too long. `None` of a streak of unknown length.
    pub length_rad: Option<Offset>,
    /// Length that it makes in the time, radians.
    pub predicted_length_rad: f64,
    /// Position angle of its motion, from north through east, [0, 2π), radians.
    pub position_angle_rad: f64,
    /// Its speed among the stars, rad/s.
    pub angular_rate_rad_s: f64,
    /// Passage less epoch of the elements, days.
    pub element_age_days: f64,
    /// Sum of the squares of all offsets in sigmas.
    pub chi_square: f64,
    /// How many of them count.
    pub terms: u32,
    /// Probability of a χ² as large as that or larger, were it this satellite.
    pub p_value: f64,
    /// Probability that it is this satellite, among all candidates and satellites of which no element set tells.
    pub probability: f64,
    pub(super) log_weight: f64,
}

/// A delay at which the satellite passes nearest to the middle of the streak.
#[derive(Copy, Clone)]
struct Met {
    late_s: f64,
    beside_rad: f64,
    sighting: Sighting,
}

/// Holds one satellite against a streak; `None` where it cannot be it: out of reach, below the horizon, or dark where light is wanted.
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
    let middle = meet(interval, propagator, streak, mid_s, guess_s)?;
    let age_days = interval.element_age_days(propagator, mid_s);
    let errors = interval.uncertainty(element_index, age_days);
    let sigmas = Sigmas::new(&errors, &middle, propagator, streak);

    // The moment of the passage.
    let (passage_s, met, evidence) = match streak.timing() {
        Timing::FirstToSecond | Timing::Whole => (mid_s, middle, None),
        Timing::Within => {
            let half_s = mid_s.max(streak.time_sigma_s().min(0.9 * DelayedTrack::MARGIN_S));
            let ends = [mid_s - half_s, mid_s + half_s]
                .map(|time_s| meet(interval, propagator, streak, time_s, middle.late_s + time_s - mid_s));
            let [Some(before), Some(after)] = ends else { return None };
            let pulls = |met: &Met| [met.late_s / sigmas.late_s, met.beside_rad / sigmas.beside_rad];
            // A streak of known length takes its time, which must be within the exposure too.
            let rate_rad_s = middle.sighting.own_rate.norm();
            let crossing_s = streak.length_rad().map_or(0.0, |length_rad| length_rad / rate_rad_s);
            let free = (1.0 - crossing_s / (2.0 * half_s)).clamp(0.0, 1.0);
            let within = within(pulls(&before), pulls(&after), free);
            let passage_s = mid_s + half_s * within.at;
            let met = meet(interval, propagator, streak, passage_s, middle.late_s + passage_s - mid_s)?;
            // ∫ dt N(δ; σ_δ) N(x; σ_x), of which `within` has the integral over [-1, 1]
            let log_density = within.log_integral + half_s.ln() - (TAU * sigmas.late_s * sigmas.beside_rad).ln();
            (passage_s, met, Some(log_density))
        }
    };
    if met.late_s.abs() > reach.along_track_s || met.beside_rad.abs() > reach.cross_track_rad {
        return None;
    }

    let mut late_s = met.late_s;
    let mut track = interval.track(element_index, late_s).ok()?;
    let mut line = Line::new(&track, passage_s, streak, met.beside_rad);
    for _ in 0..MOST_CORRECTIONS {
        // A track that gets faster or slower is not at its middle at half time: the mean of both ends is.
        let Some(early_s) = line.ends_early_s(streak).filter(|early_s| early_s.abs() > CLOSE_S) else { break };
        late_s += early_s;
        track = interval.track(element_index, late_s).ok()?;
        line = Line::new(&track, passage_s, streak, met.beside_rad);
    }
    let passage = track.point(passage_s, photometry)?;
    let is_lit =
        |time_s: f64| track.point(time_s, photometry).is_some_and(|point| point.illumination.lit_fraction() > 0.0);
    if !track.is_up(passage_s) || !(include_dark || line.times_s.iter().any(|&time_s| is_lit(time_s))) {
        return None;
    }
    let length = line.length(&track, streak, &sigmas);
    let mut candidate = Candidate {
        norad_id: propagator.norad_id(),
        element_index,
        passage,
        along_track_s: Offset { value: late_s, sigma: sigmas.late_s },
        cross_track_rad: Offset { value: line.beside_rad, sigma: sigmas.beside_rad },
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
    Weighed::of(&candidate, streak.timing(), evidence).put_into(&mut candidate);
    (candidate.chi_square <= MOST_CHI_SQUARE).then_some(candidate)
}

/// One sigma of each difference.
struct Sigmas {
    late_s: f64,
    beside_rad: f64,
    turn_rad: f64,
    /// Of the rate, as a share of it.
    rate_share: f64,
}

impl Sigmas {
    fn new(errors: &OrbitUncertainty, met: &Met, propagator: &Propagator, streak: &MeasuredStreak) -> Self {
        let rate_rad_s = met.sighting.own_rate.norm().max(1e-12);
        let across_rad = errors.cross_track_km / met.sighting.range_km;
        let place_rad = streak.place_sigma_rad();
        let mean_motion_rad_s = TAU / propagator.period_s();
        Self {
            late_s: (errors.along_track_s.powi(2)
                + streak.time_sigma_s().powi(2)
                + 0.5 * (place_rad / rate_rad_s).powi(2))
            .sqrt(),
            beside_rad: (across_rad.powi(2) + 0.5 * place_rad.powi(2)).sqrt(),
            turn_rad: (mean_motion_rad_s * across_rad / rate_rad_s).hypot(streak.angle_sigma_rad()),
            rate_share: across_rad,
        }
    }
}

/// The delay with which a satellite passes nearest to the middle of the streak at a time.
fn meet(
    interval: &ExposureInterval<'_>,
    propagator: &Propagator,
    streak: &MeasuredStreak,
    time_s: f64,
    guess_s: f64,
) -> Option<Met> {
    let place = *streak.place().vector();
    let longest_s = 0.1 * propagator.period_s();
    let mut late_s = guess_s;
    for _ in 0..MOST_STEPS {
        let sighting = interval.sighting(propagator, time_s, late_s).ok()?;
        let square = sighting.own_rate.norm_squared();
        if square == 0.0 {
            return None;
        }
        // The way left along the motion, as time: ahead of the satellite means that it has to be earlier.
        let step_s = (place.dot(&sighting.own_rate) / square).clamp(-longest_s, longest_s);
        late_s -= step_s;
        if step_s.abs() < CLOSE_S {
            let side = side(&sighting.direction, &sighting.own_rate);
            let cosine = place.dot(sighting.direction.vector());
            let beside_rad = place.dot(&side).atan2(cosine);
            return (cosine > 0.0).then_some(Met { late_s, beside_rad, sighting });
        }
    }
    None
}

/// Unit vector at right angles to the motion, towards its position angle + 90°.
fn side(direction: &Direction<Gcrs>, rate: &Vector3<f64>) -> Vector3<f64> {
    // With north through east growing, PA + 90° is motion × line of sight.
    rate.normalize().cross(direction.vector())
}

/// The streak against a track.
struct Line {
    beside_rad: f64,
    turn_rad: f64,
    position_angle_rad: f64,
    rate_rad_s: f64,
    /// Where the track is nearest to the first end, the middle and the second end.
    times_s: [f64; 3],
}

impl Line {
    fn new(track: &DelayedTrack<'_>, passage_s: f64, streak: &MeasuredStreak, beside_rad: f64) -> Self {
        let (direction, rate) = track.direction(passage_s);
        let (east, north) = direction.east_north();
        let position_angle_rad = rate.dot(&east).atan2(rate.dot(&north)).rem_euclid(TAU);
        let rate_rad_s = rate.norm();
        // The motion's direction is the same at the foot and at the middle of the streak: the way between is at right angles to it.
        let motion = rate.normalize();
        let place = streak.place();
        let (east, north) = place.east_north();
        let along = east * streak.position_angle_rad().sin() + north * streak.position_angle_rad().cos();
        let turn_rad = along.dot(&motion.cross(place.vector())).atan2(along.dot(&motion));
        let is_backward = streak.timing() != Timing::FirstToSecond && turn_rad.abs() > 0.5 * PI;
        let turn_rad = if is_backward { turn_rad - PI * turn_rad.signum() } else { turn_rad };
        let mut line = Self { beside_rad, turn_rad, position_angle_rad, rate_rad_s, times_s: [passage_s; 3] };
        if let (Some(ends), Some(length_rad)) = (streak.ends(), streak.length_rad())
            && turn_rad.abs() < LARGEST_TURN_RAD
        {
            let sign = if is_backward { -1.0 } else { 1.0 };
            let half_s = sign * 0.5 * length_rad / rate_rad_s;
            let at = [(ends[0], passage_s - half_s), (ends[1], passage_s + half_s)].map(|(end, guess_s)| {
                let time_s = track.nearest_s(&end, guess_s);
                let (direction, rate) = track.direction(time_s);
                (time_s, end.vector().dot(&side(&direction, &rate)).clamp(-1.0, 1.0).asin())
            });
            line.times_s = [at[0].0, passage_s, at[1].0];
            if streak.is_by_ends() {
                line.beside_rad = 0.5 * (at[0].1 + at[1].1);
                line.turn_rad = sign * (at[1].1 - at[0].1) / length_rad;
            }
        }
        line
    }

    /// By how much the track passes the ends too early, the mean of both; `None` where their times are not known.
    fn ends_early_s(&self, streak: &MeasuredStreak) -> Option<f64> {
        let is_timed = streak.timing() != Timing::Within && self.turn_rad.abs() < LARGEST_TURN_RAD;
        is_timed.then(|| 0.5 * (streak.duration_s() - self.times_s[0] - self.times_s[2]))
    }

    /// Length measured less predicted with its sigma, and the predicted one.
    fn length(&self, track: &DelayedTrack<'_>, streak: &MeasuredStreak, sigmas: &Sigmas) -> Option<(Offset, f64)> {
        let length_rad = streak.length_rad()?;
        let (is_whole, predicted_rad) = match streak.timing() {
            Timing::Within => (false, self.rate_rad_s * streak.duration_s()),
            _ => (true, track.direction(0.0).0.separation_rad(&track.direction(streak.duration_s()).0)),
        };
        let clock_rad = self.rate_rad_s * streak.time_sigma_s();
        let sigma = (2.0 * streak.place_sigma_rad().powi(2)
            + 2.0 * clock_rad.powi(2)
            + (predicted_rad * sigmas.rate_share).powi(2))
        .sqrt();
        let too_long_rad = length_rad - predicted_rad;
        let value = if is_whole { too_long_rad } else { too_long_rad.max(0.0) };
        Some((Offset { value, sigma }, predicted_rad))
    }
}

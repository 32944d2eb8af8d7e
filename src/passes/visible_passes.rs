//! Visible passes: above a site's horizon at night and in sunlight, with the Earth's shadow and the brightest point.
//!
//! Of the intervals above the horizon, those in daylight and those in the shadow all along are decided by their
//! samples; the others are interpolated, the borders of light closed to a millisecond, and the brightest point is
//! searched in steps of at most ten seconds and closed in on.

use hifitime::Epoch;
use rayon::prelude::*;

use super::above_horizon::{AboveHorizon, HorizonSearch, Sample, Treatment};
use super::error::{SkyError, check_epoch};
use super::evaluator::PassEvaluator;
use super::scene::Scene;
use super::sky::Sky;
use super::track::{ObserverMotion, SightLine, TrackPoint};
use crate::elements::NoradId;
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::{Illumination, Observer};
use crate::orbit::{LeftOut, OrbitArc, OrbitError};
use crate::photometry::{MagnitudeSource, PhotometryOptions};

/// A pass that began before the night is followed back this far, and one that ends after it as far ahead, seconds: low
/// satellites rise and set within it.
const TWILIGHT_REACH_S: f64 = 1800.0;
/// Step of the first search for shadow and light, seconds, and its largest number of steps.
const LIGHT_STEP_S: f64 = 10.0;
const MOST_LIGHT_STEPS: f64 = 360.0;
/// Least number of satellites for one thread.
const TOGETHER: usize = 8;
/// Borders of light are closed to this, seconds.
const BORDER_S: f64 = 1e-3;

/// Which passes to compute.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleRequest {
    /// Start.
    pub start: Epoch,
    /// End.
    pub end: Epoch,
    /// Intervals in which the site is dark, in order of time, within the two.
    pub dark: Vec<(Epoch, Epoch)>,
    /// Altitude that counts as rise and set, radians.
    pub min_altitude_rad: f64,
    /// Lowest culmination, radians.
    pub min_culmination_rad: f64,
    /// Faintest peak; passes without a magnitude are then left out too.
    pub max_magnitude: Option<f64>,
    /// Include passes in the Earth's shadow and in daylight.
    pub include_dark: bool,
    /// Points from rise to set, evenly spaced in time; 0 for none.
    pub samples: usize,
    /// Band, system, extinction.
    pub photometry: PhotometryOptions,
}

/// The visible part of a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// Its begin: at the rise, out of the shadow (full sunlight) or at nightfall.
    pub begin: TrackPoint,
    /// Its highest point.
    pub highest: TrackPoint,
    /// Its end: at the set, where the light begins to fade into the shadow, or at dawn.
    pub end: TrackPoint,
    /// Its brightest point, penumbra included; `None` where the model gives no light.
    pub peak: Option<TrackPoint>,
}

/// One pass of one satellite above a site's horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct VisiblePass {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// The point at which it reaches the lowest altitude; `None` where it was up when the search began, half an hour
    /// before the night.
    pub rise: Option<TrackPoint>,
    /// The highest point of the pass.
    pub culmination: TrackPoint,
    /// The point at which it falls below the lowest altitude; `None` where it is still up when the search ends.
    pub set: Option<TrackPoint>,
    /// The point at which the light first begins to fade into the Earth's shadow.
    pub shadow_entry: Option<TrackPoint>,
    /// The point at which full light first returns.
    pub shadow_exit: Option<TrackPoint>,
    /// Its visible part; `None` where nothing is visible.
    pub visible: Option<Visibility>,
    /// Culmination minus element epoch, days.
    pub element_age_days: f64,
    /// Points from rise to set; empty without samples in the request.
    pub samples: Vec<TrackPoint>,
}

/// Numbers of passes that were found and excluded.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct NotShown {
    /// Above the lowest altitude while the site is dark, and in the Earth's shadow at all such times. Passes that end
    /// before it gets dark or begin after are not counted.
    pub in_shadow: usize,
    /// Fainter than the limit, or without any magnitude.
    pub too_faint: usize,
    /// Those of them whose magnitude is a prior alone: the satellite's brightness is unknown.
    pub too_faint_by_prior: usize,
    /// Above the lowest altitude while the site is dark, and culminating too low.
    pub too_low: usize,
}

/// Passes and what was excluded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisiblePasses {
    /// In order of the time at which they are first visible (of culmination where they are not).
    pub passes: Vec<VisiblePass>,
    /// Numbers of excluded passes.
    pub not_shown: NotShown,
    /// Number of satellites searched.
    pub satellites: usize,
    /// Satellites without a position at some time of the search.
    pub left_out: Vec<LeftOut>,
}

/// Outcome of one pass.
enum Outcome {
    Pass(Box<VisiblePass>),
    InShadow,
    TooFaint { by_prior: bool },
    TooLow,
}

/// A search interval, and the dark intervals in it; seconds of the scene.
struct Span {
    from_s: f64,
    until_s: f64,
    dark_s: Vec<(f64, f64)>,
}

impl Sky {
    /// Every visible pass over the site, on all threads, of the satellites that `is_wanted` selects by element index.
    ///
    /// Altitudes are geometric, without refraction. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`SkyError::NoEphemeris`] outside the years of the Sun's ephemeris; [`SkyError::NoHorizon`] for an observer in
    /// orbit.
    pub fn visible_passes(
        &self,
        request: &VisibleRequest,
        is_wanted: &(dyn Fn(usize) -> bool + Sync),
    ) -> Result<VisiblePasses, SkyError> {
        check_epoch(request.start)?;
        check_epoch(request.end)?;
        let observer = self.site_observer()?;
        let scene_start = seconds_after(request.start, -TWILIGHT_REACH_S);
        let span_s = seconds_between(request.start, request.end).max(0.0) + 2.0 * TWILIGHT_REACH_S;
        let scene = self.scene_without_windows(scene_start, span_s);
        let spans = spans(request, scene_start);
        let search = Search { sky: self, scene: &scene, observer, request };
        let wanted: Vec<usize> = (0..self.index().len()).filter(|&one| is_wanted(one)).collect();
        let of_one = |&element_index: &usize| {
            // Passes found before SGP4 fails are kept.
            let mut kept = Vec::new();
            let failed = spans.iter().try_for_each(|span| search.passes(element_index, span, &mut kept)).err();
            (kept, failed.map(|reason| self.failed(element_index, reason)))
        };
        let all: Vec<(Vec<Outcome>, Option<LeftOut>)> = wanted.par_iter().with_min_len(TOGETHER).map(of_one).collect();
        let mut answer = VisiblePasses { satellites: wanted.len(), ..VisiblePasses::default() };
        answer.left_out.extend(self.left_out().iter().filter(|one| is_wanted(one.element_index)).cloned());
        for one in all.into_iter().flat_map(|(kept, failed)| {
            answer.left_out.extend(failed);
            kept
        }) {
            match one {
                Outcome::Pass(pass) => answer.passes.push(*pass),
                Outcome::InShadow => answer.not_shown.in_shadow += 1,
                Outcome::TooFaint { by_prior } => {
                    answer.not_shown.too_faint += 1;
                    answer.not_shown.too_faint_by_prior += usize::from(by_prior);
                }
                Outcome::TooLow => answer.not_shown.too_low += 1,
            }
        }
        answer.left_out.sort_by_key(|one| one.element_index);
        let seen = |pass: &VisiblePass| pass.visible.as_ref().map_or(pass.culmination.epoch, |seen| seen.begin.epoch);
        answer.passes.sort_by(|a, b| seen(a).cmp(&seen(b)).then(a.element_index.cmp(&b.element_index)));
        Ok(answer)
    }
}

/// One search for each dark interval, or one for all of the time; those that would meet are joined.
fn spans(request: &VisibleRequest, scene_start: Epoch) -> Vec<Span> {
    let at = |epoch: Epoch| seconds_between(scene_start, epoch);
    let dark_s: Vec<(f64, f64)> = request.dark.iter().map(|(from, until)| (at(*from), at(*until))).collect();
    if request.include_dark {
        return vec![Span { from_s: at(request.start), until_s: at(request.end), dark_s }];
    }
    let mut spans: Vec<Span> = Vec::new();
    for (from_s, until_s) in dark_s {
        match spans.last_mut() {
            Some(span) if from_s - TWILIGHT_REACH_S <= span.until_s => {
                span.until_s = until_s + TWILIGHT_REACH_S;
                span.dark_s.push((from_s, until_s));
            }
            _ => spans.push(Span {
                from_s: from_s - TWILIGHT_REACH_S,
                until_s: until_s + TWILIGHT_REACH_S,
                dark_s: vec![(from_s, until_s)],
            }),
        }
    }
    spans
}

struct Search<'a> {
    sky: &'a Sky,
    scene: &'a Scene,
    observer: &'a Observer,
    request: &'a VisibleRequest,
}

impl Search<'_> {
    fn passes(&self, element_index: usize, span: &Span, kept: &mut Vec<Outcome>) -> Result<(), OrbitError> {
        let Some(propagator) = self.sky.index().propagator(element_index) else { return Ok(()) };
        let minutes = propagator.minutes_since_epoch(self.scene.start);
        let horizon = HorizonSearch { scene: self.scene, propagator, minutes, observer: self.observer };
        // The shadow is convex: a satellite that is dark at its rise and at its set is dark in between, and one that
        // stays up for hours is lit at some sample. For one that rises or sets about dusk or dawn the samples do not
        // decide whether it is up in the dark.
        let treatment = |samples: &[Sample]| {
            let (first_s, last_s) = (samples[0].time_s, samples[samples.len() - 1].time_s);
            let is_in_umbra = |sample: &Sample| {
                let sun = self.scene.sun.at_s(sample.time_s).sun;
                self.sky.shadow().illumination(&sample.state.position, &sun) == Illumination::Umbra
            };
            if self.request.include_dark {
                Treatment::Compute
            } else if !span.dark_s.iter().any(|&(from_s, until_s)| first_s < until_s && last_s > from_s) {
                Treatment::Skip
            } else if span.dark_s.iter().any(|&(from_s, until_s)| first_s >= from_s && last_s <= until_s)
                && samples.iter().all(is_in_umbra)
            {
                Treatment::Count
            } else {
                Treatment::Compute
            }
        };
        let (intervals, in_shadow) =
            horizon.intervals((span.from_s, span.until_s), self.request.min_altitude_rad, &treatment)?;
        kept.extend((0..in_shadow).map(|_| Outcome::InShadow));
        for above in intervals {
            kept.extend(self.pass(element_index, &horizon, span, &above)?);
        }
        Ok(())
    }

    /// The site near a time.
    fn motion(&self, time_s: f64) -> ObserverMotion {
        let orientation = self.scene.orientation.at_s(time_s);
        let earth_velocity = self.scene.sun.at_s(time_s).earth_velocity;
        ObserverMotion::of_site(self.observer, &orientation, earth_velocity, time_s)
    }

    /// One interval above the horizon; `None` where it ends before the dark or begins after, and where observer and
    /// satellite coincide.
    fn pass(
        &self,
        element_index: usize,
        horizon: &HorizonSearch<'_>,
        span: &Span,
        above: &AboveHorizon,
    ) -> Result<Option<Outcome>, OrbitError> {
        let (begin_s, end_s) = (above.rise_s.unwrap_or(span.from_s), above.set_s.unwrap_or(span.until_s));
        if !self.request.include_dark && both(&[(begin_s, end_s)], &span.dark_s).is_empty() {
            return Ok(None);
        }
        let orientation = self.scene.orientation.at_s(above.top_s);
        let arc = OrbitArc::over_pass(
            horizon.propagator,
            horizon.minutes,
            begin_s - 1.0,
            end_s - begin_s + 2.0,
            &orientation.teme_to_gcrs,
            above.turning_rad_s,
        )?;
        let line = SightLine { arc: &arc, observer: self.motion(above.top_s) };
        let culminates = seconds_after(self.scene.start, above.top_s);
        let evaluator = PassEvaluator {
            sky: self.sky,
            scene: self.scene,
            line: &line,
            element_index,
            photometry: Some(&self.request.photometry),
            uncertainty: self.sky.uncertainty_at(element_index, culminates),
        };
        let Some(culmination) = evaluator.point(above.top_s) else { return Ok(None) };
        if culmination.altitude_rad.is_some_and(|altitude_rad| altitude_rad < self.request.min_culmination_rad) {
            return Ok(Some(Outcome::TooLow));
        }
        let steps = ((end_s - begin_s) / LIGHT_STEP_S).ceil().clamp(4.0, MOST_LIGHT_STEPS) as usize;
        let light = |time_s: f64| evaluator.illumination(time_s);
        let full = intervals_where(begin_s, end_s, steps, |time_s| light(time_s) == Illumination::Sunlit);
        let lit = intervals_where(begin_s, end_s, steps, |time_s| light(time_s) != Illumination::Umbra);
        let lit_by_night = both(&lit, &span.dark_s);
        let visible = if lit_by_night.is_empty() {
            None
        } else {
            let full_by_night = both(&full, &span.dark_s);
            let seen = if full_by_night.is_empty() { &lit_by_night } else { &full_by_night };
            visibility(&evaluator, seen, &lit_by_night, above.top_s)
        };
        let magnitude =
            visible.as_ref().and_then(|seen| seen.peak.as_ref()?.brightness.as_ref()).map(|light| light.magnitude.0);
        if visible.is_none() && !self.request.include_dark {
            return Ok(Some(Outcome::InShadow));
        }
        if self.request.max_magnitude.is_some_and(|limit| magnitude.is_none_or(|magnitude| magnitude > limit)) {
            let by_prior = magnitude.is_some() && *self.sky.model(element_index).source() == MagnitudeSource::Prior;
            return Ok(Some(Outcome::TooFaint { by_prior }));
        }
        let point = |time_s: Option<f64>| time_s.and_then(|time_s| evaluator.point(time_s));
        // Times at which full light ends within the pass, and at which it begins.
        let entry_s = full.iter().map(|interval| interval.1).find(|&time_s| time_s < end_s);
        let exit_s = full.iter().map(|interval| interval.0).find(|&time_s| time_s > begin_s);
        Ok(Some(Outcome::Pass(Box::new(VisiblePass {
            norad_id: horizon.propagator.norad_id(),
            element_index,
            rise: point(above.rise_s),
            set: point(above.set_s),
            shadow_entry: point(entry_s),
            shadow_exit: point(exit_s),
            visible,
            element_age_days: self.sky.element_age_days(element_index, culminates),
            samples: evaluator.samples(begin_s, end_s, self.request.samples),
            culmination,
        }))))
    }
}

/// The visible part in intervals of full light, and the brightest point in any light.
fn visibility(
    evaluator: &PassEvaluator<'_>,
    seen: &[(f64, f64)],
    lit: &[(f64, f64)],
    top_s: f64,
) -> Option<Visibility> {
    let ends = seen.iter().flat_map(|&(from_s, until_s)| [from_s, until_s]);
    let top = seen.iter().any(|&(from_s, until_s)| (from_s..=until_s).contains(&top_s)).then_some(top_s);
    let highest = ends
        .chain(top)
        .filter_map(|time_s| evaluator.point(time_s))
        .max_by(|a, b| a.altitude_rad.partial_cmp(&b.altitude_rad).unwrap_or(std::cmp::Ordering::Equal))?;
    let brightness = |point: &TrackPoint| point.brightness.as_ref().map_or(f64::INFINITY, |light| light.magnitude.0);
    let peak = lit
        .iter()
        .filter_map(|&(from_s, until_s)| {
            let steps = ((until_s - from_s) / LIGHT_STEP_S).ceil().clamp(8.0, MOST_LIGHT_STEPS) as usize;
            evaluator.peak_in_steps(from_s, until_s, steps)
        })
        .min_by(|a, b| brightness(a).total_cmp(&brightness(b)));
    Some(Visibility { begin: evaluator.point(seen.first()?.0)?, highest, end: evaluator.point(seen.last()?.1)?, peak })
}

/// Intervals between two times, seconds, in which a condition holds: tested in even steps, the borders bisected to a
/// millisecond and inside.
pub fn intervals_where(begin_s: f64, end_s: f64, steps: usize, holds: impl Fn(f64) -> bool) -> Vec<(f64, f64)> {
    let time_s = |step: usize| begin_s + (end_s - begin_s) * step as f64 / steps as f64;
    let border = |mut in_s: f64, mut out_s: f64| {
        while (in_s - out_s).abs() > BORDER_S {
            let middle_s = 0.5 * (in_s + out_s);
            if holds(middle_s) { in_s = middle_s } else { out_s = middle_s }
        }
        in_s
    };
    let mut found = Vec::new();
    let mut began = holds(begin_s).then_some(begin_s);
    for step in 1..=steps {
        let (before_s, now_s) = (time_s(step - 1), time_s(step));
        match (began, holds(now_s)) {
            (None, true) => began = Some(border(now_s, before_s)),
            (Some(from_s), false) => {
                found.push((from_s, border(before_s, now_s)));
                began = None;
            }
            _ => {}
        }
    }
    found.extend(began.map(|from_s| (from_s, end_s)));
    found
}

/// Intersection of two lists of intervals.
fn both(one: &[(f64, f64)], other: &[(f64, f64)]) -> Vec<(f64, f64)> {
    one.iter()
        .flat_map(|a| other.iter().map(move |b| (a.0.max(b.0), a.1.min(b.1))))
        .filter(|(from_s, until_s)| until_s > from_s)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_closed_and_intersected() {
        let found = intervals_where(0.0, 100.0, 10, |time_s| (12.0..37.5).contains(&time_s) || time_s > 80.25);
        assert_eq!(found.len(), 2);
        for ((from_s, until_s), (first_s, last_s)) in found.iter().zip([(12.0, 37.5), (80.25, 100.0)]) {
            assert!(
                (from_s - first_s).abs() < 2.0 * BORDER_S && (until_s - last_s).abs() < 2.0 * BORDER_S,
                "{found:?}"
            );
        }
        assert_eq!(both(&[(0.0, 5.0), (8.0, 9.0)], &[(4.0, 8.5)]), [(4.0, 5.0), (8.0, 8.5)]);
        assert!(both(&[(0.0, 5.0)], &[(5.0, 6.0)]).is_empty());
    }
}

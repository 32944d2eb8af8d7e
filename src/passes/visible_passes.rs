//! Visible passes: satellites above a site's horizon, at night and in sunlight, with shadow entry and exit and
//! brightest point.
//!
//! The samples of an interval above the horizon show whether all of it lies in daylight or in the Earth's shadow; such
//! intervals are excluded. In the others, the ends of the sunlit intervals are computed to a millisecond, and the
//! brightest point is searched in steps of at most ten seconds and then refined.

use hifitime::Epoch;
use rayon::prelude::*;

use super::above_horizon::{AboveHorizon, HorizonSearch, Sample, Treatment};
use super::error::check_epoch;
use super::evaluator::{PassEvaluator, magnitude_of, times};
use super::intervals::intervals_where;
use super::scene::Scene;
use super::sky::Sky;
use super::track::{ObserverMotion, SightLine, TrackPoint};
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::{Illumination, Observer};
use crate::orbit::{LeftOut, OrbitArc, PositionSource};
use crate::photometry::{Brightness, MagnitudeSource, PhotometryOptions, twilight_limit_mag};

/// Time by which the search extends before and after the night, seconds, for passes that began before it or end after
/// it. Low satellites rise and set within this time.
const TWILIGHT_REACH_S: f64 = 1800.0;
/// Step in the first search for shadow and brightness, seconds, and the largest number of steps.
const LIGHT_STEP_S: f64 = 10.0;
const MOST_LIGHT_STEPS: f64 = 360.0;
/// Smallest number of satellites per thread.
const TOGETHER: usize = 8;

/// Request for visible passes.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleRequest {
    /// Start of the search.
    pub start: Epoch,
    /// End of the search.
    pub end: Epoch,
    /// Intervals between start and end in which the site is dark, in order of time.
    pub dark: Vec<(Epoch, Epoch)>,
    /// Altitude that defines rise and set, radians.
    pub min_altitude_rad: f64,
    /// Lowest altitude of the culmination, radians.
    pub min_culmination_rad: f64,
    /// Selection by brightness; `None` for passes of any brightness.
    pub limit: Option<BrightnessLimit>,
    /// If true, passes in the Earth's shadow and in daylight are included.
    pub include_dark: bool,
    /// Number of points from rise to set, evenly spaced in time; 0 for none.
    pub samples: usize,
    /// Band, magnitude system and extinction.
    pub photometry: PhotometryOptions,
}

/// Selection of passes by the probability of being brighter than a limit.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BrightnessLimit {
    /// Magnitude limit by night.
    pub magnitude: f64,
    /// Smallest probability of being brighter than the limit, [0, 1]. Passes with a smaller one are excluded; with 0,
    /// none is.
    pub min_probability: f64,
    /// If true, the limit in twilight is that of the same eye or instrument in a brighter sky.
    pub twilight: bool,
}

/// Part of a pass in which the satellite is visible.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Visibility {
    /// Start of the visible part: the rise, the exit from the geometric shadow, nightfall, or the start of the search.
    /// If all of the pass by night is in the geometric shadow, the part of it with light from the atmosphere is
    /// visible.
    ///
    /// The geometric shadow is that of the solid Earth; it begins with its penumbra. Behind the atmosphere, a tenth of
    /// the light remains there for a satellite at 420 km.
    pub begin: TrackPoint,
    /// Highest point of the visible part.
    pub highest: TrackPoint,
    /// End of the visible part: the set, the entry into the geometric shadow (or the end of the penumbra, as for
    /// `begin`), dawn, or the end of the search.
    pub end: TrackPoint,
    /// Brightest point of the visible part; `None` if the model gives no light.
    pub peak: Option<TrackPoint>,
}

/// Pass of one satellite above a site's horizon.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VisiblePass {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Index of its element set in the catalogue of the sky.
    pub element_index: usize,
    /// Point at which the satellite rises above the lowest altitude; `None` if it was already above this altitude when
    /// the search began: half an hour before the night, or, with `include_dark`, at the start of the request.
    pub rise: Option<TrackPoint>,
    /// Highest point of the pass.
    pub culmination: TrackPoint,
    /// Point at which the satellite sets below the lowest altitude; `None` if it is still above this altitude when the
    /// search ends.
    pub set: Option<TrackPoint>,
    /// First point at which light is missing when the satellite enters the Earth's shadow; `None` if it does not. The
    /// visible part ends later, after the satellite has faded.
    pub shadow_entry: Option<TrackPoint>,
    /// Point at which the satellite is first in full sunlight again; `None` if it does not leave the shadow.
    pub shadow_exit: Option<TrackPoint>,
    /// Visible part; `None` if no part is visible.
    pub visible: Option<Visibility>,
    /// Source of the positions.
    pub position_source: PositionSource,
    /// Time from the epoch of the elements to the culmination, days.
    pub element_age_days: f64,
    /// One sigma of the times of the pass, seconds: the error along the track at the age of the elements.
    pub along_track_sigma_s: f64,
    /// Probability of being brighter than the limit at some point of the visible part, [0, 1]: the largest of its
    /// points. 0 without a visible part or without light; `None` without a limit.
    pub p_brighter: Option<f64>,
    /// Points from rise to set; empty if [`VisibleRequest::samples`] is 0.
    pub samples: Vec<TrackPoint>,
}

impl VisiblePass {
    /// Returns the brightness at the brightest visible point; `None` without a visible part or without light.
    pub fn peak_brightness(&self) -> Option<&Brightness> {
        self.visible.as_ref()?.peak.as_ref()?.brightness.as_ref()
    }
}

/// Numbers of excluded passes by reason.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct NotShown {
    /// Passes that are above the lowest altitude while the site is dark, but are in the Earth's shadow during that
    /// time. Passes during which the site is never dark are not counted.
    pub in_shadow: usize,
    /// Passes with less than the minimum probability of being brighter than the limit.
    pub too_faint: usize,
    /// Passes in `too_faint` whose magnitude comes only from a prior, because the satellite's brightness is unknown.
    pub too_faint_by_prior: usize,
    /// Passes that are above the lowest altitude while the site is dark, but whose culmination is too low.
    pub too_low: usize,
}

/// Visible passes, and numbers of excluded passes.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct VisiblePasses {
    /// Passes in the order in which they become visible; a pass that is not visible is ordered by its culmination.
    pub passes: Vec<VisiblePass>,
    /// Numbers of excluded passes.
    pub not_shown: NotShown,
    /// Number of satellites searched.
    pub satellites: usize,
    /// Expected number of visible passes that are brighter than the limit: the sum of [`VisiblePass::p_brighter`],
    /// including that of passes excluded as too faint. `None` without a limit.
    pub expected_brighter: Option<f64>,
    /// Satellites without a position at some time of the search.
    pub left_out: Vec<LeftOut>,
}

impl VisiblePasses {
    /// Returns true if a pass was found, whether or not it is shown.
    pub fn has_passes(&self) -> bool {
        let NotShown { in_shadow, too_faint, too_low, .. } = self.not_shown;
        !self.passes.is_empty() || in_shadow + too_faint + too_low > 0
    }
}

/// Result of evaluating one pass.
enum Outcome {
    Pass(Box<VisiblePass>),
    InShadow,
    TooFaint { by_prior: bool, p_brighter: f64 },
    TooLow,
}

/// A search interval and the dark intervals within it, in seconds after the start of the scene.
struct Span {
    from_s: f64,
    until_s: f64,
    dark_s: Vec<(f64, f64)>,
}

impl Sky {
    /// Finds all visible passes over the site on all threads. Only satellites whose element index `is_selected` accepts
    /// are searched.
    ///
    /// Altitudes are geometric, without refraction. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// A time is outside the years of the Sun's ephemeris, or the observer is in orbit.
    pub fn visible_passes(
        &self,
        request: &VisibleRequest,
        is_selected: &(dyn Fn(usize) -> bool + Sync),
    ) -> Result<VisiblePasses, Error> {
        check_epoch(request.start)?;
        check_epoch(request.end)?;
        let observer = self.site_observer()?;
        let scene_start = seconds_after(request.start, -TWILIGHT_REACH_S);
        let span_s = seconds_between(request.start, request.end).max(0.0) + 2.0 * TWILIGHT_REACH_S;
        let scene = self.scene_without_windows(scene_start, span_s);
        let spans = spans(request, scene_start);
        let search = Search { sky: self, scene: &scene, observer, request };
        let selected: Vec<usize> =
            (0..self.index().len()).filter(|&element_index| is_selected(element_index)).collect();
        let of_one = |&element_index: &usize| {
            // Passes that were found before SGP4 fails are kept.
            let mut kept = Vec::new();
            let mut failed = None;
            for span in &spans {
                self.watch().check()?;
                if let Err(reason) = search.passes(element_index, span, &mut kept) {
                    failed = Some(self.failed(element_index, reason));
                    break;
                }
            }
            Ok((kept, failed))
        };
        let all = selected.par_iter().with_min_len(TOGETHER).map(of_one).collect::<Result<Vec<_>, Error>>()?;
        let mut visible = VisiblePasses {
            satellites: selected.len(),
            expected_brighter: request.limit.map(|_| 0.0),
            ..VisiblePasses::default()
        };
        visible
            .left_out
            .extend(self.left_out().iter().filter(|satellite| is_selected(satellite.element_index)).cloned());
        for outcome in all.into_iter().flat_map(|(kept, failed)| {
            visible.left_out.extend(failed);
            kept
        }) {
            match outcome {
                Outcome::Pass(pass) => {
                    if let (Some(sum), Some(p_brighter)) = (visible.expected_brighter.as_mut(), pass.p_brighter) {
                        *sum += p_brighter;
                    }
                    visible.passes.push(*pass);
                }
                Outcome::InShadow => visible.not_shown.in_shadow += 1,
                Outcome::TooFaint { by_prior, p_brighter } => {
                    if let Some(sum) = visible.expected_brighter.as_mut() {
                        *sum += p_brighter;
                    }
                    visible.not_shown.too_faint += 1;
                    visible.not_shown.too_faint_by_prior += usize::from(by_prior);
                }
                Outcome::TooLow => visible.not_shown.too_low += 1,
            }
        }
        visible.left_out.sort_by_key(|satellite| satellite.element_index);
        let seen = |pass: &VisiblePass| pass.visible.as_ref().map_or(pass.culmination.epoch, |seen| seen.begin.epoch);
        visible.passes.sort_by(|a, b| seen(a).cmp(&seen(b)).then(a.element_index.cmp(&b.element_index)));
        Ok(visible)
    }
}

/// Returns one search interval for each dark interval, or one for the whole time if passes in daylight are included.
/// Overlapping intervals are joined.
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

/// Time before the decay of a satellite without passes, seconds: tracks need the positions around each time.
const DECAY_MARGIN_S: f64 = 10.0;

struct Search<'a> {
    sky: &'a Sky,
    scene: &'a Scene,
    observer: &'a Observer,
    request: &'a VisibleRequest,
}

impl Search<'_> {
    fn passes(&self, element_index: usize, span: &Span, kept: &mut Vec<Outcome>) -> Result<(), Error> {
        let ends = [span.from_s, span.until_s].map(|time_s| seconds_after(self.scene.start, time_s));
        let Some(propagator) = self.sky.index().propagator_over(element_index, ends) else { return Ok(()) };
        let middle = seconds_after(ends[0], 0.5 * seconds_between(ends[0], ends[1]));
        if let Some(reason) = self.sky.unknown_position(element_index, propagator, middle) {
            return Err(reason);
        }
        let minutes = propagator.minutes_since_epoch(self.scene.start);
        let horizon = HorizonSearch { scene: self.scene, propagator, minutes, observer: self.observer };
        // The shadow is convex: a satellite that is dark at its rise and at its set is dark in between, and a satellite
        // that stays up for hours is lit at some sample. For a satellite that rises or sets near dusk or dawn, the
        // samples do not suffice to decide whether it is above the horizon while the site is dark.
        let treatment = |samples: &[Sample]| {
            let (first_s, last_s) = (samples[0].time_s, samples[samples.len() - 1].time_s);
            let is_in_umbra = |sample: &Sample| {
                let sun = self.scene.sun.at_s(sample.time_s).sun;
                !self.sky.shadow().illumination(&sample.state.position, &sun).is_lit()
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
        // Passes before the decay of the satellite are kept.
        let decay_s = propagator.decayed().map(|decayed| seconds_between(self.scene.start, decayed) - DECAY_MARGIN_S);
        let decay_s = decay_s.filter(|decay_s| (span.from_s..span.until_s).contains(decay_s));
        let until_s = decay_s.unwrap_or(span.until_s);
        let (intervals, in_shadow) =
            horizon.intervals((span.from_s, until_s), self.request.min_altitude_rad, &treatment)?;
        kept.extend((0..in_shadow).map(|_| Outcome::InShadow));
        for above in intervals {
            let span = Span { from_s: span.from_s, until_s, dark_s: span.dark_s.clone() };
            kept.extend(self.pass(element_index, &horizon, &span, &above)?);
        }
        match decay_s {
            // The error of the decay.
            Some(_) => propagator.teme_state_at_minutes(minutes + span.until_s / 60.0).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Returns the motion of the site near a time.
    fn motion(&self, time_s: f64) -> ObserverMotion {
        let orientation = self.scene.orientation.at_s(time_s);
        let earth_velocity = self.scene.sun.at_s(time_s).earth_velocity;
        ObserverMotion::of_site(self.observer, &orientation, earth_velocity, time_s)
    }

    /// Evaluates one interval above the horizon. `None` if the site is never dark during the interval (unless
    /// `include_dark` is true), or if observer and satellite coincide.
    fn pass(
        &self,
        element_index: usize,
        horizon: &HorizonSearch<'_>,
        span: &Span,
        above: &AboveHorizon,
    ) -> Result<Option<Outcome>, Error> {
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
            uncertainty: self.sky.uncertainty_of(element_index, horizon.propagator, culminates),
        };
        if self
            .altitude_rad(&line, above.top_s)
            .is_some_and(|altitude_rad| altitude_rad < self.request.min_culmination_rad)
        {
            return Ok(Some(Outcome::TooLow));
        }
        let steps = light_steps(end_s - begin_s, 4.0);
        let bright = intervals_where(begin_s, end_s, steps, |time_s| evaluator.is_outside_geometric_shadow(time_s));
        let mut seen_s = both(&bright, &span.dark_s);
        if seen_s.is_empty() {
            let lit = intervals_where(begin_s, end_s, steps, |time_s| evaluator.illumination(time_s).is_lit());
            seen_s = both(&lit, &span.dark_s);
        }
        if seen_s.is_empty() && !self.request.include_dark {
            return Ok(Some(Outcome::InShadow));
        }
        // Most passes are too faint, so that their other points are not computed.
        let (peak, p_brighter) = self.peak(&evaluator, &seen_s);
        if let (Some(limit), Some(p_brighter)) = (self.request.limit, p_brighter)
            && p_brighter < limit.min_probability
        {
            let has_light = peak.as_ref().is_some_and(|peak| peak.brightness.is_some());
            let by_prior = has_light && *self.sky.model(element_index).source() == MagnitudeSource::Prior;
            return Ok(Some(Outcome::TooFaint { by_prior, p_brighter }));
        }
        let Some(culmination) = evaluator.point(above.top_s) else { return Ok(None) };
        let visible = if seen_s.is_empty() { None } else { visibility(&evaluator, &seen_s, above.top_s, peak) };
        let point = |time_s: Option<f64>| time_s.and_then(|time_s| evaluator.point(time_s));
        // First end, and first beginning, of full sunlight within the pass.
        let is_full = |time_s: f64| evaluator.illumination(time_s) == Illumination::Sunlit;
        let full = intervals_where(begin_s, end_s, steps, is_full);
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
            position_source: horizon.propagator.position_source(),
            element_age_days: self.sky.element_age_days(element_index, culminates),
            along_track_sigma_s: evaluator.uncertainty.along_track_s,
            p_brighter,
            samples: evaluator.samples(begin_s, end_s, self.request.samples),
            culmination,
        }))))
    }

    /// Returns the altitude of the satellite at a time, radians, without its brightness.
    fn altitude_rad(&self, line: &SightLine<'_>, time_s: f64) -> Option<f64> {
        let here = self.observer.state(&self.scene.orientation.at_s(time_s));
        Some(here.altitude_azimuth_rad(&line.aspect_at(time_s).2.geometric)?.0)
    }

    /// Returns the brightest point in the intervals `seen_s`, and the largest probability of being brighter than the
    /// limit in them. Away from the brightest point the probability can be larger than there: the limit is brighter in
    /// twilight, and the distribution of magnitudes is wider outside the fitted geometry.
    fn peak(&self, evaluator: &PassEvaluator<'_>, seen_s: &[(f64, f64)]) -> (Option<TrackPoint>, Option<f64>) {
        let limit_mag = |limit: &BrightnessLimit, time_s: f64| {
            if !limit.twilight {
                return limit.magnitude;
            }
            let sun_rad = self.observer.sun_altitude_rad(&self.scene.orientation, &self.scene.sun, time_s);
            twilight_limit_mag(limit.magnitude, sun_rad)
        };
        let probability = |time_s: f64, light: &Brightness| {
            let limit = self.request.limit.as_ref()?;
            Some(light.probability_brighter_than(limit_mag(limit, time_s)))
        };
        let (mut peak, mut best): (Option<TrackPoint>, Option<(f64, f64)>) = (None, None);
        for &(from_s, until_s) in seen_s {
            let mut magnitudes = Vec::new();
            for time_s in times(from_s, until_s, light_steps(until_s - from_s, 8.0)) {
                let light = evaluator.brightness(time_s);
                magnitudes.push((time_s, magnitude_of(light.as_ref())));
                // The sigma includes the error of the position only in the second evaluation, at the best point.
                let rough = light.and_then(|light| probability(time_s, &light));
                if rough.is_some_and(|rough| best.is_none_or(|(_, best)| rough >= best)) {
                    best = rough.map(|rough| (time_s, rough));
                }
            }
            let brightest = evaluator.peak_near(&magnitudes);
            let magnitude = |point: &TrackPoint| magnitude_of(point.brightness.as_ref());
            peak = match (peak, brightest) {
                (Some(before), Some(now)) if magnitude(&now) < magnitude(&before) => Some(now),
                (before, now) => before.or(now),
            };
        }
        let at_best = best.and_then(|(time_s, _)| probability(time_s, evaluator.point(time_s)?.brightness.as_ref()?));
        let at_peak = peak
            .as_ref()
            .and_then(|peak| probability(seconds_between(self.scene.start, peak.epoch), peak.brightness.as_ref()?));
        let largest = at_best.into_iter().chain(at_peak).fold(0.0, f64::max);
        (peak, self.request.limit.map(|_| largest))
    }
}

/// Returns the number of steps of a search for brightness over a time.
fn light_steps(span_s: f64, fewest: f64) -> usize {
    (span_s / LIGHT_STEP_S).ceil().clamp(fewest, MOST_LIGHT_STEPS) as usize
}

/// Returns the visible part, from the start of the first to the end of the last interval of `seen`.
fn visibility(
    evaluator: &PassEvaluator<'_>,
    seen: &[(f64, f64)],
    top_s: f64,
    peak: Option<TrackPoint>,
) -> Option<Visibility> {
    let ends = seen.iter().flat_map(|&(from_s, until_s)| [from_s, until_s]);
    let top = seen.iter().any(|&(from_s, until_s)| (from_s..=until_s).contains(&top_s)).then_some(top_s);
    let highest = ends
        .chain(top)
        .filter_map(|time_s| evaluator.point(time_s))
        .max_by(|a, b| a.altitude_rad.partial_cmp(&b.altitude_rad).unwrap_or(std::cmp::Ordering::Equal))?;
    Some(Visibility { begin: evaluator.point(seen.first()?.0)?, highest, end: evaluator.point(seen.last()?.1)?, peak })
}

/// Returns the intersection of two lists of intervals.
fn both(first: &[(f64, f64)], other: &[(f64, f64)]) -> Vec<(f64, f64)> {
    first
        .iter()
        .flat_map(|a| other.iter().map(move |b| (a.0.max(b.0), a.1.min(b.1))))
        .filter(|(from_s, until_s)| until_s > from_s)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_intersected() {
        assert_eq!(both(&[(0.0, 5.0), (8.0, 9.0)], &[(4.0, 8.5)]), [(4.0, 5.0), (8.0, 8.5)]);
        assert!(both(&[(0.0, 5.0)], &[(5.0, 6.0)]).is_empty());
    }
}

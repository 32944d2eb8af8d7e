//! Passes that can be seen: above a site's horizon by night and in sunlight, with the Earth's shadow and the brightest moment.
//!
//! Stretches above the horizon come from the same search as [`HorizonPass`](super::HorizonPass). Of these, the ones by daylight and those in the
//! shadow all along cost a look at their samples; the others are interpolated, the borders of light closed to a millisecond, and the brightest moment is
//! looked for in steps of at most ten seconds and closed in on.

use hifitime::Epoch;

use super::horizon::{Follow, Sample, Stretch, Worth};
use super::look::Look;
use super::scene::Scene;
use super::sightline::{ObserverMotion, SightLine};
use super::sky::{PassOptions, Sky, SkyError};
use super::track::TrackPoint;
use crate::constants::DAY_S;
use crate::elements::NoradId;
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::{Illumination, Observer};
use crate::orbit::{Arc, LeftOut, OrbitError};
use crate::photometry::{MagnitudeSource, PhotometryOptions};

/// A pass that began before the night is followed back this far, and one that ends after it as far ahead, seconds: low satellites rise and set in it.
const TWILIGHT_REACH_S: f64 = 1800.0;
/// Shadow and light are first looked for in steps of this, seconds, and in no more steps than this.
const LIGHT_STEP_S: f64 = 10.0;
const MOST_LIGHT_STEPS: f64 = 360.0;
/// Borders of light are closed to this, seconds.
const BORDER_S: f64 = 1e-3;

/// Which passes are wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleRequest {
    /// First moment.
    pub start: Epoch,
    /// Last moment.
    pub end: Epoch,
    /// When the site is dark, in order of time, within the two.
    pub dark: Vec<(Epoch, Epoch)>,
    /// What counts as rise and set, radians.
    pub min_altitude_rad: f64,
    /// Passes that culminate lower are left out, radians.
    pub min_culmination_rad: f64,
    /// Passes whose peak is fainter are left out, those without a magnitude too.
    pub max_magnitude: Option<f64>,
    /// Passes in the Earth's shadow and by daylight too.
    pub include_dark: bool,
    /// Points from rise to set, evenly spaced in time; 0 for none.
    pub samples: usize,
    /// Band, system, extinction.
    pub photometry: PhotometryOptions,
}

/// The part of a pass that can be seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// Where it begins: at the rise, out of the shadow (full sunlight) or at nightfall.
    pub begin: TrackPoint,
    /// The highest point of it.
    pub highest: TrackPoint,
    /// Where it ends: at the set, where the light begins to fade into the shadow, or at dawn.
    pub end: TrackPoint,
    /// The brightest point of it, half shadow included; `None` where the model sees nothing.
    pub peak: Option<TrackPoint>,
}

/// One pass of one satellite above a site's horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct VisiblePass {
    /// Who.
    pub norad_id: NoradId,
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Where it reaches the altitude wanted; `None` where it was up when the search began, half an hour before the night.
    pub rise: Option<TrackPoint>,
    /// The highest point of the pass.
    pub culmination: TrackPoint,
    /// Where it falls below the altitude wanted; `None` where it is still up when the search ends.
    pub set: Option<TrackPoint>,
    /// Where the light first begins to fade into the Earth's shadow.
    pub shadow_entry: Option<TrackPoint>,
    /// Where it first comes back in full.
    pub shadow_exit: Option<TrackPoint>,
    /// What of it can be seen; `None` where nothing is.
    pub visible: Option<Visibility>,
    /// Culmination less element epoch, days.
    pub element_age_days: f64,
    /// Points from rise to set, where samples were asked for.
    pub samples: Vec<TrackPoint>,
}

/// Passes that were found and are not shown.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct NotShown {
    /// Above the altitude wanted while the site is dark, and in the Earth's shadow at all such moments. Passes that end before it gets dark or begin
    /// after are not counted.
    pub in_shadow: usize,
    /// Fainter than the limit, or without any magnitude.
    pub too_faint: usize,
    /// Of these, how many are so by a prior alone: nothing is known of the satellite's brightness.
    pub too_faint_by_prior: usize,
    /// Above the altitude wanted while the site is dark, and culminating too low.
    pub too_low: usize,
}

/// The answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisiblePasses {
    /// In order of the time at which they can first be seen (that of culmination where they cannot).
    pub passes: Vec<VisiblePass>,
    /// How many others there were.
    pub not_shown: NotShown,
    /// How many satellites were asked about.
    pub satellites: usize,
    /// Satellites without a position at some moment asked for.
    pub left_out: Vec<LeftOut>,
}

/// What becomes of one pass.
enum Kept {
    Pass(Box<VisiblePass>),
    InShadow,
    TooFaint { by_prior: bool },
    TooLow,
}

/// A search: where from, where to, and when it is dark in it; seconds of the scene.
struct Span {
    from_s: f64,
    until_s: f64,
    dark_s: Vec<(f64, f64)>,
}

impl Sky {
    /// Every pass that can be seen from the site, on all threads; `is_wanted` says by element index who is asked about.
    ///
    /// Altitudes are geometric, without refraction. The answer does not depend on the number of threads.
    ///
    /// # Errors
    /// [`SkyError::NoEphemeris`] outside the years of the Sun's ephemeris; [`SkyError::NoHorizon`] for an observer in orbit.
    pub fn visible_passes(
        &self,
        request: &VisibleRequest,
        is_wanted: &(dyn Fn(usize) -> bool + Sync),
    ) -> Result<VisiblePasses, SkyError> {
        super::sky::check_epoch(request.start)?;
        super::sky::check_epoch(request.end)?;
        let observer = self.site_observer()?;
        let scene_start = seconds_after(request.start, -TWILIGHT_REACH_S);
        let span_s = seconds_between(request.start, request.end).max(0.0) + 2.0 * TWILIGHT_REACH_S;
        let scene = self.scene_without_windows(scene_start, span_s);
        let spans = spans(request, scene_start);
        let options =
            PassOptions { samples: request.samples, photometry: request.photometry, ..PassOptions::default() };
        let search = Search { sky: self, scene: &scene, observer, request, options: &options };
        let (all, left_out) = self.survey(is_wanted, |element_index, _, kept| {
            spans.iter().try_for_each(|span| search.passes(element_index, span, kept))
        });
        let satellites = (0..self.index().len()).filter(|&one| is_wanted(one)).count();
        let mut answer = VisiblePasses { satellites, left_out, ..VisiblePasses::default() };
        for one in all {
            match one {
                Kept::Pass(pass) => answer.passes.push(*pass),
                Kept::InShadow => answer.not_shown.in_shadow += 1,
                Kept::TooFaint { by_prior } => {
                    answer.not_shown.too_faint += 1;
                    answer.not_shown.too_faint_by_prior += usize::from(by_prior);
                }
                Kept::TooLow => answer.not_shown.too_low += 1,
            }
        }
        let seen = |pass: &VisiblePass| pass.visible.as_ref().map_or(pass.culmination.epoch, |seen| seen.begin.epoch);
        answer.passes.sort_by(|a, b| seen(a).cmp(&seen(b)).then(a.element_index.cmp(&b.element_index)));
        Ok(answer)
    }
}

/// One search for each stretch of darkness, or one for all of the time; those that would meet are one.
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
    options: &'a PassOptions,
}

impl Search<'_> {
    fn passes(&self, element_index: usize, span: &Span, kept: &mut Vec<Kept>) -> Result<(), OrbitError> {
        let Some(propagator) = self.sky.index().propagator(element_index) else { return Ok(()) };
        let follow = Follow {
            sky: self.sky,
            scene: self.scene,
            propagator,
            minutes: propagator.minutes_since_epoch(self.scene.start),
            observer: self.observer,
            motion: self.motion(span.from_s),
        };
        // The shadow is convex: a satellite that is dark where it comes up and where it goes down is dark in between, and one that stays up for hours
        // shows its light at some sample. Whether one that comes up or goes down about dusk or dawn is up in the dark, its samples cannot tell.
        let worth = |samples: &[Sample]| {
            let (first_s, last_s) = (samples[0].time_s, samples[samples.len() - 1].time_s);
            let is_in_umbra = |sample: &Sample| {
                let sun = self.scene.sun.at_s(sample.time_s).sun;
                self.sky.shadow().illumination(&sample.state.position, &sun) == Illumination::Umbra
            };
            if self.request.include_dark {
                Worth::Following
            } else if !span.dark_s.iter().any(|&(from_s, until_s)| first_s < until_s && last_s > from_s) {
                Worth::Nothing
            } else if span.dark_s.iter().any(|&(from_s, until_s)| first_s >= from_s && last_s <= until_s)
                && samples.iter().all(is_in_umbra)
            {
                Worth::Counting
            } else {
                Worth::Following
            }
        };
        let (stretches, in_shadow) =
            follow.stretches((span.from_s, span.until_s), self.request.min_altitude_rad, &worth)?;
        kept.extend((0..in_shadow).map(|_| Kept::InShadow));
        for stretch in stretches {
            kept.extend(self.look_at(element_index, &follow, span, &stretch)?);
        }
        Ok(())
    }

    /// The site near a moment.
    fn motion(&self, time_s: f64) -> ObserverMotion {
        let orientation = self.scene.orientation.at_s(time_s);
        let earth_velocity = self.scene.sun.at_s(time_s).earth_velocity;
        ObserverMotion::of_site(self.observer, &orientation, earth_velocity, time_s)
    }

    /// One stretch above the horizon; `None` where it ends before the dark or begins after, and where observer and satellite coincide.
    fn look_at(
        &self,
        element_index: usize,
        follow: &Follow<'_>,
        span: &Span,
        stretch: &Stretch,
    ) -> Result<Option<Kept>, OrbitError> {
        let (begin_s, end_s) = (stretch.rise_s.unwrap_or(span.from_s), stretch.set_s.unwrap_or(span.until_s));
        if !self.request.include_dark && both(&[(begin_s, end_s)], &span.dark_s).is_empty() {
            return Ok(None);
        }
        let orientation = self.scene.orientation.at_s(stretch.top_s);
        let arc = Arc::over_pass(
            follow.propagator,
            follow.minutes,
            begin_s - 1.0,
            end_s - begin_s + 2.0,
            &orientation.teme_to_gcrs,
            stretch.turning_rad_s,
        )?;
        let line = SightLine { arc: &arc, observer: self.motion(stretch.top_s) };
        let look = Look {
            scene: self.scene,
            viewpoint: self.sky.viewpoint(),
            shadow: self.sky.shadow(),
            line: &line,
            model: self.sky.model(element_index),
            options: self.options,
            uncertainty: follow.uncertainty(element_index, stretch.top_s),
        };
        let Some(culmination) = look.point(stretch.top_s) else { return Ok(None) };
        if culmination.altitude_rad.is_some_and(|altitude_rad| altitude_rad < self.request.min_culmination_rad) {
            return Ok(Some(Kept::TooLow));
        }
        let steps = ((end_s - begin_s) / LIGHT_STEP_S).ceil().clamp(4.0, MOST_LIGHT_STEPS) as usize;
        let full = stretches_where(begin_s, end_s, steps, |time_s| look.illumination(time_s) == Illumination::Sunlit);
        let lit = stretches_where(begin_s, end_s, steps, |time_s| look.illumination(time_s) != Illumination::Umbra);
        let lit_by_night = both(&lit, &span.dark_s);
        let visible = if lit_by_night.is_empty() {
            None
        } else {
            let full_by_night = both(&full, &span.dark_s);
            let seen = if full_by_night.is_empty() { &lit_by_night } else { &full_by_night };
            visibility(&look, seen, &lit_by_night, stretch.top_s)
        };
        let magnitude =
            visible.as_ref().and_then(|seen| seen.peak.as_ref()?.brightness.as_ref()).map(|light| light.magnitude.0);
        if visible.is_none() && !self.request.include_dark {
            return Ok(Some(Kept::InShadow));
        }
        if self.request.max_magnitude.is_some_and(|limit| magnitude.is_none_or(|magnitude| magnitude > limit)) {
            let by_prior = magnitude.is_some() && *self.sky.model(element_index).source() == MagnitudeSource::Prior;
            return Ok(Some(Kept::TooFaint { by_prior }));
        }
        let point = |time_s: Option<f64>| time_s.and_then(|time_s| look.point(time_s));
        // Where full light ends within the pass, and where it begins.
        let entry_s = full.iter().map(|stretch| stretch.1).find(|&time_s| time_s < end_s);
        let exit_s = full.iter().map(|stretch| stretch.0).find(|&time_s| time_s > begin_s);
        let moment = seconds_after(self.scene.start, stretch.top_s);
        Ok(Some(Kept::Pass(Box::new(VisiblePass {
            norad_id: follow.propagator.norad_id(),
            element_index,
            rise: point(stretch.rise_s),
            set: point(stretch.set_s),
            shadow_entry: point(entry_s),
            shadow_exit: point(exit_s),
            visible,
            element_age_days: seconds_between(follow.propagator.epoch(), moment) / DAY_S,
            samples: look.samples(begin_s, end_s, self.options.samples),
            culmination,
        }))))
    }
}

/// What can be seen in stretches of full light, and where it is brightest in all light.
fn visibility(look: &Look<'_>, seen: &[(f64, f64)], lit: &[(f64, f64)], top_s: f64) -> Option<Visibility> {
    let ends = seen.iter().flat_map(|&(from_s, until_s)| [from_s, until_s]);
    let top = seen.iter().any(|&(from_s, until_s)| (from_s..=until_s).contains(&top_s)).then_some(top_s);
    let highest = ends
        .chain(top)
        .filter_map(|time_s| look.point(time_s))
        .max_by(|a, b| a.altitude_rad.partial_cmp(&b.altitude_rad).unwrap_or(std::cmp::Ordering::Equal))?;
    let brightness = |point: &TrackPoint| point.brightness.as_ref().map_or(f64::INFINITY, |light| light.magnitude.0);
    let peak = lit
        .iter()
        .filter_map(|&(from_s, until_s)| {
            let steps = ((until_s - from_s) / LIGHT_STEP_S).ceil().clamp(8.0, MOST_LIGHT_STEPS) as usize;
            look.peak_in_steps(from_s, until_s, steps)
        })
        .min_by(|a, b| brightness(a).total_cmp(&brightness(b)));
    Some(Visibility { begin: look.point(seen.first()?.0)?, highest, end: look.point(seen.last()?.1)?, peak })
}

/// From when to when something holds between two times, seconds: looked at in even steps, the borders halved to a millisecond and inside.
pub fn stretches_where(begin_s: f64, end_s: f64, steps: usize, holds: impl Fn(f64) -> bool) -> Vec<(f64, f64)> {
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

/// What two lists of stretches have in common.
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
    fn stretches_are_closed_and_met() {
        let found = stretches_where(0.0, 100.0, 10, |time_s| (12.0..37.5).contains(&time_s) || time_s > 80.25);
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

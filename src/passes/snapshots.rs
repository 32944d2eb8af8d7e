//! All satellites above a site, sampled at given times.

use hifitime::Epoch;
use rayon::prelude::*;

use super::candidates::CandidateInterval;
use super::error::check_epoch;
use super::evaluator::PassEvaluator;
use super::exposure::Exposure;
use super::field::Field;
use super::scene::Scene;
use super::sky::Sky;
use super::track::{SightLine, TrackPoint};
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{Direction, seconds_after};
use crate::geometry::{ObserverState, ViewingGeometry};
use crate::orbit::{LeftOut, OrbitArc, SearchScope};
use crate::photometry::{Brightness, PhotometryOptions};

/// Largest time after the start, seconds. It limits the motion of the site during the search.
const LONGEST_S: f64 = 3600.0;
/// Largest number of times in one query.
const MOST_TIMES: usize = 10_000;
/// Standard deviation of the delay, seconds, up to which a satellite is on time.
const ON_TIME_S: f64 = 1.0;
/// Fractions of its multiples are evenly spaced: the delays of consecutive times lie between one another.
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
/// Smallest number of satellites per thread.
const TOGETHER: usize = 16;

/// Positions of a satellite in a query for snapshots. It is seen at a position above the lowest altitude if it is lit
/// there, or if `include_dark` is true.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SnapshotPositions {
    /// The predicted positions at which it is seen.
    Predicted,
    /// The predicted positions at all times, if it is seen at one of them.
    WholeTrack,
    /// The positions at which it may be seen, with probabilities: if the error of its time is more than a second,
    /// several positions along its track for each time, which differ from time to time.
    Possible,
}

/// Options of a query for snapshots.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SnapshotOptions {
    /// Lowest altitude, geometric, radians, 0 to π/2.
    pub min_altitude_rad: f64,
    /// If true, satellites in the umbra are included.
    pub include_dark: bool,
    /// Positions of each satellite.
    pub positions: SnapshotPositions,
    /// Band, magnitude system and extinction. `None` omits the brightness of all points, which is several times faster.
    pub photometry: Option<PhotometryOptions>,
}

impl SnapshotOptions {
    /// Returns options for all satellites above an altitude (radians), lit or not, without brightness.
    pub fn all_above(min_altitude_rad: f64) -> Self {
        Self { min_altitude_rad, include_dark: true, positions: SnapshotPositions::Predicted, photometry: None }
    }
}

/// Track of one satellite above a site, as a list of snapshots.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SatelliteTrack {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Index of its element set in the catalogue of the sky.
    pub element_index: usize,
    /// Snapshots in order of time, at least one.
    pub snapshots: Vec<SatelliteSnapshot>,
}

/// Position and brightness of one satellite at one time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SatelliteSnapshot {
    /// Index of the time in the query.
    pub time_index: usize,
    /// Probability of the position; 1 for predicted positions.
    pub probability: f64,
    /// Position and brightness.
    pub point: TrackPoint,
    /// Angular speed relative to the stars, rad/s.
    pub angular_rate_rad_s: f64,
}

impl SatelliteTrack {
    /// Returns the snapshot in the middle of the list.
    pub fn middle(&self) -> Option<&SatelliteSnapshot> {
        self.snapshots.get(self.snapshots.len() / 2)
    }
}

impl SatelliteSnapshot {
    /// Returns true if any part of the Sun illuminates the satellite.
    pub fn is_lit(&self) -> bool {
        self.point.illumination.is_lit()
    }
}

/// State of the site at one of the times of a query.
struct SiteAt {
    time_s: f64,
    here: ObserverState,
}

/// Possible position of a satellite at one of the times of a query.
struct PossibleAt {
    time_index: usize,
    late_s: f64,
    probability: f64,
}

impl Sky {
    /// Finds all satellites that are above an altitude at any of the times `times_s` (seconds after `start`, from 0 to
    /// an hour, in increasing order), on all threads. Returns their tracks in catalogue order, and the satellites
    /// without a position.
    ///
    /// # Errors
    /// A time is outside the years of the Sun's ephemeris; the observer is in orbit; an altitude is below 0 or above
    /// π/2; times are out of order or later than an hour; there are no times, or more than ten thousand.
    pub fn snapshots(
        &self,
        start: Epoch,
        times_s: &[f64],
        options: &SnapshotOptions,
    ) -> Result<(Vec<SatelliteTrack>, Vec<LeftOut>), Error> {
        check(times_s, options)?;
        check_epoch(start)?;
        let observer = self.site_observer()?;
        let (Some(&first_s), Some(&last_s)) = (times_s.first(), times_s.last()) else {
            return Ok((Vec::new(), Vec::new()));
        };
        let scope = match options.positions {
            SnapshotPositions::Possible => SearchScope::Delayed,
            SnapshotPositions::Predicted | SnapshotPositions::WholeTrack => SearchScope::Nominal,
        };
        let scene = self.scene(start, last_s, scope)?;
        let site_at = |&time_s: &f64| SiteAt { time_s, here: observer.state(&scene.orientation.at_s(time_s)) };
        let times: Vec<SiteAt> = times_s.iter().map(site_at).collect();
        // The sky above the altitude is searched as one circular field around the zenith at the middle time. Its radius
        // includes the motion of the zenith.
        let half_s = 0.5 * (last_s - first_s);
        let to_gcrs = observer.state(&scene.orientation.at_s(first_s + half_s)).horizon.inverse();
        let zenith = to_gcrs * Direction::from_lon_lat_rad(0.0, std::f64::consts::FRAC_PI_2);
        let reach_rad = std::f64::consts::FRAC_PI_2 - options.min_altitude_rad + EARTH_ROTATION_RAD_S * half_s;
        let exposure = Exposure {
            id: "sky".to_owned(),
            start: seconds_after(start, first_s),
            duration_s: last_s - first_s,
            pointing: zenith,
            rotation_rad: 0.0,
        };
        let field = Field::circle((2.0 * reach_rad).clamp(1e-3, std::f64::consts::PI))?;
        let on_sky = field.on_sky(&exposure.pointing, 0.0);
        let candidates =
            self.candidate_intervals(&scene, &exposure, &on_sky, None, options.include_dark, &mut Vec::new())?;
        let found = candidates
            .par_iter()
            .with_min_len(TOGETHER)
            .map(|interval| {
                self.watch().check()?;
                let found = self.snapshots_of(&scene, &times, interval, options);
                Ok(found.map_err(|reason| self.failed(interval.element_index, reason)))
            })
            .collect::<Result<Vec<_>, Error>>()?;
        let of_windows = scene.windows.iter().flat_map(|window| window.left_out());
        let mut left_out: Vec<LeftOut> = self.left_out().iter().chain(of_windows).cloned().collect();
        let mut tracks = Vec::new();
        for result in found {
            match result {
                Ok(track) => tracks.extend(track),
                Err(failed) => left_out.push(failed),
            }
        }
        left_out.sort_by_key(|satellite| satellite.element_index);
        left_out.dedup_by_key(|satellite| satellite.element_index);
        Ok((tracks, left_out))
    }

    /// Returns the brightness of a satellite at a point. Its uncertainty is that of the brightness model, without the
    /// error of the elements. It is corrected by measurements of the same pass. If the model gives no light of a sunlit
    /// satellite, it is that of the prior for its orbit. `None` in the umbra, and if extinction is applied and the
    /// satellite is on or below the observer's horizon.
    pub fn brightness(
        &self,
        element_index: usize,
        point: &TrackPoint,
        photometry: &PhotometryOptions,
    ) -> Option<Brightness> {
        self.brightness_in(element_index, point.epoch, &point.geometry, point.illumination.lit_fraction(), photometry)
    }

    /// Returns the brightness as [`Self::brightness`] does, for a time, a viewing geometry and the fraction of the
    /// Sun's light that reaches the satellite. The time selects the pass whose measurements are used.
    pub fn brightness_in(
        &self,
        element_index: usize,
        epoch: Epoch,
        geometry: &ViewingGeometry,
        lit_fraction: f64,
        photometry: &PhotometryOptions,
    ) -> Option<Brightness> {
        let photometry = self.photometry_here(photometry);
        let prior = || self.priors.model(&self.elements()[element_index]);
        let light = self
            .model(element_index)
            .brightness(geometry, lit_fraction, &photometry)
            .or_else(|| prior().brightness(geometry, lit_fraction, &photometry))?;
        Some(if self.measured.is_empty() { light } else { self.measured.apply(element_index, epoch, geometry, light) })
    }

    /// Returns the apparent magnitude of a sunlit satellite of which only orbit and geometry are known: that of the
    /// prior for its orbit. `None` if extinction is applied and the satellite is on or below the observer's horizon.
    pub fn prior_brightness(
        &self,
        element_index: usize,
        geometry: &ViewingGeometry,
        photometry: &PhotometryOptions,
    ) -> Option<Brightness> {
        let prior = self.priors.model(&self.elements()[element_index]);
        prior.brightness(geometry, 1.0, &self.photometry_here(photometry))
    }

    /// Returns the options without extinction if the observer is a telescope in orbit.
    fn photometry_here(&self, photometry: &PhotometryOptions) -> PhotometryOptions {
        let extinction_mag_per_airmass =
            photometry.extinction_mag_per_airmass.filter(|_| self.viewpoint().site().is_some());
        PhotometryOptions { extinction_mag_per_airmass, ..*photometry }
    }

    fn snapshots_of(
        &self,
        scene: &Scene,
        times: &[SiteAt],
        interval: &CandidateInterval,
        options: &SnapshotOptions,
    ) -> Result<Option<SatelliteTrack>, Error> {
        let element_index = interval.element_index;
        let [from_s, to_s] = interval.near_s;
        let all_s = [times[0].time_s, times[times.len() - 1].time_s];
        let Some(propagator) = self.propagator_over(scene.start, element_index, all_s) else { return Ok(None) };
        let mid_s = 0.5 * (from_s + to_s);
        let orientation = scene.orientation.at_s(mid_s);
        let Some(observer) = self.motion(scene, &orientation, None, mid_s) else { return Ok(None) };
        let minutes = propagator.minutes_since_epoch(scene.start);
        let arc = |from_s: f64, to_s: f64| {
            OrbitArc::new(propagator, minutes, from_s, to_s - from_s, &orientation.teme_to_gcrs)
        };
        let uncertainty = self.uncertainty_of(element_index, propagator, seconds_after(scene.start, mid_s));
        let near_arc = arc(from_s, to_s)?;
        let near_line = SightLine { arc: &near_arc, observer };
        let lowest = options.min_altitude_rad.sin();
        let is_near = |place: &PossibleAt| (from_s..=to_s).contains(&(times[place.time_index].time_s - place.late_s));
        let is_seen = |place: &PossibleAt| {
            let SiteAt { time_s, here } = &times[place.time_index];
            let (state, _, aspect) = near_line.delayed_aspect(*time_s, place.late_s);
            let sun = || scene.sun.at_s(*time_s).sun;
            let is_lit = || self.shadow().illumination(&state.position, &sun()).is_lit();
            here.sine_of_altitude(&aspect.geometric) >= lowest && (options.include_dark || is_lit())
        };
        let predicted = |time_index| PossibleAt { time_index, late_s: 0.0, probability: 1.0 };
        let possible = |time_index: usize| {
            let delays = uncertainty.lateness.delays(ON_TIME_S, (time_index as f64 * GOLDEN_RATIO).fract());
            delays.map(move |(late_s, probability)| PossibleAt { time_index, late_s, probability })
        };
        let all = 0..times.len();
        let places: Vec<PossibleAt> = match options.positions {
            SnapshotPositions::Possible => all.flat_map(possible).collect(),
            SnapshotPositions::Predicted | SnapshotPositions::WholeTrack => all.map(predicted).collect(),
        };
        let mut seen = places.iter().filter(|place| is_near(place) && is_seen(place)).peekable();
        if seen.peek().is_none() {
            return Ok(None);
        }
        let points_on = |line: &SightLine<'_>, places: &mut dyn Iterator<Item = &PossibleAt>| {
            let photometry = options.photometry.as_ref();
            let evaluator = PassEvaluator { sky: self, scene, line, element_index, photometry, uncertainty };
            let snapshot = |&PossibleAt { time_index, late_s, probability }: &PossibleAt| {
                let SiteAt { time_s, here } = &times[time_index];
                let sight = line.delayed_sight(*time_s, late_s);
                Some(SatelliteSnapshot {
                    time_index,
                    probability,
                    point: evaluator.point_over(*time_s, late_s, Some(here))?,
                    // ω = |ŝ × dŝ/dt|
                    angular_rate_rad_s: sight.vector.cross(&sight.rate_s).norm(),
                })
            };
            places.filter_map(snapshot).collect::<Vec<_>>()
        };
        let snapshots = if options.positions == SnapshotPositions::WholeTrack {
            let whole = arc(all_s[0], all_s[1])?;
            let line = SightLine { arc: &whole, observer: near_line.observer.clone() };
            points_on(&line, &mut places.iter())
        } else {
            points_on(&near_line, &mut seen)
        };
        let track = SatelliteTrack { norad_id: propagator.norad_id(), element_index, snapshots };
        Ok((!track.snapshots.is_empty()).then_some(track))
    }
}

fn check(times_s: &[f64], options: &SnapshotOptions) -> Result<(), Error> {
    if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&options.min_altitude_rad) {
        let given_deg = options.min_altitude_rad.to_degrees();
        return Err(Error::invalid("lowest altitude", format!("{given_deg} deg"), "0 to 90 deg"));
    }
    let count = times_s.len();
    if !(1..=MOST_TIMES).contains(&count) {
        return Err(Error::invalid("number of times", count, format!("1 to {MOST_TIMES}")));
    }
    let in_order = times_s.windows(2).all(|pair| pair[0] < pair[1]);
    if let Some(bad_s) = times_s.iter().find(|time_s| !(0.0..=LONGEST_S).contains(*time_s)) {
        let allowed = format!("0 to {LONGEST_S} s after the start");
        return Err(Error::invalid("time", format!("{bad_s} s"), allowed));
    }
    if in_order { Ok(()) } else { Err(Error::invalid("order of the times", "not increasing", "increasing times")) }
}

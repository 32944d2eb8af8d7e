//! Ephemeris: positions, rates and brightness of selected satellites at given times.

use hifitime::Epoch;
use rayon::prelude::*;

use super::error;
use super::error::check_epoch;
use super::evaluator::PassEvaluator;
use super::exposure::Exposure;
use super::scene::Scene;
use super::sky::Sky;
use super::track::{ObserverMotion, SightLine, TrackPoint};
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{Direction, Horizontal, Orientation, seconds_after};
use crate::geometry::ObserverState;
use crate::orbit::{LeftOut, OrbitArc, OrbitUncertainty, PositionSource};
use crate::photometry::PhotometryOptions;

/// Half of the length of the arc that is propagated around each time, seconds.
const HALF_ARC_S: f64 = 1.0;
/// Half of the step of the central differences that give rates, seconds. The relative error of a rate is (ω h)²/6, with
/// this half step h and the angular speed ω; it is 10⁻⁷ at 0.5 deg/s.
const RATE_STEP_S: f64 = 0.1;
/// Largest number of points (satellites times times) in one request.
const MOST_POINTS: usize = 1_000_000;

/// Position, rates and brightness of one satellite at one time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EphemerisPoint {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Index of its element set in the catalogue of the sky.
    pub element_index: usize,
    /// Index of the time in the request.
    pub time_index: usize,
    /// Position and brightness.
    pub point: TrackPoint,
    /// Rate of the right ascension, times the cosine of the declination, rad/s.
    pub ra_cos_dec_rate_rad_s: f64,
    /// Rate of the declination, rad/s.
    pub dec_rate_rad_s: f64,
    /// Rate of the azimuth, times the cosine of the altitude, rad/s; `None` for an observer in orbit.
    pub azimuth_cos_altitude_rate_rad_s: Option<f64>,
    /// Rate of the altitude, rad/s; `None` for an observer in orbit.
    pub altitude_rate_rad_s: Option<f64>,
    /// Rate of the distance, km/s; negative while the satellite approaches.
    pub range_rate_km_s: f64,
    /// Angle between Sun and satellite as seen by the observer, radians.
    pub elongation_rad: f64,
    /// Source of the positions.
    pub position_source: PositionSource,
    /// Time less element epoch, days; negative if the elements are newer.
    pub element_age_days: f64,
    /// Uncertainty of the predicted position at this age.
    #[doc(hidden)]
    pub uncertainty: OrbitUncertainty,
    /// False if the elements are so old that the position along the orbit, and its uncertainty, are unknown.
    pub is_known: bool,
}

impl EphemerisPoint {
    /// Returns the uncertainty across the track as an angle seen from the observer, one sigma, radians.
    pub fn cross_track_sigma_rad(&self) -> f64 {
        (self.uncertainty.cross_track_km / self.point.range_km).atan()
    }
}

/// Observer, Sun and Earth at one time, which all satellites share.
struct Moment {
    scene: Scene,
    orientation: Orientation,
    motion: ObserverMotion,
    /// State of the site one step before the time, at the time, and one step after it; `None` for an observer in orbit.
    site: Option<[ObserverState; 3]>,
}

impl Sky {
    /// Computes positions of the satellites with the given element indices at given times, also below the horizon. The
    /// points are ordered by satellite, then by time. The second value lists the satellites without a position at one
    /// or more of the times. If `photometry` is `None`, brightness is omitted.
    ///
    /// # Errors
    /// A time is outside the years of the Sun's ephemeris; the elements of a telescope in orbit give no position
    /// ([`NoPosition`](crate::ErrorKind::NoPosition)); there are more than a million points.
    pub fn ephemeris(
        &self,
        element_indices: &[usize],
        times: &[Epoch],
        photometry: Option<&PhotometryOptions>,
    ) -> Result<(Vec<EphemerisPoint>, Vec<LeftOut>), Error> {
        let count = element_indices.len().saturating_mul(times.len());
        if count > MOST_POINTS {
            return Err(Error::invalid(
                "number of positions (satellites times times)",
                count,
                format!("at most {MOST_POINTS}"),
            ));
        }
        let at_time = |(time_index, epoch): (usize, &Epoch)| {
            self.watch().check()?;
            let moment = self.moment(*epoch)?;
            let point = |&index: &usize| match self.point(index, time_index, &moment, photometry) {
                Ok(point) => Ok(point),
                Err(reason) => Err(self.failed(index, reason)),
            };
            Ok(element_indices.iter().map(point).collect())
        };
        let by_time: Vec<Vec<Result<Option<EphemerisPoint>, LeftOut>>> =
            times.par_iter().enumerate().map(at_time).collect::<Result<_, Error>>()?;
        let is_requested = |satellite: &&LeftOut| element_indices.contains(&satellite.element_index);
        let mut left_out: Vec<LeftOut> = self.left_out().iter().filter(is_requested).cloned().collect();
        let mut points = Vec::with_capacity(count);
        let mut columns: Vec<_> = by_time.into_iter().map(Vec::into_iter).collect();
        for _ in element_indices {
            for result in columns.iter_mut().filter_map(Iterator::next) {
                match result {
                    Ok(point) => points.extend(point),
                    Err(failed) => left_out.push(failed),
                }
            }
        }
        left_out.sort_by_key(|satellite| satellite.element_index);
        left_out.dedup_by_key(|satellite| satellite.element_index);
        Ok((points, left_out))
    }

    fn moment(&self, epoch: Epoch) -> Result<Moment, Error> {
        check_epoch(epoch)?;
        let scene = self.scene_without_windows(seconds_after(epoch, -HALF_ARC_S), 2.0 * HALF_ARC_S);
        let exposure = Exposure {
            id: "ephemeris".to_owned(),
            start: epoch,
            duration_s: 0.0,
            pointing: Direction::from_lon_lat_rad(0.0, 0.0),
            rotation_rad: 0.0,
        };
        let flight = self.flight(&scene, &exposure)?;
        let orientation = scene.orientation.at_s(HALF_ARC_S);
        let motion =
            self.motion(&scene, &orientation, flight.as_ref(), HALF_ARC_S).ok_or_else(|| error::no_ephemeris(epoch))?;
        let site = self.viewpoint().site().map(|observer| {
            [-RATE_STEP_S, 0.0, RATE_STEP_S].map(|step_s| observer.state(&scene.orientation.at_s(HALF_ARC_S + step_s)))
        });
        Ok(Moment { scene, orientation, motion, site })
    }

    /// Returns the point of one satellite at one time; `None` for the observing telescope itself and if SGP4 cannot be
    /// initialised.
    fn point(
        &self,
        element_index: usize,
        time_index: usize,
        moment: &Moment,
        photometry: Option<&PhotometryOptions>,
    ) -> Result<Option<EphemerisPoint>, Error> {
        let Moment { scene, orientation, motion, site } = moment;
        let propagator = self.propagator_over(scene.start, element_index, [0.0, 2.0 * HALF_ARC_S]);
        let Some(propagator) = propagator.filter(|_| !self.is_observer(element_index)) else { return Ok(None) };
        let minutes = propagator.minutes_since_epoch(scene.start);
        let arc = OrbitArc::new(propagator, minutes, 0.0, 2.0 * HALF_ARC_S, &orientation.teme_to_gcrs)?;
        let line = SightLine { arc: &arc, observer: motion.clone() };
        let epoch = seconds_after(scene.start, HALF_ARC_S);
        let uncertainty = self.uncertainty_of(element_index, propagator, epoch);
        let evaluator = PassEvaluator { sky: self, scene, line: &line, element_index, photometry, uncertainty };
        let here = site.as_ref().map(|[_, here, _]| here);
        let Some(point) = evaluator.point_over(HALF_ARC_S, 0.0, here) else { return Ok(None) };

        let [before, after] = [-RATE_STEP_S, RATE_STEP_S].map(|step_s| line.aspect_at(HALF_ARC_S + step_s).2);
        let step_s = 2.0 * RATE_STEP_S;
        // dŝ/dt = (ŝ(t + h) - ŝ(t - h)) / 2h, along the unit vectors towards east and north
        let rate_s = (after.direction.vector() - before.direction.vector()) / step_s;
        let (east, north) = point.direction.east_north();
        let horizontal_rates = site.as_ref().map(|[earlier, _, later]| {
            let [a, b] = [earlier.horizon * before.geometric, later.horizon * after.geometric];
            let rate_s = (b.vector() / b.norm_km() - a.vector() / a.norm_km()) / step_s;
            let middle = Direction::<Horizontal>::from_lon_lat_rad(
                point.azimuth_rad.unwrap_or_default(),
                point.altitude_rad.unwrap_or_default(),
            );
            let (east, up) = middle.east_north();
            (rate_s.dot(&east), rate_s.dot(&up))
        });
        let sun = (scene.sun.at_s(HALF_ARC_S).sun - line.observer.position(HALF_ARC_S)).direction();
        Ok(Some(EphemerisPoint {
            norad_id: propagator.norad_id(),
            element_index,
            time_index,
            ra_cos_dec_rate_rad_s: rate_s.dot(&east),
            dec_rate_rad_s: rate_s.dot(&north),
            azimuth_cos_altitude_rate_rad_s: horizontal_rates.map(|(azimuth, _)| azimuth),
            altitude_rate_rad_s: horizontal_rates.map(|(_, altitude)| altitude),
            range_rate_km_s: (after.range_km - before.range_km) / step_s,
            elongation_rad: sun.map_or(f64::NAN, |sun| sun.separation_rad(&point.direction)),
            position_source: propagator.position_source(),
            element_age_days: self.element_age_days(element_index, epoch),
            uncertainty,
            is_known: self.unknown_position(element_index, propagator, epoch).is_none(),
            point,
        }))
    }
}

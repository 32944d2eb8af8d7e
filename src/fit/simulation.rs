//! Simulated photometry in the form of MMT-9 records, for satellites with a known brightness law.
//!
//! 1. A night consists of the times at which the Sun is low enough at the site.
//! 2. Satellites in random order are checked every half minute. A pass begins when a satellite is high enough and its
//!    sunlight passes at least 100 km above the ground.
//! 3. A part of each pass with a random length becomes a track, until the night has enough tracks.
//! 4. Along a track the law gives the magnitudes, to which noise, scatter and the effect of other attitudes are
//!    added.
//! 5. Some tracks are attributed to a wrong satellite: their records have its number, range and phase angle, but the
//!    magnitudes of the observed one.
//!
//! Every night and every track has its own stream of random numbers, so that the result does not depend on the number
//! of threads.

use std::f64::consts::TAU;

use hifitime::{Epoch, TimeScale, Unit};
use nalgebra::Vector3;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use super::measurements::{Record, Records, Sighting};
use crate::constants::DAY_S;
use crate::elements::{ElementSet, History, NoradId};
use crate::error::Error;
use crate::frames::{EopTable, Gcrs, Orientation, OrientationTable, Position, epoch_from_mjd, mjd_utc, seconds_after};
use crate::geometry::{Site, SunTable, ViewingGeometry, sunlit_by_100_km_rule};
use crate::orbit::Propagator;
use crate::photometry::StandardMagnitude;

/// Brightness law of the simulated satellites: the magnitude at 1000 km in a geometry, `None` without lit surface.
pub type MagnitudeLaw<'a> = dyn Fn(&ViewingGeometry) -> Option<StandardMagnitude> + Sync + 'a;

/// Step of the search for passes, s.
const STEP_S: f64 = 30.0;
/// Largest number of draws of another satellite for a misidentified track, until one is above the horizon.
const DRAWS: usize = 16;

/// Lowest altitude of observed satellites.
const LEAST_ALTITUDE_DEG: f64 = 20.0;
/// Highest altitude of the Sun during observations.
const HIGHEST_SUN_DEG: f64 = -8.0;
/// Standard deviation of the effect of another attitude, mag.
const OUTLIER_MAG: f64 = 1.0;

/// Observing campaign and errors.
#[derive(Clone, Debug)]
pub struct SimulationOptions {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Any time in the local solar day in whose evening the first night begins.
    pub first_night: Epoch,
    /// Number of nights.
    pub nights: u32,
    /// Days from one night to the next, at least 1.
    pub night_step_days: u32,
    /// Largest number of tracks in a night.
    pub tracks_per_night: usize,
    /// Time between points, s.
    pub cadence_s: f64,
    /// Shortest and longest track, s.
    pub track_s: [f64; 2],
    /// Standard deviation of the photometric errors, mag.
    pub noise_mag: f64,
    /// Standard deviation of other differences between points, mag.
    pub point_scatter_mag: f64,
    /// Standard deviation of differences between tracks, mag.
    pub track_scatter_mag: f64,
    /// Fraction of tracks recorded as another satellite.
    pub wrong_association_share: f64,
    /// Fraction of tracks in another attitude.
    pub outlier_track_share: f64,
    /// Fraction of points in another attitude.
    pub outlier_point_share: f64,
}

impl SimulationOptions {
    /// Returns the options for MMT-9: noise 0.1 mag (Mallama), 0.2 mag from point to point, 0.1 mag from track to
    /// track; 3 % of the tracks misidentified, 5 % of tracks and points in another attitude (Lu 2024, section 3).
    pub fn mmt9(first_night: Epoch, nights: u32) -> Self {
        Self {
            seed: 1,
            first_night,
            nights,
            night_step_days: 1,
            tracks_per_night: 250,
            cadence_s: 0.5,
            track_s: [20.0, 200.0],
            noise_mag: 0.1,
            point_scatter_mag: 0.2,
            track_scatter_mag: 0.1,
            wrong_association_share: 0.03,
            outlier_track_share: 0.05,
            outlier_point_share: 0.05,
        }
    }
}

/// True values of a track.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TrackTruth {
    /// Observed satellite.
    pub norad_id: NoradId,
    /// Satellite in the record.
    pub recorded_as: NoradId,
    /// Effect of another attitude on all points, mag; 0 for most tracks.
    pub attitude_mag: f64,
}

/// Simulated photometry with its true values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simulation {
    /// Records with time, magnitude, range, phase angle, satellite and track.
    pub records: Records,
    /// True values of each group of records.
    pub truth: Vec<TrackTruth>,
}

/// Simulates photometry of the satellites of a history from a site, each with its element set nearest in time.
/// `each_night` is called after every night, from any thread.
///
/// # Errors
/// A night is outside the years of the time scales.
pub fn simulate(
    law: &MagnitudeLaw<'_>,
    site: &Site,
    history: &History,
    options: &SimulationOptions,
    each_night: &(dyn Fn() + Sync),
) -> Result<Simulation, Error> {
    let objects: Vec<&[ElementSet]> = history.objects().collect();
    let nights: Vec<Vec<(TrackTruth, Vec<Record>)>> = (0..options.nights)
        .into_par_iter()
        .map(|night| {
            let tracks = Night::new(night, options, site).map(|night| night.tracks(law, &objects));
            each_night();
            tracks
        })
        .collect::<Result<_, Error>>()
        .map_err(|error| {
            Error::invalid("first_night", format!("{}: {error}", options.first_night), "nights from 1900 to 2200")
        })?;
    let mut simulation = Simulation::default();
    simulation.records.sites.push(site.clone());
    simulation.records.files.push("simulation".to_owned());
    for (night, tracks) in nights.into_iter().enumerate() {
        for (number, (truth, points)) in tracks.into_iter().enumerate() {
            let group = simulation.records.groups.len() as u32;
            simulation.records.groups.push((night * 1_000_000 + number + 1).to_string());
            simulation.truth.push(truth);
            for point in points {
                let row = simulation.records.records.len() as u32 + 1;
                simulation.records.records.push(Record { group, row, ..point });
            }
        }
    }
    Ok(simulation)
}

/// Positions of observer and Sun at one time.
struct Moment {
    seconds: f64,
    orientation: Orientation,
    sun: Position<Gcrs>,
    observer: Position<Gcrs>,
    zenith: Vector3<f64>,
}

struct Night<'o> {
    number: u32,
    options: &'o SimulationOptions,
    site: &'o Site,
    noon: Epoch,
    orientations: OrientationTable,
    suns: SunTable,
    /// Times in the dark, one for each step of the search for tracks.
    dark: Vec<Moment>,
}

impl<'o> Night<'o> {
    fn new(number: u32, options: &'o SimulationOptions, site: &'o Site) -> Result<Self, Error> {
        let east_days = site.longitude_rad / TAU;
        let day =
            (mjd_utc(options.first_night) + east_days).floor() + f64::from(number) * f64::from(options.night_step_days);
        let noon = epoch_from_mjd(day + 0.5 - east_days, TimeScale::UTC)?;
        let end = seconds_after(noon, DAY_S);
        let (orientations, suns) = (OrientationTable::new(noon, end, &EopTable::embedded()), SunTable::new(noon, end));
        let mut night = Self { number, options, site, noon, orientations, suns, dark: Vec::new() };
        let is_dark =
            |moment: &Moment| moment.zenith.dot(&moment.sun.vector().normalize()) < HIGHEST_SUN_DEG.to_radians().sin();
        let steps = 0..(DAY_S / STEP_S) as u32;
        night.dark = steps.map(|step| night.at(f64::from(step) * STEP_S)).filter(is_dark).collect();
        Ok(night)
    }

    /// Returns the positions of observer and Sun at a number of seconds after noon.
    fn at(&self, seconds: f64) -> Moment {
        let orientation = self.orientations.at_s(seconds);
        let to_gcrs = &orientation.itrs_to_gcrs;
        let observer = *to_gcrs * self.site.itrs();
        let zenith = to_gcrs.matrix() * self.site.horizon().matrix().row(2).transpose();
        Moment { seconds, orientation, sun: self.suns.at_s(seconds).sun, observer, zenith }
    }

    /// Returns the random generator of the night (`track` 0) or of one of its tracks.
    fn random(&self, track: usize) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.options.seed);
        random.set_stream((u64::from(self.number) << 32) | track as u64);
        random
    }

    fn tracks(&self, law: &MagnitudeLaw<'_>, objects: &[&[ElementSet]]) -> Vec<(TrackTruth, Vec<Record>)> {
        let mut order: Vec<usize> = (0..objects.len()).collect();
        order.shuffle(&mut self.random(0));
        let mut tracks = Vec::new();
        let mut drawn = 0;
        for object in order {
            if tracks.len() >= self.options.tracks_per_night {
                break;
            }
            let Some(propagator) = self.propagator(objects[object]) else { continue };
            for pass in self.passes(&propagator) {
                drawn += 1;
                let track = self.track(law, objects, &propagator, pass, &mut self.random(drawn));
                tracks.extend(Some(track).filter(|(_, points)| !points.is_empty()));
            }
        }
        tracks.truncate(self.options.tracks_per_night);
        tracks
    }

    fn propagator(&self, sets: &[ElementSet]) -> Option<Propagator> {
        let midnight = seconds_after(self.noon, 0.5 * DAY_S);
        let distance = |set: &&ElementSet| (midnight - set.epoch).to_unit(Unit::Day).abs();
        let nearest = sets.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Propagator::new(nearest).ok()
    }

    fn satellite(&self, propagator: &Propagator, moment: &Moment) -> Option<Position<Gcrs>> {
        let minutes = propagator.minutes_since_epoch(self.noon) + moment.seconds / 60.0;
        propagator.state_at_minutes(minutes, &moment.orientation.teme_to_gcrs).ok().map(|state| state.position)
    }

    /// Returns the first and last second of each pass, in steps of the search.
    fn passes(&self, propagator: &Propagator) -> Vec<[f64; 2]> {
        let mut passes: Vec<[f64; 2]> = Vec::new();
        for moment in &self.dark {
            let Some(satellite) = self.satellite(propagator, moment) else { break };
            let sight = satellite.vector() - moment.observer.vector();
            let is_high = moment.zenith.dot(&sight) >= LEAST_ALTITUDE_DEG.to_radians().sin() * sight.norm();
            if !is_high || !sunlit_by_100_km_rule(&satellite, &moment.sun) {
                continue;
            }
            match passes.last_mut() {
                Some([_, end]) if moment.seconds - *end <= 1.5 * STEP_S => *end = moment.seconds,
                _ => passes.push([moment.seconds, moment.seconds]),
            }
        }
        passes
    }

    /// Returns the geometry, the altitude in radians, and whether the satellite is lit.
    fn seen(&self, propagator: &Propagator, moment: &Moment) -> Option<(ViewingGeometry, f64, bool)> {
        let satellite = self.satellite(propagator, moment)?;
        let geometry = ViewingGeometry::new(&satellite, &moment.observer, &moment.sun)?;
        let sine = moment.zenith.dot(&(satellite.vector() - moment.observer.vector())) / geometry.range_km;
        Some((geometry, sine.clamp(-1.0, 1.0).asin(), sunlit_by_100_km_rule(&satellite, &moment.sun)))
    }

    fn track(
        &self,
        law: &MagnitudeLaw<'_>,
        objects: &[&[ElementSet]],
        propagator: &Propagator,
        [first_s, last_s]: [f64; 2],
        random: &mut ChaCha8Rng,
    ) -> (TrackTruth, Vec<Record>) {
        let options = self.options;
        let normal = |sigma: f64, random: &mut ChaCha8Rng| sigma * random.sample::<f64, _>(StandardNormal);
        let [shortest, longest] = options.track_s;
        // A pass found at a single step has the length of one step.
        let pass_s = (last_s - first_s).max(STEP_S);
        let drawn_s = shortest + (longest - shortest) * random.random::<f64>();
        let track_s = drawn_s.min(pass_s);
        let start_s = first_s + (pass_s - track_s) * random.random::<f64>();
        let is_wrong = random.random::<f64>() < options.wrong_association_share;
        let recorded = if is_wrong { self.another(objects, propagator, start_s, random) } else { None };
        let is_outlier = random.random::<f64>() < options.outlier_track_share;
        let attitude_mag = if is_outlier { normal(OUTLIER_MAG, random) } else { 0.0 };
        let track_mag = attitude_mag + normal(options.track_scatter_mag, random);
        let truth = TrackTruth {
            norad_id: propagator.norad_id(),
            recorded_as: recorded.as_ref().unwrap_or(propagator).norad_id(),
            attitude_mag,
        };
        let mut points = Vec::new();
        for step in 0..=(track_s / options.cadence_s) as u32 {
            // Rounded to a microsecond, as in the survey.
            let seconds = ((start_s + f64::from(step) * options.cadence_s) * 1e6).round() * 1e-6;
            let moment = self.at(seconds);
            let Some((geometry, altitude_rad, is_lit)) = self.seen(propagator, &moment) else { continue };
            // A new number is drawn for every point, so that the noise of different points is independent.
            let noise_mag = normal(options.noise_mag.hypot(options.point_scatter_mag), random);
            let is_turned = random.random::<f64>() < options.outlier_point_share;
            let turned_mag = normal(OUTLIER_MAG, random);
            if !is_lit || altitude_rad < LEAST_ALTITUDE_DEG.to_radians() {
                continue;
            }
            let Some(standard) = law(&geometry) else { continue };
            let added_mag = track_mag + noise_mag + if is_turned { turned_mag } else { 0.0 };
            let recorded =
                recorded.as_ref().and_then(|other| self.seen(other, &moment)).map_or(geometry, |seen| seen.0);
            points.push(Record {
                epoch: Some(seconds_after(self.noon, seconds)),
                magnitude: standard.at_range(geometry.range_km).dimmed_by(added_mag),
                sigma_mag: None,
                sighting: Sighting::Distance {
                    range_km: recorded.range_km,
                    phase_rad: Some(recorded.phase_angle_rad()),
                },
                norad_id: Some(truth.recorded_as),
                group: 0,
                site: Some(0),
                in_penumbra: false,
                file: 0,
                row: 0,
            });
        }
        (truth, points)
    }

    /// Returns another satellite: the first of at most [`DRAWS`] draws that is above the horizon, or else the last one
    /// drawn. `None` if no draw gives another satellite.
    fn another(
        &self,
        objects: &[&[ElementSet]],
        own: &Propagator,
        seconds: f64,
        random: &mut ChaCha8Rng,
    ) -> Option<Propagator> {
        let moment = self.at(seconds);
        let mut drawn = None;
        for _ in 0..DRAWS {
            let other = self.propagator(objects[random.random_range(0..objects.len())]);
            let Some(other) = other.filter(|other| other.norad_id() != own.norad_id()) else { continue };
            let is_up = self.seen(&other, &moment).is_some_and(|(_, altitude_rad, _)| altitude_rad > 0.0);
            drawn = Some(other);
            if is_up {
                break;
            }
        }
        drawn
    }
}

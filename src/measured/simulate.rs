//! Photometry as MMT-9 would have recorded it, of satellites whose brightness is known: what a pipeline must find again.
//!
//! 1. Each night the hours are found in which the Sun stands low enough at the site.
//! 2. Satellites in an order drawn for that night are looked at every half minute; where one stands high enough and its line to the Sun
//!    clears the 100 km rule, that is a pass.
//! 3. Of each pass a stretch of drawn length is a track, until the night has enough of them.
//! 4. Along a track the model says how bright the satellite is; noise, scatter and attitude are drawn.
//! 5. Some tracks are booked under another satellite: its number, distance and phase, with the magnitudes of the true one.
//!
//! Every night and every track has a stream of random numbers of its own (ChaCha, 8 rounds), so that the answer does not depend on threads.

use std::f64::consts::TAU;

use hifitime::{Epoch, TimeScale};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use crate::catalogue::{ElementSet, History, NoradId};
use crate::frames::{EopTable, Gcrs, Position, epoch_from_mjd, mjd_utc, seconds_after};
use crate::geometry::{Site, sunlit_by_100_km_rule};
use crate::orbit::Propagator;
use crate::photometry::{BrightnessModel, Earthshine};

use super::ephemeris::{Ephemeris, Moment};
use super::error::MeasuredError;
use super::placement::{Placed, Stand, seen};
use super::record::{Record, Records, Sighting};

/// What is observed, and how badly.
#[derive(Clone, Debug)]
pub struct SimulationOptions {
    /// The same seed gives the same photometry.
    pub seed: u64,
    /// Who observes.
    pub site: Site,
    /// A moment of the day whose evening begins the first night, by the Sun's clock at the site.
    pub first_night: Epoch,
    /// How many nights are observed.
    pub nights: u32,
    /// Days from one to the next, at least 1.
    pub night_step_days: u32,
    /// Tracks a night, where the satellites make as many.
    pub tracks_per_night: usize,
    /// Satellites are observed above this altitude, radians.
    pub least_altitude_rad: f64,
    /// The Sun stands below this altitude, radians.
    pub highest_sun_rad: f64,
    /// Time between points, s.
    pub cadence_s: f64,
    /// Shortest and longest track, s; passes cut them short.
    pub track_s: [f64; 2],
    /// One sigma of the photometry, mag.
    pub noise_mag: f64,
    /// One sigma of what else differs from point to point, mag.
    pub point_scatter_mag: f64,
    /// One sigma of what differs from track to track, mag.
    pub track_scatter_mag: f64,
    /// Share of tracks booked under another satellite, [0, 1].
    pub wrong_association_share: f64,
    /// Share of tracks of a satellite in another attitude, [0, 1].
    pub outlier_track_share: f64,
    /// Share of points in another attitude, [0, 1].
    pub outlier_point_share: f64,
    /// One sigma of what another attitude does, mag.
    pub outlier_mag: f64,
    /// Light of the Earth.
    pub earthshine: Earthshine,
    /// Earth orientation.
    pub eop: EopTable,
}

impl SimulationOptions {
    /// MMT-9 over so many nights from a day on: noise 0.1 mag (Mallama), 0.2 mag from point to point, 0.1 from track to track; 3 % of the
    /// tracks booked wrongly, 5 % of tracks and points in another attitude, which makes 1 mag (Lu 2024, section 3).
    ///
    /// # Errors
    /// The bundled table of sites lacks MMT-9.
    pub fn mmt9(first_night: Epoch, nights: u32) -> Result<Self, crate::geometry::GeometryError> {
        Ok(Self {
            seed: 1,
            site: Site::by_name("MMT-9")?,
            first_night,
            nights,
            night_step_days: 1,
            tracks_per_night: 250,
            least_altitude_rad: 20_f64.to_radians(),
            highest_sun_rad: -8_f64.to_radians(),
            cadence_s: 0.5,
            track_s: [20.0, 200.0],
            noise_mag: 0.1,
            point_scatter_mag: 0.2,
            track_scatter_mag: 0.1,
            wrong_association_share: 0.03,
            outlier_track_share: 0.05,
            outlier_point_share: 0.05,
            outlier_mag: 1.0,
            earthshine: Earthshine::Off,
            eop: EopTable::embedded(),
        })
    }
}

/// What is true of a track.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TrackTruth {
    /// The satellite that was seen.
    pub norad_id: NoradId,
    /// The satellite under which it was booked.
    pub booked_as: NoradId,
    /// What another attitude does to all of its points, mag; 0 of most.
    pub attitude_mag: f64,
}

/// Simulated photometry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simulation {
    /// As readers give them: time, magnitude, distance, phase, satellite, track.
    pub records: Records,
    /// Of each group of the records.
    pub truth: Vec<TrackTruth>,
}

/// Satellites are looked at so often for passes, s.
const LOOK_S: f64 = 30.0;
/// Draws of another satellite for a track booked wrongly, until one stands above the horizon.
const DRAWS: usize = 16;

/// Photometry of the satellites of a history, each by its element set nearest in time, with the brightness of a model.
///
/// Points at which the model sees nothing lit are left out. Tracks are named by night and number. Two million points take seconds.
///
/// # Errors
/// [`MeasuredError::Setting`] for shares outside of [0, 1], times or sigmas that cannot be; [`MeasuredError::NoHistory`] where no
/// satellite is given.
pub fn simulate(
    model: &BrightnessModel,
    history: &History,
    options: &SimulationOptions,
) -> Result<Simulation, MeasuredError> {
    check(options)?;
    if history.is_empty() {
        return Err(MeasuredError::NoHistory { what: "a simulation" });
    }
    let objects: Vec<&[ElementSet]> = history.objects().collect();
    let nights: Vec<Vec<(TrackTruth, Vec<Record>)>> = (0..options.nights)
        .into_par_iter()
        .map(|night| Night::new(night, options).map_or_else(Vec::new, |night| night.tracks(model, &objects)))
        .collect();
    let mut simulation = Simulation::default();
    simulation.records.sites.push(options.site.clone());
    simulation.records.files.push("simulation".to_owned());
    simulation.records.records.reserve(nights.iter().flatten().map(|(_, points)| points.len()).sum());
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

fn check(options: &SimulationOptions) -> Result<(), MeasuredError> {
    let setting = |name, given: f64, allowed| Err(MeasuredError::Setting { name, given: given.to_string(), allowed });
    let shares = [
        ("wrong_association_share", options.wrong_association_share),
        ("outlier_track_share", options.outlier_track_share),
        ("outlier_point_share", options.outlier_point_share),
    ];
    for (name, share) in shares {
        if !(0.0..=1.0).contains(&share) {
            return setting(name, share, "0 to 1");
        }
    }
    let sigmas = [
        ("noise_mag", options.noise_mag),
        ("point_scatter_mag", options.point_scatter_mag),
        ("track_scatter_mag", options.track_scatter_mag),
        ("outlier_mag", options.outlier_mag),
    ];
    for (name, sigma) in sigmas {
        if !(0.0..=10.0).contains(&sigma) {
            return setting(name, sigma, "0 to 10 mag");
        }
    }
    if !(0.001..=3600.0).contains(&options.cadence_s) {
        return setting("cadence_s", options.cadence_s, "0.001 to 3600 s");
    }
    let [shortest, longest] = options.track_s;
    if !(shortest > 0.0 && shortest <= longest && longest.is_finite()) {
        return setting("track_s", shortest, "more than 0, and no more than the longest");
    }
    if options.night_step_days == 0 {
        return setting("night_step_days", 0.0, "1 or more");
    }
    if !(options.least_altitude_rad.is_finite() && options.highest_sun_rad.is_finite()) {
        return setting("least_altitude_rad, highest_sun_rad", f64::NAN, "finite angles");
    }
    Ok(())
}

/// One night.
struct Night<'o> {
    number: u32,
    options: &'o SimulationOptions,
    noon: Epoch,
    ephemeris: Ephemeris,
    stand: Stand,
    /// Seconds after noon, and what does not depend on the satellite, in the dark.
    looks: Vec<(f64, Moment, Position<Gcrs>, nalgebra::Vector3<f64>)>,
}

impl<'o> Night<'o> {
    /// `None` for dates beyond those of the calendar.
    fn new(number: u32, options: &'o SimulationOptions) -> Option<Self> {
        let east_days = options.site.longitude_rad / TAU;
        let day =
            (mjd_utc(options.first_night) + east_days).floor() + f64::from(number) * f64::from(options.night_step_days);
        let noon = epoch_from_mjd(day + 0.5 - east_days, TimeScale::UTC).ok()?;
        let mut ephemeris = Ephemeris::new(options.eop.clone());
        let epochs: Vec<(f64, Epoch)> = (0..(crate::constants::DAY_S / LOOK_S) as u32)
            .map(|look| f64::from(look) * LOOK_S)
            .map(|seconds| (seconds, seconds_after(noon, seconds)))
            .collect();
        ephemeris.prepare(epochs.iter().map(|(_, epoch)| *epoch));
        let stand = Stand::new(&options.site);
        let look = |&(seconds, epoch): &(f64, Epoch)| {
            let moment = ephemeris.at(epoch)?;
            let (observer, zenith) = stand.at(&moment);
            let is_dark = zenith.dot(&moment.sun.vector().normalize()) < options.highest_sun_rad.sin();
            is_dark.then_some((seconds, moment, observer, zenith))
        };
        let looks = epochs.iter().filter_map(look).collect();
        Some(Self { number, options, noon, ephemeris, stand, looks })
    }

    /// The generator of a night (`track` 0) or of one of its tracks.
    fn random(&self, track: usize) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.options.seed);
        random.set_stream((u64::from(self.number) << 32) | track as u64);
        random
    }

    fn tracks(&self, model: &BrightnessModel, objects: &[&[ElementSet]]) -> Vec<(TrackTruth, Vec<Record>)> {
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
                let track = self.track(model, objects, &propagator, pass, &mut self.random(drawn));
                tracks.extend(track.filter(|(_, points)| !points.is_empty()));
            }
        }
        tracks.truncate(self.options.tracks_per_night);
        tracks
    }

    fn propagator(&self, sets: &[ElementSet]) -> Option<Propagator> {
        let midnight = seconds_after(self.noon, 0.5 * crate::constants::DAY_S);
        let distance = |set: &&ElementSet| super::placement::age_days(set, midnight).abs();
        let nearest = sets.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Propagator::new(nearest).ok()
    }

    fn satellite(&self, propagator: &Propagator, seconds: f64, moment: &Moment) -> Option<Position<Gcrs>> {
        let minutes = propagator.minutes_since_epoch(self.noon) + seconds / 60.0;
        propagator.state_at_minutes(minutes, &moment.orientation.teme_to_gcrs).ok().map(|state| state.position)
    }

    /// First and last second of each pass, on the grid of looks.
    fn passes(&self, propagator: &Propagator) -> Vec<[f64; 2]> {
        let mut passes: Vec<[f64; 2]> = Vec::new();
        let sine = self.options.least_altitude_rad.sin();
        for (seconds, moment, observer, zenith) in &self.looks {
            let Some(satellite) = self.satellite(propagator, *seconds, moment) else { break };
            let sight = satellite.vector() - observer.vector();
            if zenith.dot(&sight) < sine * sight.norm() || !sunlit_by_100_km_rule(&satellite, &moment.sun) {
                continue;
            }
            match passes.last_mut() {
                Some([_, end]) if *seconds - *end <= 1.5 * LOOK_S => *end = *seconds,
                _ => passes.push([*seconds, *seconds]),
            }
        }
        passes
    }

    fn placed(&self, propagator: &Propagator, seconds: f64) -> Option<(Epoch, Placed)> {
        let epoch = seconds_after(self.noon, (seconds * 1e6).round() * 1e-6);
        let moment = self.ephemeris.at(epoch)?;
        let placed = seen(&self.satellite(propagator, seconds, &moment)?, &moment, &self.stand)?;
        Some((epoch, placed))
    }

    fn track(
        &self,
        model: &BrightnessModel,
        objects: &[&[ElementSet]],
        propagator: &Propagator,
        [first_s, last_s]: [f64; 2],
        random: &mut ChaCha8Rng,
    ) -> Option<(TrackTruth, Vec<Record>)> {
        let options = self.options;
        let normal = |sigma: f64, random: &mut ChaCha8Rng| sigma * random.sample::<f64, _>(StandardNormal);
        let [shortest, longest] = options.track_s;
        // A pass of one look lasts a look.
        let pass_s = (last_s - first_s).max(LOOK_S);
        let wanted_s = shortest + (longest - shortest) * random.random::<f64>();
        let track_s = wanted_s.min(pass_s);
        let start_s = first_s + (pass_s - track_s) * random.random::<f64>();
        let is_wrong = random.random::<f64>() < options.wrong_association_share;
        let booked = if is_wrong { self.another(objects, propagator, start_s, random) } else { None };
        let is_outlier = random.random::<f64>() < options.outlier_track_share;
        let attitude_mag = if is_outlier { normal(options.outlier_mag, random) } else { 0.0 };
        let track_mag = attitude_mag + normal(options.track_scatter_mag, random);
        let truth = TrackTruth {
            norad_id: propagator.norad_id(),
            booked_as: booked.as_ref().unwrap_or(propagator).norad_id(),
            attitude_mag,
        };
        let least_altitude_rad = options.least_altitude_rad;
        let mut points = Vec::new();
        for step in 0..=(track_s / options.cadence_s) as u32 {
            let seconds = start_s + f64::from(step) * options.cadence_s;
            let (epoch, placed) = self.placed(propagator, seconds)?;
            let is_lit =
                placed.satellite_and_sun.is_some_and(|(satellite, sun)| sunlit_by_100_km_rule(&satellite, &sun));
            // Drawn before anything is left out, so that points do not depend on one another.
            let noise = normal(options.noise_mag.hypot(options.point_scatter_mag), random);
            let turned = random.random::<f64>() < options.outlier_point_share;
            let turned_mag = normal(options.outlier_mag, random);
            if !is_lit || placed.altitude_rad.is_none_or(|altitude| altitude < least_altitude_rad) {
                continue;
            }
            let Some(standard) = model.standard_magnitude_with(&placed.geometry, options.earthshine) else { continue };
            let added_mag = track_mag + noise + if turned { turned_mag } else { 0.0 };
            let magnitude = standard.at_range(placed.geometry.range_km).dimmed_by(added_mag);
            let recorded = match &booked {
                Some(other) => self.placed(other, seconds)?.1.geometry,
                None => placed.geometry,
            };
            points.push(Record {
                epoch: Some(epoch),
                magnitude,
                sigma_mag: None,
                sighting: Sighting::Distance {
                    range_km: recorded.range_km,
                    phase_rad: Some(recorded.phase_angle_rad()),
                },
                norad_id: Some(truth.booked_as),
                group: 0,
                site: Some(0),
                in_penumbra: false,
                file: 0,
                row: 0,
            });
        }
        Some((truth, points))
    }

    /// Another satellite, above the horizon if one is soon drawn.
    fn another(
        &self,
        objects: &[&[ElementSet]],
        own: &Propagator,
        seconds: f64,
        random: &mut ChaCha8Rng,
    ) -> Option<Propagator> {
        let mut drawn = None;
        for _ in 0..DRAWS {
            let other = self.propagator(objects[random.random_range(0..objects.len())]);
            let Some(other) = other.filter(|other| other.norad_id() != own.norad_id()) else { continue };
            let altitude = self.placed(&other, seconds).and_then(|(_, placed)| placed.altitude_rad);
            drawn = Some(other);
            if altitude.is_some_and(|altitude| altitude > 0.0) {
                break;
            }
        }
        drawn
    }
}

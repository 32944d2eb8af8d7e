//! One night of simulated photometry: which satellites pass, and the tracks that are seen of them.

use std::f64::consts::TAU;

use hifitime::{Epoch, TimeScale};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::elements::ElementSet;
use crate::frames::{Gcrs, Position, epoch_from_mjd, mjd_utc, seconds_after};
use crate::geometry::sunlit_by_100_km_rule;
use crate::orbit::Propagator;
use crate::photometry::BrightnessModel;

use super::ephemeris::{Ephemeris, Moment};
use super::placement::{Placed, Stand, seen};
use super::record::{Record, Sighting};
use super::simulate::{SimulationOptions, TrackTruth};

/// Satellites are looked at so often for passes, s.
const LOOK_S: f64 = 30.0;
/// Draws of another satellite for a track booked wrongly, until one stands above the horizon.
const DRAWS: usize = 16;

/// One night.
pub(super) struct Night<'o> {
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
    pub(super) fn new(number: u32, options: &'o SimulationOptions) -> Option<Self> {
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

    pub(super) fn tracks(&self, model: &BrightnessModel, objects: &[&[ElementSet]]) -> Vec<(TrackTruth, Vec<Record>)> {
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

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

use hifitime::Epoch;
use rayon::prelude::*;

use crate::elements::{ElementSet, History, NoradId};
use crate::frames::EopTable;
use crate::geometry::Site;
use crate::photometry::{BrightnessModel, Earthshine};

use super::error::MeasuredError;
use super::night::Night;
use super::record::{Record, Records};

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

//! Frames, observers, Sun and horizon against astropy (ERFA), Skyfield, Vallado's example and JPL Horizons.

mod common;

use std::collections::HashMap;
use std::f64::consts::PI;

use hifitime::{Epoch, TimeScale};
use streakcast::catalogue::{Catalogue, ReadOptions};
use streakcast::constants::AU_KM;
use streakcast::frames::{
    EarthOrientationParameters, EopTable, Gcrs, Itrs, Orientation, OrientationTable, Position, Teme, epoch_from_mjd,
    seconds_after, tt_jd, ut1_jd,
};
use streakcast::geometry::{Observer, Site, SunState, SunTable};
use streakcast::orbit::Propagator;

const ARCSEC_RAD: f64 = PI / 648_000.0;

/// ERFA's own numbers through another language: rounding of sums and of angles of 10⁴ turns, seen at 42,164 km.
const SAME_THEORY_KM: f64 = 1e-8;
/// astropy's TEME carries the site's and the satellite's vectors through matrices the same way; its UT1 is rounded to 10⁻¹¹ days.
const SAME_THEORY_GMST_RAD: f64 = 1e-10;
/// Velocity of a site: astropy differentiates ERFA's own rotation rate, 1.3 times the length of day aside.
const SITE_VELOCITY_KM_S: f64 = 1e-9;
/// astropy asks epv00 for TDB, we for TT: 2 ms of the Earth's 30 km/s.
const SUN_TDB_KM: f64 = 0.06;
const EARTH_VELOCITY_TDB_KM_S: f64 = 2e-8;
/// Skyfield's nutation is cut to 2000A's larger terms, its TEME turns by another equation of the equinoxes: 1 mas, at 42,164 km.
const SKYFIELD_ANGLE_RAD: f64 = 1e-3 * ARCSEC_RAD;
/// Skyfield knows UT1 by the same table but interpolates delta T: 0.1 ms of turning.
const SKYFIELD_SITE_KM: f64 = 1e-4;
/// epv00 against JPL: documented as 11 km (heliocentric) and 5 mm/s.
const DE421_SUN_KM: f64 = 11.0;
const DE421_EARTH_VELOCITY_KM_S: f64 = 5e-6;

struct Row {
    epoch: Epoch,
    parameters: EarthOrientationParameters,
    columns: HashMap<String, f64>,
}

impl Row {
    fn number(&self, name: &str) -> f64 {
        *self.columns.get(name).unwrap_or_else(|| panic!("no column {name}"))
    }

    fn vector(&self, stem: &str, unit: &str) -> nalgebra::Vector3<f64> {
        let component = |axis: &str| self.number(&format!("{stem}{axis}_{unit}"));
        nalgebra::Vector3::new(component("x"), component("y"), component("z"))
    }
}

fn golden_rows() -> Vec<Row> {
    let text =
        std::fs::read_to_string(common::golden_dir().join("frames_golden.csv")).expect("tests/data/frames_golden.csv");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().expect("a head").split(',').collect();
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let columns: HashMap<String, f64> = names[1..]
                .iter()
                .zip(&fields[1..])
                .map(|(name, field)| (name.to_string(), field.parse().expect("a number")))
                .collect();
            let parameters = EarthOrientationParameters {
                ut1_minus_utc_s: columns["ut1_minus_utc_s"],
                xp_rad: columns["xp_arcsec"] * ARCSEC_RAD,
                yp_rad: columns["yp_arcsec"] * ARCSEC_RAD,
            };
            Row { epoch: format!("{} UTC", fields[0]).parse().expect("an epoch"), parameters, columns }
        })
        .collect()
}

/// The largest of some numbers, with a name for the message.
struct Worst(&'static str, f64, f64);

impl Worst {
    fn see(&mut self, value: f64) {
        // Not a number is the worst of all.
        self.1 = if value > self.1 || value.is_nan() { value } else { self.1 };
    }
}

impl Drop for Worst {
    fn drop(&mut self) {
        println!("{}: worst {:.3e}, allowed {:.1e}", self.0, self.1, self.2);
        if !std::thread::panicking() {
            assert!(self.1 <= self.2, "{}: {:e} > {:e}", self.0, self.1, self.2);
        }
    }
}

#[test]
fn valid_rotations_against_astropy() {
    let rows = golden_rows();
    assert_eq!(rows.len(), 60);
    let mut gmst = Worst("GMST82 against ERFA, rad", 0.0, SAME_THEORY_GMST_RAD);
    let mut itrs = Worst("TEME to ITRS against astropy, km", 0.0, SAME_THEORY_KM);
    let mut gcrs = Worst("TEME to GCRS against astropy, km", 0.0, SAME_THEORY_KM);
    for row in &rows {
        let (day, fraction) = ut1_jd(row.epoch, row.parameters.ut1_minus_utc_s);
        gmst.see((sofars::erst::gmst82(day, fraction) - row.number("gmst82_rad")).sin().abs());
        let orientation = Orientation::from_parameters(row.epoch, &row.parameters);
        let satellite = Position::<Teme>::from_vector(row.vector("teme_", "km"));
        let ours: Position<Itrs> = orientation.itrs_to_teme.inverse() * satellite;
        itrs.see((ours.vector() - row.vector("itrs_", "km")).norm());
        let ours: Position<Gcrs> = orientation.teme_to_gcrs * satellite;
        gcrs.see((ours.vector() - row.vector("gcrs_", "km")).norm());
    }
}

#[test]
fn valid_observers_and_sun_against_astropy() {
    let mut place = Worst("site in GCRS against astropy, km", 0.0, SAME_THEORY_KM);
    let mut speed = Worst("site velocity in GCRS against astropy, km/s", 0.0, SITE_VELOCITY_KM_S);
    let mut sun = Worst("Sun against astropy, km", 0.0, SUN_TDB_KM);
    let mut earth = Worst("Earth's velocity against astropy, km/s", 0.0, EARTH_VELOCITY_TDB_KM_S);
    for row in golden_rows() {
        let orientation = Orientation::from_parameters(row.epoch, &row.parameters);
        let state = observer(&row).state(&orientation);
        place.see((state.position.vector() - row.vector("site_", "km")).norm());
        speed.see((state.velocity.vector() - row.vector("site_v", "km_s")).norm());
        let ours = SunState::at(row.epoch);
        sun.see((ours.sun.vector() - row.vector("sun_", "km")).norm());
        earth.see((ours.earth_velocity.vector() - row.vector("earth_v", "km_s")).norm());
    }
}

#[test]
fn valid_frames_against_skyfield() {
    let mut gcrs = Worst("TEME to GCRS against Skyfield, rad", 0.0, SKYFIELD_ANGLE_RAD);
    let mut place = Worst("site in GCRS against Skyfield, km", 0.0, SKYFIELD_SITE_KM);
    let mut horizon = Worst("altitude and azimuth against Skyfield, rad", 0.0, 10.0 * SKYFIELD_ANGLE_RAD);
    let mut sun = Worst("Sun against DE421, km", 0.0, DE421_SUN_KM);
    let mut earth = Worst("Earth's velocity against DE421, km/s", 0.0, DE421_EARTH_VELOCITY_KM_S);
    for row in golden_rows() {
        let orientation = Orientation::from_parameters(row.epoch, &row.parameters);
        let satellite = orientation.teme_to_gcrs * Position::<Teme>::from_vector(row.vector("teme_", "km"));
        gcrs.see((satellite.vector() - row.vector("skyfield_gcrs_", "km")).norm() / satellite.norm_km());
        let state = observer(&row).state(&orientation);
        place.see((state.position.vector() - row.vector("skyfield_site_", "km")).norm());
        let (altitude, azimuth) = state.altitude_azimuth_rad(&(satellite - state.position)).expect("not at the site");
        let theirs =
            (row.number("skyfield_altitude_deg").to_radians(), row.number("skyfield_azimuth_deg").to_radians());
        horizon.see((altitude - theirs.0).abs());
        horizon.see(((azimuth - theirs.1).sin() * altitude.cos()).abs());
        let ours = SunState::at(row.epoch);
        sun.see((ours.sun.vector() - row.vector("de421_sun_", "km")).norm());
        earth.see((ours.earth_velocity.vector() - row.vector("de421_earth_v", "km_s")).norm());
    }
}

fn observer(row: &Row) -> Observer {
    let site = Site::new_deg("golden", row.number("latitude_deg"), row.number("longitude_deg"), row.number("height_m"));
    Observer::new(site.expect("a site"))
}

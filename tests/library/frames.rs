//! Frames, observers, Sun and horizon compared with astropy (ERFA), Skyfield, an example of Vallado, and JPL Horizons.

use crate::common::agreement::Agreement;
use std::collections::HashMap;
use std::f64::consts::PI;

use hifitime::{Epoch, TimeScale};
use streakcast::constants::{AU_KM, DAY_S};
use streakcast::elements::{ReadOptions, Satellites};
use streakcast::frames::{
    Direction, EarthOrientationParameters, EopStatus, EopTable, Gcrs, Itrs, Orientation, OrientationTable, Position,
    Teme, Velocity, annual_aberration, epoch_from_mjd, gcrs_to_of_date, mjd_utc, seconds_after, ut1_jd,
    without_annual_aberration,
};
use streakcast::geometry::{Observer, Site, SunState, SunTable};
use streakcast::orbit::Propagator;

const ARCSEC_RAD: f64 = PI / 648_000.0;

/// Tolerances for the same theory in another language: rounding errors, at 42,164 km some 10⁻¹¹ km per product.
const SAME_THEORY_KM: f64 = 1e-8;
const SAME_THEORY_RAD: f64 = 1e-12;
const SAME_THEORY_KM_S: f64 = 1e-12;
/// Tolerances of Sun and Earth: astropy evaluates epv00 at TDB, this library at TT. They differ by up to 1.7 ms, and
/// the Earth moves at 30 km/s with an acceleration of 6 mm/s².
const SUN_TDB_KM: f64 = 0.055;
const EARTH_VELOCITY_TDB_KM_S: f64 = 1.5e-8;
/// Tolerance of precession, nutation and sidereal time of Skyfield, whose theories differ by 0.1 mas.
const SKYFIELD_ANGLE_RAD: f64 = 1e-4 * ARCSEC_RAD;
/// Tolerance of sites: Skyfield interpolates delta T daily and adds leap seconds afterwards, 0.1 ms of rotation.
const SKYFIELD_SITE_KM: f64 = 5e-5;
const SKYFIELD_HORIZON_RAD: f64 = 7.3e-5 * 1e-4;
/// Tolerances of epv00 compared with JPL's ephemeris: SOFA documents at most 11.2 km and 5 mm/s for 1900 to 2100.
const DE421_SUN_KM: f64 = 11.2;
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
    let text = std::fs::read_to_string(crate::common::golden_dir().join("frames_golden.csv"))
        .expect("tests/data/frames_golden.csv");
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

#[test]
fn valid_rotations_against_astropy() {
    let rows = golden_rows();
    assert_eq!(rows.len(), 60);
    let mut gmst = Agreement::new("Greenwich mean sidereal time 1982", "ERFA (astropy 8.0.2)", SAME_THEORY_RAD, "rad");
    let mut itrs = Agreement::new("TEME to ITRS", "astropy 8.0.2", SAME_THEORY_KM, "km");
    let mut gcrs = Agreement::new("TEME to GCRS", "astropy 8.0.2", SAME_THEORY_KM, "km");
    for row in &rows {
        let (day, fraction) = ut1_jd(row.epoch, row.parameters.ut1_minus_utc_s);
        gmst.add((sofars::erst::gmst82(day, fraction) - row.number("gmst82_rad")).sin().abs());
        let orientation = Orientation::from_parameters(row.epoch, &row.parameters);
        let satellite = Position::<Teme>::from_vector(row.vector("teme_", "km"));
        let computed: Position<Itrs> = orientation.itrs_to_teme.inverse() * satellite;
        itrs.add((computed.vector() - row.vector("itrs_", "km")).norm());
        let computed: Position<Gcrs> = orientation.teme_to_gcrs * satellite;
        gcrs.add((computed.vector() - row.vector("gcrs_", "km")).norm());
    }
}

#[test]
fn valid_observers_and_sun_against_astropy() {
    let mut place = Agreement::new("Sites in GCRS", "astropy 8.0.2", SAME_THEORY_KM, "km");
    let mut speed = Agreement::new("Velocity of sites in GCRS", "astropy 8.0.2", SAME_THEORY_KM_S, "km/s");
    let mut sun = Agreement::new("Position of the Sun", "astropy 8.0.2 (ERFA epv00)", SUN_TDB_KM, "km");
    let mut earth =
        Agreement::new("Velocity of the Earth", "astropy 8.0.2 (ERFA epv00)", EARTH_VELOCITY_TDB_KM_S, "km/s");
    for row in golden_rows() {
        let orientation = Orientation::from_parameters(row.epoch, &row.parameters);
        let state = observer(&row).state(&orientation);
        place.add((state.position.vector() - row.vector("site_", "km")).norm());
        speed.add((state.velocity.vector() - row.vector("site_v", "km_s")).norm());
        let computed = SunState::at(row.epoch);
        sun.add((computed.sun.vector() - row.vector("sun_", "km")).norm());
        earth.add((computed.earth_velocity.vector() - row.vector("earth_v", "km_s")).norm());
    }
}

/// Tolerance of apparent positions: the Sun deflects the light of stars at 30 degrees or more by up to 0.015".
const DEFLECTION_RAD: f64 = 0.016 * ARCSEC_RAD;

#[test]
fn valid_apparent_positions_of_stars_against_erfa() {
    let mut place = Agreement::new("Apparent places of stars, equinox of date", "ERFA", DEFLECTION_RAD, "rad");
    for row in golden_rows() {
        let star = Direction::<Gcrs>::from_lon_lat_rad(row.number("star_ra_rad"), row.number("star_dec_rad"));
        let velocity = SunState::at(row.epoch).earth_velocity;
        let computed = gcrs_to_of_date(row.epoch) * annual_aberration(&star, &velocity);
        let expected = Direction::from_lon_lat_rad(row.number("apparent_ra_rad"), row.number("apparent_dec_rad"));
        place.add(computed.separation_rad(&expected));
        let back = without_annual_aberration(&(gcrs_to_of_date(row.epoch).inverse() * computed), &velocity);
        assert!(back.separation_rad(&star) < 1e-14);
    }
}

#[test]
fn valid_frames_against_skyfield() {
    let mut gcrs = Agreement::new("TEME to GCRS", "Skyfield 1.55", SKYFIELD_ANGLE_RAD, "rad");
    let mut place = Agreement::new("Sites in GCRS (its UT1 is interpolated)", "Skyfield 1.55", SKYFIELD_SITE_KM, "km");
    let mut horizon = Agreement::new("Altitude and azimuth", "Skyfield 1.55", SKYFIELD_HORIZON_RAD, "rad");
    let mut sun = Agreement::new("Position of the Sun", "JPL DE421", DE421_SUN_KM, "km");
    let mut earth = Agreement::new("Velocity of the Earth", "JPL DE421", DE421_EARTH_VELOCITY_KM_S, "km/s");
    for row in golden_rows() {
        let orientation = Orientation::from_parameters(row.epoch, &row.parameters);
        let satellite = orientation.teme_to_gcrs * Position::<Teme>::from_vector(row.vector("teme_", "km"));
        gcrs.add((satellite.vector() - row.vector("skyfield_gcrs_", "km")).norm() / satellite.norm_km());
        let state = observer(&row).state(&orientation);
        place.add((state.position.vector() - row.vector("skyfield_site_", "km")).norm());
        let (altitude, azimuth) = state.altitude_azimuth_rad(&(satellite - state.position)).expect("not at the site");
        let expected =
            (row.number("skyfield_altitude_deg").to_radians(), row.number("skyfield_azimuth_deg").to_radians());
        horizon.add((altitude - expected.0).abs());
        horizon.add(((azimuth - expected.1).sin() * altitude.cos()).abs());
        let computed = SunState::at(row.epoch);
        sun.add((computed.sun.vector() - row.vector("de421_sun_", "km")).norm());
        earth.add((computed.earth_velocity.vector() - row.vector("de421_earth_v", "km_s")).norm());
    }
}

fn observer(row: &Row) -> Observer {
    let site = Site::new_deg("golden", row.number("latitude_deg"), row.number("longitude_deg"), row.number("height_m"));
    Observer::new(site.expect("a site"))
}

/// Tolerances of the bundled table: it has a row every three days and documented differences of at most 0.5 ms (0.2 m).
const EMBEDDED_UT1_S: f64 = 0.5e-3;
const EMBEDDED_SITE_KM: f64 = 0.25e-3;

#[test]
fn valid_embedded_table_against_astropy_and_interpolation() {
    let eop = EopTable::embedded();
    let mut ut1 = Agreement::new("Built-in UT1 - UTC", "IERS finals2000A (astropy)", EMBEDDED_UT1_S, "s");
    let mut place = Agreement::new("Sites, built-in UT1 and pole", "astropy 8.0.2", EMBEDDED_SITE_KM, "km");
    let mut interpolated =
        Agreement::new("Sites, orientation interpolated over a night", "orientation of each time", 1e-6, "km");
    let mut sun = Agreement::new("Sun, interpolated over a night", "astropy 8.0.2", 1e-9, "rad");
    for row in golden_rows() {
        assert!(eop.status(row.epoch).is_covered());
        ut1.add((eop.at(row.epoch).ut1_minus_utc_s - row.parameters.ut1_minus_utc_s).abs());
        let observer = observer(&row);
        let exact = observer.position(&Orientation::at(row.epoch, &eop));
        place.add((exact.vector() - row.vector("site_", "km")).norm());
        // Table of a night that began 9.3 hours before.
        let start = seconds_after(row.epoch, -33_480.0);
        let end = seconds_after(start, 50_000.0);
        let sampled = observer.position(&OrientationTable::new(start, end, &eop).at_s(33_480.0));
        interpolated.add((sampled.vector() - exact.vector()).norm());
        let computed = SunTable::new(start, end).at_s(33_480.0).sun;
        sun.add((computed.vector() - row.vector("sun_", "km")).norm() / AU_KM);
    }
}

#[test]
fn valid_finals2000a_against_astropy() {
    let Some(data) = crate::common::data_dir() else { return };
    let text = std::fs::read_to_string(data.join("aux").join("finals2000A.all")).expect("finals2000A.all");
    let table = EopTable::from_finals2000a(&text).expect("a table");
    assert_eq!(table.first().map(mjd_utc), Some(41_684.0));
    assert_eq!(table.last().map(mjd_utc), Some(61_707.0));
    println!("{}", table.describe());
    let rows = golden_rows();
    // astropy uses the final values of Bulletin B where available; those of Bulletin A differ by their errors.
    let mut ut1 = Agreement::new("UT1 - UTC of finals2000A", "astropy 8.0.2", 1e-4, "s");
    let mut pole = Agreement::new("Pole of finals2000A", "astropy 8.0.2", 5e-4, "arcsec");
    for row in &rows {
        let computed = table.at(row.epoch);
        ut1.add((computed.ut1_minus_utc_s - row.parameters.ut1_minus_utc_s).abs());
        pole.add((computed.xp_rad - row.parameters.xp_rad).abs() / ARCSEC_RAD);
        pole.add((computed.yp_rad - row.parameters.yp_rad).abs() / ARCSEC_RAD);
    }
    // Every day of the bundled table.
    let embedded = EopTable::embedded();
    let mut daily = Agreement::new("Built-in UT1 - UTC, every day since 2000", "IERS finals2000A", EMBEDDED_UT1_S, "s");
    let mut daily_pole = Agreement::new("Built-in pole, every day since 2000", "IERS finals2000A", 1.1e-3, "arcsec");
    for day in 51_544..=61_707 {
        let epoch = epoch_from_mjd(f64::from(day), TimeScale::UTC).expect("a day");
        let (computed, expected) = (embedded.at(epoch), table.at(epoch));
        daily.add((computed.ut1_minus_utc_s - expected.ut1_minus_utc_s).abs());
        daily_pole
            .add((computed.xp_rad - expected.xp_rad).abs().max((computed.yp_rad - expected.yp_rad).abs()) / ARCSEC_RAD);
        assert_eq!(
            matches!(embedded.status(epoch), EopStatus::Predicted),
            matches!(table.status(epoch), EopStatus::Predicted),
            "MJD {day}"
        );
    }
}

/// Tolerance of Vallado's example, whose components are printed to 10⁻⁸ km for a time with 10⁻¹⁰ days (4·10⁻⁸ km).
const VALLADO_KM: f64 = 1e-7;

#[test]
fn valid_teme_to_itrf_against_vallado() {
    let Some(data) = crate::common::data_dir() else { return };
    let path = data.join("reference").join("skyfield").join("vallado_appendix_c_teme_itrf.csv");
    let text = std::fs::read_to_string(path).expect("the example");
    let numbers = |frame: &str| -> Vec<f64> {
        let line = text.lines().find(|line| line.starts_with(frame)).expect(frame);
        line.split(',').skip(1).map(|field| field.parse().expect("a number")).collect()
    };
    let (teme, itrf) = (numbers("TEME"), numbers("ITRF"));
    // 07:51:28.386009 UTC minus 0.439961 s. The example gives UT1 as a Julian date in one f64, 2453101.8274067831,
    // which has a resolution of 40 µs (3 cm of rotation).
    let seconds_ut1 = (2_453_101.827_406_783 - 2_453_101.5) * DAY_S;
    let midnight: Epoch = "2004-04-06T00:00:00 UTC".parse().expect("an epoch");
    let epoch = seconds_after(midnight, seconds_ut1 + 0.439_961);
    let parameters = EarthOrientationParameters {
        ut1_minus_utc_s: -0.439961,
        xp_rad: -0.140682 * ARCSEC_RAD,
        yp_rad: 0.333309 * ARCSEC_RAD,
    };
    let to_itrs = Orientation::from_parameters(epoch, &parameters).itrs_to_teme.inverse();
    let place = to_itrs * Position::<Teme>::new(teme[0], teme[1], teme[2]);
    let expected = nalgebra::Vector3::new(itrf[0], itrf[1], itrf[2]);
    let mut example = Agreement::new("TEME to ITRF", "Vallado et al. (2006), appendix C", VALLADO_KM, "km");
    example.add((place.vector() - expected).norm());
}

/// Tolerances for Horizons, which uses another SGP4 and rounds the epoch of its element set to 10⁻⁸ days (1 ms, 8 m
/// along the track). The test of these rows in Skyfield allows 2 m.
const HORIZONS_ISS_KM: f64 = 2e-3;
const HORIZONS_ISS_KM_S: f64 = 2e-6;

#[test]
fn valid_iss_state_against_horizons() {
    let Some(data) = crate::common::data_dir() else { return };
    let path = data.join("reference").join("skyfield").join("iss_horizons_gcrs.csv");
    let text = std::fs::read_to_string(path).expect("the rows");
    let remarks = text.lines().filter_map(|line| line.strip_prefix("# "));
    let elements: Vec<&str> = remarks.filter(|line| line.starts_with(['1', '2'])).collect();
    let catalogue =
        Satellites::from_bytes("iss", elements.join("\n").as_bytes(), &ReadOptions::default()).expect("elements");
    let propagator = Propagator::new(&catalogue.element_sets[0]).expect("an orbit");
    let mut place = Agreement::new("Position of the ISS", "JPL Horizons", HORIZONS_ISS_KM, "km");
    let mut speed = Agreement::new("Velocity of the ISS", "JPL Horizons", HORIZONS_ISS_KM_S, "km/s");
    for (line, mjd) in text.lines().filter(|line| line.starts_with("2018")).zip([58_303.0, 58_304.0]) {
        let row: Vec<f64> = line.split(',').skip(1).map(|field| field.parse().expect("a number")).collect();
        let epoch = epoch_from_mjd(mjd, TimeScale::TDB).expect("a date");
        let orientation = Orientation::at(epoch, &EopTable::embedded());
        let state = propagator.state(epoch, &orientation.teme_to_gcrs).expect("a state");
        let expected = Position::<Gcrs>::new(row[0] * AU_KM, row[1] * AU_KM, row[2] * AU_KM);
        place.add((state.position - expected).norm_km());
        let expected = Velocity::<Gcrs>::new(row[3] * AU_KM / DAY_S, row[4] * AU_KM / DAY_S, row[5] * AU_KM / DAY_S);
        speed.add((state.velocity - expected).norm_km_s());
    }
}

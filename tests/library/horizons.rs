//! Astrometric directions compared with tables of JPL Horizons for Starlink element sets.

use crate::common::agreement::Agreement;
use std::collections::HashMap;
use std::f64::consts::PI;

use hifitime::Epoch;
use streakcast::constants::{AU_KM, SPEED_OF_LIGHT_KM_S};
use streakcast::elements::{ElementSet, ReadOptions, Satellites};
use streakcast::frames::{
    Direction, EopTable, Gcrs, OrientationTable, Position, Velocity, annual_aberration, parse_declination_deg,
    parse_right_ascension_deg, seconds_after, seconds_between,
};
use streakcast::geometry::{Observer, ObserverState, Site, SunTable, aspect};
use streakcast::orbit::{DragModel, Propagator};
use streakcast::passes::{ModelChoice, Sky};

const ARCSEC_RAD: f64 = PI / 648_000.0;

/// Largest median error, from the printed digits: right ascension 0.01 s (0.15"), declination 0.1". An error of 1 m
/// across the line of sight is 0.35" at 600 km.
const MEDIAN_ARCSEC: f64 = 0.3;
const WORST_ARCSEC: f64 = 1.0;
/// Tolerance of ranges, which are printed to 10⁻¹⁴ au (1.5 m); the position of the site has an error of a metre.
const RANGE_KM: f64 = 5e-3;
/// Relative tolerance of rates, printed in "/h with seven digits; those computed here are differences over a second on
/// an arc of ten minutes.
const RATE_RELATIVE: f64 = 2e-4;
const RANGE_RATE_KM_S: f64 = 2e-4;
/// Tolerance of azimuth and elevation, degrees: they are printed to 0.0001 degrees, and the choice of the pole for the
/// horizon has a similar effect (0.47" = 0.00013 degrees in July 2021).
const HORIZON_DEG: f64 = 3e-4;

/// A row of the file `dat`:
/// `NAME.txt: 2021-Jul-16 09:12:42.000 flags RA(3) Dec(3) dRA·cosDec dDec Az El dAz dEl LST(3) delta deldot S-O-T /r
/// S-T-O`.
struct Row {
    name: String,
    epoch: Epoch,
    direction: Direction<Gcrs>,
    rate_arcsec_h: [f64; 2],
    azimuth_deg: f64,
    elevation_deg: f64,
    range_km: f64,
    range_rate_km_s: f64,
    /// Rate of azimuth times the cosine of the elevation, and rate of elevation, arcseconds a minute.
    horizon_rate_arcsec_min: [f64; 2],
    elongation_deg: f64,
    phase_angle_deg: f64,
}

fn read_row(line: &str) -> Option<Row> {
    let (name, rest) = line.split_once(".txt:")?;
    let mut words = rest.split_whitespace();
    let (date, clock) = (words.next()?, words.next()?);
    let month = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let parts: Vec<&str> = date.split('-').collect();
    let month = month.iter().position(|known| *known == parts[1])? + 1;
    let epoch = format!("{}-{month:02}-{}T{clock} UTC", parts[0], parts[2]).parse().ok()?;
    // Flags for Sun and Moon may be between time and position.
    let words: Vec<&str> = words.skip_while(|word| word.parse::<f64>().is_err()).collect();
    let number = |index: usize| words.get(index).and_then(|word| word.parse::<f64>().ok());
    let right_ascension_deg = parse_right_ascension_deg(&words[0..3].join(":")).ok()?;
    let declination_deg = parse_declination_deg(&words[3..6].join(":")).ok()?;
    Some(Row {
        name: name.to_owned(),
        epoch,
        direction: Direction::from_lon_lat_rad(right_ascension_deg.to_radians(), declination_deg.to_radians()),
        rate_arcsec_h: [number(6)?, number(7)?],
        azimuth_deg: number(8)?,
        elevation_deg: number(9)?,
        range_km: number(15)? * AU_KM,
        range_rate_km_s: number(16)?,
        horizon_rate_arcsec_min: [number(10)?, number(11)?],
        elongation_deg: number(17)?,
        phase_angle_deg: number(19)?,
    })
}

struct Setting {
    rows: Vec<Row>,
    elements: HashMap<String, ElementSet>,
    observer: Observer,
    orientation: OrientationTable,
    sun: SunTable,
}

/// Direction of a satellite and its light path.
struct Sight {
    direction: Direction<Gcrs>,
    geometric: Position<Gcrs>,
    /// Distance from the observer at reception to the satellite at emission, in barycentric coordinates: delta in
    /// Horizons.
    light_path_km: f64,
    earth_velocity: Velocity<Gcrs>,
    observer: ObserverState,
}

fn setting(site: Site, eop: &EopTable) -> Option<Setting> {
    let folder = crate::common::data_dir()?.join("photometry").join("boley2021_plaskett");
    let text = std::fs::read_to_string(folder.join("dat")).expect("dat");
    let catalogue = Satellites::read(&[folder.join("starlink.15JUL2021")], &ReadOptions::default()).expect("elements");
    let elements: HashMap<String, ElementSet> =
        catalogue.element_sets.into_iter().map(|set| (set.name.to_string(), set)).collect();
    // The elements of a few rows, of OneWeb, are missing in the file.
    let rows = text.lines().filter(|line| !line.trim().is_empty()).map(|line| read_row(line).expect(line));
    let rows: Vec<Row> = rows.filter(|row| elements.contains_key(&row.name)).collect();
    assert!(rows.len() >= 400, "{}", rows.len());
    let start: Epoch = "2021-07-16T00:00:00 UTC".parse().expect("an epoch");
    let end = seconds_after(start, 2.0 * 86_400.0);
    let (orientation, sun) = (OrientationTable::new(start, end, eop), SunTable::new(start, end));
    Some(Setting { rows, elements, observer: Observer::new(site), orientation, sun })
}

impl Setting {
    fn seen(&self, name: &str, epoch: Epoch) -> Sight {
        let seconds = seconds_between(self.orientation.reference(), epoch);
        let orientation = self.orientation.at_s(seconds);
        let observer = self.observer.state(&orientation);
        let satellite =
            Propagator::new(&self.elements[name]).and_then(|p| p.state(epoch, &orientation.teme_to_gcrs)).expect(name);
        let earth_velocity = self.sun.at_s(seconds).earth_velocity;
        let aspect = aspect(&satellite.position, &satellite.velocity, &observer.position, &earth_velocity);
        let on_the_way = (satellite.velocity + earth_velocity).displacement(aspect.range_km / SPEED_OF_LIGHT_KM_S);
        let light_path_km = (aspect.geometric - on_the_way).norm_km();
        Sight { direction: aspect.direction, geometric: aspect.geometric, light_path_km, earth_velocity, observer }
    }

    /// Returns the median and the largest separation from the rows, arcseconds.
    fn separations_arcsec(&self, direction: impl Fn(&Sight) -> Direction<Gcrs>) -> (f64, f64) {
        summary(
            self.rows
                .iter()
                .map(|row| direction(&self.seen(&row.name, row.epoch)).separation_rad(&row.direction) / ARCSEC_RAD),
        )
    }
}

/// Returns the median and the largest value.
fn summary(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values[values.len() - 1])
}

/// Returns the bundled site of MPC 658 with complete Earth orientation.
fn full_setting() -> Option<Setting> {
    setting(Site::from_mpc("658").expect("the Dominion Astrophysical Observatory"), &EopTable::embedded())
}

#[test]
fn valid_directions_against_horizons() {
    let Some(setting) = full_setting() else { return };
    let mut directions = Agreement::new("Astrometric directions of Starlinks", "JPL Horizons", WORST_ARCSEC, "arcsec");
    let mut middle =
        Agreement::new("Astrometric directions of Starlinks, median", "JPL Horizons", MEDIAN_ARCSEC, "arcsec");
    for row in &setting.rows {
        directions.add(setting.seen(&row.name, row.epoch).direction.separation_rad(&row.direction) / ARCSEC_RAD);
    }
    middle.add(setting.separations_arcsec(|sight| sight.direction).0);
    // The light-time effect of the Earth's motion is significant: without it all directions differ by 20".
    let (plain, _) = setting.separations_arcsec(|sight| sight.geometric.direction().expect("not at the site"));
    assert!((15.0..30.0).contains(&plain), "{plain}");
}

/// Horizons applies polar motion. Its rows give the position 48.520031 N, 123.417137 W, 244.14 m for the pole at its
/// origin, and 48.519974 N, 123.417006 W, 244.16 m for the pole of July 2021 (0.235", 0.403"). The latter has the
/// longitude in the list of the Minor Planet Center, 236.5830, to half a metre. A site that was determined without
/// polar motion is displaced by the pole, here by 11.6 m or 3.6".
#[test]
fn valid_directions_without_polar_motion_from_the_displaced_site() {
    let site = Site::new_deg("658 displaced by the pole", 48.520_031, -123.417_137, 244.14).expect("a site");
    let Some(setting) = setting(site, &EopTable::embedded().without_polar_motion()) else { return };
    let (median, worst) = setting.separations_arcsec(|sight| sight.direction);
    println!("without polar motion: median {median:.3}\", worst {worst:.3}\"");
    assert!(median <= MEDIAN_ARCSEC, "{median}");
    assert!(worst <= WORST_ARCSEC, "{worst}");
}

#[test]
fn valid_ranges_and_rates_against_horizons() {
    let Some(setting) = full_setting() else { return };
    let ranges =
        summary(setting.rows.iter().map(|row| (setting.seen(&row.name, row.epoch).light_path_km - row.range_km).abs()));
    let steps: Vec<(&Row, Sight, Sight)> = setting
        .rows
        .iter()
        .map(|row| {
            let at = |seconds| setting.seen(&row.name, seconds_after(row.epoch, seconds));
            (row, at(-0.5), at(0.5))
        })
        .collect();
    let rates = summary(steps.iter().map(|(row, before, after)| {
        let computed = before.direction.separation_rad(&after.direction) / ARCSEC_RAD * 3600.0;
        (computed / row.rate_arcsec_h[0].hypot(row.rate_arcsec_h[1]) - 1.0).abs()
    }));
    let range_rates = summary(
        steps
            .iter()
            .map(|(row, before, after)| (after.light_path_km - before.light_path_km - row.range_rate_km_s).abs()),
    );
    println!("median and worst: range {ranges:?} km, rate {rates:?}, range rate {range_rates:?} km/s");
    Agreement::new("Ranges of Starlinks", "JPL Horizons", RANGE_KM, "km").add(ranges.1);
    assert!(rates.1 <= RATE_RELATIVE);
    Agreement::new("Range rates of Starlinks", "JPL Horizons", RANGE_RATE_KM_S, "km/s").add(range_rates.1);
}

/// Azimuth and elevation of Horizons are apparent, without refraction: the astrometric direction with the aberration by
/// the orbital motion and the rotation of the Earth.
#[test]
fn valid_apparent_horizon_against_horizons() {
    let Some(setting) = full_setting() else { return };
    let (median, worst) = summary(setting.rows.iter().map(|row| {
        let sight = setting.seen(&row.name, row.epoch);
        let velocity = sight.earth_velocity + sight.observer.velocity;
        let computed = sight.observer.horizon * annual_aberration(&sight.direction, &velocity);
        let expected = Direction::from_lon_lat_rad(row.azimuth_deg.to_radians(), row.elevation_deg.to_radians());
        computed.separation_rad(&expected).to_degrees()
    }));
    println!("apparent azimuth and elevation: median {median:.1e} deg, worst {worst:.1e} deg");
    assert!(worst <= HORIZON_DEG, "{worst}");
    // The geometric values of this library differ by the motion of the satellite during the light time.
    let (_, worst) = summary(setting.rows.iter().map(|row| {
        let sight = setting.seen(&row.name, row.epoch);
        let (altitude, azimuth) = sight.observer.altitude_azimuth_rad(&sight.geometric).expect("not at the site");
        let expected: Direction<Gcrs> =
            Direction::from_lon_lat_rad(row.azimuth_deg.to_radians(), row.elevation_deg.to_radians());
        Direction::from_lon_lat_rad(azimuth, altitude).separation_rad(&expected).to_degrees()
    }));
    println!("geometric azimuth and altitude: worst {worst:.1e} deg");
    assert!(worst < 0.002, "{worst}");
}

/// Range and range rate of Horizons are those of the light path, from the barycentric position of the site at reception
/// to the satellite at emission: they differ from those at reception by up to (8 + 30) km/s times 4 ms.
const LIGHT_PATH_KM: f64 = 0.2;
/// Tolerance of the range rate: 0.2 km, rotating at up to 0.02 rad/s.
const LIGHT_PATH_RATE_KM_S: f64 = 4e-3;
/// Relative tolerance of the rates of azimuth and elevation, which are apparent in Horizons: aberration of 20" changes
/// with the direction.
const HORIZON_RATE_RELATIVE: f64 = 5e-4;
/// Tolerance of angles to the Sun: aberration of 20" at satellite or observer, and rounding to 0.0001 degrees.
const SUN_ANGLE_DEG: f64 = 0.012;

#[test]
fn valid_ephemeris_against_horizons() {
    let Some(setting) = full_setting() else { return };
    let sets: Vec<ElementSet> = setting.elements.values().cloned().collect();
    let sky = Sky::with_models(sets, setting.observer.clone(), EopTable::embedded(), &ModelChoice::default())
        .with_drag(DragModel::Published);
    let by_name: HashMap<&str, usize> =
        sky.elements().iter().enumerate().map(|(index, set)| (set.name.as_ref(), index)).collect();
    let authority = "JPL Horizons";
    let mut direction = Agreement::new("Ephemeris of Starlinks: directions", authority, WORST_ARCSEC, "arcsec");
    let mut rate = Agreement::new("Ephemeris of Starlinks: rates, relative", authority, RATE_RELATIVE, "");
    let mut horizon = Agreement::new("Ephemeris of Starlinks: altitude and azimuth", authority, 0.002, "deg");
    let mut turning =
        Agreement::new("Ephemeris of Starlinks: horizontal rates, relative", authority, HORIZON_RATE_RELATIVE, "");
    let mut range = Agreement::new("Ephemeris of Starlinks: ranges", authority, LIGHT_PATH_KM, "km");
    let mut range_rate = Agreement::new("Ephemeris of Starlinks: range rates", authority, LIGHT_PATH_RATE_KM_S, "km/s");
    let mut sun = Agreement::new("Ephemeris of Starlinks: phase and elongation", authority, SUN_ANGLE_DEG, "deg");
    for row in &setting.rows {
        let (points, _) = sky.ephemeris(&[by_name[row.name.as_str()]], &[row.epoch], None).expect("a place");
        let [place] = points.as_slice() else { panic!("{} places", points.len()) };
        direction.add(place.point.direction.separation_rad(&row.direction) / ARCSEC_RAD);
        let per_hour = 3600.0 / ARCSEC_RAD;
        let [ra, dec] = row.rate_arcsec_h;
        let computed = place.ra_cos_dec_rate_rad_s.hypot(place.dec_rate_rad_s) * per_hour;
        // Both components are of date in Horizons; near the pole, precession rotates them by degrees.
        rate.add((computed / ra.hypot(dec) - 1.0).abs());
        let expected =
            Direction::<Gcrs>::from_lon_lat_rad(row.azimuth_deg.to_radians(), row.elevation_deg.to_radians());
        let (altitude, azimuth) = (place.point.altitude_rad.expect("a site"), place.point.azimuth_rad.expect("a site"));
        horizon.add(Direction::from_lon_lat_rad(azimuth, altitude).separation_rad(&expected).to_degrees());
        let [azimuth_rate, altitude_rate] = row.horizon_rate_arcsec_min;
        let per_minute = 60.0 / ARCSEC_RAD;
        let computed = [place.azimuth_cos_altitude_rate_rad_s, place.altitude_rate_rad_s];
        let [computed_azimuth, computed_altitude] = computed.map(|rate| rate.expect("a site") * per_minute);
        turning.add((computed_azimuth.hypot(computed_altitude) / azimuth_rate.hypot(altitude_rate) - 1.0).abs());
        range.add((place.point.range_km - row.range_km).abs());
        range_rate.add((place.range_rate_km_s - row.range_rate_km_s).abs());
        sun.add((place.point.geometry.phase_angle_rad().to_degrees() - row.phase_angle_deg).abs());
        sun.add((place.elongation_rad.to_degrees() - row.elongation_deg).abs());
    }
}

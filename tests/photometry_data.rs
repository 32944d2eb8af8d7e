//! Shipped models against public photometry: Pomenis, Slingshot and MMT-9. Left out, loudly, without the data folder.

mod common;

use std::io::Read;
use std::path::Path;
use std::str::FromStr;

use hifitime::Epoch;
use nalgebra::Vector3;
use streakcast::frames::{EopTable, Gcrs, Itrs, Orientation, Position};
use streakcast::geometry::{Site, SunState, ViewingGeometry};
use streakcast::photometry::{BrightnessModel, Magnitude, ModelLibrary};

/// Offset, scatter and root mean square of measured minus computed, mag.
#[derive(Debug)]
struct Residuals {
    n: usize,
    mean: f64,
    scatter: f64,
    rms: f64,
    /// 1.4826 times the median absolute deviation.
    core: f64,
}

impl Residuals {
    fn of(name: &str, mut values: Vec<f64>) -> Self {
        let n = values.len();
        let mean = values.iter().sum::<f64>() / n as f64;
        let rms = (values.iter().map(|x| x * x).sum::<f64>() / n as f64).sqrt();
        let median = |v: &mut Vec<f64>| {
            v.sort_by(f64::total_cmp);
            v[v.len() / 2]
        };
        let middle = median(&mut values);
        let mut apart: Vec<f64> = values.iter().map(|x| (x - middle).abs()).collect();
        let residuals =
            Self { n, mean, scatter: (rms * rms - mean * mean).sqrt(), rms, core: 1.4826 * median(&mut apart) };
        println!("{name}: {residuals:.3?}");
        residuals
    }
}

/// Text of a file, unpacked if it is packed.
fn text_of(path: &Path) -> String {
    let bytes = std::fs::read(path).unwrap();
    let mut text = String::new();
    if path.extension().is_some_and(|e| e == "gz") {
        flate2::read::GzDecoder::new(&bytes[..]).read_to_string(&mut text).unwrap();
    } else {
        text = String::from_utf8(bytes).unwrap();
    }
    text
}

/// The rows of a CSV file with `#` lines before it, as (column by name) lookups.
fn rows(path: &Path, columns: &[&str]) -> Vec<Vec<String>> {
    let text = text_of(path);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.trim_start().as_bytes());
    let headers = reader.headers().unwrap().clone();
    let places: Vec<usize> = columns
        .iter()
        .map(|c| headers.iter().position(|h| h.trim() == *c).unwrap_or_else(|| panic!("no {c}")))
        .collect();
    reader.records().map(|r| r.unwrap()).map(|r| places.iter().map(|&i| r[i].to_owned()).collect()).collect()
}

/// How far along a line of sight a satellite of this height (above a sphere about the geocentre through the site)
/// is, km.
fn range_to_height(site: &Vector3<f64>, sight: &Vector3<f64>, height_km: f64) -> f64 {
    let (site_km, rise) = (site.norm(), site.dot(sight));
    let radius = site_km + height_km;
    -rise + (rise * rise + radius * radius - site_km * site_km).sqrt()
}

/// Measured magnitude brought to 1000 km, and the geometry it was measured in.
fn pomenis(data: &Path) -> Vec<(f64, ViewingGeometry)> {
    let site = Site::new_deg("Pomenis", 32.4434, -110.7881, 2790.0).unwrap();
    let eop = EopTable::none();
    rows(
        &data.join("photometry/pomenis/pomenis_observations.csv"),
        &["observation_time", "satellite_height", "satellite_altitude", "satellite_azimuth", "ab_magnitude"],
    )
    .iter()
    .map(|row| {
        let epoch = Epoch::from_str(&format!("{} UTC", row[0])).unwrap();
        let [height_km, altitude, azimuth, measured] = [1, 2, 3, 4].map(|i| row[i].parse::<f64>().unwrap());
        let orientation = Orientation::at(epoch, &eop);
        let (alt, az) = (altitude.to_radians(), azimuth.to_radians());
        let sight = streakcast::frames::Direction::from_vector(Vector3::new(
            alt.cos() * az.cos(),
            alt.cos() * az.sin(),
            alt.sin(),
        ));
        let sight_itrs = site.horizon().inverse() * sight;
        let observer: Position<Itrs> = site.itrs();
        let range_km = range_to_height(observer.vector(), sight_itrs.vector(), height_km);
        let satellite = observer + sight_itrs.at_range(range_km);
        let [satellite, observer]: [Position<Gcrs>; 2] = [satellite, observer].map(|p| orientation.itrs_to_gcrs * p);
        let geometry = ViewingGeometry::new(&satellite, &observer, &SunState::at(epoch).sun).unwrap();
        (Magnitude(measured).to_standard(range_km).0, geometry)
    })
    .collect()
}

fn against(model: &BrightnessModel, points: &[(f64, ViewingGeometry)]) -> Vec<f64> {
    points.iter().filter_map(|(measured, geometry)| Some(measured - model.standard_magnitude(geometry)?.0)).collect()
}

#[test]
fn valid_starlink_v15_against_pomenis() {
    let Some(data) = common::data_dir() else { return };
    let points = pomenis(&data);
    assert_eq!(points.len(), 920);
    let library = ModelLibrary::embedded();
    let model = library.get("starlink-v1.5").unwrap();
    let brdf = Residuals::of("Pomenis, starlink-v1.5", against(&model, &points));
    assert_eq!(brdf.n, 920, "every point is lit and seen in the model");
    // The feasibility fit states RMS 0.668 and core 0.386 on the full set of 1173 points; the folder holds 920 of them.
    const RMS_TOLERANCE_MAG: f64 = 0.02;
    assert!((brdf.rms - 0.668).abs() < RMS_TOLERANCE_MAG && (brdf.core - 0.386).abs() < RMS_TOLERANCE_MAG);
    assert!(brdf.mean.abs() < 0.05);
    // The sigma that the file states is the scatter of single points.
    assert!((model.file().unwrap().sigma_mag - brdf.rms).abs() < 0.05);
    // Nearly all of the points it was fitted to lie in the range that it states.
    let inside = points.iter().filter(|(_, geometry)| model.covers(geometry)).count();
    assert!(inside > 890, "{inside}");
    let phase = library.get("starlink-v1.5-phase").unwrap();
    let published = Residuals::of("Pomenis, starlink-v1.5-phase", against(&phase, &points));
    assert!((phase.file().unwrap().sigma_mag - published.rms).abs() < 0.05);
    assert!(brdf.rms < published.rms, "the panels explain more than the phase alone");
}

#[test]
fn valid_v2mini_phase_function_against_slingshot() {
    let Some(data) = common::data_dir() else { return };
    let library = ModelLibrary::embedded();
    let model = library.get("v2mini").unwrap();
    let site = Vector3::new(6371.0, 0.0, 0.0);
    let points: Vec<(f64, ViewingGeometry)> = rows(
        &data.join("photometry/slingshot_v2/Observations_in_field.csv"),
        &["sun altitude", "sat altitude", "sat height", "measured_ab", "az diff"],
    )
    .iter()
    .map(|row| {
        let [sun, altitude, height_m, measured, azimuth] = [0, 1, 2, 3, 4].map(|i| row[i].parse::<f64>().unwrap());
        // Up is x; azimuths count from the Sun's.
        let towards = |altitude: f64, azimuth: f64| {
            let (alt, az) = (altitude.to_radians(), azimuth.to_radians());
            Vector3::new(alt.sin(), alt.cos() * az.cos(), alt.cos() * az.sin())
        };
        let sight = towards(altitude, azimuth);
        let range_km = range_to_height(&site, &sight, height_m / 1000.0);
        let [satellite, observer, sun] =
            [site + sight * range_km, site, towards(sun, 0.0) * 149_597_870.7].map(Position::<Gcrs>::from_vector);
        (Magnitude(measured).to_standard(range_km).0, ViewingGeometry::new(&satellite, &observer, &sun).unwrap())
    })
    .collect();
    let residuals = Residuals::of("Slingshot, v2mini", against(&model, &points));
    assert_eq!(residuals.n, 1232);
    // Published function, other instrument, no fit: what the file states as its sigma.
    assert!((model.file().unwrap().sigma_mag - residuals.rms).abs() < 0.05 && residuals.mean.abs() < 0.3);
}

/// Magnitudes at 1000 km and phase angles (rad) of clear-filter MMT-9 rows out of the penumbra.
fn mmt9(data: &Path, file: &str) -> Vec<(f64, f64)> {
    rows(&data.join("derived").join(file), &["Mag", "Filter", "Penumbra", "Distance", "Phase"])
        .iter()
        .filter(|row| row[1] == "Clear" && row[2] == "0")
        .map(|row| {
            let [mag, distance_km, phase_deg] = [0, 3, 4].map(|i| row[i].parse::<f64>().unwrap());
            (Magnitude(mag).to_standard(distance_km).0, phase_deg.to_radians())
        })
        .collect()
}

#[test]
fn valid_visorsat_and_oneweb_against_mmt9() {
    let Some(data) = common::data_dir() else { return };
    let library = ModelLibrary::embedded();
    for (file, name, n) in
        [("mmt9_starlink_visorsat.csv.gz", "visorsat", 12_633), ("mmt9_oneweb.csv.gz", "oneweb", 57_436)]
    {
        let model = library.get(name).unwrap();
        let residuals: Vec<f64> = mmt9(&data, file)
            .into_iter()
            .map(|(measured, phase)| {
                // Sun on the chassis plane and observer in its half plane: the phase angle is the observer's
                // latitude, turned over the zenith past 90°.
                let (longitude, latitude) = if phase <= std::f64::consts::FRAC_PI_2 {
                    (0.0, -phase)
                } else {
                    (std::f64::consts::PI, phase - std::f64::consts::PI)
                };
                let geometry = ViewingGeometry::from_angles(0.0, longitude, latitude, 1000.0, 550.0).unwrap();
                measured - model.standard_magnitude(&geometry).unwrap().0
            })
            .collect();
        let residuals = Residuals::of(&format!("MMT-9, {name}"), residuals);
        assert_eq!(residuals.n, n);
        assert!(residuals.mean.abs() < 0.1, "{name}");
        let stated = model.file().unwrap().sigma_mag;
        assert!((stated - residuals.rms).abs() < 0.1, "{name}: stated {stated}, found {}", residuals.rms);
        assert!(residuals.scatter >= residuals.core);
    }
}

#[test]
fn valid_amateurs_table_is_read_whole_and_carries_the_priors() {
    let Some(data) = common::data_dir() else { return };
    let bytes = std::fs::read(data.join("metadata/qs.mag")).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let table = streakcast::photometry::StandardMagnitudes::from_qs_mag(&text).unwrap();
    println!("{} objects", table.len());
    assert!((4000..4300).contains(&table.len()));
    // Names with "Rk" are rocket bodies, with "Deb" debris; the rest is taken for payloads.
    let mut sums = [(0usize, 0.0, 0.0); 2];
    for line in text.lines() {
        let (Some(id), Some(name)) = (line.get(0..5).and_then(|id| id.trim().parse().ok()), line.get(18..33)) else {
            continue;
        };
        let Some(magnitude) = table.get(id) else { continue };
        if name.contains("Deb") || name.contains(" Db") {
            continue;
        }
        let (n, sum, squares) = &mut sums[usize::from(name.contains("Rk"))];
        *n += 1;
        *sum += magnitude.0;
        *squares += magnitude.0 * magnitude.0;
    }
    let library = ModelLibrary::embedded();
    for ((n, sum, squares), name) in sums.into_iter().zip(["unknown", "rocket-body"]) {
        let mean = sum / n as f64;
        let scatter = (squares / n as f64 - mean * mean).sqrt();
        println!("{name}: {n} objects, mean {mean:.2}, scatter {scatter:.2}");
        let stated = library.get(name).unwrap();
        let file = stated.file().unwrap();
        assert!((file.mean_mag.unwrap() - mean).abs() < 0.1 && (file.sigma_mag - scatter).abs() < 0.1, "{name}");
    }
}

//! Times of entry and exit of the geometric shadow, compared with a cone and with rays past the ellipsoid, and light
//! behind the atmosphere compared with traced rays.

use crate::common::agreement::Agreement;
use std::collections::BTreeSet;

use hifitime::Epoch;
use streakcast::elements::{NoradId, ReadOptions, Satellites};
use streakcast::frames::{EopTable, Gcrs, OrientationTable, Position, seconds_after};
use streakcast::geometry::{Illumination, ShadowModel, SunTable};
use streakcast::orbit::Propagator;

/// Tolerance of times, seconds: the positions of Sun and Earth differ (epv00 and DE421, 11 km), times are bisected to
/// 0.1 ms, and high orbits along the edge of the shadow have the largest differences.
const MOMENT_S: f64 = 0.02;

/// Returns the angles between the edge of a spherical Earth and the near and far edge of the Sun, radians, negative in
/// the penumbra and umbra. The formula is that of the golden cone; the positions are those of this library.
fn cone(satellite: &Position<Gcrs>, sun: &Position<Gcrs>) -> [f64; 2] {
    let to_sun = *sun - *satellite;
    let (r, d) = (satellite.norm_km(), to_sun.norm_km());
    let cosine = -satellite.vector().dot(to_sun.vector()) / (r * d);
    let (angle, earth, disk) = (cosine.acos(), (6378.137 / r).asin(), (695_700.0 / d).asin());
    [angle - earth - disk, angle - earth + disk]
}

/// Tolerance of the light behind the atmosphere against traced rays, as a fraction of the Sun's light (0.001 mag in
/// full light). It was chosen before the comparison.
const LIGHT: f64 = 1e-3;

/// Rays through the standard atmosphere, traced step by step; `tests/reference/make_atmosphere_goldens.py`.
#[test]
fn valid_light_behind_the_atmosphere_against_traced_rays() {
    let text =
        std::fs::read_to_string(crate::common::golden_dir().join("atmosphere_golden.csv")).expect("the golden numbers");
    let sun = Position::<Gcrs>::new(streakcast::constants::AU_KM, 0.0, 0.0);
    let mut light = Agreement::new("Sunlight through the atmosphere", "traced rays", LIGHT, "");
    let mut compared = 0;
    for line in text.lines().skip(2) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let [radius_km, height_km, expected] = cells[..] else { panic!("{line}") };
        let (sin, cos) = ((6378.137 + height_km) / radius_km).asin().sin_cos();
        let satellite = Position::<Gcrs>::new(-radius_km * cos, radius_km * sin, 0.0);
        match ShadowModel::Atmosphere.illumination(&satellite, &sun) {
            Illumination::Penumbra { lit_fraction } => {
                light.add(lit_fraction - expected);
                compared += 1;
            }
            Illumination::Umbra => assert!(expected < 0.01 + LIGHT, "{line}"),
            Illumination::Sunlit => assert!(expected > 0.99 - LIGHT, "{line}"),
        }
    }
    assert!(compared > 25, "{compared}");
}

#[test]
fn valid_shadow_moments_against_skyfield() {
    let Some(data) = crate::common::data_dir() else { return };
    let path = data.join("tle/active/active_2026-04-25.txt");
    let sets = Satellites::read(&[path], &ReadOptions::default()).expect("the catalogue reads").element_sets;
    let eop = EopTable::embedded();
    let (mut satellites, mut rows) = (BTreeSet::new(), 0);
    let mut kinds_apart_s = 0.0_f64;
    let mut of_ellipsoid =
        Agreement::new("Entry into and exit from the shadow, ellipsoid", "Skyfield 1.55", MOMENT_S, "s");
    let mut of_cone = Agreement::new("Entry into and exit from the shadow, cone", "Skyfield 1.55", MOMENT_S, "s");
    let text =
        std::fs::read_to_string(crate::common::golden_dir().join("shadow_golden.csv")).expect("the golden numbers");
    for line in text.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let id = NoradId(cells[0].parse().expect("an id"));
        let propagator = Propagator::new(sets.iter().find(|set| set.norad_id == id).expect("known")).expect("an orbit");
        let (umbra, entering) = (cells[1] == "umbra", cells[2] == "entry");
        let start: Epoch = format!("{} UTC", cells[3]).parse().expect("an epoch");
        let [by_cone_s, by_ellipsoid_s]: [f64; 2] = [4, 5].map(|cell: usize| cells[cell].parse().expect("seconds"));
        let end = seconds_after(start, by_cone_s.max(by_ellipsoid_s) + 100.0);
        let (orientation, sun) = (OrientationTable::new(start, end, &eop), SunTable::new(start, end));
        let state = |seconds: f64| {
            let place = propagator.state(seconds_after(start, seconds), &orientation.at_s(seconds).teme_to_gcrs);
            (place.expect("a state").position, sun.at_s(seconds).sun)
        };
        let is_in = |seconds: f64| {
            let (place, sun) = state(seconds);
            match ShadowModel::Geometric.illumination(&place, &sun) {
                Illumination::Sunlit => false,
                Illumination::Penumbra { .. } => !umbra,
                Illumination::Umbra => true,
            }
        };
        let is_in_cone = |seconds: f64| {
            let (place, sun) = state(seconds);
            cone(&place, &sun)[usize::from(umbra)] < 0.0
        };
        // Bisected within half a minute of the golden time.
        let moment = |near_s: f64, is_in: &dyn Fn(f64) -> bool| {
            let (mut low, mut high) = (near_s - 30.0, near_s + 30.0);
            assert!(is_in(low) != entering && is_in(high) == entering, "{line}");
            while high - low > 1e-4 {
                let middle = 0.5 * (low + high);
                if is_in(middle) == entering { high = middle } else { low = middle }
            }
            0.5 * (low + high)
        };
        of_ellipsoid.add(moment(by_ellipsoid_s, &is_in) - by_ellipsoid_s);
        of_cone.add(moment(by_cone_s, &is_in_cone) - by_cone_s);
        kinds_apart_s = kinds_apart_s.max((by_cone_s - by_ellipsoid_s).abs());
        satellites.insert(id.0);
        rows += 1;
    }
    println!(
        "{} satellites, {rows} moments; cone and ellipsoid lie up to {kinds_apart_s:.1} s apart",
        satellites.len()
    );
    assert!(satellites.len() == 56 && rows == 458, "{} {rows}", satellites.len());
}

//! One sigma of an element set contains 68 % of the measured errors of element sets.

use streakcast::orbit::{OrbitClass, OrbitKind, OrbitUncertainty, uncertainty};

/// Expected fraction of residuals within one sigma, and its tolerance for a class: half of the objects (those of the
/// golden file) were not used in the fit, and classes contain quiet and active satellites.
const SHARE: f64 = 0.6827;
const SHARE_TOLERANCE: f64 = 0.10;

struct Residual {
    kind: OrbitKind,
    sigma: OrbitUncertainty,
    floor: OrbitUncertainty,
    along_track_s: f64,
    out_of_plane_km: f64,
    radial_km: f64,
}

fn kind(name: &str) -> OrbitKind {
    match name {
        "OnStation" => OrbitKind::OnStation,
        "Manoeuvring" => OrbitKind::Manoeuvring,
        "LowEarth" => OrbitKind::LowEarth,
        "MediumEarth" => OrbitKind::MediumEarth,
        "Geosynchronous" => OrbitKind::Geosynchronous,
        "Eccentric" => OrbitKind::Eccentric,
        other => panic!("unknown kind {other}"),
    }
}

fn residuals() -> Vec<Residual> {
    let text =
        std::fs::read_to_string(crate::common::golden_dir().join("orbit_residuals.csv")).expect("the golden file");
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |cell: usize| cells[cell].parse::<f64>().expect("a number");
            let class = OrbitClass::new(kind(cells[0]), 1_440.0 / number(2), number(1));
            Residual {
                kind: class.kind,
                sigma: uncertainty(class, number(3)),
                floor: uncertainty(class, 0.0),
                along_track_s: number(4),
                out_of_plane_km: number(5),
                radial_km: number(6),
            }
        })
        .collect()
}

fn share(inside: impl Iterator<Item = bool>) -> (f64, usize) {
    let (yes, all) = inside.fold((0, 0), |(yes, all), inside| (yes + usize::from(inside), all + 1));
    (yes as f64 / all as f64, all)
}

const KINDS: [OrbitKind; 6] = [
    OrbitKind::OnStation,
    OrbitKind::Manoeuvring,
    OrbitKind::LowEarth,
    OrbitKind::MediumEarth,
    OrbitKind::Geosynchronous,
    OrbitKind::Eccentric,
];

/// Only residuals are used for which the floor is less than half of sigma. The floor is the error at epoch, which is
/// not visible because successive element sets share observations.
#[test]
fn valid_one_sigma_along_the_track_contains_68_percent_of_held_out_residuals() {
    let residuals = residuals();
    for kind in KINDS {
        let grown = residuals.iter().filter(|r| r.kind == kind && r.sigma.along_track_s > 2.0 * r.floor.along_track_s);
        let (share, number) = share(grown.map(|r| r.along_track_s.abs() <= r.sigma.along_track_s));
        println!("{kind:?}: {share:.3} of {number} along the track");
        assert!(number >= 80, "{kind:?}: only {number} residuals");
        assert!((share - SHARE).abs() <= SHARE_TOLERANCE, "{kind:?}: {share:.3} of {number}");
    }
}

#[test]
fn valid_one_sigma_across_the_track_contains_68_percent_of_held_out_residuals() {
    let residuals = residuals();
    for kind in KINDS {
        let both = residuals
            .iter()
            .filter(|r| r.kind == kind)
            .flat_map(|r| [r.out_of_plane_km, r.radial_km].map(|across_km| across_km.abs() <= r.sigma.cross_track_km));
        let (share, number) = share(both);
        println!("{kind:?}: {share:.3} of {number} across the track");
        assert!(number >= 160, "{kind:?}: only {number} residuals");
        assert!((share - SHARE).abs() <= SHARE_TOLERANCE, "{kind:?}: {share:.3} of {number}");
    }
}

//! Observed streak of Starlink-1102 in an exposure of the Dark Energy Camera, compared with the track from element
//! sets.

use hifitime::Epoch;
use nalgebra::Vector3;
use streakcast::elements::{ElementSet, ReadOptions, Satellites};
use streakcast::frames::{Direction, EopTable, Gcrs, seconds_between};
use streakcast::geometry::{Observer, Site};
use streakcast::images::{CountBasis, FrameFile, PixelPosition, Wcs};
use streakcast::passes::{Exposure, ModelChoice, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::streaks::{
    FrameOverrides, Modulation, SatelliteLight, SkyPoint, SkyTrack, TargetFrame, Tracking, satellites,
};

const FRAME: &str = "frames/trailblazer/cutout_c4d_200306_000415_ori.fits.fz";
/// Catalogue number of STARLINK-1102.
const NORAD: u32 = 44920;

/// Ends of the streak in the cutout of chip S28, pixels counted from 0: the line with the largest mean pixel value,
/// after subtraction of the gradient along columns, on a grid of half a pixel.
const SEEN: [PixelPosition; 2] = [PixelPosition { x: 0.0, y: 67.5 }, PixelPosition { x: 70.0, y: -3.0 }];

fn track(elements: &ElementSet, exposure: &Exposure, radius_deg: f64) -> Option<SkyTrack> {
    let site = Site::from_mpc("W84").unwrap();
    let choice = ModelChoice::new(&ModelLibrary::embedded()).unwrap();
    let eop = EopTable::embedded();
    let sky = Sky::with_models(vec![elements.clone()], Observer::new(site), eop.clone(), &choice);
    let light = SatelliteLight {
        photometry: &PhotometryOptions::default(),
        modulation: &Modulation::default(),
        resolve_panels: false,
        tracking: &Tracking::Sidereal,
        size_m: None,
    };
    let found = satellites(&sky, &eop, exposure, radius_deg.to_radians(), &light).unwrap();
    found.sources.into_iter().next().map(|source| source.parts[0].track.clone())
}

#[test]
fn valid_starlink_1102_crosses_the_decam_exposure_as_observed() {
    let Some(folder) = crate::common::data_dir() else { return };
    let frame = FrameFile::open(&folder.join(FRAME)).unwrap();
    let chip = frame.hdus().iter().find(|hdu| hdu.name == "S28").unwrap();
    let wcs = Wcs::from_header(frame.header(chip.index).unwrap()).unwrap();
    let seen = SEEN.map(|end| wcs.to_sky(end).unwrap());
    let exposure = Exposure {
        id: "941420".to_owned(),
        start: "2020-03-06T00:04:15.410235 UTC".parse::<Epoch>().unwrap(),
        duration_s: 120.0,
        pointing: seen[0],
        rotation_rad: 0.0,
    };
    // The header has the position of the instrument. That of the observatory is 70 m away, which is 11" at this
    // satellite.
    let overrides = FrameOverrides { zero_point: Some((30.0, CountBasis::Frame)), ..FrameOverrides::default() };
    let frame = TargetFrame::open(&folder.join(FRAME), &overrides).unwrap();
    let site = frame.site().unwrap().unwrap().site;
    assert_eq!(site.mpc_code.as_deref(), Some("W84"));
    // Elements 11.5 days old, and 9.5 days old during a manoeuvre: distance of the track from the streak, arcmin, and
    // radius of a field that the track just crosses (it deviates from a great circle by 3" in one degree). The error of
    // the measured streak is half a pixel, 0.002'.
    for (file, age_days, beside_arcmin, radius_deg) in [
        ("supgp/starlink_supgp_2020-02-23.tle", 11.48, 0.456, 0.03),
        ("supgp/starlink_supgp_2020-02-25.tle", 9.48, 27.04, 0.47),
    ] {
        let catalogue = Satellites::read(&[folder.join("tle").join(file)], &ReadOptions::default()).unwrap();
        let elements = catalogue.element_sets.iter().find(|one| one.norad_id.0 == NORAD).unwrap();
        assert!((seconds_between(elements.epoch, exposure.start) / 86_400.0 - age_days).abs() < 0.01, "{file}");
        let track = track(elements, &exposure, radius_deg).expect("the satellite crosses the field");
        // Great circle through the two points of the track that are nearest to the streak.
        let away = |pair: &[SkyPoint]| pair[0].direction.separation_rad(&seen[0]);
        let near = track.points.windows(2).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
        let [from, to] = [near[0].direction, near[1].direction];
        let pole: Vector3<f64> = from.vector().cross(to.vector()).normalize();
        let beside = |place: &Direction<Gcrs>| (place.vector().dot(&pole).asin().to_degrees() * 60.0).abs();
        for place in &seen {
            assert!((beside(place) - beside_arcmin).abs() < 0.01, "{file}: {:.3}'", beside(place));
        }
        // The ends are measured to half a pixel, and are 70 pixels apart: 0.4 degrees.
        let turned = (from.position_angle_rad(&to) - seen[1].position_angle_rad(&seen[0])).to_degrees();
        assert!(turned.abs() < 0.4, "{file}: {turned:.3} deg");
        // Chip S28 has 9' by 18', and the streak crosses all of it. A track 0.5' beside the streak is on the chip
        // during the exposure.
        assert!((0.0..120.0).contains(&near[0].time_s));
    }
}

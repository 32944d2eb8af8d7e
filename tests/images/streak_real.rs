//! An observed streak: Starlink-1102 in an exposure of the Dark Energy Camera, compared with the track from element sets.

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
/// STARLINK-1102.
const NORAD: u32 = 44920;

/// The streak in the cutout of chip S28: the line with the brightest mean of the pixels after subtraction of the columns'
/// gradient (counted from 0; found on a grid of half a pixel).
const SEEN: [PixelPosition; 2] = [PixelPosition { x: 0.0, y: 67.5 }, PixelPosition { x: 70.0, y: -3.0 }];

fn track(elements: &ElementSet, exposure: &Exposure, radius_deg: f64) -> Option<SkyTrack> {
    let site = Site::from_mpc("W84").unwrap();
    let choice = ModelChoice::new(&ModelLibrary::embedded()).unwrap();
    // As on the command line without an EOP table: with polar motion, 12 m there, the streak is 3" nearer.
    let eop = EopTable::embedded().without_polar_motion();
    let sky = Sky::with_models(vec![elements.clone()], Observer::new(site), eop.clone(), &choice);
    let light = SatelliteLight {
        photometry: &PhotometryOptions::default(),
        modulation: &Modulation::default(),
        resolve_panels: false,
        tracking: &Tracking::Sidereal,
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
    // The header gives the instrument's position: that of the observatory is 70 m away, 11" at this satellite.
    let overrides = FrameOverrides { zero_point: Some((30.0, CountBasis::Frame)), ..FrameOverrides::default() };
    let frame = TargetFrame::open(&folder.join(FRAME), &overrides).unwrap();
    let site = frame.site().unwrap().unwrap();
    assert_eq!(site.mpc_code.as_deref(), Some("W84"));
    // Elements 11.5 days old, and 9.5 days old within a manoeuvre: distance of the track from the streak, arcmin, and a
    // field that it just crosses (the track bends by 3" within a degree). The streak is measured to half a pixel,
    // 0.002'.
    for (file, age_days, beside_arcmin, radius_deg) in [
        ("supgp/starlink_supgp_2020-02-23.tle", 11.48, 0.50, 0.03),
        ("supgp/starlink_supgp_2020-02-25.tle", 9.48, 27.09, 0.47),
    ] {
        let catalogue = Satellites::read(&[folder.join("tle").join(file)], &ReadOptions::default()).unwrap();
        let elements = catalogue.element_sets.iter().find(|one| one.norad_id.0 == NORAD).unwrap();
        assert!((seconds_between(elements.epoch, exposure.start) / 86_400.0 - age_days).abs() < 0.01, "{file}");
        let track = track(elements, &exposure, radius_deg).expect("the satellite crosses the field");
        // The great circle through the two points of the track nearest to the streak.
        let away = |pair: &[SkyPoint]| pair[0].direction.separation_rad(&seen[0]);
        let near = track.points.windows(2).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
        let [from, to] = [near[0].direction, near[1].direction];
        let pole: Vector3<f64> = from.vector().cross(to.vector()).normalize();
        let beside = |place: &Direction<Gcrs>| (place.vector().dot(&pole).asin().to_degrees() * 60.0).abs();
        for place in &seen {
            assert!((beside(place) - beside_arcmin).abs() < 0.01, "{file}: {:.3}'", beside(place));
        }
        // The line was measured over 70 pixels to half a pixel at its ends: 0.4 degrees.
        let turned = (from.position_angle_rad(&to) - seen[1].position_angle_rad(&seen[0])).to_degrees();
        assert!(turned.abs() < 0.4, "{file}: {turned:.3} deg");
        // Chip S28 is 9' by 18', and the streak crosses all of it: a track 0.5' beside it is on the chip at a time
        // within the exposure.
        assert!((0.0..120.0).contains(&near[0].time_s));
    }
}

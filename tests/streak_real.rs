//! A streak that was seen: Starlink-1102 in an exposure of the Dark Energy Camera, and where its elements put it.
#![cfg(feature = "fits")]

mod common;

use hifitime::Epoch;
use nalgebra::Vector3;
use streakcast::camera::{FrameFile, PixelPosition, Wcs};
use streakcast::catalogue::{Catalogue, ElementSet, ReadOptions};
use streakcast::frames::{Direction, EopTable, Gcrs};
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{Exposure, ModelChoice, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::streak::{Modulation, SatelliteLight, SkyTrack, satellites};

const FRAME: &str = "frames/trailblazer/cutout_c4d_200306_000415_ori.fits.fz";
/// STARLINK-1102.
const NORAD: u32 = 44920;

/// The streak as it lies in the cutout of chip S28: the line on which the pixels, their columns' gradient taken out, are brightest on the average
/// (counted from 0; found on a grid of half a pixel).
const SEEN: [PixelPosition; 2] = [PixelPosition { x: 0.0, y: 67.5 }, PixelPosition { x: 70.0, y: -3.0 }];

fn track(elements: &ElementSet, exposure: &Exposure) -> Option<SkyTrack> {
    let site = Site::by_mpc_code("W84").unwrap();
    let choice = ModelChoice::new(&ModelLibrary::embedded()).unwrap();
    let eop = EopTable::embedded();
    let sky = Sky::new(vec![elements.clone()], Observer::new(site), eop.clone(), &choice);
    let light = SatelliteLight {
        photometry: &PhotometryOptions::default(),
        modulation: &Modulation::default(),
        resolve_panels: false,
    };
    let found = satellites(&sky, &eop, exposure, 1.0f64.to_radians(), &light).unwrap();
    found.sources.into_iter().next().map(|source| source.parts[0].track.clone())
}

#[test]
fn valid_starlink_1102_crosses_the_decam_exposure_as_it_was_seen() {
    let Some(folder) = common::data_dir() else { return };
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
    for (file, most_arcmin) in
        [("supgp/starlink_supgp_2020-02-23.tle", 15.0), ("supgp/starlink_supgp_2020-02-25.tle", 15.0)]
    {
        let catalogue = Catalogue::read(&[folder.join("tle").join(file)], &ReadOptions::default()).unwrap();
        let elements = catalogue.element_sets.iter().find(|one| one.norad_id.0 == NORAD).unwrap();
        let track = track(elements, &exposure);
        println!("{file} {:?}", track.as_ref().map(|t| t.points.len()));
        let Some(track) = track else { continue };
        // The pole of the great circle through the two points of the track nearest to the streak.
        let near = track
            .points
            .windows(2)
            .min_by(|a, b| a[0].direction.separation_rad(&seen[0]).total_cmp(&b[0].direction.separation_rad(&seen[0])))
            .unwrap();
        let pole: Vector3<f64> = near[0].direction.vector().cross(near[1].direction.vector()).normalize();
        let off = |d: &Direction<Gcrs>| d.vector().dot(&pole).asin().to_degrees() * 60.0;
        println!(
            "{file}: off {:.3}' {:.3}' time {:.2} s PA seen {:.3} predicted {:.3} mag {:?} rate {:.1}\"/s range {}",
            off(&seen[0]),
            off(&seen[1]),
            near[0].time_s,
            seen[0].position_angle_rad(&seen[1]).to_degrees(),
            near[0].direction.position_angle_rad(&near[1].direction).to_degrees(),
            near[0].magnitude,
            near[0].direction.separation_rad(&near[1].direction).to_degrees() * 3600.0
                / (near[1].time_s - near[0].time_s),
            near[0].range_km
        );
        let _ = most_arcmin;
    }
}

//! Sky chart of the brightest passes of a night, and the light curve of one of them: `cargo run --example plot_pass --
//! FOLDER` writes PNG and SVG.
//!
//! The satellites are synthetic. For real element sets, replace the line that creates `elements` by
//! `Satellites::read(&paths, &ReadOptions::default())?.element_sets`.

use std::error::Error;
use std::path::PathBuf;

use streakcast::elements::Constellation;
use streakcast::forecast::{ForecastRequest, Selection, forecast};
use streakcast::frames::parse_instant;
use streakcast::frames::{EopTable, mjd_utc};
use streakcast::geometry::{Observer, Site};
use streakcast::passes::{ModelChoice, Sky, TrackPoint, VisiblePass};
use streakcast::photometry::ModelLibrary;
use streakcast::plot::{LightCurve, SkyChart, SkyTrack, light_curve, sky_chart};
use streakcast::schedule::night_of;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_owned()));

    // 1. Passes of a night brighter than magnitude 4.9 near the zenith, with points along each.
    let noon = parse_instant("2026-08-14T12:00:00Z", None)?;
    let elements = Constellation::by_name("starlink-gen1")?.element_sets(noon);
    let site = Site::from_mpc("X05")?;
    let (from, to) = night_of(noon, site.longitude_rad);
    let sky = Sky::with_models(
        elements,
        Observer::new(site.clone()),
        EopTable::embedded(),
        &ModelChoice::new(&ModelLibrary::embedded())?,
    );
    let request = ForecastRequest {
        max_magnitude: Some(4.9),
        min_culmination_rad: 86.0_f64.to_radians(),
        samples: 101,
        ..ForecastRequest::new(from, to)
    };
    let result = forecast(&sky, &request, &Selection::default())?;

    // 2. Charts are drawn from columns.
    let passes = result.found.passes.iter();
    let tracks: Vec<SkyTrack> =
        passes.map(|pass| track(sky.elements()[pass.element_index].name.to_string(), pass)).collect();
    let over = sky_chart(&SkyChart {
        local: None,
        site: Some(&site),
        title: "Bright passes over Rubin Observatory, 2026-08-14",
        caption: "Satellites are synthetic.",
        tracks: &tracks,
    })?;
    let first = tracks.first().ok_or("no pass is that bright")?;
    let curve = light_curve(&LightCurve {
        title: &first.name,
        caption: "From rise to set.",
        time_mjd: &first.time_mjd,
        magnitude: &first.magnitude,
        sigma_mag: &first.sigma_mag,
        in_fitted_range: &[],
        in_field: &[],
        shutter: None,
        limit_mag: Some(6.0),
        local: None,
    })?;
    for (name, picture) in [("passes", over), ("pass", curve)] {
        std::fs::write(folder.join(format!("{name}.png")), picture.to_png()?)?;
        std::fs::write(folder.join(format!("{name}.svg")), picture.to_svg()?)?;
    }
    println!("{} passes in passes.png, {} in pass.png", tracks.len(), first.name);
    Ok(())
}

fn track(name: String, pass: &VisiblePass) -> SkyTrack {
    let points = &pass.samples;
    let column = |value: fn(&TrackPoint) -> Option<f64>| points.iter().map(|p| value(p).unwrap_or(f64::NAN)).collect();
    SkyTrack {
        name,
        time_mjd: points.iter().map(|point| mjd_utc(point.epoch)).collect(),
        azimuth_deg: column(|point| point.azimuth_rad.map(f64::to_degrees)),
        altitude_deg: column(|point| point.altitude_rad.map(f64::to_degrees)),
        magnitude: column(|point| point.brightness.as_ref().map(|light| light.magnitude.0)),
        sigma_mag: column(|point| point.brightness.as_ref().map(|light| light.sigma_mag)),
        time_sigma_s: pass.along_track_sigma_s,
    }
}

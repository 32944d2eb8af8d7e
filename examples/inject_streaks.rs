//! Injection of three random streaks into a synthetic chip of 2,000 by 2,000 pixels, with their true parameters.
//!
//! `cargo run --example inject_streaks`

use std::error::Error;

use streakcast::frames::Direction;
use streakcast::images::{LightArea, Plane, Wcs};
use streakcast::streaks::{
    Chip, CountScale, Optics, RandomStreaks, SeeingForm, Shot, Source, SourceName, SourcePart, StreakNumber, Tracking,
    direction_on, draw_on_chip,
};

fn main() -> Result<(), Box<dyn Error>> {
    let (seed, exposure_s) = (11, 30.0);
    let centre = Direction::from_lon_lat_rad(1.0, -0.4);
    let chip = Chip {
        hdu: 0,
        name: "one".to_owned(),
        rows: 2000,
        columns: 2000,
        light_area: LightArea::whole(2000, 2000),
        wcs: Wcs::tangent(centre, 0.5, 0.0, 2000, 2000)?,
        is_on_sky: true,
        // A star of magnitude 25 gives one count in 30 s.
        scale: CountScale::of_frame(25.0, exposure_s)?,
    };
    let random_streaks = RandomStreaks {
        number: StreakNumber::Exactly(3),
        magnitude: [5.0, 8.0],
        rate_rad_s: [0.3f64.to_radians(), 0.8f64.to_radians()],
    };
    let (_, radius_rad) = chip.circle().ok_or("the chip is on the sky")?;
    let tracks =
        random_streaks.tracks(seed, exposure_s, 2.5 * radius_rad, |drawn, _| direction_on([&chip].into_iter(), drawn));
    let sources: Vec<Source> = (1..)
        .zip(&tracks)
        .map(|(number, track)| Source {
            name: SourceName::Random(number),
            mag_source: "random".to_owned(),
            element_age_days: None,
            hdu: None,
            image_fwhm_arcsec: None,
            parts: vec![SourcePart { label: "whole", track: track.clone(), radius_m: 1.0 }],
        })
        .collect();

    let optics =
        Optics { form: SeeingForm::Moffat { beta: 3.5 }, seeing_arcsec: 1.2, outer_radius_m: 0.5, inner_radius_m: 0.2 };
    let shot = Shot {
        opened: "2026-08-14T23:30:00 UTC".parse()?,
        exposure_s,
        centre,
        tracking: &Tracking::Sidereal,
        optics: &optics,
        truth_points: 11,
    };
    let mut plane = Plane::zeros(chip.rows, chip.columns);
    let mut streaks = Vec::new();
    for source in &sources {
        streaks.extend(draw_on_chip(source, &chip, &shot)?);
    }
    streaks.iter().for_each(|streak| streak.patch.add_to(&mut plane));
    let brightest = plane.values().iter().copied().fold(0.0, f32::max);
    println!("{} streaks, brightest pixel {brightest:.0} counts", streaks.len());
    for streak in &streaks {
        let Some(middle) = &streak.middle else { continue };
        let (right_ascension, declination) = (middle.direction.longitude_rad(), middle.direction.latitude_rad());
        println!(
            "{}: {:.4} {:.4} deg, {:.0} pixels long, {:.1} arcsec/s, magnitude {:.2}",
            streak.source.name,
            right_ascension.to_degrees(),
            declination.to_degrees(),
            streak.length_pix,
            streak.rate_arcsec_s,
            streak.peak_magnitude.unwrap_or(f64::NAN)
        );
    }
    Ok(())
}

//! Fraction of the sky over Rubin Observatory with satellites brighter than 7 mag: `cargo run --example sky_map`.

use std::error::Error;

use streakcast::geometry::Site;
use streakcast::maps::{Earth, Grid, SkyView};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};

fn main() -> Result<(), Box<dyn Error>> {
    // 1. A brightness model for satellites at 550 km.
    let library = ModelLibrary::embedded();
    let model = library.get("starlink-v1.5").ok_or("no such model")?;
    let site = Site::from_mpc("X05")?;
    println!("{}: {} at 550 km, Sun in the west", site.name, model.source());

    // 2. HEALPix cells have equal areas, so a fraction of cells is a fraction of the sky.
    let grid = Grid::healpix(64)?;
    for sun_altitude_deg in [-12.0_f64, -18.0, -24.0, -30.0] {
        let sun = (270_f64.to_radians(), sun_altitude_deg.to_radians());
        let earth = Earth::Ellipsoid(site.clone());
        let view = SkyView::new(&model, earth, 550.0, sun.0, sun.1, PhotometryOptions::default())?;
        let map = view.map(grid)?;

        // 3. Only directions more than 20 degrees above the horizon, where telescopes usually point.
        let high: Vec<_> = map.points.iter().filter(|point| point.altitude_rad > 20_f64.to_radians()).collect();
        let share = |count: usize| 100.0 * count as f64 / high.len() as f64;
        let lit = high.iter().filter(|point| point.lit_fraction > 0.0).count();
        let bright = high.iter().filter(|point| point.magnitude.is_some_and(|magnitude| magnitude.0 < 7.0)).count();
        println!(
            "Sun at {sun_altitude_deg}: lit {:.0} % of the sky, brighter than 7 mag {:.0} %",
            share(lit),
            share(bright)
        );
    }
    Ok(())
}

//! Time to compute a map of the whole sky at nside 64 on all cores, and to draw it.

use divan::{Bencher, black_box};
use streakcast::maps::{Earth, Grid, SkyView};
use streakcast::photometry::{BrightnessModel, Earthshine, ModelLibrary, PhotometryOptions};

fn main() {
    divan::main();
}

fn model() -> BrightnessModel {
    ModelLibrary::embedded().get("starlink-v1.5").expect("a shipped model").as_ref().clone()
}

fn view(model: &BrightnessModel, sun_altitude_deg: f64, earthshine: Earthshine) -> SkyView<'_> {
    let sun = sun_altitude_deg.to_radians();
    let options = PhotometryOptions { earthshine, ..PhotometryOptions::default() };
    SkyView::new(model, Earth::Sphere, 550.0, 0.0, sun, options).expect("a sound question")
}

/// The map has 24,704 directions at or above the horizon. With the Sun at 0°, almost no satellite is in the shadow.
#[divan::bench(args = [0.0, -16.0])]
fn all_sky_nside_64(bencher: Bencher, sun_altitude_deg: f64) {
    let model = model();
    let view = view(&model, sun_altitude_deg, Earthshine::Off);
    let grid = Grid::healpix(64).expect("a division");
    bencher.bench(|| black_box(view.map(black_box(grid)).unwrap()));
}

#[divan::bench(args = [0.0, -16.0])]
fn all_sky_nside_64_with_earthshine(bencher: Bencher, sun_altitude_deg: f64) {
    let model = model();
    let view = view(&model, sun_altitude_deg, Earthshine::Computed);
    let grid = Grid::healpix(64).expect("a division");
    bencher.bench(|| black_box(view.map(black_box(grid)).unwrap()));
}

#[cfg(feature = "plot")]
#[divan::bench]
fn picture_png(bencher: Bencher) {
    let model = model();
    let view = view(&model, -16.0, Earthshine::Computed);
    bencher.bench(|| streakcast::plot::sky_picture(black_box(&view)).to_png());
}

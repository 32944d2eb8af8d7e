//! Time to compute reference frames and the Sun, exactly and from tables, and the Earth's shadow; each has a target.

use divan::{Bencher, black_box};
use hifitime::Epoch;
use streakcast::frames::{EopTable, Gcrs, Orientation, OrientationTable, Position, seconds_after};
use streakcast::geometry::{Observer, Site, SunState, SunTable, aspect, illumination};

fn main() {
    divan::main();
}

fn dusk() -> Epoch {
    Epoch::from_gregorian_utc_hms(2026, 4, 25, 23, 0, 0)
}

#[divan::bench]
fn orientation_exact(bencher: Bencher) {
    let eop = EopTable::embedded();
    bencher.bench(|| Orientation::at(black_box(dusk()), &eop));
}

/// Table of the Earth's orientation for a night; target: 1 ms.
#[divan::bench]
fn orientation_table_of_a_night(bencher: Bencher) {
    let eop = EopTable::embedded();
    bencher.bench(|| OrientationTable::new(dusk(), seconds_after(dusk(), 36_000.0), &eop));
}

/// Table of the Earth's orientation for a year; target: 0.1 s.
#[divan::bench(sample_count = 10)]
fn orientation_table_of_a_year(bencher: Bencher) {
    let eop = EopTable::embedded();
    bencher.bench(|| OrientationTable::new(dusk(), seconds_after(dusk(), 365.0 * 86_400.0), &eop));
}

/// Target: 0.3 µs.
#[divan::bench]
fn orientation_from_table(bencher: Bencher) {
    let table = OrientationTable::new(dusk(), seconds_after(dusk(), 36_000.0), &EopTable::embedded());
    bencher.bench(|| table.at_s(black_box(12_345.6)));
}

#[divan::bench]
fn sun_exact() -> SunState {
    SunState::at(black_box(dusk()))
}

/// Target: 0.2 µs.
#[divan::bench]
fn sun_from_table(bencher: Bencher) {
    let table = SunTable::new(dusk(), seconds_after(dusk(), 36_000.0));
    bencher.bench(|| table.at_s(black_box(12_345.6)));
}

#[divan::bench]
fn observer_state(bencher: Bencher) {
    let observer = Observer::new(Site::by_name("rubin").expect("the site"));
    let orientation = Orientation::at(dusk(), &EopTable::embedded());
    bencher.bench(|| observer.state(black_box(&orientation)));
}

#[divan::bench]
fn aspect_of_a_satellite(bencher: Bencher) {
    let satellite = Position::<Gcrs>::new(6900.0, 300.0, 100.0);
    let observer = Position::<Gcrs>::new(6370.0, 10.0, 20.0);
    let sun = SunState::at(dusk());
    bencher.bench(|| aspect(black_box(&satellite), &sun.earth_velocity, &observer, &sun.earth_velocity));
}

/// Target: 0.2 µs far from the shadow. Behind the Earth and in the penumbra it takes longer, because inverse
/// trigonometric functions are required.
#[divan::bench(args = [0.0, 0.5, 1.168, 2.0])]
fn shadow(bencher: Bencher, angle_from_antisun_rad: f64) {
    let sun = Position::<Gcrs>::new(1.5e8, 0.0, 0.0);
    let (sin, cos) = angle_from_antisun_rad.sin_cos();
    let satellite = Position::<Gcrs>::new(-6928.0 * cos, 6928.0 * sin, 0.0);
    bencher.bench(|| illumination(black_box(&satellite), black_box(&sun)));
}

/// Bundled table of Earth orientation: after the first call it is cloned. Files of finals2000A are not read.
#[divan::bench]
fn embedded_table() -> EopTable {
    EopTable::embedded()
}

//! Light that the Earth throws on a satellite (Lu 2024, section 2.4).
//!
//! Every part of the Earth that the Sun lights and the satellite sees is a Lambertian source. The paper sums them over
//! HEALPix pixels ([`healpix_earthshine`], the reference); what is used is a product rule on the lit ground in view
//! ([`Shine::on_panel`] for one question, [`EarthshineNodes`] for many under one Sun) or a table of it
//! ([`EarthshineTable`]). The paper lights the chassis only, and so do models of two panels; nodes light any panel of any law.
//! Light between satellite parts, refraction, the air's own glow in twilight, and the Sun's disk are not in it.
//!
//! Convergence, as the worst error of diffuse light and of the magnitude of a chassis that only the Earth lights
//! (c4 0.11, c5 0.08; printed by `cargo test --test earthshine -- --nocapture`). Of HEALPix with its pole at the nadir, n = 22,
//! 550 km, Sun -12° to 40°, against the rule:
//!
//! | nside | lit cells | diffuse | total, mag |
//! |---|---|---|---|
//! | 32 | 480 | 2.1e-2 | 0.15 |
//! | 64 | 1,984 | 4.4e-3 | 0.032 |
//! | 128 | 7,812 | 1.1e-3 | 0.0078 |
//! | 256 | 31,000 | 2.7e-4 | 0.0019 |
//! | 512 | 124,500 | 6.8e-5 | 0.0005 |
//!
//! Of the rule against one with 6 times the nodes, 200 km to 36,000 km, all Suns:
//!
//! | exponent | nodes at 550 km, at most | total, mag |
//! |---|---|---|
//! | 1 | 1,260 | 0.0003 |
//! | 2 | 270 | 0.0002 |
//! | 5 | 170 | 0.0001 |
//! | 22 | 358 | 0.0004 |
//! | 60 | 724 | 0.0006 |
//! | 200 | 2,056 | 0.0007 |
//!
//! Of the table with the chassis' own diffuse sunlight added where the Sun stands below it: 0.0008 mag at most for exponents 1 to 60;
//! earthshine alone, which there is far too little to matter, 0.005 mag.
//!
//! Below exponent 1 the lobe ends in a step 90° off and the rule is good to some hundredths; above 200 it is not tested.
//!
//! A map of the Earth instead of one albedo: `EarthshineNodes::new(sun, height, &Albedo::Map(&map, below), exponent)`, then
//! [`EarthshineNodes::shine`] and `SatelliteModel::earth_terms_of`. It needs the place below the satellite and the Sun's
//! azimuth there, which magnitudes otherwise do not, so it is for the library's callers.

mod albedo;
mod arithmetic;
mod cap;
mod healpix;
mod nodes;
mod rule;
mod table;

pub use albedo::{Albedo, AlbedoMap, EarthBelow, PAPER_ALBEDO, SurfaceAlbedos};
pub use healpix::healpix_earthshine;
pub use nodes::{EarthTerms, EarthshineNodes, Shine};
pub use table::EarthshineTable;

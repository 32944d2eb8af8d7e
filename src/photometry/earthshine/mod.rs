//! Light that the Earth throws on a satellite (Lu 2024, section 2.4).
//!
//! Every part of the Earth that the Sun lights and the satellite sees is a Lambertian source of albedo 0.3. The paper
//! sums over HEALPix pixels (tests do too); here a product rule lays fewer and better nodes on the lit ground in view.
//! The paper lights the chassis only, and so do models of two panels; lists of panels light any panel by any law.
//! Light between satellite parts, refraction, the air's own glow in twilight, and the Sun's disk are left out.
//!
//! Convergence, as the worst error of diffuse light and of the magnitude of a chassis that only the Earth lights
//! (c4 0.19, c5 0.09; printed by `cargo test --test library earthshine -- --nocapture`). HEALPix with its pole at the
//! nadir, n = 22, 550 km, Sun -12° to 40°, against the rule:
//!
//! | nside | lit cells | diffuse | total, mag |
//! |---|---|---|---|
//! | 32 | 480 | 2.1e-2 | 0.15 |
//! | 64 | 1,984 | 4.4e-3 | 0.032 |
//! | 128 | 7,812 | 1.1e-3 | 0.0078 |
//! | 256 | 31,000 | 2.7e-4 | 0.0019 |
//! | 512 | 124,500 | 6.8e-5 | 0.0005 |
//!
//! The rule against a much finer one, 200 km to 36,000 km, all Suns:
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
//! Below exponent 1 the lobe ends in a step 90° off and the rule is good to some hundredths; above 200 it is not tested.

mod lit_earth;
mod rule;

pub use lit_earth::{EARTH_ALBEDO, LitEarth, Shine};

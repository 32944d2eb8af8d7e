//! Sunlight reflected by the Earth onto a satellite (Lu 2024, section 2.4).
//!
//! Every part of the Earth that is lit by the Sun and visible from the satellite is a Lambertian source of albedo 0.3.
//! The paper sums over HEALPix pixels (as tests do); here a product rule places fewer and better nodes on the lit
//! ground in view. The paper lights the chassis only, and so do two-panel models; in lists of panels any panel may be
//! lit, with any law. Light between satellite parts, refraction, twilight airglow and the size of the Sun's disk are
//! neglected.
//!
//! Convergence, as the largest error of diffuse light and of the magnitude of a chassis lit by the Earth only (c4 0.19,
//! c5 0.09; printed by `cargo test --test library earthshine -- --nocapture`). HEALPix with its pole at the nadir, n =
//! 22, 550 km, Sun -12° to 40°, against the rule:
//!
//! | nside | lit cells | diffuse | total, mag |
//! |---|---|---|---|
//! | 32 | 480 | 2.1e-2 | 0.15 |
//! | 64 | 1,984 | 4.4e-3 | 0.032 |
//! | 128 | 7,812 | 1.1e-3 | 0.0078 |
//! | 256 | 31,000 | 2.7e-4 | 0.0019 |
//! | 512 | 124,500 | 6.8e-5 | 0.0005 |
//!
//! The rule against a much finer one, 200 km to 36,000 km, all positions of the Sun:
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
//! Below exponent 1 the lobe ends with a step at 90° and the error is some hundredths; exponents above 200 are not
//! tested.

mod lit_earth;
mod rule;

pub use lit_earth::{EARTH_ALBEDO, LitEarth, PanelEarthshine};

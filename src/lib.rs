//! Satellites crossing astronomers' exposures: which, when, where and how bright.
//!
//! Data flows one way, and so do the imports:
//!
//! ```text
//! ElementSet ─ Propagator ─ Position<Gcrs> ─ ViewingGeometry ─ SatelliteModel ─ Magnitude
//! catalogue    orbit         frames          geometry          photometry
//!                                                                   │
//!                   Exposure ── Sky::field_passes ── FieldPass { TrackPoint … }
//!                   passes       passes                    │
//!                                                  schedule: ExposureFlag
//! ```
//!
//! Radians and kilometres inside, degrees at the faces and in files. Every right ascension and declination is
//! ICRS astrometric topocentric unless it says otherwise: the place a satellite takes among catalogue stars on a
//! calibrated image. The library never prints, and never asks the environment, the clock or the network.

pub mod config;
pub mod constants;
pub mod elements;
#[cfg(feature = "fit")]
pub mod fit;
pub mod forecast;
pub mod frames;
pub mod geometry;
pub mod identify;
pub mod images;
pub mod maps;
#[doc(hidden)]
pub mod math;
pub mod orbit;
pub mod output;
pub mod passes;
pub mod photometry;
#[cfg(feature = "plot")]
pub mod plot;
pub mod schedule;
pub mod streaks;

//! Satellites crossing astronomers' exposures: which, when, where and how bright.
//!
//! A [`Sky`] combines satellites with a site. It judges an exposure, given a field of view and a policy, and returns a
//! [`Verdict`]:
//!
//! ```
//! use streakcast::frames::parse_instant;
//! use streakcast::{Exposure, Field, Policy, Satellites, Site, Sky};
//!
//! fn main() -> Result<(), streakcast::Error> {
//!     // Real element sets: Satellites::from_files(["gp.csv"])?
//!     let satellites = Satellites::synthetic("starlink-gen1", parse_instant("2026-08-14T00:00:00Z", None)?)?;
//!     let sky = Sky::new(satellites, Site::from_mpc("X05")?);
//!     let exposure = Exposure::new("2026-08-14T23:36:25Z", 30.0, "14h53m36s", "-08d54m")?;
//!     let verdict = sky.judge(&exposure, &Field::circle_deg(3.5)?, &Policy::limit_mag(7.0))?;
//!     println!("{verdict}");
//!     for pass in &verdict.passes {
//!         println!("{} {} {:.1}", pass.norad_id, pass.enter.epoch, pass.peak_magnitude());
//!     }
//!     Ok(())
//! }
//! ```
//!
//! The names at the root use embedded brightness models and Earth orientation; [`Sky::with_models`] accepts others. The
//! modules provide more: [`schedule`] judges whole schedules and finds clear windows, [`forecast`] lists the visible
//! passes of a night, [`identify`] identifies the satellite of a measured streak, [`streaks`] draws streaks into
//! frames, [`photometry`] computes magnitudes.
//!
//! The library uses radians and kilometres internally, degrees at interfaces and in files. Every right ascension and
//! declination is ICRS astrometric topocentric unless documented otherwise: the position relative to catalogue stars on
//! a calibrated image. The library never prints, and never reads the environment, the clock or the network.
//!
//! Results and most enums are `#[non_exhaustive]`. Options have public fields and a default: end a literal with
//! `..Default::default()`, because a minor version may add fields.
//!
//! # Features
//!
//! The default needs no C compiler. `fits` adds frames and HEALPix maps as FITS (CFITSIO is compiled in, on Unix),
//! `sqlite` adds Rubin opsim databases (SQLite is compiled in), `plot` adds charts and maps as PNG and SVG, and `fit`
//! adds fits of brightness models to photometry.

#[doc(hidden)]
pub mod config;
#[doc(hidden)]
pub mod constants;
pub mod elements;
mod error;
#[cfg(feature = "fit")]
pub mod fit;
pub mod forecast;
pub mod frames;
pub mod geometry;
pub mod identify;
pub mod images;
#[doc(hidden)]
pub mod input;
pub mod learn;
pub mod maps;
#[doc(hidden)]
pub mod math;
pub mod measure;
#[doc(hidden)]
pub mod message;
pub mod orbit;
#[doc(hidden)]
pub mod output;
pub mod passes;
pub mod photometry;
#[cfg(feature = "plot")]
pub mod plot;
pub mod schedule;
pub mod streaks;
mod units;
mod watch;

pub use elements::Satellites;
pub use error::{Error, ErrorKind};
pub use geometry::Site;
pub use hifitime;
pub use passes::{Exposure, Field, Pass, Sky};
pub use schedule::{Policy, Verdict};
pub use watch::Watch;

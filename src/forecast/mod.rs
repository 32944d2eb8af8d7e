//! Forecast of the passes of a night over a site, ephemerides of satellites, numbers of lit satellites by Sun altitude,
//! and comparison with published numbers.
//!
//! `request` defines the request, `outlook` computes the night and its passes, `pass_table` and `exports` write the
//! passes. `ephemeris` computes positions of selected satellites at given times. `statistics` counts lit satellites as
//! a function of the Sun's altitude, `reproduce` compares with published numbers.

mod ephemeris;
mod error;
mod exports;
mod outlook;
mod pass_table;
mod reproduce;
mod request;
mod selection;
mod statistics;

pub use ephemeris::{Ephemeris, EphemerisRequest, EphemerisRow, ephemeris, ephemeris_table};
pub use error::ForecastError;
pub use exports::{AngleType, EmptyNight, calendar, score_report, tdm};
pub use outlook::{Forecast, Night, forecast, night_table};
pub use pass_table::{PassColumns, PassRow, compass, light_curve_table, pass_table, readable_table};
pub use reproduce::{HU2022, Reproduced, bassa2022, hu2022, lu2024b, lu2024b_constellations, reproduced_table};
pub use request::{ForecastRequest, PassOrder};
pub use selection::{Selected, Selection};
pub use statistics::{SkyCount, SkyCounts, StatisticsRequest, sky_counts, statistics_table};

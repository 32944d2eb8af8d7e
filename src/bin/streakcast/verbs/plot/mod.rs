//! `plot`: draws pictures and writes their data files. Each plot has its own module.
//!
//! `columns` reads the output tables of verbs, and `curves` those of forecasts. `target` opens the output files,
//! `clock` defines local time, and `exposures` defines the table of exposures for plots of nights.

mod arguments;
mod clock;
mod columns;
mod corner;
mod curves;
mod equatorial_rate;
mod exposures;
mod field;
mod light_curve;
mod night;
mod residuals;
mod run;
mod sky_chart;
mod sky_rate;
mod sun_altitude;
mod target;

pub use arguments::PlotArguments;
pub use run::run;
pub use target::{data_path, json_of};

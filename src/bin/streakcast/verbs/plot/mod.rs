//! `plot`: pictures with their data beside. One plot a file; `columns` reads tables that verbs wrote (of forecasts
//! `curves`), `target` names the files, `clock` holds local time, `exposures` what the plots of nights share.

mod arguments;
mod clock;
mod columns;
#[cfg(feature = "fit")]
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

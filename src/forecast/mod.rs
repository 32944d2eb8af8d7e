//! What an observer will see: the passes of a night over a site, as tables, light curves, calendars and messages.
//!
//! `night` says when it is dark, `request` what is wanted, `outlook` asks the sky; `pass_table`, `light_curve`, `readable`, `night_table`, `calendar`, `tdm`
//! and `score` write the answer.

mod calendar;
mod error;
mod light_curve;
mod night;
mod night_table;
mod outlook;
mod pass_table;
mod readable;
mod request;
mod score;
mod tdm;

pub use calendar::calendar;
pub use error::ForecastError;
pub use light_curve::light_curve_table;
pub use night::Night;
pub use night_table::night_table;
pub use outlook::{Forecast, forecast};
pub use pass_table::{PassRow, pass_table};
pub use readable::{compass, readable_table};
pub use request::{ForecastRequest, Selection};
pub use score::score_report;
pub use tdm::{AngleType, tdm};

//! What an observer will see: the passes of a night over a site, as tables, light curves, calendars and messages.
//!
//! `night` says when it is dark, `request` what is wanted, `outlook` asks the sky; `pass_table`, `light_curve`, `readable`, `night_table`, `calendar`, `tdm`
//! and `score` write the answer. `statistics` counts what is lit over a site against the Sun's altitude, `reproduce` holds published counts beside ours.

mod calendar;
mod error;
mod light_curve;
mod night;
mod night_table;
mod outlook;
mod pass_table;
mod readable;
mod reproduce;
mod request;
mod score;
mod statistics;
mod statistics_table;
mod tdm;

pub use calendar::{EmptyNight, calendar};
pub use error::ForecastError;
pub use light_curve::light_curve_table;
pub use night::Night;
pub use night_table::night_table;
pub use outlook::{Forecast, forecast};
pub use pass_table::{PassRow, pass_table};
pub use readable::{compass, readable_table};
pub use reproduce::{
    AGREES_PERCENT, HU2022, HU2022_FIRST_VISITS, LU2024B_PERCENT, Reproduced, bassa2022, expected_above, hu2022,
    lu2024b, lu2024b_constellations, reproduced_table,
};
pub use request::{ForecastRequest, Selection};
pub use score::score_report;
pub use statistics::{MAGNITUDES, SkyCount, SkyCounts, StatisticsRequest, sky_counts};
pub use statistics_table::statistics_table;
pub use tdm::{AngleType, tdm};

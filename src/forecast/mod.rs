//! Forecast of the passes of a night over a site, ephemerides of satellites, numbers of lit satellites by Sun altitude,
//! and comparison with published numbers.
//!
//! `request` defines the request, `outlook` computes the night and its passes, `pass_table` and `exports` write the
//! passes. `ephemeris` computes positions of selected satellites at given times. `statistics` counts lit satellites as
//! a function of the Sun's altitude, `trail_statistics` trails in random exposures of a telescope in orbit, `reproduce`
//! and `borlaff2026` compare with published numbers.
//!
//! ```
//! use streakcast::forecast::{ForecastRequest, Selection, forecast};
//! use streakcast::frames::{parse_instant, seconds_after};
//! use streakcast::{Satellites, Site, Sky};
//!
//! let dusk = parse_instant("2026-08-14T23:00:00Z", None)?;
//! let sky = Sky::new(Satellites::synthetic("starlink-gen1", dusk)?, Site::from_mpc("X05")?);
//! let mut request = ForecastRequest::new(dusk, seconds_after(dusk, 600.0));
//! request.min_culmination_rad = 60.0_f64.to_radians();
//! let found = forecast(&sky, &request, &Selection::default())?.found;
//! println!("{} passes", found.passes.len());
//! # Ok::<(), streakcast::Error>(())
//! ```

mod borlaff2026;
mod ephemeris;
mod exports;
mod outlook;
mod pass_table;
mod reproduce;
mod request;
mod selection;
mod statistics;
mod trail_statistics;

pub use ephemeris::{Ephemeris, EphemerisRequest, EphemerisRow, ephemeris};
pub use outlook::{Forecast, Night, forecast};
pub use request::{ForecastRequest, PassOrder};
pub use selection::Selection;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    borlaff2026::borlaff2026,
    ephemeris::ephemeris_table,
    exports::{AngleType, EmptyNight, calendar, score_report, tdm},
    outlook::night_table,
    pass_table::{PassColumns, light_curve_table, pass_table, readable_table},
    reproduce::{HU2022, Reproduced, bassa2022, hu2022, lu2024b, lu2024b_constellations, reproduced_table},
    statistics::{SkyCount, StatisticsRequest, sky_counts, statistics_table},
    trail_statistics::{
        Mean, OrbitHeight, Trail, TrailRequest, TrailStatistics, trail_angle_table, trail_histogram_table,
        trail_statistics, trail_table,
    },
};

//! One document that names site, elements, models, camera and policy, and what it takes to make a sky of it.
//!
//! Every face fills the same [`Setup`]: the command line from its flags, a configuration file (TOML) from its keys, a
//! plugin from its arguments. Laid over each other ([`Setup::over`]) they are resolved here and nowhere else.

mod camera;
mod choices;
mod document;
mod error;
mod health;
mod place;
mod prepared;
mod requests;
mod resolve;
mod scales;
mod units;
mod warnings;

pub use choices::{FieldSetup, ModelsSetup, OneOrMany, PolicySetup, Quantity, SiteSetup, SiteTable, TelescopeSetup};
pub use document::Setup;
pub use error::SetupError;
pub use health::{AgeBin, ElementState, Finding, Health, MomentSource, Severity, Unmatched, finding_table};
pub use prepared::{Prepared, Stock};
pub use requests::{ForecastSaid, QuestionError, StreakAsked, StreakSaid, above_the_horizon, time_range};
pub use resolve::{MOST_SAMPLES, OLD_ELEMENTS_DAYS};
pub use scales::state_scales;
pub use units::{parse_angle_deg, parse_duration_s, parse_moment, parse_time_scale};

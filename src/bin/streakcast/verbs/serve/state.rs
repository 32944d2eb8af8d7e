//! Inputs and verdicts of the server, computed once at the start and never changed.

use std::collections::BTreeMap;

use hifitime::Epoch;
use streakcast::config::{Config, ObservationPlan, PreparedSky};
use streakcast::geometry::Site;
use streakcast::orbit::LeftOut;
use streakcast::output::Provenance;
use streakcast::passes::{PassOptions, Sky};
use streakcast::photometry::ModelLibrary;
use streakcast::schedule::{FlagRequest, Policy, Schedule, Verdict, evening_mjd};

use super::problem::Problem;

/// Schedule with its verdicts, and satellites.
pub struct ServerState {
    pub config: Config,
    pub prepared: PreparedSky,
    /// Site of all responses except those of SatChecker's paths.
    pub site: Site,
    pub plan: ObservationPlan,
    pub schedule: Schedule,
    /// Verdicts, one for each row of the schedule.
    pub flags: Vec<Verdict>,
    /// Warnings about the verdicts, and the number of satellites left out.
    pub caveats: Caveats,
    /// Provenance without its lists (rejected records), which may be long.
    pub provenance: Provenance,
    pub library: ModelLibrary,
    /// Rows by the evening's date (MJD) of their night.
    pub nights: BTreeMap<i64, Vec<usize>>,
    /// Local time minus UTC, hours.
    pub utc_offset_h: f64,
}

/// Warnings about a response, and the number of satellites left out of it.
pub struct Caveats {
    /// Warnings, as on the command line.
    pub warnings: Vec<String>,
    /// Number of satellites left out.
    pub left_out_count: usize,
}

impl ServerState {
    pub fn sky(&self) -> &Sky {
        &self.prepared.sky
    }

    /// Returns the caveats of a response for times from `first` to `last` with the satellites `left_out`.
    ///
    /// # Errors
    /// All satellites are left out, so that an empty response would be wrong.
    pub fn caveats_at(&self, first: Epoch, last: Epoch, left_out: &[LeftOut]) -> Result<Caveats, Problem> {
        let of_left_out = self.prepared.left_out_warning(left_out, first);
        let mut warnings = self.prepared.warnings_at(first, last);
        warnings.extend(of_left_out.map_err(|error| Problem::new(400, error.to_string()))?);
        Ok(Caveats { warnings, left_out_count: left_out.len() })
    }

    /// Returns the request for verdicts with this policy.
    pub fn request<'a>(&'a self, policy: &'a Policy) -> FlagRequest<'a> {
        FlagRequest { policy, ..self.plan.request(self.sky()) }
    }

    /// Returns the options of `passes`.
    pub fn pass_options(&self, samples: usize) -> PassOptions {
        PassOptions {
            include_dark: false,
            min_probability: self.plan.policy.min_probability,
            samples,
            photometry: self.plan.photometry,
            ..PassOptions::default()
        }
    }
}

/// Returns the rows of each night by the MJD of its evening. Invalid rows are in the first night.
pub fn nights_of(schedule: &Schedule, site: &Site) -> BTreeMap<i64, Vec<usize>> {
    let mut nights: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (row, exposure) in schedule.valid_exposures() {
        nights.entry(evening_mjd(exposure.start, site.longitude_rad)).or_default().push(row);
    }
    let invalid = schedule.exposures.iter().enumerate().filter(|(_, row)| row.exposure.is_err());
    if let Some(mut first) = nights.first_entry() {
        first.get_mut().extend(invalid.map(|(row, _)| row));
        first.get_mut().sort_unstable();
    }
    nights
}

/// Returns the whole-hour time zone in which the Sun culminates closest to noon, hours ahead of UTC.
pub fn zone_h(site: &Site) -> f64 {
    (site.longitude_rad.to_degrees() / 15.0).round()
}

//! What every answer rests on: read once, never changed, so that the same question has the same answer as long as the server runs.

use std::collections::BTreeMap;

use hifitime::Epoch;
use streakcast::config::{Config, ObservationPlan, PreparedSky};
use streakcast::geometry::Site;
use streakcast::orbit::LeftOut;
use streakcast::output::{Provenance, format_utc};
use streakcast::passes::{PassOptions, Sky};
use streakcast::photometry::ModelLibrary;
use streakcast::schedule::{ExposureFlag, FlagRequest, Policy, Schedule, evening_mjd};

use super::reply::Problem;

/// The schedule, its verdicts, and the sky they were made under.
pub struct House {
    pub config: Config,
    /// The sky of all answers.
    pub prepared: PreparedSky,
    /// Where it is seen from, unless a question says another place.
    pub site: Site,
    pub asked: ObservationPlan,
    pub schedule: Schedule,
    /// One for each row.
    pub flags: Vec<ExposureFlag>,
    /// Those of the whole schedule.
    pub caveats: Caveats,
    /// Without lists of rejected records, which may be long.
    pub provenance: Provenance,
    pub library: ModelLibrary,
    /// Rows by the evening's date (MJD) of their night.
    pub nights: BTreeMap<i64, Vec<usize>>,
    /// Local time less UTC, hours.
    pub utc_offset_h: f64,
}

/// What to know of an answer.
pub struct Caveats {
    /// In the words of the command line.
    pub warnings: Vec<String>,
    /// How many satellites the answer does without.
    pub left_out_count: usize,
}

impl House {
    /// The sky that every answer asks.
    pub fn sky(&self) -> &Sky {
        &self.prepared.sky
    }

    /// Those of an answer from `first` to `last` that does without these satellites.
    ///
    /// Where all are left out there is no answer: a sky that nobody can tell of is not empty.
    pub fn caveats_at(&self, first: Epoch, last: Epoch, left_out: &[LeftOut]) -> Result<Caveats, Problem> {
        let of_left_out = self.prepared.left_out_warning(left_out, first);
        let mut warnings = self.prepared.warnings_at(first, last);
        warnings.extend(of_left_out.map_err(|error| Problem::new(400, error.to_string()))?);
        Ok(Caveats { warnings, left_out_count: left_out.len() })
    }

    /// What exposures are judged against, with another policy than the server's own or with that.
    pub fn request<'a>(&'a self, policy: &'a Policy) -> FlagRequest<'a> {
        FlagRequest { policy, ..self.asked.request(self.sky()) }
    }

    /// What is wanted of passes, as `passes` wants it.
    pub fn pass_options(&self, samples: usize) -> PassOptions {
        PassOptions {
            include_dark: false,
            min_probability: self.asked.policy.min_probability,
            samples,
            photometry: self.asked.photometry,
            ..PassOptions::default()
        }
    }
}

/// The evening's date of a night, as 2024-08-13.
pub fn date_of(evening_mjd: i64) -> String {
    let mut text = format_utc(Epoch::from_mjd_utc(evening_mjd as f64), 0);
    text.truncate(10);
    text
}

/// Rows by their night's evening; those that cannot be judged are in the first.
pub fn nights_of(schedule: &Schedule, site: &Site) -> BTreeMap<i64, Vec<usize>> {
    let mut nights: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (row, exposure) in schedule.judged() {
        nights.entry(evening_mjd(exposure.start, site.longitude_rad)).or_default().push(row);
    }
    let invalid = schedule.exposures.iter().enumerate().filter(|(_, row)| row.exposure.is_err());
    if let Some(mut first) = nights.first_entry() {
        first.get_mut().extend(invalid.map(|(row, _)| row));
        first.get_mut().sort_unstable();
    }
    nights
}

/// The zone in which the Sun culminates nearest to 12 h, hours ahead of UTC.
pub fn zone_h(site: &Site) -> f64 {
    (site.longitude_rad.to_degrees() / 15.0).round()
}

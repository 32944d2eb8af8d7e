//! What every answer rests on: read once, never changed, so that the same question has the same answer as long as the server runs.

use std::collections::BTreeMap;

use hifitime::Epoch;
use streakcast::passes::{PassOptions, Sky};
use streakcast::photometry::ModelLibrary;
use streakcast::schedule::{ExposureFlag, FlagReport, FlagRequest, Policy, Schedule, evening_mjd};
use streakcast::setup::{Prepared, Setup};
use streakcast::table::{Provenance, format_utc};

use super::super::judged::Asked;

/// The schedule, its verdicts, and the sky they were made under.
pub struct House {
    pub setup: Setup,
    /// The sky of all answers; its warnings are those of the whole schedule.
    pub prepared: Prepared,
    pub asked: Asked,
    pub schedule: Schedule,
    /// One for each row.
    pub flags: Vec<ExposureFlag>,
    /// Satellites left out of some exposure of the schedule.
    pub left_out_count: usize,
    /// Without lists of rejected records, which may be long.
    pub provenance: Provenance,
    pub library: ModelLibrary,
    /// Rows by the evening's date (MJD) of their night; those that cannot be judged are in the first.
    pub nights: BTreeMap<i64, Vec<usize>>,
    /// Local time less UTC, hours.
    pub utc_offset_h: f64,
}

impl House {
    pub fn new(
        setup: Setup,
        prepared: Prepared,
        provenance: Provenance,
        asked: Asked,
        schedule: Schedule,
        report: FlagReport,
        utc_offset_h: Option<f64>,
    ) -> anyhow::Result<Self> {
        let library = setup.model_library()?;
        let longitude_rad = prepared.sky.viewpoint().site().map_or(0.0, |observer| observer.site().longitude_rad);
        let mut nights: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        for (row, exposure) in schedule.judged() {
            nights.entry(evening_mjd(exposure.start, longitude_rad)).or_default().push(row);
        }
        let invalid = schedule.exposures.iter().enumerate().filter(|(_, row)| row.exposure.is_err());
        if let Some(mut first) = nights.first_entry() {
            first.get_mut().extend(invalid.map(|(row, _)| row));
            first.get_mut().sort_unstable();
        }
        // The zone in which the Sun culminates nearest to 12 h.
        let utc_offset_h = utc_offset_h.unwrap_or_else(|| (longitude_rad.to_degrees() / 15.0).round());
        Ok(Self {
            setup,
            prepared,
            asked,
            schedule,
            flags: report.flags,
            left_out_count: report.left_out.len(),
            provenance,
            library,
            nights,
            utc_offset_h,
        })
    }

    /// The sky that every answer asks.
    pub fn sky(&self) -> &Sky {
        &self.prepared.sky
    }

    /// What exposures are judged against, with another policy than the server's own or with that.
    pub fn request<'a>(&'a self, policy: &'a Policy) -> FlagRequest<'a> {
        FlagRequest {
            sky: self.sky(),
            field: &self.asked.field,
            policy,
            telescope: self.asked.telescope.as_ref(),
            photometry: &self.asked.photometry,
        }
    }

    /// What is wanted of passes, as `passes` wants it.
    pub fn pass_options(&self, samples: usize) -> PassOptions {
        PassOptions {
            include_dark: false,
            min_probability: self.asked.policy.min_probability,
            samples,
            photometry: self.asked.photometry,
        }
    }
}

/// The evening's date of a night, as 2024-08-13.
pub fn date_of(evening_mjd: i64) -> String {
    let mut text = format_utc(Epoch::from_mjd_utc(evening_mjd as f64), 0);
    text.truncate(10);
    text
}

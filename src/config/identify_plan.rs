//! Checked measured streak, and the candidates for it.

use hifitime::Epoch;

use super::document::Config;
use super::prepared::PreparedSky;
use crate::error::Error;
use crate::frames::seconds_after;
use crate::identify::{CandidateRow, Identified, IdentifyOptions, MeasuredStreak, candidate_table, identify_streak};
use crate::output::Table;
use crate::passes::Exposure;

/// Measured streak, with the option that specified it.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifyPlan {
    /// Measured streak.
    pub streak: MeasuredStreak,
    /// Option that specified the position: `--end`, `--position-angle`, `--from-pix` or `--region`.
    pub source: &'static str,
    /// Sentences about times in the header of the frame that can be read in two ways.
    pub remarks: Vec<String>,
}

/// Choice of the candidates.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct IdentifySettings {
    /// True if satellites in the Earth's shadow are candidates; that of the configuration if `None`.
    pub include_dark: Option<bool>,
    /// Largest number of candidates in a table.
    pub top: usize,
}

/// Candidates of one streak.
#[derive(Clone, Debug)]
pub struct IdentifiedStreak {
    /// All candidates.
    pub found: Identified,
    /// Table of the first candidates; empty if no candidate fits, because all are far from the streak.
    pub candidates: Table,
    /// Warning about satellites whose positions cannot be computed.
    pub left_out: Option<String>,
}

impl IdentifySettings {
    /// Returns true if satellites in the Earth's shadow are candidates.
    pub fn includes_dark(&self, config: &Config) -> bool {
        self.include_dark.or(config.include_dark).unwrap_or(false)
    }
}

impl IdentifyPlan {
    /// Returns the begin and the end of the time in which the streak was made.
    pub fn span(&self) -> (Epoch, Epoch) {
        let start = self.streak.start();
        (start, seconds_after(start, self.streak.duration_s()))
    }

    /// Searches the candidates in a sky that is prepared for the time of the streak.
    ///
    /// # Errors
    /// The streak is below the horizon, or positions cannot be computed.
    pub fn identify(
        &self,
        config: &Config,
        prepared: &PreparedSky,
        settings: &IdentifySettings,
    ) -> Result<IdentifiedStreak, Error> {
        prepared.check_altitude("streak", &self.exposure())?;
        let options =
            IdentifyOptions { include_dark: settings.includes_dark(config), photometry: config.photometry()? };
        let found = identify_streak(&prepared.sky, &self.streak, &options)?;
        let left_out = prepared.left_out_warning(&found.left_out, self.streak.start())?;
        let top = if found.is_without_fit() { 0 } else { settings.top };
        let candidates = candidate_table(found.candidates.iter().take(top).map(|candidate| CandidateRow {
            candidate,
            elements: &prepared.sky.elements()[candidate.element_index],
            photometry: &options.photometry,
        }));
        Ok(IdentifiedStreak { found, candidates, left_out })
    }

    /// Returns an exposure at the time of the streak, pointed at its middle.
    fn exposure(&self) -> Exposure {
        Exposure {
            id: String::new(),
            start: self.streak.start(),
            duration_s: self.streak.duration_s(),
            pointing: self.streak.middle(),
            rotation_rad: 0.0,
        }
    }
}

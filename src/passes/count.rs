//! How many streaks exposures have at places of a site's sky: counted at several moments, for averages.

use hifitime::Epoch;

use super::exposure::Exposure;
use super::field::Field;
use super::sky::{PassOptions, Sky, SkyError};
use super::track::FieldPass;
use crate::frames::{Direction, EopTable, Horizontal, Orientation, seconds_after};
use crate::orbit::LeftOut;
use crate::photometry::PhotometryOptions;

/// What is counted: exposures of one length through one field.
#[derive(Clone, Debug)]
pub struct CountRequest<'a> {
    /// Azimuths and altitudes of the field's centre while the shutter opens; it then follows the stars.
    pub directions: &'a [Direction<Horizontal>],
    /// Shutter openings.
    pub moments: &'a [Epoch],
    /// Length of an exposure, seconds.
    pub duration_s: f64,
    /// The field, its y axis to the north.
    pub field: &'a Field,
    /// Band and system of the magnitudes.
    pub photometry: PhotometryOptions,
    /// Streaks brighter than this at their brightest are counted apart, mag.
    pub limit_mag: Option<f64>,
}

/// Streaks of one exposure.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct StreakCount {
    /// Lit satellites whose nominal tracks cross.
    pub streaks: usize,
    /// Those of them that are brighter than the limit; 0 without one.
    pub bright: usize,
}

/// Counts, and where the Sun stood.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// By moment, then by direction.
    pub by_moment: Vec<Vec<StreakCount>>,
    /// Altitude and azimuth of the Sun's centre in the middle of the exposures of each moment, radians, without refraction.
    pub sun_rad: Vec<(f64, f64)>,
    /// Satellites without a position for at least one of the exposures.
    pub left_out: Vec<LeftOut>,
}

impl Sky {
    /// Counts the streaks of an exposure at every moment in every direction.
    ///
    /// # Errors
    /// [`SkyError::NoHorizon`] for an observer in orbit; otherwise as [`Sky::field_passes`].
    pub fn streak_counts(&self, request: &CountRequest<'_>, eop: &EopTable) -> Result<Counts, SkyError> {
        let mut counts = Counts::default();
        let options = PassOptions { photometry: request.photometry, ..PassOptions::default() };
        let mut exposures = Vec::new();
        for &moment in request.moments {
            let observer = self.site_observer()?;
            let from_horizon = observer.state(&Orientation::at(moment, eop)).horizon.inverse();
            exposures.extend(request.directions.iter().map(|direction| Exposure {
                id: String::new(),
                start: moment,
                duration_s: request.duration_s,
                pointing: from_horizon * *direction,
                rotation_rad: 0.0,
            }));
            let middle = seconds_after(moment, request.duration_s / 2.0);
            counts.sun_rad.push(self.sun_altitude_azimuth_rad(middle, eop)?);
        }
        // Together, so that exposures near in time share their preparation.
        let passes = self.field_passes(&exposures, request.field, &options)?;
        let peak = |pass: &FieldPass| {
            pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref()).map(|brightness| brightness.magnitude.0)
        };
        let count = |passes: &Vec<FieldPass>| {
            let lit = || passes.iter().filter(|pass| pass.lit && pass.is_crossing());
            let is_bright =
                |pass: &&FieldPass| peak(pass).zip(request.limit_mag).is_some_and(|(mag, limit)| mag < limit);
            StreakCount { streaks: lit().count(), bright: lit().filter(is_bright).count() }
        };
        counts.by_moment = match request.directions.len() {
            0 => vec![Vec::new(); request.moments.len()],
            n => passes.by_exposure.chunks(n).map(|chunk| chunk.iter().map(count).collect()).collect(),
        };
        counts.left_out = passes.left_out;
        Ok(counts)
    }

    /// Altitude and azimuth (from north through east) of the Sun's centre, radians, without refraction and aberration (20").
    ///
    /// # Errors
    /// [`SkyError::NoHorizon`] for an observer in orbit, [`SkyError::NoEphemeris`] outside the years 1900 to 2100.
    pub fn sun_altitude_azimuth_rad(&self, moment: Epoch, eop: &EopTable) -> Result<(f64, f64), SkyError> {
        let state = self.site_observer()?.state(&Orientation::at(moment, eop));
        state.sun_altitude_azimuth_rad(moment).ok_or(SkyError::NoEphemeris { epoch: moment })
    }

    /// The first moment from `from` on, within a day, at which the Sun's centre stands at an altitude; `None` where it never does that day.
    ///
    /// # Errors
    /// As [`Sky::sun_altitude_azimuth_rad`].
    pub fn sun_reaches(&self, altitude_rad: f64, from: Epoch, eop: &EopTable) -> Result<Option<Epoch>, SkyError> {
        /// The Sun moves 2.5° meanwhile at most: it does not cross an altitude twice but about noon and midnight, where it hardly moves.
        const STEP_S: f64 = 600.0;
        /// Good to a thousandth of a degree.
        const CLOSE_S: f64 = 0.1;
        let above = |seconds: f64| -> Result<f64, SkyError> {
            Ok(self.sun_altitude_azimuth_rad(seconds_after(from, seconds), eop)?.0 - altitude_rad)
        };
        let mut low_s = 0.0;
        let mut low = above(low_s)?;
        while low_s < crate::constants::DAY_S {
            let mut high_s = low_s + STEP_S;
            let high = above(high_s)?;
            if low == 0.0 {
                return Ok(Some(seconds_after(from, low_s)));
            }
            if low * high < 0.0 {
                while high_s - low_s > CLOSE_S {
                    let middle_s = (low_s + high_s) / 2.0;
                    if above(middle_s)? * low > 0.0 { low_s = middle_s } else { high_s = middle_s }
                }
                return Ok(Some(seconds_after(from, (low_s + high_s) / 2.0)));
            }
            (low_s, low) = (high_s, high);
        }
        Ok(None)
    }
}

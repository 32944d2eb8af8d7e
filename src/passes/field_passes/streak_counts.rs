//! Numbers of streaks in exposures with given azimuths and altitudes at a site, at several times.

use hifitime::Epoch;

use super::super::altaz::AltAz;
use super::super::exposure::Exposure;
use super::super::field::Field;
use super::super::sky::Sky;
use super::super::track::Pass;
use super::options::PassOptions;
use crate::error::Error;
use crate::frames::{Direction, Horizontal, seconds_after};
use crate::orbit::LeftOut;
use crate::photometry::PhotometryOptions;

/// Exposures, all of one length and with one field, in which streaks are counted.
#[derive(Clone, Debug)]
pub struct CountRequest<'a> {
    /// Azimuths and altitudes of the centre of the field when the shutter opens; the telescope then tracks the stars.
    pub directions: &'a [Direction<Horizontal>],
    /// Times of shutter opening.
    pub moments: &'a [Epoch],
    /// Exposure time, seconds.
    pub duration_s: f64,
    /// Field of view, with its y axis to the north.
    pub field: &'a Field,
    /// Band and magnitude system.
    pub photometry: PhotometryOptions,
    /// Magnitude limit: streaks brighter than it are also counted.
    pub limit_mag: Option<f64>,
}

/// Numbers of streaks in one exposure.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct StreakCount {
    /// Number of sunlit satellites whose nominal tracks cross the field.
    pub streaks: usize,
    /// Expected number of these brighter than the limit, the sum of their probabilities; 0 without a limit.
    pub bright: f64,
}

/// Numbers of streaks, with the positions of the Sun.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Numbers of streaks by time, then by direction.
    pub by_moment: Vec<Vec<StreakCount>>,
    /// Position of the Sun's centre at the middle of the exposures of each time, without refraction.
    pub sun: Vec<AltAz>,
    /// Satellites without a position in at least one of the exposures.
    pub left_out: Vec<LeftOut>,
}

impl Sky {
    /// Counts the streaks of one exposure in every direction at every time.
    ///
    /// # Errors
    /// The observer is in orbit; otherwise the errors of [`Sky::field_passes`].
    #[doc(hidden)]
    pub fn streak_counts(&self, request: &CountRequest<'_>) -> Result<Counts, Error> {
        let mut counts = Counts::default();
        let options = PassOptions { photometry: request.photometry, ..PassOptions::default() };
        let mut exposures = Vec::new();
        for &start in request.moments {
            let orientation = self.orientation_over(start, start).at_s(0.0);
            let from_horizon = self.site_observer()?.state(&orientation).horizon.inverse();
            exposures.extend(request.directions.iter().map(|direction| Exposure {
                id: String::new(),
                start,
                duration_s: request.duration_s,
                pointing: from_horizon * *direction,
                rotation_rad: 0.0,
            }));
            let middle = seconds_after(start, request.duration_s / 2.0);
            counts.sun.push(self.sun_altaz(middle)?);
        }
        // All exposures form one query, so that exposures near in time share data that are computed once.
        // Positions along the orbit need not be known for numbers of streaks.
        let sky = self.clone().with_elements_of_any_age();
        let passes = sky.field_passes(&exposures, request.field, &options)?;
        let count = |passes: &Vec<Pass>| {
            let lit = || passes.iter().filter(|pass| pass.lit && pass.is_crossing());
            let bright = request
                .limit_mag
                .map_or(0.0, |limit_mag| lit().fold(0.0, |sum, pass| sum + pass.probability_brighter_than(limit_mag)));
            StreakCount { streaks: lit().count(), bright }
        };
        counts.by_moment = match request.directions.len() {
            0 => vec![Vec::new(); request.moments.len()],
            n => passes.by_exposure.chunks(n).map(|chunk| chunk.iter().map(count).collect()).collect(),
        };
        counts.left_out = passes.left_out;
        Ok(counts)
    }
}

//! A measured streak: where it lies, and when it was made.

use std::path::PathBuf;

use hifitime::Epoch;
use serde::Deserialize;

use super::error::QuestionError;
use super::streak_line::{Line, Place, place};
use crate::config::{Quantity, Setup, parse_angle_deg, parse_duration_s, parse_moment};
use crate::frames::seconds_between;
use crate::identify::{MeasuredStreak, Timing};
use crate::passes::Exposure;

/// One sigma of the clock, s.
const TIME_SIGMA_S: f64 = 0.5;
/// One sigma of an angle that was said, degrees.
const ANGLE_SIGMA_DEG: f64 = 1.0;

const WAYS: &str =
    "--end RA,DEC twice; --ra, --dec and --position-angle; --image with --from-pix and --to-pix; or --region FILE";

/// A streak as it was said: texts with their units, nothing resolved.
///
/// ```
/// let said: streakcast::config::StreakSaid =
///     serde_json::from_str(r#"{"end": ["325.4006,10.458", "325.4633,10.4838"], "exposure": "30s"}"#)?;
/// assert!(!said.whole_streak);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StreakSaid {
    /// Both ends, ICRS, each `RA,DEC`.
    pub end: Vec<String>,
    /// Right ascension of the middle, instead.
    pub ra: Option<String>,
    /// Declination of the middle.
    pub dec: Option<String>,
    /// Position angle of the line there, either direction, degrees from north through east.
    pub position_angle: Option<f64>,
    /// Its length with its unit, where that is known.
    pub length: Option<String>,
    /// A frame (FITS) with the streak: its coordinates and times.
    pub image: Option<PathBuf>,
    /// One end in the frame, `X,Y` counted from 1.
    pub from_pix: Option<String>,
    /// The other end.
    pub to_pix: Option<String>,
    /// HDU of the frame, from 0; the only image where unsaid.
    pub hdu: Option<usize>,
    /// A file of regions of DS9 drawn around the streak.
    pub region: Option<PathBuf>,
    /// One sigma of an end with its unit.
    pub place_sigma: Option<String>,
    /// One sigma of the position angle with its unit.
    pub angle_sigma: Option<String>,
    /// When the satellite was at the first and at the second end.
    pub times: Vec<String>,
    /// Shutter opening; the frame's where unsaid.
    pub start: Option<String>,
    /// Length of the exposure with its unit; the frame's where unsaid.
    pub exposure: Option<String>,
    /// Both ends are where the satellite was as the shutter opened and closed.
    pub whole_streak: bool,
    /// One sigma of the clock with its unit.
    pub time_sigma: Option<String>,
}

/// What is to be identified, and where it came from in words.
#[derive(Clone, Debug, PartialEq)]
pub struct StreakAsked {
    /// The streak.
    pub streak: MeasuredStreak,
    /// The way in which it was said: `--end`, `--position-angle`, `--from-pix` or `--region`.
    pub from: &'static str,
}

impl StreakAsked {
    /// The exposure of the streak, pointed at its middle: what a sky is held against.
    pub fn exposure(&self) -> Exposure {
        Exposure {
            id: String::new(),
            start: self.streak.start(),
            duration_s: self.streak.duration_s(),
            pointing: self.streak.place(),
            rotation_rad: 0.0,
        }
    }
}

impl StreakSaid {
    /// The streak that is meant; the files that it names are read.
    ///
    /// # Errors
    /// No streak or several, no time, a file that cannot be read, a place outside of the frame, numbers out of range.
    pub fn asked(&self, setup: &Setup) -> Result<StreakAsked, QuestionError> {
        let ways = self.ways();
        let from = match ways.as_slice() {
            [one] => *one,
            [] => return Err(QuestionError::said(format!("no streak; say {WAYS}"))),
            several => {
                let several = several.join(" and ");
                return Err(QuestionError::said(format!("{several} exclude each other; say {WAYS}")));
            }
        };
        let Place { line, sigma_arcsec } = place(self, from)?;
        let (start, duration_s, timing) = self.timed(setup)?;
        let said = self.place_sigma.as_deref();
        let sigma_deg = said.map_or(Ok(sigma_arcsec / 3600.0), |said| parse_angle_deg("place-sigma", said))?;
        let place_sigma_rad = sigma_deg.to_radians();
        let said = self.time_sigma.as_deref();
        let time_sigma_s = said.map_or(Ok(TIME_SIGMA_S), |said| parse_duration_s("time-sigma", said))?;
        let said = self.angle_sigma.as_deref();
        let angle_sigma_deg = said.map_or(Ok(ANGLE_SIGMA_DEG), |said| parse_angle_deg("angle-sigma", said))?;
        let time = (start, duration_s);
        let streak = match line {
            Line::Ends(ends) => MeasuredStreak::from_ends(ends, time, timing, place_sigma_rad, time_sigma_s)?,
            Line::Middle { place, angle_deg, length_deg } => MeasuredStreak::from_place(
                place,
                (angle_deg.to_radians(), angle_sigma_deg.to_radians()),
                length_deg.map(f64::to_radians),
                time,
                timing,
                place_sigma_rad,
                time_sigma_s,
            )?,
        };
        Ok(StreakAsked { streak, from })
    }

    /// The ways in which it was said.
    fn ways(&self) -> Vec<&'static str> {
        let middle = self.position_angle.is_some() || self.ra.is_some() || self.dec.is_some();
        let ways = [
            ("--end", !self.end.is_empty()),
            ("--position-angle", middle),
            ("--from-pix", self.from_pix.is_some() || self.to_pix.is_some()),
            ("--region", self.region.is_some()),
        ];
        ways.into_iter().filter(|(_, is_said)| *is_said).map(|(way, _)| way).collect()
    }

    /// Beginning and length of the time, and what is known of it.
    fn timed(&self, setup: &Setup) -> Result<(Epoch, f64, Timing), QuestionError> {
        let scale = setup.time_scale()?;
        match self.times.as_slice() {
            [] => {
                let timing = if self.whole_streak { Timing::Whole } else { Timing::Within };
                let (start, duration_s) = self.exposed(setup)?;
                Ok((start, duration_s, timing))
            }
            [first, second] => {
                let (first, second) = (parse_moment(first, scale)?, parse_moment(second, scale)?);
                let duration_s = seconds_between(first, second);
                if duration_s <= 0.0 {
                    return Err(QuestionError::said(format!(
                        "times: the second is {duration_s} s after the first; allowed: that of the first --end first, then that of the second, later"
                    )));
                }
                Ok((first, duration_s, Timing::FirstToSecond))
            }
            other => Err(QuestionError::said(format!("times: {}; allowed: two, one for each --end", other.len()))),
        }
    }

    /// When the shutter opened and for how long: as said, else as the configuration or the frame says.
    fn exposed(&self, setup: &Setup) -> Result<(Epoch, f64), QuestionError> {
        let said = |said: &Option<String>, configured: &Option<Quantity>| {
            said.clone().or(configured.as_ref().map(Quantity::text))
        };
        let scale = setup.time_scale()?;
        let start = said(&self.start, &setup.start).map(|start| parse_moment(&start, scale)).transpose()?;
        let duration_s =
            said(&self.exposure, &setup.exposure).map(|length| parse_duration_s("exposure", &length)).transpose()?;
        #[cfg(feature = "fits")]
        if let Some(path) = &self.image {
            return super::streak_frame::exposure(path, self.hdu, start, duration_s);
        }
        match (start, duration_s) {
            (Some(start), Some(duration_s)) => Ok((start, duration_s)),
            (None, _) => Err(QuestionError::said(
                "no start of the exposure; say --start 2024-08-14T00:30:00.000Z, or --times with both --end",
            )),
            (_, None) => Err(QuestionError::said("no length of the exposure; say --exposure 30s")),
        }
    }
}

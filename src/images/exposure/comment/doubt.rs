//! Uncertainties of times in comments, and remarks about clocks.

use super::clock::{OTHER_SCALES, UNIVERSAL};
use super::part::FILLERS;
use super::quantity::{HOUR_S, quantities};
use super::seconds::seconds_in;
use super::words::{CLOCK, Comment, EXPOSURE, PARTS, Role, lists};

/// Words of times that are only near the part of the exposure that the comment states.
const APPROXIMATE: &str = "approximate approximately approx estimated about nominal first";
/// Words of comments that state nothing else than a date, in addition to the words of exposures and clocks.
const NEUTRAL: &str = "as is was when which with on by taken acquired acquisition data gregorian calendar greenwich modified \
     coordinated international atomic standard matching ob day format iso isot iso8601 fits value number since nov days seconds hours sec \
     row midas desc typical yy hhmmss ddthh mmthh thh ss sss ssss mm 1st";
/// Words of errors of times.
const ERRORS: &str = "error uncertainty inaccuracy drift";
/// Words of remarks about clocks.
const CLOCK_ERRORS: &str = "offset error errors fast slow late early wrong corrected correction shifted drift";
/// Words of shifts of the start by a stated time.
const SHIFTS: &str =
    "offset error fast slow late later early earlier ahead behind delay delayed lag subtract add minus plus shifted";
/// Largest shift, uncertainty, or difference of starts and lengths that is not stated, seconds: satellites of low
/// orbits move by 0.1 deg in it.
pub const AGREED_S: f64 = 0.1;
/// Beginnings of statements of the uncertainty of a time.
const UNCERTAINTIES: &[&str] =
    &["+/-", "+-", "~", "accura", "uncertain", "error", "within", "tolerance", "precision", "off by"];

impl Comment {
    /// Returns the uncertainty of the time that the comment states, seconds, as in "+/- 30 s" or "accurate to 1 min".
    pub fn uncertainty_s(&self) -> Option<f64> {
        let lower = self.text.to_ascii_lowercase();
        UNCERTAINTIES.iter().find_map(|mark| {
            let rest = lower.split_once(mark)?.1;
            let rest = &rest[rest.find(|c: char| c.is_ascii_digit())?..];
            let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'))?;
            let unit = rest[end..].trim_start().split(|c: char| !c.is_ascii_alphabetic()).next()?;
            Some(rest[..end].parse::<f64>().ok()? * seconds_in(unit)?)
        })
    }

    /// Returns true if the comment states an uncertainty of more than 0.1 s, or that the value is approximate.
    pub fn is_approximate(&self) -> bool {
        self.has(APPROXIMATE) || self.uncertainty_s().is_some_and(|uncertainty_s| uncertainty_s > AGREED_S)
    }

    /// Returns true if a remark states that the times of the header are local, of the middle or the end, or wrong.
    pub fn is_about_times(&self) -> bool {
        let is_other_part = || matches!(self.role(None), Ok(Some(Role::Middle | Role::End)));
        let is_about = self.has("times timestamps timestamp clock") || self.has_pair("date", "obs");
        is_about && (self.is_local() || is_other_part() || self.has(CLOCK_ERRORS))
    }

    /// Returns true if the comment of a number states that it is the error of times.
    pub fn is_of_clock_error(&self) -> bool {
        let is_about = self.has("times clock timestamps") || self.has_pair("date", "obs");
        self.has_pair("time timing timestamp", ERRORS) || (is_about && self.has(ERRORS))
    }

    /// Returns true if the comment states a shift of more than 0.1 s, as in "start + 30 s", "UTC start (5 s delay)" and
    /// "30 s before start". Hours are those of a zone, and "TAI - 37 s" is a scale.
    pub(super) fn is_shifted(&self) -> bool {
        let lower = self.text.to_ascii_lowercase();
        lower.split([',', ';', '(', ')', '[', ']']).any(|clause| {
            let end = UNCERTAINTIES.iter().filter_map(|mark| clause.find(mark)).min();
            let clause = &clause[..end.unwrap_or(clause.len())];
            let has_word = Self::new(clause).has(SHIFTS);
            quantities(clause).iter().any(|shift| {
                let before = clause[..shift.at.start].trim_end();
                let of_sign = before.strip_suffix(['+', '-']).map(str::trim_end).is_some_and(|part| {
                    let word = part.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
                    !part.ends_with(|c: char| c.is_ascii_digit()) && !lists(OTHER_SCALES, word)
                });
                let next = clause[shift.at.end..].split_whitespace().next().unwrap_or_default();
                shift.number * shift.unit_s > AGREED_S
                    && shift.unit_s < HOUR_S
                    && (of_sign || has_word || lists("before after", next))
            })
        })
    }

    /// Returns true if the comment states that the time is only near a part of the exposure, or if it states no part
    /// and contains other words than those of a date, such as "trigger" and "clock unsynchronised".
    pub fn is_doubtful(&self) -> bool {
        let is_known = |word: &str| {
            [PARTS[0].1, EXPOSURE, CLOCK, FILLERS, UNIVERSAL, NEUTRAL].iter().any(|list| lists(list, word))
                || word.len() == 1
                || word.bytes().all(|byte| byte.is_ascii_digit())
        };
        self.has(APPROXIMATE) || self.is_shifted() || (self.parts().0.is_empty() && !self.words().all(is_known))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncertain_times_in_comments() {
        for (text, seconds) in [
            ("Exposure start (+/- 30 s)", Some(30.0)),
            ("UTC, accurate to 1 min", Some(60.0)),
            ("clock error < 0.5 s", Some(0.5)),
            ("UTC (precision: 10 ms)", Some(0.01)),
            ("precision of 3 digits", None),
            ("UT1-UTC < 1 s", None),
            ("start of exposure 30 s", None),
        ] {
            assert_eq!(Comment::new(text).uncertainty_s(), seconds, "{text}");
        }
        for text in [
            "UTC (5 s delay)",
            "GPS trigger time",
            "PPS",
            "clock unsynchronised",
            "Start of first exposure",
            "approx. start",
            "noon",
        ] {
            assert!(Comment::new(text).is_doubtful(), "{text}");
        }
        // Comments in headers of SDSS, DECam, ESO, TESS, wcslib, LCO and SBIG.
        for text in [
            "",
            "1st row - TAI",
            "UTC epoch",
            "Observing date",
            "TSTART as UTC calendar date",
            "ISO-8601 observation date matching MJD-OBS",
            "[UTC] Start date and time of the observation",
            "SBIGFITSEXT UTC of start exp. in ISO 8601",
            "Date of obs. YYYY-mm-ddTHH:MM:SS",
            "[s] UTC seconds of day at start",
            "trigger time, start of exposure",
            "UTC start, corrected for shutter delay",
            "UTC start (20 ms delay)",
        ] {
            assert!(!Comment::new(text).is_doubtful(), "{text}");
        }
    }
}

//! Local times and time scales in comments.

use hifitime::TimeScale;

use super::quantity::{HOUR_S, number_end, quantities};
use super::words::{Comment, lists};

/// Words of local times.
const LOCAL: &str = "local localtime locale lokal lokale lokalzeit ortszeit civil wall daylight sommerzeit winterzeit";
/// Words that form the name of a zone together with "time", "standard time" or "summer time".
const ZONE_NAMES: &str = "eastern mountain pacific atlantic newfoundland hawaii hawaiian alaska alaskan samoa \
     beijing china chinese taipei japan japanese tokyo korea korean india indian chile chilean argentina brazil \
     brasilia moscow european australian zealand africa african israel arabian gulf singapore london british irish \
     paris berlin madrid sydney zone observatory site station legal official standard summer winter";
/// Abbreviations of zone times, in capitals. EST is also short for "estimated" (SharpCap: "Est. Frame Start").
const ZONES: &str = "BJT WIB PST PDT MST MDT CST CDT EST EDT HST HDT AKST AKDT AST ADT NST NDT CET CEST EET EEST WEST BST \
     IST MEZ MESZ JST KST HKT SGT PKT AEST AEDT ACST ACDT AWST NZST NZDT MSK SAST CLT CLST BRT BRST LT LMT";
/// Computers whose clock may be local, and words of a clock.
const COMPUTERS: &str = "computer pc host laptop workstation system";
const COMPUTER_CLOCKS: &str = "time clock timestamp date";
/// Hours as units.
const HOURS: &str = "h hr hrs hour hours";
/// Words that an offset from universal time follows.
const WITH_OFFSET: &str = "ut utc gmt zone timezone local obs";
/// Abbreviations of other time scales, and words of universal time.
pub(super) const OTHER_SCALES: &str = "tai iat tt tdt tdb gps";
pub(super) const UNIVERSAL: &str = "ut utc ut1 gmt universal zulu";

impl Comment {
    /// Returns true if the comment states universal time.
    pub fn is_universal(&self) -> bool {
        self.has(UNIVERSAL)
    }

    /// Returns true if the comment states that a time was converted to universal time, as in "TSTART, expressed in
    /// UTC".
    pub fn is_converted_to_universal(&self) -> bool {
        let lower = self.text.to_ascii_lowercase();
        let is_converted = self.has("expressed converted") || lower.contains("tstart") || lower.contains("tstop");
        is_converted && self.has_pair("in as to into", UNIVERSAL) && !self.has("not")
    }

    /// Returns true if the comment states a local time.
    pub fn is_local(&self) -> bool {
        // "local time converted to UTC", "UTC = local + 7 h"
        let is_converted = self.has("converted") && !self.has("not never be must should");
        if is_converted && self.has_pair("to into", UNIVERSAL) {
            return false;
        }
        if let Some((name, sum)) = self.text.split_once('=').map(|(name, sum)| (Self::new(name), Self::new(sum)))
            && name.words().next().is_some()
            && name.words().all(|word| lists(UNIVERSAL, word))
        {
            // "UTC = DATE-OBS + 7 h"
            let is_hours = |word: &str| lists(HOURS, word.trim_start_matches(|c: char| c.is_ascii_digit()));
            return sum.has_pair("date time", "obs beg") && sum.words().any(is_hours);
        }
        // "UTC; local = UTC-7"
        let clauses = self.text.split([',', ';', '(', ')', '[', ']']).map(Self::new);
        let mut clauses = clauses.filter(|clause| !clause.clauses.is_empty());
        if let Some(first) = clauses.next() {
            let (defining, others): (Vec<Self>, Vec<Self>) = clauses.partition(Self::defines_local);
            if first.is_universal() && !defining.is_empty() {
                return first.is_local() || others.iter().any(Self::is_local);
            }
            // "MST (UTC = MST + 7 h)", "MST; UTC is 7 h ahead"
            let has_sum = |other: &Self| {
                let has_hours = || quantities(&other.text.to_ascii_lowercase()).iter().any(|sum| sum.unit_s == HOUR_S);
                other.is_universal() && (other.text.contains('=') || other.has("ahead behind") || has_hours())
            };
            if !first.is_universal() && others.iter().any(has_sum) && first.is_local() {
                return true;
            }
        }
        if self.has_offset() {
            return true;
        }
        // "UTC minus 7 hours", "not UTC"
        let is_denied = || {
            let others = self.words().filter(|word| lists(UNIVERSAL, word) || lists(OTHER_SCALES, word));
            (self.has_pair("not", UNIVERSAL) || self.has_pair("in", UNIVERSAL) && self.has_pair("not", "in"))
                && others.count() == 1
        };
        if self.has_pair(UNIVERSAL, "minus plus") || is_denied() {
            return true;
        }
        let is_universal = self.has(UNIVERSAL);
        // "local PC clock set to UTC"
        if self.has(LOCAL)
            && !(is_universal && self.has_pair("local", "site pc computer clock host server observatory"))
        {
            return true;
        }
        let has_number = self.text.contains(['+', '-']) && self.text.contains(|c: char| ('1'..='9').contains(&c));
        if self.has("timezone zone") && (!is_universal || has_number) {
            return true;
        }
        // "est." is short for estimated; HST is also the telescope.
        let is_zone =
            |word: &str| ZONES.split(' ').any(|zone| zone == word) && !self.text.contains(&format!("{word}."));
        !is_universal && (self.words().any(is_zone) || self.has_pair(ZONE_NAMES, "time standard summer zeit"))
    }

    /// Returns true if a clause states the offset of another time from universal time, or where that time is, as in
    /// "local = UTC-7", "MST is UTC - 7 h" and "local time: see DATE-LOC".
    fn defines_local(&self) -> bool {
        let is_other = |part: &Self| {
            part.has(LOCAL) || part.has("zone timezone site observatory") || part.words().any(|word| lists(ZONES, word))
        };
        match self.text.split_once('=') {
            Some((before, _)) => is_other(&Self::new(before)),
            None => {
                let has_sign = self.text.contains(['+', '-']) || self.has("minus plus");
                let has_offset = has_sign && self.text.contains(|c: char| c.is_ascii_digit());
                is_other(self) && (has_offset || self.has("see loc loctime localtim converted behind ahead no"))
            }
        }
    }

    /// Returns true if the comment states an offset from UTC of 1 to 14 h in quarters of an hour, such as `UTC-7`,
    /// `(GMT +5:30)`, and, if it does not state UTC, `-07:00` or `+7 h`. "0-24 h" is no offset.
    fn has_offset(&self) -> bool {
        let lower = self.text.to_ascii_lowercase();
        lower.match_indices(['+', '-']).any(|(at, _)| {
            let before = lower[..at].trim_end_matches([' ', ':', '=', '(']);
            let word = before.rsplit(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
            let rest = lower[at + 1..].trim_start();
            let (hours, unit) = rest.split_at(number_end(rest));
            // "UTC-0730"
            let basic = Some(hours).filter(|hours| hours.len() == 4).and_then(|hours| hours.parse::<u32>().ok());
            let minutes = unit.strip_prefix(':').map(|minutes| &minutes[..number_end(minutes)]);
            let is_clock = minutes.is_some_and(|minutes| minutes.len() == 2);
            let minutes = minutes.and_then(|text| text.parse::<f64>().ok()).unwrap_or(0.0);
            let hours = match basic {
                Some(basic) => f64::from(basic / 100) + f64::from(basic % 100) / 60.0,
                None => hours.parse::<f64>().unwrap_or(0.0) + minutes / 60.0,
            };
            let unit = unit.trim_start().split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
            let is_offset = (1.0..=14.0).contains(&hours) && (4.0 * hours).fract() == 0.0;
            let is_sign = !lower[..at].ends_with(|c: char| c == '/' || c.is_ascii_digit());
            let is_after_zone = lists(WITH_OFFSET, word);
            let is_stated =
                if self.is_universal() { is_after_zone } else { is_after_zone || is_clock || lists(HOURS, unit) };
            is_offset && is_sign && is_stated
        })
    }

    /// Returns true if the comment states a zone or an offset from universal time.
    pub fn is_of_zone(&self) -> bool {
        self.has("timezone") || self.has_pair("time", "zone") || (self.has("offset") && self.is_universal())
    }

    /// Returns true if the comment states another time scale than the given one, and not the given one.
    pub fn contradicts(&self, scale: TimeScale) -> bool {
        let names = match scale {
            TimeScale::UTC => UNIVERSAL,
            TimeScale::TAI => "tai iat",
            TimeScale::TT => "tt tdt et",
            TimeScale::TDB => "tdb",
            _ => "gps gpst",
        };
        let stated = self.scale().map(|stated| stated.unwrap_or(TimeScale::UTC));
        let is_stated = self.is_universal() || stated != Ok(TimeScale::UTC);
        is_stated && stated.is_ok_and(|stated| stated != scale) && !self.has(names)
    }

    /// Returns the digits after `TAI -`; `None` if there are none.
    fn offset_from_tai(&self) -> Option<String> {
        let upper = self.text.to_ascii_uppercase();
        let rest = upper.split_once("TAI")?.1.trim_start();
        let rest = rest.strip_prefix('-').or_else(|| rest.strip_prefix("MINUS"))?.trim_start();
        let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
        (!digits.is_empty()).then_some(digits)
    }

    /// Returns the time scale that the comment states, other than UTC.
    ///
    /// # Errors
    /// The clock of a computer, which may be local, a scale that is not supported, TAI minus other than the 37 s of UTC
    /// since 2017, or GPS time, which is also a name for the UTC of a GPS receiver, 18 s earlier.
    pub fn scale(&self) -> Result<Option<TimeScale>, &'static str> {
        if self.has(UNIVERSAL) {
            return Ok(None);
        }
        if self.has_pair(COMPUTERS, COMPUTER_CLOCKS) && !self.has_pair("system", "clock time") {
            return Err("of the clock of a computer, which may be local,");
        }
        if self.has("GPST")
            || self.has_pair("gps", "time times scale week seconds")
            || self.words().all(|word| word == "GPS")
        {
            return if self.clauses.is_empty() { Ok(None) } else { Err("in GPS time or in UTC of a GPS receiver") };
        }
        // "TAI - 37 s" is UTC.
        if let Some(offset) = self.offset_from_tai() {
            return if offset == "37" { Ok(None) } else { Err("in TAI minus another number of seconds than 37") };
        }
        let is = |name: &str| self.words().any(|word| word == name);
        if is("TCB") || is("TCG") {
            Err("in coordinate time")
        } else if is("TAI") || is("IAT") || self.has_pair("atomic", "time") {
            Ok(Some(TimeScale::TAI))
        } else if is("TT") || is("TDT") || self.has_pair("terrestrial ephemeris", "time dynamical") {
            Ok(Some(TimeScale::TT))
        } else if is("TDB") {
            Ok(Some(TimeScale::TDB))
        } else {
            Ok(None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_scales_than_timesys_are_contradictions() {
        for (text, scale, is_other) in [
            ("TAI at start", TimeScale::UTC, true),
            ("UTC at start", TimeScale::TAI, true),
            ("TAI (not UTC)", TimeScale::TAI, false),
            ("UTC (TAI - 37 s)", TimeScale::UTC, false),
            ("start of exposure", TimeScale::TAI, false),
        ] {
            assert_eq!(Comment::new(text).contradicts(scale), is_other, "{text}");
        }
    }

    #[test]
    fn times_that_were_converted_to_utc() {
        for (text, is_converted) in [
            ("TSTART, expressed in UTC", true),
            ("TSTART as UTC calendar date", true),
            ("converted to UTC", true),
            ("Start Time (UTC) of exposure", false),
            ("TSTART", false),
            ("TSTART, not expressed in UTC", false),
        ] {
            assert_eq!(Comment::new(text).is_converted_to_universal(), is_converted, "{text}");
        }
    }

    #[test]
    fn clocks_of_computers_may_be_local() {
        for text in ["computer clock time", "PC time", "host time at start"] {
            assert!(Comment::new(text).scale().is_err(), "{text}");
        }
        for text in ["PC clock, UTC", "System Clock:Est. Frame Start", "System time", "host name"] {
            assert_eq!(Comment::new(text).scale(), Ok(None), "{text}");
        }
    }
}

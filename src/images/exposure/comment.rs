//! Comments of header cards: what they state about the instant, the unit or the number of parts of a value.

use hifitime::TimeScale;

/// Part of an exposure to which an instant refers.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Role {
    Start,
    Middle,
    End,
}

const STARTS: &[&str] = &[
    "start",
    "starts",
    "started",
    "starting",
    "begin",
    "begins",
    "beginning",
    "began",
    "beg",
    "open",
    "opens",
    "opened",
    "opening",
];
const MIDDLES: &[&str] = &[
    "mid",
    "middle",
    "midpoint",
    "midpoints",
    "midpt",
    "midtime",
    "midexp",
    "midexposure",
    "midobs",
    "midobservation",
    "midframe",
    "midscan",
    "midway",
    "half",
    "halfway",
    "effective",
    "weighted",
    "center",
    "centre",
    "central",
    "average",
    "averaged",
    "avg",
    "mean",
];
const ENDS: &[&str] = &[
    "end",
    "ends",
    "ended",
    "ending",
    "endexp",
    "endobs",
    "finish",
    "finished",
    "stop",
    "stops",
    "stopped",
    "close",
    "closes",
    "closed",
    "closing",
    "completion",
    "completed",
];
/// Words of events after the exposure, at an unknown delay.
const EVENTS: &[&str] = &[
    "received",
    "reception",
    "arrival",
    "arrived",
    "created",
    "creation",
    "saved",
    "saving",
    "stored",
    "written",
    "writing",
    "write",
    "generated",
    "modified",
    "downloaded",
    "download",
    "transferred",
    "readout",
];
const CORRECTED: &[&str] = &["heliocentric", "barycentric", "hjd", "bjd", "bmjd", "hmjd"];
/// Abbreviations of zone times, in capitals. EST is also short for "estimated" (SharpCap: "Est. Frame Start").
const ZONES: &[&str] = &[
    "PST", "PDT", "MST", "MDT", "CST", "CDT", "EST", "EDT", "HST", "AKST", "AKDT", "CET", "CEST", "EET", "EEST",
    "WEST", "BST", "JST", "KST", "AEST", "AEDT", "ACST", "AWST", "NZST", "NZDT", "MSK", "SAST", "CLT", "CLST", "BRT",
    "LT", "LMT",
];
const UNIVERSAL: &[&str] = &["ut", "utc", "ut1", "gmt", "universal", "zulu"];

/// Comment of a card with its words.
#[derive(Clone, Debug)]
pub struct Comment {
    text: String,
    /// Words as written: runs of letters and digits.
    words: Vec<String>,
}

impl Comment {
    pub fn new(text: &str) -> Self {
        let words = text.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
        Self { text: text.to_owned(), words: words.map(str::to_owned).collect() }
    }

    /// Returns the text without surrounding blanks.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns true if the comment contains one of these words (in lower case).
    pub fn has(&self, words: &[&str]) -> bool {
        self.words.iter().any(|word| words.iter().any(|other| word.eq_ignore_ascii_case(other)))
    }

    /// Returns the part of the exposure that the comment states; `None` if it states none. `named` is the part that the
    /// name of the keyword states; it applies if the comment mentions several parts.
    ///
    /// # Errors
    /// The reason why the instant cannot be used: it is a local time, or the time of another event, or the comment
    /// mentions several parts, or another part than the name.
    pub fn role(&self, named: Option<Role>) -> Result<Option<Role>, &'static str> {
        if self.has(&["sidereal", "lst"]) {
            return Err("a sidereal time");
        }
        if self.is_local() {
            return Err("a local time");
        }
        if self.has(CORRECTED) {
            return Err("a time corrected to the Sun or the barycentre");
        }
        if self.has(EVENTS) {
            return Err("the time of an event after the exposure");
        }
        let is_mean_time = self.words.windows(2).any(|pair| {
            pair[0].eq_ignore_ascii_case("mean")
                && ["time", "solar"].iter().any(|next| pair[1].eq_ignore_ascii_case(next))
        });
        let middles = if is_mean_time { &MIDDLES[..MIDDLES.len() - 1] } else { MIDDLES };
        let parts = [(STARTS, Role::Start), (middles, Role::Middle), (ENDS, Role::End)];
        let stated: Vec<Role> = parts.iter().filter(|(words, _)| self.has(words)).map(|(_, role)| *role).collect();
        match (&stated[..], named) {
            ([], named) => Ok(named),
            ([role], Some(named)) if *role != named => Err("not the part of the exposure that the keyword names,"),
            ([role], _) => Ok(Some(*role)),
            (_, Some(named)) => Ok(Some(named)),
            (_, None) => Err("of more than one part of the exposure"),
        }
    }

    /// Returns true if the comment states a local time.
    pub fn is_local(&self) -> bool {
        if self.has(&["local", "localtime", "civil", "wall", "timezone"]) {
            return true;
        }
        if self.has_offset() {
            return true;
        }
        // "est." is short for estimated; HST is also the telescope.
        let is_zone = |word: &String| ZONES.contains(&word.as_str()) && !self.text.contains(&format!("{word}."));
        !self.has(UNIVERSAL) && self.words.iter().any(is_zone)
    }

    /// Returns true if the comment states an offset from UTC other than 0, such as `UTC-7` or `(GMT +5:30)`.
    fn has_offset(&self) -> bool {
        let lower = self.text.to_ascii_lowercase();
        ["utc", "gmt", "ut"].iter().any(|name| {
            lower.match_indices(name).any(|(at, _)| {
                let rest = lower[at + name.len()..].trim_start();
                let is_word = !lower[..at].ends_with(|c: char| c.is_ascii_alphanumeric());
                let digits = rest
                    .strip_prefix(['+', '-'])
                    .map(|rest| rest.trim_start().split(|c: char| c != ':' && !c.is_ascii_digit()));
                let offset = digits.and_then(|mut digits| digits.next()).unwrap_or_default();
                is_word && offset.len() <= 5 && offset.contains(|c: char| ('1'..='9').contains(&c))
            })
        })
    }

    /// Returns the time scale that the comment states, other than UTC.
    pub fn scale(&self) -> Option<TimeScale> {
        if self.has(UNIVERSAL) {
            return None;
        }
        let is = |name: &str| self.words.iter().any(|word| word == name);
        if is("TAI") {
            Some(TimeScale::TAI)
        } else if is("TT") {
            Some(TimeScale::TT)
        } else if is("TDB") {
            Some(TimeScale::TDB)
        } else {
            None
        }
    }

    /// Returns the number of seconds in the unit of time that the comment states; `None` if it states none.
    ///
    /// A unit in brackets at the beginning (FITS standard 4.0, section 4.3.2) takes precedence over words.
    ///
    /// # Errors
    /// An unknown unit in brackets, or several units.
    pub fn unit_s(&self) -> Result<Option<f64>, String> {
        if let Some((unit, _)) = self.text.trim_start().strip_prefix('[').and_then(|rest| rest.split_once(']'))
            && unit.bytes().any(|byte| byte.is_ascii_alphabetic())
        {
            return seconds_in(unit.trim()).map(Some).ok_or_else(|| format!("the unit [{}]", unit.trim()));
        }
        let lower = self.text.to_ascii_lowercase();
        // Characters that are not ASCII, such as the Greek letter of microseconds, are read as question marks.
        if lower.contains("?s") {
            return Err("a unit that is not ASCII".to_owned());
        }
        // Short words are units only in brackets, after "in" or "unit", or alone: "(s)", "in min", "hr".
        let is_short =
            |word: &str| word.len() <= 2 && !["us", "ms", "ns"].contains(&word) || ["min", "day"].contains(&word);
        let marks = ["(", "[", "in ", "unit ", "units ", "unit:", "unit=", "unit: ", "unit = ", "units: ", "units = "];
        let is_marked =
            |word: &str| lower.trim() == word || marks.iter().any(|mark| lower.contains(&format!("{mark}{word}")));
        let words = lower.split(|c: char| !c.is_ascii_alphabetic());
        let mut units: Vec<f64> =
            words.filter(|word| !is_short(word) || is_marked(word)).filter_map(seconds_in).collect();
        units.sort_by(f64::total_cmp);
        units.dedup();
        let part = [("thousandth", 1e-3), ("hundredth", 1e-2), ("tenth", 1e-1)];
        let part = part.iter().find(|(word, _)| lower.contains(word)).map_or(1.0, |(_, part)| *part);
        match units[..] {
            [] => Ok(None),
            [one] => Ok(Some(part * one)),
            _ => Err("several units".to_owned()),
        }
    }
}

/// Returns the number of seconds in a unit of time, for example `ms`, `[10 us]` or `hours`; `None` for other words.
pub fn seconds_in(unit: &str) -> Option<f64> {
    let digits = unit.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(0);
    let factor: f64 = if digits > 0 { unit[..digits].parse().ok()? } else { 1.0 };
    let name = unit[digits..].trim().trim_end_matches('.');
    let seconds = match name.to_ascii_lowercase().as_str() {
        "s" | "sec" | "secs" | "second" | "seconds" => 1.0,
        "ds" | "decisecond" | "deciseconds" => 0.1,
        "cs" | "centisecond" | "centiseconds" => 1e-2,
        "ms" | "msec" | "msecs" | "millisec" | "millisecs" | "millisecond" | "milliseconds" => 1e-3,
        "us" | "usec" | "usecs" | "microsec" | "microsecs" | "microsecond" | "microseconds" => 1e-6,
        "ns" | "nsec" | "nanosec" | "nanosecond" | "nanoseconds" => 1e-9,
        "ks" | "ksec" | "kilosecond" | "kiloseconds" => 1e3,
        "min" | "mins" | "minute" | "minutes" => 60.0,
        "h" | "hr" | "hrs" | "hour" | "hours" => 3600.0,
        "d" | "day" | "days" => crate::constants::DAY_S,
        _ => return None,
    };
    Some(factor * seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_in_comments() {
        for (text, role) in [
            ("UTC at midpoint of exposure", Ok(Some(Role::Middle))),
            ("[UTC] Mid-exposure", Ok(Some(Role::Middle))),
            ("Observation mean time", Ok(None)),
            ("Greenwich Mean Time", Ok(None)),
            ("mean of the exposure, UT", Ok(Some(Role::Middle))),
            ("UTC seconds since midnight", Ok(None)),
            ("MIDAS desc.: O_TIME(1)", Ok(None)),
            ("Gregorian calendar date of the observation", Ok(None)),
            ("System Clock:Est. Frame Start", Ok(Some(Role::Start))),
            ("SYSTEM CLOCK:EST. FRAME END", Ok(Some(Role::End))),
            ("shutter closed", Ok(Some(Role::End))),
            ("System Clock:Frame Received", Err("the time of an event after the exposure")),
            ("Image created time", Err("the time of an event after the exposure")),
            ("Start of readout", Err("the time of an event after the exposure")),
            ("Local time at start", Err("a local time")),
            ("MST, start", Err("a local time")),
            ("Local sidereal time", Err("a sidereal time")),
            ("start, UTC-7", Err("a local time")),
            ("computer clock (GMT +5:30)", Err("a local time")),
            ("UTC+0, start", Ok(Some(Role::Start))),
            ("UT1-UTC < 1 s", Ok(None)),
            ("half-way through the exposure", Ok(Some(Role::Middle))),
            ("BJD of start", Err("a time corrected to the Sun or the barycentre")),
            ("start or end of exposure", Err("of more than one part of the exposure")),
        ] {
            assert_eq!(Comment::new(text).role(None), role, "{text}");
        }
        assert_eq!(Comment::new("mean of start and end").role(Some(Role::Middle)), Ok(Some(Role::Middle)));
        assert!(Comment::new("end of exposure").role(Some(Role::Start)).is_err());
    }

    #[test]
    fn units_in_comments() {
        for (text, seconds) in [
            ("", Ok(None)),
            ("[s] Exposure duration", Ok(Some(1.0))),
            ("[sec] at most 5 minutes", Ok(Some(1.0))),
            ("[d] time on source", Ok(Some(86400.0))),
            ("[10 us] steps", Ok(Some(10.0 * 1e-6))),
            ("[ks]", Ok(Some(1e3))),
            ("Exposure time (s)", Ok(Some(1.0))),
            ("Exposure time (h)", Ok(Some(3600.0))),
            ("exposure in min", Ok(Some(60.0))),
            ("Observation: Exposure Minutes", Ok(Some(60.0))),
            ("min exposure", Ok(None)),
            ("exposure of the day", Ok(None)),
            ("us", Ok(Some(1e-6))),
            ("hr", Ok(Some(3600.0))),
            ("unit = d", Ok(Some(86400.0))),
            ("exposure time in hundredths of a second", Ok(Some(1e-2))),
            ("[0:3600] exposure", Ok(None)),
            ("[furlong] exposure", Err("the unit [furlong]".to_owned())),
            ("seconds, not ms", Err("several units".to_owned())),
            ("exposure (?s)", Err("a unit that is not ASCII".to_owned())),
        ] {
            assert_eq!(Comment::new(text).unit_s(), seconds, "{text}");
        }
    }
}

//! Part of the exposure to which an instant refers, by the comment of its card.

use super::clock::{OTHER_SCALES, UNIVERSAL};
use super::seconds::seconds_in;
use super::words::{CLOCK, Comment, EXPOSURE, PARTS, Role, lists};

/// Words of the end that have another meaning before a noun.
const ADJECTIVES: &str = "complete off";
/// Words between a part and what it qualifies.
pub(super) const FILLERS: &str = "of the at to a an in and or between this first each actual through during for from de du der des la le da do della \
     est";
/// Words of periods that contain other exposures.
const PERIODS: &str = "block blocks ob sequence sequences series night run session program programme queue script";
/// Ends and middles as sums or in languages in which the word alone has other meanings, without blanks, in lower case.
const PHRASES: &[(Role, &[&str])] = &[
    // The end minus the exposure time
    (Role::Start, &["-exptime", "-texp", "-t_exp", "-xposure", "minusexp"]),
    (Role::Middle, &["50%of", "50%exp", "end)/2", "stop)/2", "metaposa", "metaesposizione"]),
    (Role::End, &["+exp", "+texp", "+t_exp", "+xposure", "plusexp", "fineesposizione", "finedell", "fineposa"]),
];
/// Beginnings of names of the exposure time in formulas, and a half of it before and after such a name.
const LENGTHS: &[&str] = &["exp", "texp", "t_exp", "xpos", "itime", "integ", "dur", "telapse", "dit"];
const HALVES_BEFORE: &[&str] = &["0.5*", "1/2*", "+1/2", "0.5x", ".5*", "half*"];
const HALVES_AFTER: &[&str] = &["/2", "*0.5", "*.5"];
/// Words of another event, unless the comment states a part of this exposure.
const OTHERS: &str = "previous preceding next following last after post recorded recording grabbed";
/// Words of times before the exposure.
const PLANS: &str = "planned intended requested scheduled proposed";
/// Words of events after the exposure, at an unknown delay.
const EVENTS: &str = "received reception arrival arrived created creation saved saving stored written writing write \
     generated modified downloaded download transferred transfer readout";
/// Words of the program that wrote the keyword, as in "UTC, written by TCS".
const WRITERS: &str = "written created generated modified stored saved";
/// Words with which a part beside such an event is not that of the time.
const UNSTATED: &str = "plus after not no unknown file packet";
/// Words of times at the Sun or the barycentre.
const CORRECTED: &str = "heliocentric barycentric hjd bjd bmjd hmjd";
/// Reason why the time of such an event cannot be used.
pub const AFTER_EXPOSURE: &str = "the time of an event after the exposure";
/// Reason why a comment without a clear part cannot be used.
const UNCLEAR: &str = "perhaps of another part of the exposure, or of another event,";

impl Comment {
    /// Returns the part of the exposure that the comment states; `None` if it states none. `named` is the part that the
    /// name of the keyword states; it applies if the comment mentions several parts.
    ///
    /// # Errors
    /// The reason why the instant cannot be used: it is a local time, or the time of another event, or the comment
    /// mentions several parts, or another part than the name.
    pub fn role(&self, named: Option<Role>) -> Result<Option<Role>, &'static str> {
        if self.has("sidereal siderial lst lmst gmst gast") {
            return Err("a sidereal time");
        }
        if self.is_local() {
            return Err("a local time");
        }
        if self.has(CORRECTED) {
            return Err("a time corrected to the Sun or the barycentre");
        }
        if self.has("rjd tjd djd")
            || self.has_pair("reduced truncated dublin", "jd julian")
            || self.text.match_indices("24000").any(|(at, _)| {
                let rest = &self.text[at..];
                let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.' || c == ',')).unwrap_or(rest.len());
                let day = rest[..end].replace(',', ".").trim_end_matches('.').parse::<f64>();
                day.is_ok_and(|day| day < 2_500_000.0 && day != 2_400_000.5)
            })
        {
            return Err("a Julian date from another day on");
        }
        if self.has(PLANS) {
            return Err("a planned time");
        }
        // "start + 30 s"
        let has_part = PARTS.iter().any(|(_, list)| self.has(list));
        if self.is_of_period() || (has_part && self.is_shifted()) {
            return Err(UNCLEAR);
        }
        let (stated, is_unclear) = self.parts();
        let has_event = self.has(EVENTS) && !self.has_pair("daylight", "saving savings");
        if has_event && !self.is_of_writer() && (stated.is_empty() || !self.begins_with_part()) {
            return Err(AFTER_EXPOSURE);
        }
        match (&stated[..], named) {
            ([], None) if is_unclear => Err(UNCLEAR),
            ([], named) => Ok(named),
            ([role], Some(named)) if *role != named => Err("not the part of the exposure that the keyword names,"),
            ([role], _) => Ok(Some(*role)),
            (_, Some(named)) => Ok(Some(named)),
            // "mean of start and end"
            ([Role::Start, Role::Middle, Role::End], None) if self.has_pair(PARTS[1].1, "of between") => {
                Ok(Some(Role::Middle))
            }
            (_, None) => Err("of more than one part of the exposure"),
        }
    }

    /// Returns true if the only event in the comment is the writing of the keyword, as in "[UTC] written by TCS".
    fn is_of_writer(&self) -> bool {
        let is_keyword = |word: &String| lists(UNIVERSAL, word) || lists("keyword header card value", word);
        let is_by = |words: &Vec<String>| {
            let at = words.windows(2).position(|pair| lists(WRITERS, &pair[0]) && pair[1] == "by");
            at.is_some_and(|at| words[..at].iter().all(is_keyword))
        };
        self.words().filter(|word| lists(EVENTS, word)).count() == 1 && self.clauses.iter().any(is_by)
    }

    /// Returns true if the comment begins with a part of the exposure, as "start of exposure, which ends with readout".
    fn begins_with_part(&self) -> bool {
        let first = self.words().find(|word| !lists(CLOCK, word) && !lists(FILLERS, word));
        let is_part = |word: &str| PARTS.iter().any(|(_, list)| lists(list, word));
        first.is_some_and(is_part) && !self.has(UNSTATED) && !self.text.contains('+')
    }

    /// Returns the parts that the comment states, and true if other words may state the middle, the end or an event.
    pub(super) fn parts(&self) -> (Vec<Role>, bool) {
        // "UTC (DATE-END: end)" concerns other keywords from their first name on.
        let is_keyword = |pair: &[String]| {
            ["DATE", "MJD", "JD", "TIME", "UT", "UTC"].contains(&pair[0].as_str())
                && ["BEG", "OBS", "AVG", "MID", "END", "STR", "STOP"].contains(&pair[1].as_str())
                && ['-', '_'].iter().any(|sign| self.text.contains(&format!("{}{sign}{}", pair[0], pair[1])))
        };
        let others_from = self.clauses.iter().position(|words| words.windows(2).any(is_keyword));
        let of_others = others_from.is_some();
        // The hyphen of "mid-exptime" is no minus.
        let mut lower = format!(" {}", self.text.to_ascii_lowercase());
        for word in ["mid", "middle", "half", "post", "pre", " end"] {
            lower = lower.replace(&format!("{word}-"), word);
        }
        let joined: String = lower.split_ascii_whitespace().collect();
        let phrase = PHRASES.iter().find(|(role, list)| {
            (*role != Role::End || !of_others || is_sum(&joined)) && list.iter().any(|phrase| joined.contains(phrase))
        });
        let mut stated: Vec<Role> = phrase.map(|(role, _)| *role).into_iter().collect();
        if has_half(&joined) {
            stated = vec![Role::Middle];
        }
        // "start + exptime/2", "DATE-BEG + EXPTIME"
        if matches!(stated[..], [Role::Start | Role::Middle]) || (stated == [Role::End] && is_sum(&joined)) {
            return (stated, false);
        }
        let mut is_unclear = self.has(OTHERS);
        for (clause, words) in self.clauses.iter().enumerate() {
            let of_others = others_from.is_some_and(|from| clause >= from);
            for (role, list) in PARTS {
                for (at, _) in words.iter().enumerate().filter(|(_, word)| lists(list, word)) {
                    // "Complete timestamp", but "exposure complete".
                    let is_adjective = lists(ADJECTIVES, &words[at])
                        && !(at > 0 && lists(EXPOSURE, &words[at - 1]))
                        && words.len() > at + 1;
                    if is_adjective || is_of_event(words, at) {
                        continue;
                    }
                    // "UTC, not at the exposure end", but "not start" is of another part, and "not UTC at end" of the
                    // end.
                    let is_part = |word: &str| PARTS.iter().any(|(_, list)| lists(list, word));
                    let is_scale = |word: &str| lists(UNIVERSAL, word) || lists(OTHER_SCALES, word);
                    let is_between = |word: &str| {
                        let is_noun = lists(EXPOSURE, word) || (lists(CLOCK, word) && !is_scale(word));
                        is_noun || lists(FILLERS, word) || is_part(word)
                    };
                    let before = words[..at].iter().rev().find(|word| !is_between(word));
                    if before.is_some_and(|word| word.eq_ignore_ascii_case("not")) {
                        is_unclear |= *role == Role::Start;
                        continue;
                    }
                    match qualifies(words, at) {
                        Some(true) if !of_others || (*role == Role::Start && stated.is_empty()) => stated.push(*role),
                        None => {}
                        _ => is_unclear |= *role != Role::Start,
                    }
                }
            }
        }
        stated.sort_by_key(|role| *role as u8);
        stated.dedup();
        (stated, is_unclear)
    }

    /// Returns true if the comment states a part of a period with other exposures, as in "start of observation block",
    /// but not in "start of exposure in sequence".
    fn is_of_period(&self) -> bool {
        let is_part = |word: &String| PARTS.iter().any(|(_, list)| lists(list, word));
        self.clauses.iter().any(|words| {
            let Some(part) = words.iter().position(is_part) else { return false };
            let period = words[part..].iter().position(|word| lists(PERIODS, word));
            // The word before that of the period may belong to it.
            period.is_some_and(|at| {
                let is_of_exposure = words.get(part + at + 1).is_some_and(|word| lists(EXPOSURE, word));
                let before = &words[part..(part + at).saturating_sub(1)];
                !is_of_exposure && !before.iter().any(|word| lists(EXPOSURE, word))
            })
        })
    }
}

/// Returns true if a text without blanks contains a half of the exposure time, such as `0.5*texp` and `exptime/2`.
fn has_half(joined: &str) -> bool {
    LENGTHS.iter().any(|length| {
        let is_before = HALVES_BEFORE.iter().any(|half| joined.contains(&format!("{half}{length}")));
        let is_after = || {
            joined.match_indices(length).any(|(at, _)| {
                let rest = joined[at..].trim_start_matches(|c: char| c.is_ascii_alphabetic() || c == '_');
                HALVES_AFTER.iter().any(|half| {
                    rest.strip_prefix(half).is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()))
                })
            })
        };
        is_before || is_after()
    })
}

/// Returns true if a text without blanks is the sum of another keyword and a name, as in `date-beg+exptime`, but not
/// `mjd-obs+exptime/172800`.
fn is_sum(joined: &str) -> bool {
    let rest = joined.trim_start_matches(['(', '[', '=']);
    let name = rest.find(|c: char| c != '-' && !c.is_ascii_alphanumeric()).map_or(rest, |end| &rest[..end]);
    let Some(added) = rest[name.len()..].strip_prefix('+') else { return false };
    let end = added.trim_start_matches(|c: char| c == '_' || c.is_ascii_alphabetic());
    name.contains('-') && (end.is_empty() || end.starts_with(['(', ')', ']', ',', ';']))
}

/// Returns true if a word of a part qualifies an event after the exposure, as in "start of image transfer" and "readout
/// start time", but not in "end of exposure before readout".
fn is_of_event(words: &[String], at: usize) -> bool {
    let is_clock = |word: &String| lists(FILLERS, word) || lists(CLOCK, word);
    // "start time saved by the server" is a start.
    let is_noun = |word: &String| lists(EVENTS, word) && !word.ends_with("ed") && word != "written";
    let is_event = |word: Option<&String>| word.is_some_and(is_noun);
    let mut rest = words[at + 1..].iter().skip_while(|word| is_clock(word));
    match rest.next() {
        None => is_event(words[..at].iter().rev().find(|word| !is_clock(word))),
        Some(next) => is_event(Some(next)) || (lists(EXPOSURE, next) && is_event(rest.next())),
    }
}

/// Returns true if a word of a part qualifies the time or the exposure, false if it may, and `None` if it does not. The
/// word that follows in the clause decides, or else the word that precedes.
fn qualifies(words: &[String], at: usize) -> Option<bool> {
    // "start of the 30 s exposure"
    let is_number = |word: &str| word.starts_with(|c: char| c.is_ascii_digit());
    let is_unit = |at: usize| at > 0 && is_number(&words[at - 1]) && seconds_in(&words[at]).is_some();
    let counts = |at: &usize| !lists(FILLERS, &words[*at]) && !is_number(&words[*at]) && !is_unit(*at);
    let next = (at + 1..words.len()).find(counts).map(|at| &words[at]);
    let previous = (0..at).rev().find(counts).map(|at| &words[at]);
    let is_part = |word: &str| PARTS.iter().any(|(_, list)| lists(list, word));
    match (next, previous) {
        (Some(next), _) if lists(EXPOSURE, next) || lists(CLOCK, next) || is_part(next) => Some(true),
        (Some(_), Some(previous)) if lists(EXPOSURE, previous) => Some(true),
        (None, Some(previous)) if lists(EXPOSURE, previous) || lists(CLOCK, previous) || is_part(previous) => {
            Some(true)
        }
        (None, None) => Some(true),
        // The name of a place, such as "Goddard Space Flight Center".
        (None, Some(_)) if lists("center centre", &words[at]) => None,
        (Some(_), _) if lists("centro", &words[at]) => None,
        _ => Some(false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_in_comments() {
        for (text, role) in [
            ("UTC at midpoint of exposure", Ok(Some(Role::Middle))),
            ("[UTC] Mid-exposure", Ok(Some(Role::Middle))),
            ("Observation mean time", Ok(Some(Role::Middle))),
            ("mean time of exposure", Ok(Some(Role::Middle))),
            ("average of start and end", Ok(Some(Role::Middle))),
            ("DATE-OBS + 0.5*EXPTIME", Ok(Some(Role::Middle))),
            ("UT at t_start + 0.5*texp", Ok(Some(Role::Middle))),
            ("start + 1/2 exp (UTC)", Ok(Some(Role::Middle))),
            ("DATE-BEG + XPOSURE/2", Ok(Some(Role::Middle))),
            ("frame 1/2, exposure 1/20 s", Ok(None)),
            ("DATE-BEG + EXPTIME", Ok(Some(Role::End))),
            ("MJD-OBS + texp", Ok(Some(Role::End))),
            ("DATE-END - EXPTIME", Ok(Some(Role::Start))),
            ("UTC at shutter close minus exposure", Ok(Some(Role::Start))),
            ("end - exptime/2", Ok(Some(Role::Middle))),
            ("(start + end) / 2", Ok(Some(Role::Middle))),
            ("start of the 30 s exposure", Ok(Some(Role::Start))),
            ("middle of the 5 minute exposure", Ok(Some(Role::Middle))),
            ("end of 30s exposure", Ok(Some(Role::End))),
            ("end of 30 s delay", Err(UNCLEAR)),
            ("UTC, not mid-exposure", Ok(None)),
            ("UTC, not mid or end", Ok(None)),
            ("UTC (not the exposure end)", Ok(None)),
            ("not shutter close", Ok(None)),
            ("UTC, not at shutter closing", Ok(None)),
            ("UTC, not exposure middle", Ok(None)),
            ("UTC, not at the time of the frame end", Ok(None)),
            ("UT; start of exposure, not exposure end", Ok(Some(Role::Start))),
            ("TAI not UTC at end", Ok(Some(Role::End))),
            ("UTC, not the exposure start", Err(UNCLEAR)),
            ("UTC date & time, exposure-1", Ok(None)),
            ("not the start of exposure", Err(UNCLEAR)),
            ("not the end but the start", Ok(None)),
            ("halfway through the exposure", Ok(Some(Role::Middle))),
            ("JD - 2400001", Err("a Julian date from another day on")),
            ("start + 30 s", Err(UNCLEAR)),
            ("UTC at end of exposure - 2 s", Err(UNCLEAR)),
            ("start + 1.5 s", Err(UNCLEAR)),
            ("UTC start (+30 s)", Err(UNCLEAR)),
            ("start of integration + 30 s", Err(UNCLEAR)),
            ("opening of the shutter + 30 s", Err(UNCLEAR)),
            ("MJD at end + 30.5 s", Err(UNCLEAR)),
            ("30 s before start of exposure", Err(UNCLEAR)),
            ("exposure begins 30 s later", Err(UNCLEAR)),
            ("UTC start, delayed by 2 min", Err(UNCLEAR)),
            ("start + 30 s +/- 1 s", Err(UNCLEAR)),
            ("UTC start (20 ms delay)", Ok(Some(Role::Start))),
            ("UTC at start (TAI - 37 s)", Ok(Some(Role::Start))),
            ("start of exposure (1-30 s)", Ok(Some(Role::Start))),
            ("start of exposure, 30 s, before readout", Ok(Some(Role::Start))),
            ("start (+/- 30 s)", Ok(Some(Role::Start))),
            ("start, -07:00", Err("a local time")),
            ("start +00:00", Ok(Some(Role::Start))),
            ("not in UT", Err("a local time")),
            ("MST; UTC is 7 h ahead", Err("a local time")),
            ("to UTC: +7 h", Err("a local time")),
            ("DATE-OBS + 7 h = UTC", Err("a local time")),
            ("UTC (MST + 7 h)", Ok(None)),
            ("UTC; no daylight saving", Ok(None)),
            ("L.T. at start", Err("a local time")),
            ("L.S.T.", Err("a sidereal time")),
            ("MST (UTC = MST + 7 h)", Err("a local time")),
            ("CEST, start; UT = CEST - 2 h", Err("a local time")),
            ("UTC = DATE-OBS + 7 h", Err("a local time")),
            ("UTC = MST + 7 h", Ok(None)),
            ("UTC at 50% exposure", Ok(Some(Role::Middle))),
            ("(DATE-BEG+DATE-END)/2", Ok(Some(Role::Middle))),
            ("MJD (mid), see DATE-OBS for start", Ok(Some(Role::Middle))),
            ("JD - 2400000", Err("a Julian date from another day on")),
            ("JD-2400000.5 at start", Ok(Some(Role::Start))),
            ("JD - 2400000,5 at start", Ok(Some(Role::Start))),
            ("JD - 24000000.5", Ok(None)),
            ("UTC at mid-exptime", Ok(Some(Role::Middle))),
            ("UTC at mid-texp", Err(UNCLEAR)),
            ("post-exptime", Err(UNCLEAR)),
            ("UT MID EXPOSURE", Ok(Some(Role::Middle))),
            ("UTC END OF EXPOSURE", Ok(Some(Role::End))),
            ("TIME STOP OF EXPOSURE", Ok(Some(Role::End))),
            ("reduced JD", Err("a Julian date from another day on")),
            ("Belichtungsmitte", Ok(Some(Role::Middle))),
            ("MJD-OBS + EXPTIME/172800", Ok(None)),
            ("UTC start of 1/2 exposures", Ok(Some(Role::Start))),
            ("start of exposure (TAI, not UTC)", Ok(Some(Role::Start))),
            ("UTC, not UT1", Ok(None)),
            ("UTC minus 7 hours", Err("a local time")),
            ("camera clock not UTC", Err("a local time")),
            ("JD, mean equinox", Ok(None)),
            ("UTC from front end computer", Ok(None)),
            ("UTC of exposure, f-stop 8", Ok(None)),
            ("UTC to half a second", Ok(None)),
            ("Goddard Space Flight Center, UTC", Ok(None)),
            ("UTC start of first, mid-exposure in DATE-AVG", Ok(Some(Role::Start))),
            ("start of exposure after shutter delay", Ok(Some(Role::Start))),
            ("shutter shut", Ok(Some(Role::End))),
            ("fin de pose TU", Ok(Some(Role::End))),
            ("UTC, average of NTP servers", Err(UNCLEAR)),
            ("UTC (DATE-END: end)", Err(UNCLEAR)),
            ("UT at stop of previous exposure", Err(UNCLEAR)),
            ("UTC after exposure", Err(UNCLEAR)),
            ("middle of night", Err(UNCLEAR)),
            ("Mountain Standard Time", Err("a local time")),
            ("Beijing time", Err("a local time")),
            ("New Zealand daylight time", Err("a local time")),
            ("Ortszeit (MESZ)", Err("a local time")),
            ("computer time zone -7", Err("a local time")),
            ("time zone: UTC", Ok(None)),
            ("UTC, not local time", Ok(None)),
            ("UTC; local = UTC-7", Ok(None)),
            ("UTC (local time is UTC-7h)", Ok(None)),
            ("UTC of mid-exposure; MST is UTC - 7 h", Ok(Some(Role::Middle))),
            ("UTC (time zone UTC+2), start", Ok(Some(Role::Start))),
            ("UTC of start (local time: see LOCTIME)", Ok(Some(Role::Start))),
            ("UTC = local + 7h", Ok(None)),
            ("local time converted to UTC", Ok(None)),
            ("local time, not converted to UTC", Err("a local time")),
            ("local time (to be converted to UTC)", Err("a local time")),
            ("UTC (local time)", Err("a local time")),
            ("UTC, time = local", Err("a local time")),
            ("UTC (UTC-7)", Err("a local time")),
            ("UTC; local = UTC-7, local", Err("a local time")),
            ("[UTC] written by TCS", Ok(None)),
            ("UTC start of exposure (keyword written by TCS)", Ok(Some(Role::Start))),
            ("[UTC] written by TCS after readout", Err(AFTER_EXPOSURE)),
            ("image created by camera", Err(AFTER_EXPOSURE)),
            ("Local site PC clock set to UTC", Ok(None)),
            ("Greenwich Mean Time", Ok(None)),
            ("mean of the exposure, UT", Ok(Some(Role::Middle))),
            ("UTC seconds since midnight", Ok(None)),
            ("MIDAS desc.: O_TIME(1)", Ok(None)),
            ("Gregorian calendar date of the observation", Ok(None)),
            ("System Clock:Est. Frame Start", Ok(Some(Role::Start))),
            ("SYSTEM CLOCK:EST. FRAME END", Ok(Some(Role::End))),
            ("shutter closed", Ok(Some(Role::End))),
            ("shutter closure", Ok(Some(Role::End))),
            ("EndExposure", Ok(Some(Role::End))),
            ("exposureMidTime", Ok(Some(Role::Middle))),
            ("expend", Ok(Some(Role::End))),
            ("Belichtungsbeginn", Ok(Some(Role::Start))),
            ("start time saved by server", Ok(Some(Role::Start))),
            ("PixInsight date", Ok(None)),
            ("MeanSolarTime", Err(UNCLEAR)),
            ("Greenwich mean solar time", Ok(None)),
            ("System Clock:Frame Received", Err(AFTER_EXPOSURE)),
            ("Image created time", Err(AFTER_EXPOSURE)),
            ("Start of readout", Err(AFTER_EXPOSURE)),
            ("readout start time", Err(AFTER_EXPOSURE)),
            ("UTC at end of image transfer", Err(AFTER_EXPOSURE)),
            ("start of exposure, which ends with readout", Ok(Some(Role::Start))),
            ("UTC at end of exposure, before readout", Ok(Some(Role::End))),
            ("end of exposure (excluding readout)", Ok(Some(Role::End))),
            ("Image saved after end of exposure", Err(AFTER_EXPOSURE)),
            ("readout, end", Err(AFTER_EXPOSURE)),
            ("time saved, not start of exposure", Err(AFTER_EXPOSURE)),
            ("exposure start plus readout", Err(AFTER_EXPOSURE)),
            ("Start of image file writing", Err(AFTER_EXPOSURE)),
            ("Start of exposure + readout", Err(AFTER_EXPOSURE)),
            ("Start of frame-transfer exposure", Ok(Some(Role::Start))),
            ("UTC at end of frame transfer", Err(AFTER_EXPOSURE)),
            ("UTC transmitted by time server", Ok(None)),
            ("UTC, meant for plate solving", Ok(None)),
            ("UTC from NTP endpoint", Ok(None)),
            ("UTC intended start of exposure", Err("a planned time")),
            ("EndOfExposure", Ok(Some(Role::End))),
            ("TimeOfExposureEnd", Ok(Some(Role::End))),
            ("Julian date in mean solar days", Ok(None)),
            ("Local time at start", Err("a local time")),
            ("MST, start", Err("a local time")),
            ("Local sidereal time", Err("a sidereal time")),
            ("start, UTC-7", Err("a local time")),
            ("computer clock (GMT +5:30)", Err("a local time")),
            ("UTC+0, start", Ok(Some(Role::Start))),
            ("UT, 0-24 h", Ok(None)),
            ("[h] UT, 0-24 h", Ok(None)),
            ("UT start, dec -31:16", Ok(Some(Role::Start))),
            ("Date (UTC), observer at +19:49", Ok(None)),
            ("UTC; HA -2.5 h", Ok(None)),
            ("UT+0h", Ok(None)),
            ("UT +5.5", Err("a local time")),
            ("start, UTC-0700", Err("a local time")),
            ("UTC+0545", Err("a local time")),
            ("UTC+0000", Ok(None)),
            ("GMT +05:45", Err("a local time")),
            ("Local PC clock, UTC, NTP stratum 1", Ok(None)),
            ("Local computer clock (UTC, 1 ms)", Ok(None)),
            ("site time, 24 h, UTC", Ok(None)),
            ("Local site clock, NTP stratum 2, UTC", Ok(None)),
            ("UT1-UTC < 1 s", Ok(None)),
            ("half-way through the exposure", Ok(Some(Role::Middle))),
            ("BJD of start", Err("a time corrected to the Sun or the barycentre")),
            ("UTC at which frame was recorded", Err(UNCLEAR)),
            ("timestamp when the frame was grabbed by host", Err(UNCLEAR)),
            ("Planned start of exposure", Err("a planned time")),
            ("UTC start of observation block", Err(UNCLEAR)),
            ("begin of the night", Err(UNCLEAR)),
            ("start of exposure in sequence", Ok(Some(Role::Start))),
            ("LMST", Err("a sidereal time")),
            ("BJT", Err("a local time")),
            ("acq. complete", Ok(Some(Role::End))),
            ("complete UTC date", Ok(None)),
            ("shutter off", Ok(Some(Role::End))),
            ("EOE", Ok(Some(Role::End))),
            ("UTmid", Ok(Some(Role::Middle))),
            ("start time + exptime", Err("of more than one part of the exposure")),
            ("time + exptime", Ok(Some(Role::End))),
            ("UTC start; end is DATE-OBS+EXPTIME", Ok(Some(Role::Start))),
            ("Complete timestamp (UTC)", Ok(None)),
            ("complete observation date and time", Ok(None)),
            ("UTC, exposure complete", Ok(Some(Role::End))),
            ("UTC at shutter off", Ok(Some(Role::End))),
            ("Start of observing run exposure", Ok(Some(Role::Start))),
            ("UTC, Centro Astronomico", Ok(None)),
            ("start+exptime/2", Ok(Some(Role::Middle))),
            ("fine esposizione", Ok(Some(Role::End))),
            ("UTC, fine resolution", Ok(None)),
            ("fim da exposicao", Ok(Some(Role::End))),
            ("Aufnahmeende", Ok(Some(Role::End))),
            ("centro de la exposicion", Ok(Some(Role::Middle))),
            ("start or end of exposure", Err("of more than one part of the exposure")),
        ] {
            assert_eq!(Comment::new(text).role(None), role, "{text}");
        }
        assert_eq!(Comment::new("mean of start and end").role(Some(Role::Middle)), Ok(Some(Role::Middle)));
        assert!(Comment::new("end of exposure").role(Some(Role::Start)).is_err());
    }
}

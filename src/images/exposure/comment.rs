//! Comments of header cards: what they state about the instant, the unit or the number of parts of a value.

use hifitime::TimeScale;

/// Part of an exposure to which an instant refers.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Role {
    Start,
    Middle,
    End,
}

/// Words of the parts of an exposure. They count only where they qualify a word of [`EXPOSURE`] or [`CLOCK`].
const PARTS: &[(Role, &str)] = &[
    (
        Role::Start,
        "start starts started starting begin begins beginning began beg open opens opened opening debut beginn anfang \
         inicio inizio utstart aufnahmebeginn belichtungsbeginn",
    ),
    (
        Role::Middle,
        "mid middle midpoint midpoints midpt midtime midexp midexposure midobs midobservation midframe midscan midway \
         tmid utmid utcmid jdmid meantime half halfway effective weighted center centre central average averaged avg mean median mitte \
         milieu mitad medio centro meio aufnahmemitte belichtungsmitte",
    ),
    (
        Role::End,
        "end ends ended ending endexp endobs finish finished stop stops stopped close closes closed closing shut off \
         complete completion completed terminated fin fim ende utend eoe aufnahmeende belichtungsende",
    ),
];
/// Words of the end that have another meaning before a noun.
const ADJECTIVES: &str = "complete off";
const EXPOSURE: &str = "exposure exposures exposed exp expo exposition exposicion exposicao esposizione exptime pose posa \
     belichtung aufnahme integration integrations int observation observations observing obs frame frames image images \
     img shutter scan capture stack interval visit coadd coadds dce";
const CLOCK: &str = "time times date dates datetime timestamp timestamps stamp t ut utc ut1 tu tai tt tdb gmt epoch jd \
     mjd julian instant moment point pt way yyyy ccyy dd hh hms ymd";
/// Words between a part and what it qualifies.
const FILLERS: &str = "of the at to a an in and or between this first each actual through during for from de du der des la le da do della \
     est";
/// Words of periods that contain other exposures.
const PERIODS: &str = "block blocks ob sequence sequences series night run session program programme queue script";
/// Ends and middles as sums or in languages in which the word alone has other meanings, without blanks, in lower case.
const PHRASES: &[(Role, &[&str])] = &[
    (Role::Middle, &["50%of", "metaposa", "metaesposizione"]),
    (Role::End, &["+exp", "+texp", "+t_exp", "+xposure", "plusexp", "fineesposizione", "finedell", "fineposa"]),
];
/// Beginnings of names of the exposure time in formulas, and a half of it before and after such a name.
const LENGTHS: &[&str] = &["exp", "texp", "t_exp", "xpos", "itime", "integ", "dur", "telapse", "dit"];
const HALVES_BEFORE: &[&str] = &["0.5*", "1/2*", "+1/2", "0.5x", ".5*", "half*"];
const HALVES_AFTER: &[&str] = &["/2", "*0.5", "*.5"];
/// Phrases in which a word of a part or of a zone qualifies something else.
const OTHER_MEANINGS: &[&str] = &[
    "front end",
    "back end",
    "f stop",
    "closed loop",
    "open loop",
    "open source",
    "data center",
    "data centre",
    "half second",
    "half a second",
    "half day",
    "half a day",
    "greenwich mean",
    "universal mean",
    "mean solar",
    "mean equinox",
    "modified julian",
    "modified jd",
    "mid night",
    "not local",
    "not in local",
    "non local",
    "not the local",
];
/// Words of another event, unless the comment states a part of this exposure.
const OTHERS: &str = "previous preceding next following last after post recorded recording grabbed";
/// Words of times before the exposure.
const PLANS: &str = "planned requested scheduled proposed";
/// Words of events after the exposure, at an unknown delay.
const EVENTS: &str = "received reception arrival arrived created creation saved saving stored written writing write \
     generated modified downloaded download transferred readout";
const CORRECTED: &str = "heliocentric barycentric hjd bjd bmjd hmjd";
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
const UNIVERSAL: &str = "ut utc ut1 gmt universal zulu";

/// Words of times that are only near the part of the exposure that the comment states.
const APPROXIMATE: &str = "approximate approximately approx about nominal first";
/// Words of comments that state nothing else than a date, in addition to the words of exposures and clocks.
const NEUTRAL: &str = "as is was when which with on by taken acquired acquisition data gregorian calendar greenwich modified \
     coordinated international atomic standard matching ob day format iso isot iso8601 fits value number since nov days seconds hours sec \
     row midas desc tstart typical yy hhmmss ddthh mmthh ss sss ssss mm 1st";
const ERRORS: &str = "error uncertainty inaccuracy drift";
/// Words of remarks about clocks.
const CLOCK_ERRORS: &str = "offset error errors fast slow late early wrong corrected correction shifted drift";
/// Beginnings of statements of the uncertainty of a time.
const UNCERTAINTIES: &[&str] =
    &["+/-", "+-", "~", "accura", "uncertain", "error", "within", "tolerance", "precision", "off by"];

const UNCLEAR: &str = "perhaps of another part of the exposure, or of another event,";

/// Returns true if a list of words contains a word, in upper or lower case.
fn lists(list: &str, word: &str) -> bool {
    list.split_ascii_whitespace().any(|other| other.eq_ignore_ascii_case(word))
}

/// Comment of a card with its words.
#[derive(Clone, Debug)]
pub struct Comment {
    text: String,
    /// Clauses between commas, brackets, ... with their words as written: runs of letters and digits, without the
    /// phrases of [`OTHER_MEANINGS`].
    clauses: Vec<Vec<String>>,
}

impl Comment {
    pub fn new(text: &str) -> Self {
        let clauses = text.split([',', ';', ':', '.', '(', ')', '[', ']']).map(|clause| {
            let words = clause.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
            let mut words: Vec<String> = words.map(str::to_owned).collect();
            for phrase in OTHER_MEANINGS {
                let phrase: Vec<&str> = phrase.split(' ').collect();
                let is_phrase = |part: &[String]| part.iter().zip(&phrase).all(|(a, b)| a.eq_ignore_ascii_case(b));
                while let Some(at) = words.windows(phrase.len()).position(is_phrase) {
                    words.drain(at..at + phrase.len());
                }
            }
            words
        });
        Self { text: text.to_owned(), clauses: clauses.filter(|words| !words.is_empty()).collect() }
    }

    /// Returns the text without surrounding blanks.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn words(&self) -> impl Iterator<Item = &str> {
        self.clauses.iter().flatten().map(String::as_str)
    }

    /// Returns true if the comment contains a word of a list.
    pub fn has(&self, list: &str) -> bool {
        self.words().any(|word| lists(list, word))
    }

    /// Returns true if a word of the first list is followed by a word of the second list in the same clause.
    pub fn has_pair(&self, first: &str, second: &str) -> bool {
        let is_pair = |pair: &[String]| lists(first, &pair[0]) && lists(second, &pair[1]);
        self.clauses.iter().any(|words| words.windows(2).any(is_pair))
    }

    /// Returns the part of the exposure that the comment states; `None` if it states none. `named` is the part that the
    /// name of the keyword states; it applies if the comment mentions several parts.
    ///
    /// # Errors
    /// The reason why the instant cannot be used: it is a local time, or the time of another event, or the comment
    /// mentions several parts, or another part than the name.
    pub fn role(&self, named: Option<Role>) -> Result<Option<Role>, &'static str> {
        if self.has("sidereal lst lmst gmst gast") {
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
        if self.has(PLANS) {
            return Err("a planned time");
        }
        if self.is_of_period() {
            return Err(UNCLEAR);
        }
        let (stated, is_unclear) = self.parts();
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

    /// Returns the parts that the comment states, and true if other words may state the middle, the end or an event.
    fn parts(&self) -> (Vec<Role>, bool) {
        // "UTC (DATE-END: end)" concerns other keywords.
        let is_keyword = |word: &str| {
            word.split_once('-').is_some_and(|(clock, part)| {
                ["DATE", "MJD", "JD", "TIME", "UT", "UTC"].contains(&clock)
                    && ["BEG", "OBS", "AVG", "MID", "END", "STR", "STOP"].contains(&part)
            })
        };
        let of_others = self.text.split(|c: char| c != '-' && !c.is_ascii_alphanumeric()).any(is_keyword);
        let joined: String = self.text.to_ascii_lowercase().split_ascii_whitespace().collect();
        let phrase = PHRASES.iter().find(|(role, list)| {
            (*role == Role::Middle || !of_others || is_sum(&joined))
                && list.iter().any(|phrase| joined.contains(phrase))
        });
        let mut stated: Vec<Role> = phrase.map(|(role, _)| *role).into_iter().collect();
        if has_half(&joined) {
            stated = vec![Role::Middle];
        }
        // "start + exptime/2", "DATE-BEG + EXPTIME"
        if stated == [Role::Middle] || (stated == [Role::End] && is_sum(&joined)) {
            return (stated, false);
        }
        let mut is_unclear = self.has(OTHERS);
        for (role, list) in PARTS {
            for words in &self.clauses {
                for (at, _) in words.iter().enumerate().filter(|(_, word)| lists(list, word)) {
                    // "Complete timestamp", but "exposure complete".
                    let is_adjective = lists(ADJECTIVES, &words[at])
                        && !(at > 0 && lists(EXPOSURE, &words[at - 1]))
                        && words.len() > at + 1;
                    if is_adjective {
                        continue;
                    }
                    match qualifies(words, at) {
                        Some(true) if *role == Role::Start || !of_others => stated.push(*role),
                        None => {}
                        _ => is_unclear |= *role != Role::Start,
                    }
                }
            }
        }
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

    /// Returns true if the comment states universal time.
    pub fn is_universal(&self) -> bool {
        self.has(UNIVERSAL)
    }

    /// Returns true if the comment states a local time.
    pub fn is_local(&self) -> bool {
        if self.has_offset() {
            return true;
        }
        // "UTC minus 7 hours", "not UTC"
        let is_denied = || {
            let others = self.words().filter(|word| lists(UNIVERSAL, word) || lists("tai iat tt tdt tdb gps", word));
            self.has_pair("not", UNIVERSAL) && others.count() == 1
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

    /// Returns true if the comment states an uncertainty of more than a second, or that the value is approximate.
    pub fn is_approximate(&self) -> bool {
        self.has(APPROXIMATE) || self.uncertainty_s().is_some_and(|uncertainty_s| uncertainty_s > 1.0)
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

    /// Returns true if the comment states that the time is only near a part of the exposure, or if it states no part and
    /// contains other words than those of a date, such as "trigger" and "clock unsynchronised".
    pub fn is_doubtful(&self) -> bool {
        let is_known = |word: &str| {
            [PARTS[0].1, EXPOSURE, CLOCK, FILLERS, UNIVERSAL, NEUTRAL].iter().any(|list| lists(list, word))
                || word.len() == 1
                || word.bytes().all(|byte| byte.is_ascii_digit())
        };
        self.has(APPROXIMATE) || (self.parts().0.is_empty() && !self.words().all(is_known))
    }

    /// Returns true if the comment states a zone or an offset from universal time.
    pub fn is_of_zone(&self) -> bool {
        self.has("timezone") || self.has_pair("time", "zone") || (self.has("offset") && self.is_universal())
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
        // "milli-seconds" and "minute(s)" are one word.
        let mut lower = self.text.to_ascii_lowercase();
        for prefix in ["milli", "micro", "nano", "deci", "centi", "u"] {
            lower = lower.replace(&format!("{prefix}-sec"), &format!("{prefix}sec"));
            lower = lower.replace(&format!("{prefix} sec"), &format!("{prefix}sec"));
        }
        for word in ["second", "minute", "hour", "day", "sec"] {
            lower = lower.replace(&format!("{word}(s)"), word);
        }
        // Characters that are not ASCII, such as the Greek letter of microseconds, are read as question marks.
        if lower.contains("?s") {
            return Err("a unit that is not ASCII".to_owned());
        }
        let (part, lower) = fraction(&lower)?;
        // Short words are units only in brackets, after "in" or "unit", or alone: "(s)", "in min", "hr".
        let is_short =
            |word: &str| word.len() <= 2 && !["us", "ms", "ns"].contains(&word) || ["min", "day"].contains(&word);
        let marks = [
            "(",
            "[",
            "in ",
            "unit ",
            "units ",
            "unit:",
            "unit=",
            "unit: ",
            "unit = ",
            "units: ",
            "units = ",
            "fraction of ",
            "fraction of a ",
            "fractional ",
        ];
        // "(min/max)" is no unit.
        let follows = |mark: &str, word: &str| {
            let phrase = format!("{mark}{word}");
            let mut nexts = lower.match_indices(&phrase).map(|(at, _)| lower[at + phrase.len()..].chars().next());
            nexts.any(|next| next.is_none_or(|next| next != '/' && !next.is_ascii_alphanumeric()))
        };
        let is_marked =
            |word: &str| lower.trim().trim_end_matches('.') == word || marks.iter().any(|mark| follows(mark, word));
        if is_marked("m") {
            return Err("the unit m".to_owned());
        }
        for form in ["log10", "log(", "1/x"] {
            if lower.contains(form) {
                return Err(format!("a function of seconds ({form})"));
            }
        }
        let words = lower.split(|c: char| !c.is_ascii_alphabetic());
        let mut units: Vec<f64> =
            words.filter(|word| !is_short(word) || is_marked(word)).filter_map(seconds_in).collect();
        if units.is_empty() && (is_marked("jd") || is_marked("mjd")) {
            units.push(crate::constants::DAY_S);
        }
        units.sort_by(f64::total_cmp);
        units.dedup();
        let named = [("thousandth", 1e-3), ("hundredth", 1e-2), ("tenth", 1e-1)];
        let named = named.iter().find(|(word, _)| lower.contains(word)).map(|(_, part)| *part);
        let part = named.unwrap_or(part);
        match units[..] {
            [] => Ok(None),
            [unit_s] => Ok(Some(part * unit_s)),
            _ => Err("several units".to_owned()),
        }
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

/// Returns true if a word of a part qualifies the time or the exposure, false if it may, and `None` if it does not. The
/// word that follows in the clause decides, or else the word that precedes.
fn qualifies(words: &[String], at: usize) -> Option<bool> {
    let counts = |word: &&String| !lists(FILLERS, word) && !word.starts_with(|c: char| c.is_ascii_digit());
    let next = words[at + 1..].iter().find(counts);
    let previous = words[..at].iter().rev().find(counts);
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

/// Returns the factor of a unit such as `1/1000 s`, 1 if the text contains none, and the text without the factor.
///
/// # Errors
/// A unit divided by a number.
fn fraction(text: &str) -> Result<(f64, String), String> {
    for (at, _) in text.match_indices('/') {
        let divisor = text[at + 1..].split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
        let Ok(number) = divisor.parse::<f64>() else { continue };
        let before = text[..at].rsplit(|c: char| !c.is_ascii_alphanumeric()).next().unwrap_or_default();
        if before == "1" && number > 1.0 {
            let rest = text[at + 1 + divisor.len()..].trim_start();
            // "frame 1/5" is no unit.
            let word = rest.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
            if seconds_in(word).is_none() {
                continue;
            }
            return Ok((number.recip(), format!("{}{rest}", &text[..at - 1])));
        }
        if seconds_in(before).is_some() {
            return Err("a unit divided by a number".to_owned());
        }
    }
    Ok((1.0, text.to_owned()))
}

/// Returns the number of seconds in a unit of time, for example `ms`, `10 us`, `1/1000 s` or `hours`; `None` for other
/// words.
pub fn seconds_in(unit: &str) -> Option<f64> {
    if let Some((_, rest)) = unit.split_once("1/") {
        let (divisor, name) = rest.split_once(' ')?;
        return Some(seconds_in(name.trim())? / divisor.parse::<f64>().ok().filter(|divisor| *divisor > 0.0)?);
    }
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
        "min" | "mins" | "mn" | "minute" | "minutes" => 60.0,
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
            ("Local site PC clock set to UTC", Ok(None)),
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
        for text in
            ["GPS trigger time", "PPS", "clock unsynchronised", "Start of first exposure", "approx. start", "noon"]
        {
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
        ] {
            assert!(!Comment::new(text).is_doubtful(), "{text}");
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
            ("min.", Ok(Some(60.0))),
            ("hr", Ok(Some(3600.0))),
            ("unit = d", Ok(Some(86400.0))),
            ("exposure time in hundredths of a second", Ok(Some(1e-2))),
            ("[0:3600] exposure", Ok(None)),
            ("[furlong] exposure", Err("the unit [furlong]".to_owned())),
            ("seconds, not ms", Err("several units".to_owned())),
            ("Exposure in 1/1000 s", Ok(Some(1e-3))),
            ("[1/10000 s] exposure", Ok(Some(1e-4))),
            ("in milli-seconds", Ok(Some(1e-3))),
            ("micro seconds", Ok(Some(1e-6))),
            ("minute(s)", Ok(Some(60.0))),
            ("fraction of a day", Ok(Some(86400.0))),
            ("JD", Ok(Some(86400.0))),
            ("Max exposure (min/max/avg)", Ok(None)),
            ("exposure in m", Err("the unit m".to_owned())),
            ("mn", Ok(Some(60.0))),
            ("log10(s)", Err("a function of seconds (log10)".to_owned())),
            ("shutter speed 1/x s", Err("a function of seconds (1/x)".to_owned())),
            ("secs/1000", Err("a unit divided by a number".to_owned())),
            ("exposure (?s)", Err("a unit that is not ASCII".to_owned())),
        ] {
            assert_eq!(Comment::new(text).unit_s(), seconds, "{text}");
        }
    }
}

//! Units of time in comments.

use super::quantity::{number_end, quantities};
use super::seconds::{ENDINGS, fraction, seconds_in};
use super::words::{Comment, EXPOSURE, FRAMES, lists};

/// Units of other kinds or longer than days, in singular and plural.
const OTHER_UNITS: &str = "week weeks month months year years fortnight fortnights fps hz khz";
/// Words that are units where only a unit can be, as in "in frames".
const COUNTS: &str = "frames reads counts pulses samples loops rows";
/// Words of other quantities.
const NO_TIMES: &str = "inverse reciprocal denominator percent ev";
/// Units of speeds, and functions of seconds.
const SPEEDS: &[&str] = &["m/s", "km/s"];
const FUNCTIONS: &[&str] =
    &["log10", "log2", "log(", "log sec", "log seconds", "1/x", "per sec", "per second", "per seconds"];
/// Statements of factors, and their error.
const SCALINGS: &[&str] = &["multiplied by", "divided by", "scaled by"];
const SCALED: &str = "a unit divided or multiplied by a number";
/// Last words of the name of an exposure time.
const EXPOSURE_TIME: &str = "time exposure exp exptime texp integration duration length";
/// Words of pixels and rows, which divide a unit in comments such as "min/pixel" without another meaning.
const PIXELS: &str = "pixel pixels pix px row rows line lines column columns";
/// Other spellings of fractions and days; letters that are not ASCII are question marks.
const SPELLINGS: &[(&str, &str)] = &[
    ("1000ths", "thousandths"),
    ("100ths", "hundredths"),
    ("10ths", "tenths"),
    ("??", "?"),
    ("d?as", "dias"),
    ("d?cim", "decim"),
    ("i?m", "iem"),
    ("l?sim", "lesim"),
    ("t?sim", "tesim"),
];
impl Comment {
    /// Returns the number of seconds in the unit of time that the comment states, as [`Comment::unit_of_s`], without
    /// the value: durations in the comment are errors.
    pub fn unit_s(&self) -> Result<Option<f64>, String> {
        self.unit_of_s(f64::NAN)
    }

    /// Returns the number of seconds in the unit of time that the comment states for a value; `None` if it states none.
    ///
    /// A unit in brackets at the beginning (FITS standard 4.0, section 4.3.2) takes precedence over words.
    ///
    /// # Errors
    /// An unknown unit in brackets, several units, or a duration that is not the value.
    pub fn unit_of_s(&self, value: f64) -> Result<Option<f64>, String> {
        if let Some((unit, rest)) = self.text.trim_start().strip_prefix('[').and_then(|rest| rest.split_once(']'))
            && unit.bytes().any(|byte| byte.is_ascii_alphabetic())
        {
            // "[s] x 10"
            let rest = rest.trim_start().to_ascii_lowercase();
            let is_scaled =
                rest.starts_with(['x', '*', '/']) && is_divided(&format!("{} {rest}", unit.to_ascii_lowercase()));
            if is_scaled || SCALINGS.iter().any(|scaling| rest.starts_with(scaling)) {
                return Err(SCALED.to_owned());
            }
            return seconds_in(without_divisors(unit).trim())
                .map(Some)
                .ok_or_else(|| format!("the unit [{}]", unit.trim()));
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
        for (spelling, usual) in SPELLINGS {
            lower = lower.replace(spelling, usual);
        }
        let lower = without_denied(&lower);
        // The Greek letter of microseconds.
        if lower.contains("?s") {
            return Err("a unit that is not ASCII".to_owned());
        }
        if let Some(speed) = SPEEDS.iter().find(|speed| has_form(&lower, speed)) {
            return Err(format!("the unit {speed}"));
        }
        if is_divided(&lower) || SCALINGS.iter().any(|scaling| lower.contains(scaling)) {
            return Err(SCALED.to_owned());
        }
        let (text, has_clock_form) = without_clock_forms(&without_least_values(&without_divisors(&lower)));
        // In "exposure in s, error 10 ms" and "seconds (1/60 s steps)", the number with a unit is no unit of the value.
        let quantities = quantities(&text);
        let mut bare = text.clone();
        for quantity in quantities.iter().rev() {
            bare.replace_range(quantity.at.clone(), "");
        }
        if let Some(unit_s) = self.named_unit_s(&bare)? {
            return Ok(Some(unit_s));
        }
        if has_clock_form {
            return Err("the form of a clock, such as h:m:s".to_owned());
        }
        if self.has(NO_TIMES) || self.has_pair("shutter exposure", "speed rate") || text.contains('%') {
            return Err("another unit than of a time".to_owned());
        }
        self.unit_of_quantities_s(&text, &quantities, value)
    }

    /// Returns the number of seconds in the unit that a word or a sign of the comment, in lower case, names.
    fn named_unit_s(&self, lower: &str) -> Result<Option<f64>, String> {
        // Short words are units only in brackets, after "in" or "unit", or alone: "(s)", "in min", "hr".
        let is_short = |word: &str| {
            word.len() <= 2 && !["us", "ms", "ns"].contains(&word)
                || ["min", "day", "ora", "ore", "tag", "dia", "std"].contains(&word)
        };
        let marks = [
            "(",
            "[",
            "in ",
            "en ",
            "em ",
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
        // Minutes and seconds as in angles: "exposure (')".
        let (signs, marked) = ([("'", 60.0), ("\"", 1.0)], [["(", ")"], ["[", "]"]]);
        if let Some((_, unit_s)) = signs
            .iter()
            .find(|(sign, _)| marked.iter().any(|[open, close]| lower.contains(&format!("{open}{sign}{close}"))))
        {
            return Ok(Some(*unit_s));
        }
        // "(min/max)" is no unit.
        let follows = |mark: &str, word: &str| {
            let phrase = format!("{mark}{word}");
            let is_part_of_word = |c: char| c.is_ascii_alphanumeric();
            lower.match_indices(&phrase).any(|(at, _)| {
                let (before, after) = (&lower[..at], &lower[at + phrase.len()..]);
                let is_word = !(mark.starts_with(is_part_of_word) && before.ends_with(is_part_of_word));
                // "in H band", "in h-alpha"
                let is_filter = ["-", " band", " filter"].iter().any(|name| after.starts_with(name));
                is_word && !is_filter && !after.starts_with(|c: char| c == '/' || is_part_of_word(c))
            })
        };
        // "Exposure time, h" and "Exposure time / min", but not "Exposure time; mount: min"
        let start = [",", ";", ":", " / "].iter().filter_map(|mark| Some(lower.rfind(mark)? + mark.len())).max();
        let (before, last) = lower.split_at(start.unwrap_or(0));
        let last = last.trim().trim_end_matches(['.', ')', ']']);
        let name = before.trim_end_matches(|c: char| !c.is_ascii_alphabetic());
        let name = name.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        let is_last = name.is_empty() || lists(EXPOSURE_TIME, name);
        let is_letter = ["D", "H"].contains(
            &self.text.trim_end_matches([' ', '.', ')', ']']).rsplit([' ', ',', ';', ':']).next().unwrap_or_default(),
        );
        let is_other = is_short(last) && seconds_in(last).is_some_and(|unit_s| unit_s != 1.0);
        if is_other && !name.is_empty() && (if is_last { is_letter } else { !before.ends_with(':') }) {
            return Err(format!("seconds or in the unit {last}"));
        }
        // "s (was ms before 2020)"
        let is_first = |word: &str| word == "s" && self.clauses.first().is_some_and(|words| words[..] == ["s"]);
        let is_marked =
            |word: &str| (is_last && last == word) || is_first(word) || marks.iter().any(|mark| follows(mark, word));
        if is_marked("m") {
            return Err("the unit m".to_owned());
        }
        if let Some(form) = FUNCTIONS.iter().find(|form| has_form(lower, form)) {
            return Err(format!("a function of seconds ({form})"));
        }
        if is_rate(lower) {
            return Err("a rate per second".to_owned());
        }
        let words = lower.split(|c: char| !c.is_ascii_alphabetic()).filter(|word| !word.is_empty());
        let words: Vec<&str> = words.collect();
        let (mut units, mut part): (Vec<f64>, f64) = (Vec::new(), 1.0);
        for (at, word) in words.iter().enumerate() {
            let (word, rest) = (*word, fraction(word));
            let Some((rest, size)) = rest else {
                units.extend(seconds_in(word).filter(|_| !is_short(word) || is_marked(word)));
                continue;
            };
            // "to the nearest tenth of a second" is an accuracy, and "tenth exposure" a number.
            let before = words[..at].iter().rev().find(|word| !["a", "the", "nearest"].contains(word));
            let is_accuracy = before.is_some_and(|word| ["to", "within"].contains(word));
            let unit_s = |word: &&str| seconds_in(word).filter(|_| word.len() > 1 || *word == "s");
            let mut next = words[at + 1..].iter().take_while(|word| !begins_with_exposure(word)).take(3);
            let of_next = next.find_map(unit_s).filter(|_| !is_accuracy);
            let of_word = seconds_in(rest).filter(|_| !ENDINGS.contains(&rest));
            if !is_accuracy && (of_word.is_some() || of_next.is_some()) {
                part = size;
            } else if !is_accuracy && !rest.is_empty() {
                return Err(format!("{word} of an unknown unit"));
            }
            units.extend(of_word.or(of_next));
        }
        if units.is_empty() && (is_marked("jd") || is_marked("mjd")) {
            units.push(crate::constants::DAY_S);
        }
        // "exposure in frames", but not "exposure in frames of the stack"
        let is_other = |word: &&&str| {
            let ends =
                |at: usize| lower[at + word.len()..].trim_start().chars().next().is_none_or(|c| ",;:.()[]".contains(c));
            let is_last = || lower.match_indices(**word).any(|(at, _)| ends(at));
            let is_unit = || words.len() == 1 || (is_last() && marks[2..].iter().any(|mark| follows(mark, word)));
            (lists(OTHER_UNITS, word) && is_marked(word)) || (lists(COUNTS, word) && is_unit())
        };
        if let Some(word) = words.iter().find(is_other).filter(|_| units.is_empty()) {
            return Err(format!("the unit {word}"));
        }
        units.sort_by(f64::total_cmp);
        units.dedup();
        match units[..] {
            [] => Ok(None),
            [unit_s] => Ok(Some(part * unit_s)),
            _ => Err("several units".to_owned()),
        }
    }
}

/// Returns true if a text contains a unit or an exposure time divided or multiplied by a number, as in "secs/1000",
/// "exposure x10" and "10x exposure", but not "s / 2 coadds".
fn is_divided(text: &str) -> bool {
    let is_scaled = |word: &str| seconds_in(word).is_some() || lists(EXPOSURE_TIME, word);
    text.match_indices(['/', '*', 'x']).any(|(at, sign)| {
        // Not the x of "max"
        if sign == "x" && text[..at].ends_with(|c: char| c.is_ascii_alphabetic()) {
            return false;
        }
        let before = text[..at].trim_end_matches([' ', '(', ')', ']']);
        let unit = before.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        let rest = text[at + 1..].trim_start();
        let end = number_end(rest);
        let next = rest.split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        // "x6", "6 x"
        let is_number = !before.is_empty() && before.len() == number_end(before);
        let is_alone = (before.is_empty() && end > 0) || (is_number && rest.is_empty());
        // "exptime/1.0"
        let is_one = |number: &str| number.trim_end_matches('.').parse() == Ok(1.0);
        if is_one(&rest[..end]) {
            return false;
        }
        (sign != "/" && is_alone)
            || (end > 0 && is_scaled(unit) && !begins_with_exposure(&rest[end..]))
            || (sign != "/" && before.ends_with(|c: char| c.is_ascii_digit()) && lists(EXPOSURE_TIME, next))
    })
}

/// Returns true if a text contains a form of [`FUNCTIONS`] that is no part of other words, as in "log section".
fn has_form(text: &str, form: &str) -> bool {
    text.match_indices(form).any(|(at, _)| {
        let is_end = !form.ends_with(|c: char| c.is_ascii_alphabetic())
            || !text[at + form.len()..].starts_with(|c: char| c.is_ascii_alphabetic());
        is_end && !text[..at].ends_with(|c: char| c.is_ascii_alphanumeric())
    })
}

/// Returns true if a text contains a negative power of a unit of time, as in "s-1" and "sec^-1".
fn is_rate(text: &str) -> bool {
    text.match_indices("-1").any(|(at, power)| {
        let unit =
            text[..at].trim_end_matches('^').rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        let is_power = !text[at + power.len()..].starts_with(|c: char| c.is_ascii_alphanumeric() || c == '.');
        is_power && seconds_in(unit).is_some()
    })
}

/// Returns a text in lower case without denied units, as in "seconds, not ms" and "[s] (not in minutes)".
fn without_denied(text: &str) -> String {
    let mut kept = text.to_owned();
    while let Some(denied) = kept.match_indices("not ").find_map(|(at, sign)| {
        let from = at + sign.len() + if kept[at + sign.len()..].starts_with("in ") { 3 } else { 0 };
        let end = kept[from..].find(|c: char| !c.is_ascii_alphabetic()).map_or(kept.len(), |end| from + end);
        seconds_in(&kept[from..end]).map(|_| at..end)
    }) {
        kept.replace_range(denied, "");
    }
    kept
}

/// Returns true if the first word of a text, in lower case, is one of an exposure, as in "min/frame".
pub fn begins_with_exposure(text: &str) -> bool {
    begins_with(text, FRAMES) || begins_with(text, EXPOSURE)
}

fn begins_with(text: &str, list: &str) -> bool {
    lists(list, text.trim_start().split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default())
}

/// Returns a text without "/frame", "per pixel" and similar words.
fn without_divisors(text: &str) -> String {
    ["/", " per "].into_iter().fold(text.to_owned(), |text, sign| {
        let mut parts = text.split(sign);
        let mut kept = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            if begins_with_exposure(part) || begins_with(part, PIXELS) {
                kept += part.trim_start().trim_start_matches(|c: char| c.is_ascii_alphabetic());
            } else {
                kept += sign;
                kept += part;
            }
        }
        kept
    })
}

/// Returns a text in which least values, as in "min 0.1, max 3600", are written as greatest ones, because "min" is also
/// a unit.
fn without_least_values(text: &str) -> String {
    let value = |at: usize, word: &str| text[at + word.len()..].trim_start_matches([' ', '.', '=', ':', '<', '>']);
    let limits = |word: &'static str| {
        text.match_indices(word).map(|(at, _)| at).filter(move |at| {
            let before = text[..*at].trim_end();
            let is_word = before.len() < *at || !before.ends_with(|c: char| c.is_ascii_alphabetic());
            let is_word = is_word && !before.ends_with(|c: char| c.is_ascii_digit());
            is_word && value(*at, word).starts_with(|c: char| c.is_ascii_digit())
        })
    };
    let has_greatest = limits("max").chain(limits("maximum")).next().is_some();
    let mut kept = text.to_owned();
    for at in limits("min") {
        if has_greatest || quantities(value(at, "min")).first().is_some_and(|quantity| quantity.at.start == 0) {
            kept.replace_range(at..at + "min".len(), "max");
        }
    }
    kept
}

/// Returns a text without units joined as on a clock, as in "(hours:min)" and "hh:mm:ss", and true if it had some.
fn without_clock_forms(text: &str) -> (String, bool) {
    let is_unit = |word: &str| {
        let first = word.chars().next();
        let is_repeated =
            || word.len() <= 2 && "hms".contains(first.unwrap_or(' ')) && word.chars().all(|c| Some(c) == first);
        !word.is_empty() && (seconds_in(word).is_some() || is_repeated())
    };
    let is_form = |run: &str| {
        let words: Vec<&str> = run.split(':').collect();
        words.windows(2).any(|pair| is_unit(pair[0]) && is_unit(pair[1]))
    };
    let mut kept = text.to_owned();
    let runs = text.split(|c: char| c != ':' && !c.is_ascii_alphabetic());
    for form in runs.filter(|run| is_form(run)).chain(["mm.ss", "hh.mm", "mmss", "hhmm"]) {
        kept = kept.replace(form, "");
    }
    let has_some = kept != text;
    (kept, has_some)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ("seconds, not ms", Ok(Some(1.0))),
            ("exposure in ms (not in seconds)", Ok(Some(1e-3))),
            ("s (was ms before 2020)", Err("several units".to_owned())),
            ("weeks", Err("the unit weeks".to_owned())),
            ("exposure in years", Err("the unit years".to_owned())),
            ("Exposure (fps)", Err("the unit fps".to_owned())),
            ("temps", Ok(None)),
            ("exposure time in this stack", Ok(None)),
            ("exposure in frames, unguided", Err("the unit frames".to_owned())),
            ("exposure in frames", Err("the unit frames".to_owned())),
            ("exposure of stars in s", Ok(Some(1.0))),
            ("(x6)", Err(SCALED.to_owned())),
            ("6 x", Err(SCALED.to_owned())),
            ("shutter speed denominator", Err("another unit than of a time".to_owned())),
            ("shutter speed (s)", Ok(Some(1.0))),
            ("exposure x10", Err(SCALED.to_owned())),
            ("10x exposure time", Err(SCALED.to_owned())),
            ("exposure time multiplied by 10", Err(SCALED.to_owned())),
            ("exposure time x 3 frames", Ok(None)),
            ("frames per second", Err("a function of seconds (per second)".to_owned())),
            ("s^-1", Err("a rate per second".to_owned())),
            ("exposure rate, s-1", Err("a rate per second".to_owned())),
            ("exposure rate", Err("another unit than of a time".to_owned())),
            ("Exposure time, frame rate 5", Ok(None)),
            ("in min^-1", Err("a rate per second".to_owned())),
            ("[s] x 10", Err(SCALED.to_owned())),
            ("[s] divided by 10", Err(SCALED.to_owned())),
            ("[ms] / 100", Err(SCALED.to_owned())),
            ("(s) *10", Err(SCALED.to_owned())),
            ("[s] x 3 frames", Ok(Some(1.0))),
            ("Exposure time in seconds, taken in parts", Ok(Some(1.0))),
            ("Exposure time in GMOS", Ok(None)),
            ("Exposure in this", Ok(None)),
            ("obs", Ok(None)),
            ("Exposures", Ok(None)),
            ("tps", Ok(None)),
            ("segs", Ok(Some(1.0))),
            ("tiempo en seg", Ok(Some(1.0))),
            ("counts", Err("the unit counts".to_owned())),
            ("exposure in pulses", Err("the unit pulses".to_owned())),
            ("Exposure time per sector", Ok(None)),
            ("exposure per section", Ok(None)),
            ("from catalog seconds", Ok(Some(1.0))),
            ("*", Ok(None)),
            ("x", Ok(None)),
            ("Exposure x 1", Ok(None)),
            ("exptime/1.0", Ok(None)),
            ("exp time, high speed mode", Ok(None)),
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
            ("exposure (')", Ok(Some(60.0))),
            ("exposure (hours:min)", Err("the form of a clock, such as h:m:s".to_owned())),
            ("duration hh:mm:ss", Err("the form of a clock, such as h:m:s".to_owned())),
            ("exposure in s: requested", Ok(Some(1.0))),
            ("secs/1000", Err(SCALED.to_owned())),
            ("exposure (seconds x 10)", Err(SCALED.to_owned())),
            ("exposure in s, error 10 ms", Ok(Some(1.0))),
            ("seconds; 1/60 s accuracy", Ok(Some(1.0))),
            ("exposure [ms], dead time 2 s", Ok(Some(1e-3))),
            ("ticks", Err("steps of unknown size".to_owned())),
            ("line times", Err("steps of unknown size".to_owned())),
            ("exposure in s, line times 20 us", Ok(Some(1.0))),
            ("exposure in m/s", Err("the unit m/s".to_owned())),
            ("exposure, km/s", Err("the unit km/s".to_owned())),
            ("exposure (h/m/s)", Err("the unit m/s".to_owned())),
            ("clock cycles", Err("steps of unknown size".to_owned())),
            ("exposure in s (1200 lines)", Ok(Some(1.0))),
            ("exposure (max 30 s)", Ok(None)),
            ("seconds (min 0.1, max 3600)", Ok(Some(1.0))),
            ("exposure (min 0.1, max 3600)", Ok(None)),
            ("exposure (min: 0.1 s)", Ok(None)),
            ("Exposure in min (max 60)", Ok(Some(60.0))),
            ("(min) maximum 60", Ok(Some(60.0))),
            ("Integration time (min), MaxIm DL", Ok(Some(60.0))),
            ("exposure in min, climax", Ok(Some(60.0))),
            ("exposure in min, max. of 3 attempts", Ok(Some(60.0))),
            ("(min/frame)", Ok(Some(60.0))),
            ("Exposure (h/frame)", Ok(Some(3600.0))),
            ("exposure time, min / coadd", Ok(Some(60.0))),
            ("Exposure time in seconds, hh:mm start", Ok(Some(1.0))),
            ("Exposure in s (see UT: h:m:s)", Ok(Some(1.0))),
            ("h:m:s start, exposure in min", Ok(Some(60.0))),
            ("Exposure in sec / 2 coadds", Ok(Some(1.0))),
            ("msec x 3 frames", Ok(Some(1e-3))),
            ("sec / 1000", Err(SCALED.to_owned())),
            ("Exposure time, D", Err("seconds or in the unit d".to_owned())),
            ("Exposure time, H.", Err("seconds or in the unit h".to_owned())),
            ("Total (exposure time, min)", Ok(Some(60.0))),
            ("Exposure time, d", Ok(Some(86400.0))),
            ("Exposure time; mount: min", Ok(None)),
            ("Exposure time, filter: H", Ok(None)),
            ("Exposure of the object, h", Err("seconds or in the unit h".to_owned())),
            ("mm.ss", Err("the form of a clock, such as h:m:s".to_owned())),
            ("Exp. time, h", Ok(Some(3600.0))),
            ("Integration time / min", Ok(Some(60.0))),
            ("Belichtungszeit in Minuten", Ok(Some(60.0))),
            ("duree en heures", Ok(Some(3600.0))),
            ("tiempo en segundos", Ok(Some(1.0))),
            ("Belichtungszeit in Mikrosekunden", Ok(Some(1e-6))),
            ("tiempo en milisegundos", Ok(Some(1e-3))),
            ("tiempo en microsegundos", Ok(Some(1e-6))),
            ("in ore", Ok(Some(3600.0))),
            ("tempo di posa in giorni", Ok(Some(86400.0))),
            ("in Tagen", Ok(Some(86400.0))),
            ("en dias", Ok(Some(86400.0))),
            ("duree en min", Ok(Some(60.0))),
            ("tag of exposure, taken when min", Ok(None)),
            ("Exposure (min/pixel)", Ok(Some(60.0))),
            ("min per pixel", Ok(Some(60.0))),
            ("Exposure time in min per dither", Ok(Some(60.0))),
            ("Exposure (h per field)", Ok(Some(3600.0))),
            ("tenths of s", Ok(Some(0.1))),
            ("Zehntel s", Ok(Some(0.1))),
            ("hundredths of a min", Ok(Some(1e-2 * 60.0))),
            ("[min/pixel]", Ok(Some(60.0))),
            ("Belichtungszeit in Zehntelsekunden", Ok(Some(0.1))),
            ("Hundertstel Sekunden", Ok(Some(1e-2))),
            ("Tausendstelsekunden", Ok(Some(1e-3))),
            ("dixi?mes de seconde", Ok(Some(0.1))),
            ("centi??mes de seconde", Ok(Some(1e-2))),
            ("d?cimas de segundo", Ok(Some(0.1))),
            ("millesimi di secondo", Ok(Some(1e-3))),
            ("mil?simas de segundo", Ok(Some(1e-3))),
            ("100ths of a second", Ok(Some(1e-2))),
            ("d?as", Ok(Some(86400.0))),
            ("tempo em min", Ok(Some(60.0))),
            ("belichting in uren", Ok(Some(3600.0))),
            ("Belichtung (Std.)", Ok(Some(3600.0))),
            ("Std exposure", Ok(None)),
            ("micros", Ok(Some(1e-6))),
            ("seconds to a tenth of a second", Ok(Some(1.0))),
            ("tenth exposure, seconds", Ok(Some(1.0))),
            ("seconds, two decimals", Ok(Some(1.0))),
            ("in minutter", Ok(Some(60.0))),
            ("Exposure time in H band", Ok(None)),
            ("in tenths", Err("tenths of an unknown unit".to_owned())),
            ("sec (x100)", Err(SCALED.to_owned())),
            ("secondary mirror", Ok(None)),
            ("exposure (?s)", Err("a unit that is not ASCII".to_owned())),
        ] {
            assert_eq!(Comment::new(text).unit_s(), seconds, "{text}");
        }
    }
}

//! Units of time in comments.

use std::ops::Range;

use super::words::{Comment, EXPOSURE, FRAMES, lists};

/// Words before the size of a unit, as in "units of 10 ms" and "1 tick = 10 ms", and words of steps without a size.
const SIZED: &str = "unit units tick ticks";
const STEPS: &str = "ticks jiffies";
/// Words beside a duration that may be the size of a unit or a resolution.
const RESOLUTIONS: &str = "unit units tick ticks jiffies step steps increment increments multiple multiples";
/// Words and signs before a duration that limits the value or is its error.
const LIMITS: &str = "max maximum min minimum error accuracy uncertainty precision resolution";
const LIMIT_SIGNS: &[&str] =
    &["+/-", "+-", "<", ">", "than", "within", "accurate to", "precise to", "rounded to", "good to"];
/// Last words of the name of an exposure time.
const EXPOSURE_TIME: &str = "time exposure exp exptime texp integration duration length";
/// Words of pixels and rows, which divide a unit in comments such as "min/pixel" without another meaning.
const PIXELS: &str = "pixel pixels pix px row rows line lines column columns";
/// Stems of fractions in several languages.
const FRACTIONS: &[(&str, f64)] = &[
    ("tenth", 1e-1),
    ("zehntel", 1e-1),
    ("dixiem", 1e-1),
    ("decim", 1e-1),
    ("hundredth", 1e-2),
    ("hundertstel", 1e-2),
    ("centiem", 1e-2),
    ("centesim", 1e-2),
    ("thousandth", 1e-3),
    ("tausendstel", 1e-3),
    ("milliem", 1e-3),
    ("millesim", 1e-3),
    ("milesim", 1e-3),
];
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
/// Largest difference between a duration in a comment and the value, a fraction of the duration.
const QUANTITY_SLACK: f64 = 0.01;
/// Endings of words of seconds, minutes and hours in several languages, after their stems.
const ENDINGS: &[&str] = &["", "s", "e", "es", "en", "n", "o", "os", "i", "a", "as"];

impl Comment {
    /// Returns the number of seconds in the unit of time that the comment states, as [`Comment::unit_of_s`], without the
    /// value: durations in the comment are errors.
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
        if let Some((unit, _)) = self.text.trim_start().strip_prefix('[').and_then(|rest| rest.split_once(']'))
            && unit.bytes().any(|byte| byte.is_ascii_alphabetic())
        {
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
        // The Greek letter of microseconds.
        if lower.contains("?s") {
            return Err("a unit that is not ASCII".to_owned());
        }
        if is_divided(&lower) {
            return Err("a unit divided or multiplied by a number".to_owned());
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
        self.unit_of_quantities_s(&text, &quantities, value)
    }

    /// Returns the number of seconds in the unit of a value beside durations: `10 ms` as in "units of 10 ms", `1/1000 s` as
    /// in "in 1/1000 s", a second if a duration is the value in seconds, and its unit if the number is the value.
    fn unit_of_quantities_s(&self, text: &str, all: &[Quantity], value: f64) -> Result<Option<f64>, String> {
        let last_word =
            |text: &str| text.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default().to_owned();
        let before = |quantity: &Quantity| text[..quantity.at.start].trim_end();
        let is_limit = |quantity: &&Quantity| {
            let before = before(quantity).trim_end_matches([' ', ':', '=', '.']);
            // In "1 min 30 s", "min" is a unit.
            (lists(LIMITS, &last_word(before)) && all.iter().all(|other| other.at.end != before.len()))
                || LIMIT_SIGNS.iter().any(|sign| before.ends_with(sign))
                || text[quantity.at.end..].trim_start().starts_with("resolution")
        };
        let stated: Vec<&Quantity> = all.iter().filter(|quantity| !is_limit(quantity)).collect();
        let Some(first) = stated.first() else {
            return if self.has(STEPS) { Err("steps of unknown size".to_owned()) } else { Ok(None) };
        };
        let is_size = |quantity: &&&Quantity| {
            let before = before(quantity);
            let named = before.strip_suffix("of").or_else(|| before.strip_suffix('=')).map(str::trim_end);
            let is_alone = quantity.at.len() == text.trim().len();
            named.is_some_and(|named| lists(SIZED, &last_word(named)))
                || (quantity.is_fraction && (is_alone || last_word(before) == "in"))
        };
        let agree = |duration: f64| (value - duration).abs() <= QUANTITY_SLACK * duration;
        let shown = || format!("seconds or in the unit of {:?}", &text[first.at.clone()]);
        let mut units: Vec<f64> = if let Some(size) = stated.iter().find(is_size) {
            if value.fract() != 0.0 {
                return Err(shown());
            }
            vec![size.number * size.unit_s]
        } else if self.has(RESOLUTIONS) {
            return Err("a unit or a resolution".to_owned());
        } else {
            // "3 x 20 s"
            let times = |quantity: &Quantity| {
                let count = before(quantity).strip_suffix(['x', '*'])?.trim_end();
                count.rsplit(|c: char| !c.is_ascii_digit()).next()?.parse::<f64>().ok()
            };
            let unit_s = |quantity: &&Quantity| {
                let duration_s = quantity.number * quantity.unit_s;
                let is_in_seconds = agree(duration_s) || times(quantity).is_some_and(|count| agree(count * duration_s));
                if is_in_seconds { Some(1.0) } else { agree(quantity.number).then_some(quantity.unit_s) }
            };
            // "1 min 30 s"
            let is_sum = agree(stated.iter().map(|quantity| quantity.number * quantity.unit_s).sum());
            if is_sum { vec![1.0] } else { stated.iter().filter_map(unit_s).collect() }
        };
        units.dedup();
        match units[..] {
            [unit_s] => Ok(Some(unit_s)),
            _ => Err(shown()),
        }
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
        let is_marked = |word: &str| (is_last && last == word) || marks.iter().any(|mark| follows(mark, word));
        if is_marked("m") {
            return Err("the unit m".to_owned());
        }
        for form in ["log10", "log(", "1/x"] {
            if lower.contains(form) {
                return Err(format!("a function of seconds ({form})"));
            }
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
        units.sort_by(f64::total_cmp);
        units.dedup();
        match units[..] {
            [] => Ok(None),
            [unit_s] => Ok(Some(part * unit_s)),
            _ => Err("several units".to_owned()),
        }
    }
}

/// Duration in a comment, in lower case.
struct Quantity {
    at: Range<usize>,
    number: f64,
    unit_s: f64,
    /// True for `1/1000 s`.
    is_fraction: bool,
}

/// Returns the end of a number, perhaps a fraction or with an exponent, that begins a text.
fn number_end(text: &str) -> usize {
    let end = |text: &str, signs: &[char]| {
        text.find(|c: char| !(c.is_ascii_digit() || signs.contains(&c))).unwrap_or(text.len())
    };
    let mantissa = end(text, &['.', '/']);
    let exponent = text[mantissa..].strip_prefix('e').map(|rest| rest.trim_start_matches(['+', '-']));
    match exponent.map(|digits| (digits, end(digits, &[]))) {
        Some((digits, count)) if count > 0 => text.len() - digits.len() + count,
        _ => mantissa,
    }
}

/// Returns the numbers of a text, in lower case, that are followed by a unit of time.
fn quantities(text: &str) -> Vec<Quantity> {
    let mut quantities = Vec::new();
    let mut from = 0;
    while let Some(offset) = text[from..].find(|c: char| c.is_ascii_digit()) {
        let digit = from + offset;
        let before = text[..digit].strip_suffix('.').filter(|before| !before.ends_with(char::is_alphanumeric));
        let before = before.unwrap_or(&text[..digit]);
        let start = before.len();
        let end = start + number_end(&text[start..]);
        from = end;
        let (top, bottom) = text[start..end].split_once('/').unwrap_or((&text[start..end], "1"));
        let (Ok(top), Ok(bottom)) = (top.parse::<f64>(), bottom.parse::<f64>()) else { continue };
        let rest = text[end..].trim_start_matches([' ', '-']);
        let unit = &rest[..rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len())];
        // "2D image"
        let is_dimension = text[end..].starts_with('d') && unit == "d";
        let Some(unit_s) = seconds_in(unit).filter(|_| !is_dimension && bottom > 0.0) else { continue };
        if before.ends_with(char::is_alphanumeric) {
            continue;
        }
        from = text.len() - rest.len() + unit.len();
        let is_fraction = top == 1.0 && bottom > 1.0;
        quantities.push(Quantity { at: start..from, number: top / bottom, unit_s, is_fraction });
    }
    quantities
}

/// Returns true if a text contains a unit divided or multiplied by a number, as in "secs/1000", but not "s / 2 coadds".
fn is_divided(text: &str) -> bool {
    text.match_indices(['/', '*', 'x']).any(|(at, _)| {
        let unit = text[..at].trim_end_matches([' ', '(']);
        let unit = unit.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        let number = text[at + 1..].trim_start();
        let end = number_end(number);
        end > 0 && seconds_in(unit).is_some() && !begins_with_exposure(&number[end..])
    })
}

/// Returns true if the first word of a text, in lower case, is one of an exposure, as in "min/frame".
pub fn begins_with_exposure(text: &str) -> bool {
    begins_with(text, FRAMES) || begins_with(text, EXPOSURE)
}

fn begins_with(text: &str, list: &str) -> bool {
    lists(list, text.trim_start().split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default())
}

/// Returns the rest of a word after the stem of a fraction, and the fraction, as in "zehntelsekunden"; `None` for other
/// words, such as "decimal".
fn fraction(word: &str) -> Option<(&str, f64)> {
    let (rest, size) = FRACTIONS.iter().find_map(|(stem, size)| Some((word.strip_prefix(stem)?, *size)))?;
    (ENDINGS.contains(&rest) || seconds_in(rest).is_some()).then_some((rest, size))
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

/// Returns a text in which least values, as in "min 0.1, max 3600", are written as greatest ones, because "min" is also a
/// unit.
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

/// Returns the number of seconds in a unit of time, for example `ms`, `10 us`, `1/1000 s`, `hours` or `Minuten`; `None` for
/// other words.
pub fn seconds_in(unit: &str) -> Option<f64> {
    if let Some((_, rest)) = unit.split_once("1/") {
        let (divisor, name) = rest.split_once(' ')?;
        return Some(seconds_in(name.trim())? / divisor.parse::<f64>().ok().filter(|divisor| *divisor > 0.0)?);
    }
    let digits = unit.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(0);
    let factor: f64 = if digits > 0 { unit[..digits].parse().ok()? } else { 1.0 };
    let name = unit[digits..].trim().trim_end_matches('.').to_ascii_lowercase();
    let is_of = |stems: &[&str], name: &str| {
        stems.iter().any(|stem| name.strip_prefix(stem).is_some_and(|ending| ENDINGS.contains(&ending)))
    };
    let begins = |stems: &[&str], name: &str| stems.iter().any(|stem| name.starts_with(stem));
    let is_second = |name: &str| name == "s" || is_of(&["sec", "second"], name) || begins(&["segund", "sekund"], name);
    let prefixes = [
        ("deci", 0.1),
        ("d", 0.1),
        ("centi", 1e-2),
        ("c", 1e-2),
        ("milli", 1e-3),
        ("mili", 1e-3),
        ("m", 1e-3),
        ("micro", 1e-6),
        ("mikro", 1e-6),
        ("u", 1e-6),
        ("nano", 1e-9),
        ("n", 1e-9),
        ("kilo", 1e3),
        ("k", 1e3),
    ];
    let prefixed =
        || prefixes.iter().find(|(prefix, _)| name.strip_prefix(prefix).is_some_and(is_second)).map(|(_, size)| *size);
    let seconds = match name.as_str() {
        "min" | "mins" | "mn" => 60.0,
        "h" | "hr" | "hrs" => 3600.0,
        "d" => crate::constants::DAY_S,
        name if is_second(name) => 1.0,
        name if begins(&["minut"], name) => 60.0,
        name if is_of(&["hour", "heur", "hora", "stund"], name) => 3600.0,
        "ora" | "ore" | "uur" | "uren" | "std" => 3600.0,
        "dagen" | "giorno" | "giorni" | "tag" | "tage" | "tagen" | "dia" | "dias" => crate::constants::DAY_S,
        name if is_of(&["day", "jour"], name) => crate::constants::DAY_S,
        _ => prefixed()?,
    };
    Some(factor * seconds)
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
            ("seconds, not ms", Err("several units".to_owned())),
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
            ("secs/1000", Err("a unit divided or multiplied by a number".to_owned())),
            ("exposure (seconds x 10)", Err("a unit divided or multiplied by a number".to_owned())),
            ("exposure in s, error 10 ms", Ok(Some(1.0))),
            ("seconds; 1/60 s accuracy", Ok(Some(1.0))),
            ("exposure [ms], dead time 2 s", Ok(Some(1e-3))),
            ("ticks", Err("steps of unknown size".to_owned())),
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
            ("sec / 1000", Err("a unit divided or multiplied by a number".to_owned())),
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
            ("sec (x100)", Err("a unit divided or multiplied by a number".to_owned())),
            ("secondary mirror", Ok(None)),
            ("exposure (?s)", Err("a unit that is not ASCII".to_owned())),
        ] {
            assert_eq!(Comment::new(text).unit_s(), seconds, "{text}");
        }
    }
    #[test]
    fn durations_in_comments() {
        let unclear = |text: &str| Err(format!("seconds or in the unit of {text:?}"));
        let resolution = || Err("a unit or a resolution".to_owned());
        for (text, value, seconds) in [
            ("30 s", 30.0, Ok(Some(1.0))),
            ("exposure of 30 s", 30.0, Ok(Some(1.0))),
            ("exposure of 30 s", 20.0, unclear("30 s")),
            ("5 minutes exposure", 300.0, Ok(Some(1.0))),
            ("5 minutes exposure", 5.0, Ok(Some(60.0))),
            ("5 minutes exposure", 4.0, unclear("5 minutes")),
            ("~5 minutes", 299.0, Ok(Some(1.0))),
            ("exposure 5 min = 300 s", 300.0, Ok(Some(1.0))),
            ("1 min 30 s", 90.0, Ok(Some(1.0))),
            ("Exposure 1/20 s", 0.05, Ok(Some(1.0))),
            ("Exposure time in 10 ms", 5.0, unclear("10 ms")),
            ("(10 ms)", 5.0, unclear("10 ms")),
            ("in 0.1 s", 5.0, unclear("0.1 s")),
            ("in .1 s", 5.0, unclear(".1 s")),
            ("in 1e-3 s", 5.0, unclear("1e-3 s")),
            ("exposure in 1e-3 s units", 5.0, resolution()),
            ("1 unit = 10 ms", 5.0, Ok(Some(0.01))),
            ("in units of 10 ms", 5.0, Ok(Some(0.01))),
            ("in units of 10 ms", 0.5, unclear("10 ms")),
            ("ticks of 1/60 s", 5.0, Ok(Some(1.0 / 60.0))),
            ("Exposure in 1/1000 s", 5.0, Ok(Some(1e-3))),
            ("1/100 s", 200.0, Ok(Some(0.01))),
            ("total (3 x 20 s)", 60.0, Ok(Some(1.0))),
            ("total (3 x 20 s)", 50.0, unclear("20 s")),
            ("Exposure time, resolution 1 ms", 30.0, Ok(None)),
            ("Exposure time (1 ms resolution)", 30.0, Ok(None)),
            ("multiples of 0.1 s", 5.0, resolution()),
            ("Exposure time (0.1 s steps)", 5.0, resolution()),
            ("10 ms increments", 10.0, resolution()),
            ("exposure in s, 0.1 s steps", 5.0, Ok(Some(1.0))),
            ("exposure +/- 5 s", 60.0, Ok(None)),
            ("exposure time, accurate to 1 s", 60.0, Ok(None)),
            ("2D image", 5.0, Ok(None)),
        ] {
            assert_eq!(Comment::new(text).unit_of_s(value), seconds, "{text}, {value}");
        }
    }
}

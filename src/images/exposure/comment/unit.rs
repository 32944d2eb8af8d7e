//! Units of time in comments.

use super::words::{Comment, lists};

/// Words of steps, before or after their size, as in "units of 10 ms" and "10 ms steps".
const SIZED: &str = "unit units step steps tick ticks increments multiples";
const STEPS: &str = "ticks jiffies";
/// Endings of words of seconds, minutes and hours in several languages, after their stems.
const ENDINGS: &[&str] = &["", "s", "e", "es", "en", "n", "o", "os", "i", "a", "as"];

impl Comment {
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
        if is_clock_form(&lower) {
            return Err("the form of a clock, such as h:m:s".to_owned());
        }
        let multiple_s = multiple(&lower)?;
        // In "exposure in s, error 10 ms" and "seconds (1/60 s steps)", the number with a unit is no unit of the value.
        let bare = without_quantities(&lower);
        let unit = self.named_unit_s(&bare)?;
        if unit.is_some() || multiple_s.is_some() {
            return Ok(unit.or(multiple_s));
        }
        match self.named_unit_s(&lower)? {
            None if self.has(STEPS) => Err("steps of unknown size".to_owned()),
            unit => Ok(unit),
        }
    }

    /// Returns the number of seconds in the unit that a word or a sign of the comment, in lower case, names.
    fn named_unit_s(&self, lower: &str) -> Result<Option<f64>, String> {
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
            let mut nexts = lower.match_indices(&phrase).map(|(at, _)| lower[at + phrase.len()..].chars().next());
            nexts.any(|next| next.is_none_or(|next| next != '/' && !next.is_ascii_alphanumeric()))
        };
        // "Exposure time, h" and "Exposure time / min", but not "(min 0.1, max 30)".
        let last = lower.rsplit([',', ';', ':']).next().unwrap_or_default();
        let last = last.rsplit(" / ").next().unwrap_or_default().trim().trim_end_matches('.');
        let is_least = |word: &str| word == "min" && lower.contains("max");
        let is_marked = |word: &str| !is_least(word) && (last == word || marks.iter().any(|mark| follows(mark, word)));
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
        let part = named.iter().find(|(word, _)| lower.contains(word)).map_or(1.0, |(_, part)| *part);
        match units[..] {
            [] => Ok(None),
            [unit_s] => Ok(Some(part * unit_s)),
            _ => Err("several units".to_owned()),
        }
    }
}

/// Returns the number of seconds in a unit with a factor: `1/1000 s` anywhere, and `10 ms` as in "units of 10 ms" and
/// "10 ms steps"; `None` if the text contains none.
///
/// # Errors
/// A unit divided or multiplied by a number.
fn multiple(text: &str) -> Result<Option<f64>, String> {
    let text = text.trim();
    let is_part_of_word = |c: char| c.is_ascii_alphanumeric() || c == '.';
    let begins_word = |at: usize| !text[..at].ends_with(is_part_of_word);
    let numbers = text.char_indices().filter(|(at, c)| c.is_ascii_digit() && begins_word(*at));
    for (at, _) in numbers {
        let end =
            at + text[at..].find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '/')).unwrap_or(text.len() - at);
        let (top, bottom) = text[at..end].split_once('/').unwrap_or((&text[at..end], "1"));
        let (Ok(top), Ok(bottom)) = (top.parse::<f64>(), bottom.parse::<f64>()) else { continue };
        let is_fraction = top == 1.0 && bottom > 1.0;
        let before = text[..at].trim_end();
        let word_before = before.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        let operator = before.chars().next_back().filter(|c| matches!(c, '/' | '*' | 'x'));
        let is_operator = operator.is_some_and(|c| c != 'x' || word_before == "x");
        let factored = before.trim_end_matches(['/', '*', 'x', ' ']);
        let unit_before = factored.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        if is_operator && seconds_in(unit_before).is_some() && factored.ends_with(|c: char| c.is_ascii_alphabetic()) {
            return Err("a unit divided or multiplied by a number".to_owned());
        }
        let rest = text[end..].trim_start();
        let unit_end = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
        let Some(unit_s) = seconds_in(&rest[..unit_end]) else { continue };
        let mut after = rest[unit_end..].split(|c: char| !c.is_ascii_alphabetic()).filter(|word| !word.is_empty());
        let mut words_before = before.rsplit(|c: char| !c.is_ascii_alphabetic()).filter(|word| !word.is_empty());
        let (last, last_but_one) = (words_before.next(), words_before.next());
        let is_sized = |word: Option<&str>| word.is_some_and(|word| lists(SIZED, word));
        // "30 s" alone repeats the value.
        let is_unit = (last == Some("of") && is_sized(last_but_one)) || is_sized(after.next());
        if is_fraction || (is_unit && bottom == 1.0 && top > 0.0) {
            return Ok(Some(unit_s * top / bottom));
        }
    }
    Ok(None)
}

/// Returns a text without numbers that are followed by a unit, and without this unit.
fn without_quantities(text: &str) -> String {
    let (mut kept, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        let end =
            at + rest[at..].find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '/')).unwrap_or(rest.len() - at);
        let unit = rest[end..].trim_start();
        let unit_end = unit.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(unit.len());
        let is_quantity = seconds_in(&unit[..unit_end]).is_some()
            && !(kept.clone() + &rest[..at]).ends_with(|c: char| c.is_ascii_alphanumeric());
        kept += &rest[..if is_quantity { at } else { end }];
        rest = if is_quantity { &unit[unit_end..] } else { &rest[end..] };
    }
    kept + rest
}

/// Returns true if a text contains units joined by colons, as in "(hours:min)" and "hh:mm:ss".
fn is_clock_form(text: &str) -> bool {
    let is_unit = |word: &str| {
        let first = word.chars().next();
        let is_repeated =
            || word.len() <= 2 && "hms".contains(first.unwrap_or(' ')) && word.chars().all(|c| Some(c) == first);
        seconds_in(word).is_some() || is_repeated() || word == "m"
    };
    if ["mm.ss", "hh.mm", "mmss", "hhmm"].iter().any(|form| text.contains(form)) {
        return true;
    }
    let is_form = |(at, _): (usize, &str)| {
        let before = text[..at].rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        let after = text[at + 1..].split(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default();
        is_unit(before) && is_unit(after)
    };
    text.match_indices(':').any(is_form)
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
    let is_second = |name: &str| is_of(&["sec", "second", "segund", "sekund"], name);
    let prefixes = [
        ("deci", 0.1),
        ("centi", 1e-2),
        ("milli", 1e-3),
        ("m", 1e-3),
        ("micro", 1e-6),
        ("u", 1e-6),
        ("nano", 1e-9),
        ("n", 1e-9),
        ("kilo", 1e3),
        ("k", 1e3),
    ];
    let prefixed =
        || prefixes.iter().find(|(prefix, _)| name.strip_prefix(prefix).is_some_and(is_second)).map(|(_, size)| *size);
    let seconds = match name.as_str() {
        "s" => 1.0,
        "ds" => 0.1,
        "cs" => 1e-2,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "ks" => 1e3,
        "min" | "mins" | "mn" => 60.0,
        "h" | "hr" | "hrs" => 3600.0,
        "d" => crate::constants::DAY_S,
        name if is_second(name) => 1.0,
        name if is_of(&["minut"], name) => 60.0,
        name if is_of(&["hour", "heur", "hora", "stund"], name) => 3600.0,
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
            ("exposure (')", Ok(Some(60.0))),
            ("exposure (hours:min)", Err("the form of a clock, such as h:m:s".to_owned())),
            ("duration hh:mm:ss", Err("the form of a clock, such as h:m:s".to_owned())),
            ("exposure in s: requested", Ok(Some(1.0))),
            ("secs/1000", Err("a unit divided or multiplied by a number".to_owned())),
            ("exposure (seconds x 10)", Err("a unit divided or multiplied by a number".to_owned())),
            ("in units of 10 ms", Ok(Some(0.01))),
            ("10 ms steps", Ok(Some(0.01))),
            ("ticks of 1/60 s", Ok(Some(1.0 / 60.0))),
            ("30 s", Ok(None)),
            ("exposure in s, error 10 ms", Ok(Some(1.0))),
            ("seconds; 1/60 s accuracy", Ok(Some(1.0))),
            ("exposure [ms], dead time 2 s", Ok(Some(1e-3))),
            ("ticks", Err("steps of unknown size".to_owned())),
            ("exposure of 30 s", Ok(None)),
            ("exposure (max 30 s)", Ok(None)),
            ("seconds (min 0.1, max 3600)", Ok(Some(1.0))),
            ("mm.ss", Err("the form of a clock, such as h:m:s".to_owned())),
            ("Exp. time, h", Ok(Some(3600.0))),
            ("Integration time / min", Ok(Some(60.0))),
            ("Belichtungszeit in Minuten", Ok(Some(60.0))),
            ("duree en heures", Ok(Some(3600.0))),
            ("tiempo en segundos", Ok(Some(1.0))),
            ("secondary mirror", Ok(None)),
            ("exposure (?s)", Err("a unit that is not ASCII".to_owned())),
        ] {
            assert_eq!(Comment::new(text).unit_s(), seconds, "{text}");
        }
    }
}

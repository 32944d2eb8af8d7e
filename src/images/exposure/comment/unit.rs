//! Units of time in comments.

use super::Comment;

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

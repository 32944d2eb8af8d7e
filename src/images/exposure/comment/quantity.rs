//! Durations in comments, such as "10 ms": the value itself, the size of its unit, or a resolution.

use std::ops::Range;

use super::seconds::seconds_in;
use super::words::{Comment, lists};

/// Words before the size of a unit, as in "units of 10 ms" and "1 tick = 10 ms", and words of steps without a size.
const SIZED: &str = "unit units tick ticks";
const STEPS: &str = "ticks jiffies cycles clocks lines";
/// Words beside a duration that may be the size of a unit or a resolution.
const RESOLUTIONS: &str = "unit units tick ticks jiffies step steps increment increments multiple multiples";
/// Words and signs before a duration that limits the value or is its error.
const LIMITS: &str = "max maximum min minimum error accuracy uncertainty precision resolution";
const LIMIT_SIGNS: &[&str] =
    &["+/-", "+-", "<", ">", "than", "within", "accurate to", "precise to", "rounded to", "good to"];
/// Largest difference between a duration in a comment and the value, a fraction of the duration.
const QUANTITY_SLACK: f64 = 0.01;
/// An hour, seconds: the unit of zones.
pub(super) const HOUR_S: f64 = 3600.0;

impl Comment {
    /// Returns the number of seconds in the unit of a value beside durations: `10 ms` as in "units of 10 ms", `1/1000
    /// s` as in "in 1/1000 s", a second if a duration is the value in seconds, and its unit if the number is the value.
    pub(super) fn unit_of_quantities_s(&self, text: &str, all: &[Quantity], value: f64) -> Result<Option<f64>, String> {
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
            return if self.has(STEPS) || self.has_pair("line row", "times") {
                Err("steps of unknown size".to_owned())
            } else {
                Ok(None)
            };
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
}

/// Duration in a comment, in lower case.
pub(super) struct Quantity {
    pub at: Range<usize>,
    pub number: f64,
    pub unit_s: f64,
    /// True for `1/1000 s`.
    is_fraction: bool,
}

/// Returns the end of a number, perhaps a fraction or with an exponent, that begins a text.
pub(super) fn number_end(text: &str) -> usize {
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
pub(super) fn quantities(text: &str) -> Vec<Quantity> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
            ("exposure in line times", 5.0, Err("steps of unknown size".to_owned())),
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

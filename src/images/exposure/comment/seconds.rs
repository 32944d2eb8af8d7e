//! Names of units of time and of fractions in several languages.

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
/// Endings of words of seconds, minutes and hours in several languages, after their stems.
pub const ENDINGS: &[&str] = &["", "s", "e", "es", "en", "n", "o", "os", "i", "a", "as"];

/// Returns the rest of a word after the stem of a fraction, and the fraction, as in "zehntelsekunden"; `None` for other
/// words, such as "decimal".
pub fn fraction(word: &str) -> Option<(&str, f64)> {
    let (rest, size) = FRACTIONS.iter().find_map(|(stem, size)| Some((word.strip_prefix(stem)?, *size)))?;
    (ENDINGS.contains(&rest) || seconds_in(rest).is_some()).then_some((rest, size))
}

/// Returns the number of seconds in a unit of time, for example `ms`, `10 us`, `1/1000 s`, `hours` or `Minuten`; `None`
/// for other words.
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
    let is_second = |name: &str| {
        ["s", "seg", "segs"].contains(&name) || is_of(&["sec", "second"], name) || begins(&["segund", "sekund"], name)
    };
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

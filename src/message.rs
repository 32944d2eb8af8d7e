//! Parts of messages, of bounded length: values of inputs, lists of names, and whole messages; the precision of times.

use std::borrow::Cow;
use std::fmt;

/// Largest number of characters of a message.
pub const LONGEST_MESSAGE: usize = 1000;
/// Largest number of characters of a value.
const LONGEST_VALUE: usize = 60;
/// Largest number of characters of a statement about values, which quotes some of them.
const LONGEST_STATEMENT: usize = 200;
/// Largest number of names in a list.
const MOST_NAMES: usize = 12;
/// Number of messages of one kind that are shown.
const MOST_MESSAGES: usize = 3;
/// Number of characters at the end of a message that are kept if it is too long: the accepted values.
const KEPT_END: usize = 300;

/// Value of an input in a message: its first 60 characters, with control characters and invisible marks escaped.
#[derive(Clone, PartialEq, Eq)]
pub struct Quoted(String);

impl Quoted {
    /// Shortens and escapes a value.
    pub fn new(value: impl AsRef<str>) -> Self {
        Self(shortened(value.as_ref(), LONGEST_VALUE))
    }

    /// Shortens and escapes a statement about values, which is longer than one of them.
    pub fn statement(text: &str) -> Self {
        Self(shortened(text, LONGEST_STATEMENT))
    }

    /// Returns the text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

fn shortened(value: &str, longest: usize) -> String {
    let mut characters = value.chars();
    let first: String = characters.by_ref().take(longest).collect();
    let shown = printable(&first).replace('\n', "\\n");
    if characters.next().is_some() { shown + "..." } else { shown }
}

impl fmt::Display for Quoted {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl fmt::Debug for Quoted {
    /// Writes the value in quotation marks.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "\"{}\"", self.0)
    }
}

/// Returns the first 12 names, shortened and separated by commas, and the number of the others.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let mut shown: Vec<String> = names.by_ref().take(MOST_NAMES).map(|name| Quoted::new(name).to_string()).collect();
    let others = names.count();
    if others > 0 {
        shown.push(format!("and {others} more"));
    }
    shown.join(", ")
}

/// Returns the first three of several messages of one kind, and the number of the others. `what` describes them in
/// plural, for example "targets without a window".
pub fn first_of(messages: impl IntoIterator<Item = String>, what: &str) -> Vec<String> {
    let mut messages = messages.into_iter();
    let mut shown: Vec<String> = messages.by_ref().take(MOST_MESSAGES).collect();
    let others = messages.count();
    if others > 0 {
        shown.push(format!("{others} more {what}"));
    }
    shown
}

/// Returns a message of at most [`LONGEST_MESSAGE`] characters. If it is longer, its middle is left out.
pub fn bounded(message: &str) -> Cow<'_, str> {
    let length = message.chars().count();
    if length <= LONGEST_MESSAGE {
        return Cow::Borrowed(message);
    }
    let cut = |first: usize| format!(" ... ({} characters omitted) ... ", length - first - KEPT_END);
    let first = LONGEST_MESSAGE - KEPT_END - cut(0).len();
    let begin: String = message.chars().take(first).collect();
    let end: String = message.chars().skip(length - KEPT_END).collect();
    Cow::Owned(begin + &cut(first) + &end)
}

/// Escapes control characters except line breaks in text from files, because terminals interpret them. Unicode controls
/// of the writing direction are escaped too, because they change the order in which text appears.
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_hidden =
        |c: char| c.is_control() && c != '\n' || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let escaped = |c: char| if is_hidden(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(escaped).collect())
}

/// Returns the step to which times are rounded whose error is `sigma_s`: 1 s, 10 s, 1 min or 10 min; 1 min for NaN.
pub fn known_step_s(sigma_s: f64) -> f64 {
    let least = |step_s: &f64| sigma_s <= *step_s || (sigma_s.is_nan() && *step_s == 60.0);
    [1.0, 10.0, 60.0].into_iter().find(least).unwrap_or(600.0)
}

/// Letters and symbols, each with its substitute in ASCII.
const ASCII_SUBSTITUTES: &[(&str, &str)] = &[
    ("ÀÁÂÃÄÅĀĂĄ", "A"),
    ("àáâãäåāăą", "a"),
    ("Æ", "AE"),
    ("æ", "ae"),
    ("ÇĆČĊ", "C"),
    ("çćčċ", "c"),
    ("ĎĐÐ", "D"),
    ("ďđð", "d"),
    ("ÈÉÊËĒĖĘĚ", "E"),
    ("èéêëēėęě", "e"),
    ("ĞĢĠ", "G"),
    ("ğģġ", "g"),
    ("ÌÍÎÏĪĮİ", "I"),
    ("ìíîïīįı", "i"),
    ("Ķ", "K"),
    ("ķ", "k"),
    ("ŁĽĻĹ", "L"),
    ("łľļĺ", "l"),
    ("ÑŃŇŅ", "N"),
    ("ñńňņ", "n"),
    ("ÒÓÔÕÖØŌŐ", "O"),
    ("òóôõöøōő", "o"),
    ("Œ", "OE"),
    ("œ", "oe"),
    ("ŘŔ", "R"),
    ("řŕ", "r"),
    ("ŚŠŞȘ", "S"),
    ("śšşș", "s"),
    ("ß", "ss"),
    ("ŤŢȚ", "T"),
    ("ťţț", "t"),
    ("Þ", "Th"),
    ("þ", "th"),
    ("ÙÚÛÜŪŮŰŲ", "U"),
    ("ùúûüūůűų", "u"),
    ("ŴẀẂẄ", "W"),
    ("ŵẁẃẅ", "w"),
    ("ÝŸŶ", "Y"),
    ("ýÿŷ", "y"),
    ("ŹŻŽ", "Z"),
    ("źżž", "z"),
    ("‘’ʻʼ", "'"),
    ("“”", "\""),
    ("‐‑–—−", "-"),
    ("°", "deg"),
    ("…", "..."),
    ("\u{a0}\u{202f}", " "),
];

/// Returns a text without accents, with `?` for other characters beyond ASCII.
pub(crate) fn in_ascii(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            ' '..='~' => plain.push(c),
            // Combining accents.
            '\u{300}'..='\u{36f}' => {}
            _ => plain += ASCII_SUBSTITUTES.iter().find(|(kin, _)| kin.contains(c)).map_or("?", |(_, ascii)| ascii),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_shortened_and_escaped() {
        assert_eq!(Quoted::new("12 h").to_string(), "12 h");
        assert_eq!(Quoted::new("a\u{1b}[31m\nb\u{202e}").to_string(), "a\\u{1b}[31m\\nb\\u{202e}");
        assert_eq!(Quoted::new("é".repeat(60)).to_string(), "é".repeat(60));
        assert_eq!(Quoted::new("é".repeat(61)).to_string(), "é".repeat(60) + "...");
    }

    #[test]
    fn lists_end_with_the_number_of_the_others() {
        let names: Vec<String> = (0..100_000).map(|number| number.to_string()).collect();
        assert_eq!(listed(names[..3].iter().map(String::as_str)), "0, 1, 2");
        assert!(listed(names.iter().map(String::as_str)).ends_with("10, 11, and 99988 more"));
    }

    #[test]
    fn long_messages_keep_their_begin_and_end() {
        for length in [0, 999, 1000] {
            let text = "é".repeat(length);
            assert_eq!(bounded(&text), text);
        }
        for length in [1001, 10_000_000] {
            let text = "invalid value 'é".to_owned() + &"x".repeat(length) + "'; allowed: a number";
            let short = bounded(&text);
            assert!(short.chars().count() <= LONGEST_MESSAGE && short.chars().count() > 900);
            assert!(short.starts_with("invalid value 'é") && short.ends_with("'; allowed: a number"));
            assert!(short.contains(" characters omitted) "), "{short}");
        }
    }
}

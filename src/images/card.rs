//! Card of a FITS header: 80 characters, which are kept unchanged.

use std::fmt::Write;

/// Characters in a card.
pub const CARD_LENGTH: usize = 80;

/// Longest quoted text on one card, in characters; a quote within the text counts twice.
const LONGEST_TEXT: usize = 68;

/// Longest keyword, including keywords of the HIERARCH convention; longer keywords are truncated.
const LONGEST_KEYWORD: usize = 40;

/// Largest number of characters of text on one HISTORY or COMMENT card.
const LONGEST_REMARK: usize = 72;

/// Column in which a number or a logical value ends in the fixed format of the FITS standard.
const FIXED_END: usize = 30;

/// Value of a card.
#[derive(Clone, Debug, PartialEq)]
pub enum CardValue {
    /// Text without trailing blanks.
    Text(String),
    /// An integer.
    Integer(i64),
    /// Floating-point number; written with as many digits as needed to read the same number back (at most 17).
    Real(f64),
    /// Logical value, T or F.
    Logical(bool),
    /// Undefined value.
    Undefined,
}

impl From<f64> for CardValue {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Real(number) } else { Self::Undefined }
    }
}

impl From<i64> for CardValue {
    fn from(number: i64) -> Self {
        Self::Integer(number)
    }
}

impl From<&str> for CardValue {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<bool> for CardValue {
    fn from(value: bool) -> Self {
        Self::Logical(value)
    }
}

/// One header card. It stores the 80 bytes that were read, so that cards that cannot be parsed are not lost.
#[derive(Clone, PartialEq, Eq)]
pub struct Card {
    image: [u8; CARD_LENGTH],
}

impl std::fmt::Debug for Card {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Card({:?})", self.text().trim_end())
    }
}

impl Card {
    /// Creates a card from the bytes of a file, padded with blanks or truncated to 80 bytes.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        let mut image = [b' '; CARD_LENGTH];
        let length = bytes.len().min(CARD_LENGTH);
        image[..length].copy_from_slice(&bytes[..length]);
        Self { image }
    }

    /// Creates the cards of a keyword with its value. A text that is longer than a card is continued on CONTINUE cards.
    ///
    /// Keywords of more than eight characters, and keywords with a blank, are written by the HIERARCH convention.
    /// Characters that are not ASCII become `?`. A comment that does not fit is truncated.
    pub fn with_value(keyword: &str, value: &CardValue, comment: &str) -> Vec<Self> {
        let mut keyword = to_ascii(keyword).to_ascii_uppercase();
        keyword.truncate(LONGEST_KEYWORD);
        let head = if keyword.len() <= 8 && !keyword.contains(' ') {
            format!("{keyword:<8}= ")
        } else {
            format!("HIERARCH {keyword} = ")
        };
        let comment = to_ascii(comment);
        let quoted = match value {
            CardValue::Text(text) => to_ascii(text).replace('\'', "''"),
            CardValue::Integer(number) => return vec![Self::of_number(&head, &number.to_string(), &comment)],
            CardValue::Real(number) => return vec![Self::of_number(&head, &format_real(*number), &comment)],
            CardValue::Logical(true) => return vec![Self::of_number(&head, "T", &comment)],
            CardValue::Logical(false) => return vec![Self::of_number(&head, "F", &comment)],
            CardValue::Undefined => return vec![Self::of_number(&head, "", &comment)],
        };
        let space = CARD_LENGTH - head.len() - 2;
        if quoted.len() <= space {
            return vec![Self::with_comment(format!("{head}'{quoted:<8}'"), &comment)];
        }
        // A long text: each card except the last one ends in an ampersand.
        let mut cards = Vec::new();
        let mut rest = quoted.as_str();
        let mut start = head;
        loop {
            let space = (CARD_LENGTH - start.len() - 2).min(LONGEST_TEXT);
            if rest.len() <= space {
                cards.push(Self::with_comment(format!("{start}'{rest}'"), &comment));
                return cards;
            }
            let mut cut = space - 1;
            // A doubled quote must not be split between two cards.
            if (rest[..cut].len() - rest[..cut].trim_end_matches('\'').len()) % 2 == 1 {
                cut -= 1;
            }
            cards.push(Self::from_bytes(format!("{start}'{}&'", &rest[..cut]).as_bytes()));
            rest = &rest[cut..];
            start = "CONTINUE  ".to_owned();
        }
    }

    /// Creates HISTORY or COMMENT cards from a text, with up to 72 characters each, broken between words if possible.
    pub fn remark(keyword: &str, text: &str) -> Vec<Self> {
        let text = to_ascii(text);
        let mut cards = Vec::new();
        let mut rest = text.as_str();
        loop {
            let mut cut = rest.len();
            if cut > LONGEST_REMARK {
                cut = rest[..LONGEST_REMARK].rfind(' ').map_or(LONGEST_REMARK, |blank| blank + 1);
            }
            cards.push(Self::from_bytes(format!("{keyword:<8}{}", &rest[..cut]).as_bytes()));
            rest = &rest[cut..];
            if rest.is_empty() {
                return cards;
            }
        }
    }

    fn of_number(head: &str, number: &str, comment: &str) -> Self {
        let width = FIXED_END.saturating_sub(head.len());
        Self::with_comment(format!("{head}{number:>width$}"), comment)
    }

    fn with_comment(mut text: String, comment: &str) -> Self {
        if !comment.is_empty() {
            let _ = write!(text, "{:1$} / {comment}", "", FIXED_END.saturating_sub(text.len()));
        }
        Self::from_bytes(text.as_bytes())
    }

    /// Returns the 80 bytes.
    pub fn bytes(&self) -> &[u8; CARD_LENGTH] {
        &self.image
    }

    /// Returns the 80 characters; bytes that are not printable ASCII become `?`.
    pub fn text(&self) -> String {
        self.image.iter().map(|byte| if (b' '..=b'~').contains(byte) { char::from(*byte) } else { '?' }).collect()
    }

    /// Returns the keyword in capitals; for a HIERARCH card, the keyword after HIERARCH. Empty for a blank card.
    pub fn keyword(&self) -> String {
        let text = self.text();
        if let Some(rest) = text.strip_prefix("HIERARCH ")
            && let Some((name, _)) = rest.split_once('=')
        {
            return name.trim().to_ascii_uppercase();
        }
        text[..8].trim_end().to_ascii_uppercase()
    }

    /// Returns the value; `None` for a card without a value (remark, CONTINUE, blank card) or with an invalid value.
    pub fn value(&self) -> Option<CardValue> {
        self.split().0
    }

    /// Returns the comment after the value; empty if there is none.
    pub fn comment(&self) -> String {
        self.split().1
    }

    /// Returns the text of a HISTORY, COMMENT, blank or CONTINUE card.
    pub fn remark_text(&self) -> String {
        self.text()[8..].trim_end().to_owned()
    }

    /// Returns the field after the equals sign, or the text of a CONTINUE card.
    fn field(&self) -> Option<String> {
        let text = self.text();
        if text.starts_with("HIERARCH ") {
            return text.split_once('=').map(|(_, field)| field.to_owned());
        }
        let is_value = &text[8..10] == "= " || (text.as_bytes()[8] == b'=' && !text.starts_with(' '));
        if is_value {
            return Some(text[9..].to_owned());
        }
        text.starts_with("CONTINUE").then(|| text[8..].to_owned())
    }

    fn split(&self) -> (Option<CardValue>, String) {
        let Some(field) = self.field() else { return (None, String::new()) };
        let field = field.trim_start();
        let comment = |rest: &str| rest.trim_start().trim_start_matches('/').trim().to_owned();
        if let Some(quoted) = field.strip_prefix('\'') {
            let mut text = String::new();
            let mut rest = quoted;
            while let Some(end) = rest.find('\'') {
                text.push_str(&rest[..end]);
                rest = &rest[end + 1..];
                if !rest.starts_with('\'') {
                    return (Some(CardValue::Text(text.trim_end().to_owned())), comment(rest));
                }
                text.push('\'');
                rest = &rest[1..];
            }
            // The closing quote is missing: the rest of the card is the text.
            text.push_str(rest);
            return (Some(CardValue::Text(text.trim_end().to_owned())), String::new());
        }
        let (value, rest) = field.find('/').map_or((field, ""), |slash| field.split_at(slash));
        (parse_plain(value.trim()), comment(rest))
    }

    /// Returns the quoted text with its trailing blanks, which are significant in texts that are divided over several
    /// keywords (IRAF's WAT).
    pub(super) fn padded_text(&self) -> Option<String> {
        let Some(CardValue::Text(text)) = self.value() else { return None };
        Some(format!("{text:<LONGEST_TEXT$}"))
    }
}

/// Parses a value without quotation marks.
fn parse_plain(text: &str) -> Option<CardValue> {
    match text {
        "" => return Some(CardValue::Undefined),
        "T" => return Some(CardValue::Logical(true)),
        "F" => return Some(CardValue::Logical(false)),
        _ => {}
    }
    if let Ok(number) = text.parse::<i64>() {
        return Some(CardValue::Integer(number));
    }
    parse_real(text).map(CardValue::Real)
}

/// Parses a real number of a FITS header. The exponent may be marked with D. `inf` and `nan` are rejected.
pub(super) fn parse_real(text: &str) -> Option<f64> {
    let text = text.trim();
    if !text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
        return None;
    }
    text.replace(['D', 'd'], "E").parse::<f64>().ok().filter(|number| number.is_finite())
}

/// Formats a number as the shortest text that reads back as the same number, with a decimal point.
fn format_real(number: f64) -> String {
    let size = number.abs();
    if number == 0.0 || (1e-4..1e15).contains(&size) {
        let text = format!("{number}");
        return if text.contains('.') { text } else { format!("{text}.0") };
    }
    let text = format!("{number:E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let point = if mantissa.contains('.') { "" } else { ".0" };
    format!("{mantissa}{point}E{exponent}")
}

/// Replaces characters that are not ASCII by `?`.
pub(super) fn to_ascii(text: &str) -> String {
    text.chars().map(|c| if (' '..='~').contains(&c) { c } else { '?' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card_of(keyword: &str, value: impl Into<CardValue>, comment: &str) -> Card {
        let mut cards = Card::with_value(keyword, &value.into(), comment);
        assert_eq!(cards.len(), 1);
        cards.remove(0)
    }

    #[test]
    fn verif_written_values_read_back() {
        for number in
            [0.1 + 0.2, -1.0, 58_914.002_956_14, 6.626e-34, 1e300, -4.9e-324, 1e15, 123_456_789_012_345_680.0, 1e-4]
        {
            let card = card_of("CRVAL1", number, "a number");
            assert_eq!(card.value(), Some(CardValue::Real(number)), "{card:?}");
            assert_eq!(card.comment(), "a number");
        }
        assert_eq!(card_of("NAXIS", 2_i64, "").text().trim_end(), "NAXIS   =                    2");
        assert_eq!(card_of("SIMPLE", true, "is FITS").text().trim_end(), "SIMPLE  =                    T / is FITS");
        assert_eq!(card_of("OBJECT", "d'Arrest", "").value(), Some(CardValue::Text("d'Arrest".to_owned())));
        let long_name = card_of("MAGZERO_RMS", 1.5, "");
        assert_eq!(long_name.keyword(), "MAGZERO_RMS");
        assert_eq!(long_name.value(), Some(CardValue::Real(1.5)));
        assert_eq!(card_of("X", f64::NAN, "").value(), Some(CardValue::Undefined));
    }

    #[test]
    fn verif_values_written_by_other_software() {
        for (text, value) in [
            ("RADESYS =  'FK5     '           / frame", CardValue::Text("FK5".to_owned())),
            ("GAIN    = 1.0     / now in electrons", CardValue::Real(1.0)),
            ("CD1_1   =   1.5D-05", CardValue::Real(1.5e-5)),
            ("CRPIX1  =                 361.", CardValue::Real(361.0)),
            ("CRPIX1=1565", CardValue::Undefined),
            ("A       = 'open", CardValue::Text("open".to_owned())),
            ("B       =", CardValue::Undefined),
            ("C       = 'a / b'  / c", CardValue::Text("a / b".to_owned())),
        ] {
            let card = Card::from_bytes(text.as_bytes());
            // CRPIX1=1565 has no equals sign in column 9, so it has no value.
            let expected = (!text.starts_with("CRPIX1=")).then_some(value);
            assert_eq!(card.value(), expected, "{text}");
        }
        assert_eq!(Card::from_bytes(b"E       = nan").value(), None);
    }

    #[test]
    fn verif_remarks_are_broken_between_words() {
        let cards = Card::remark("HISTORY", &"word ".repeat(30));
        assert_eq!(cards.len(), 3);
        assert!(cards.iter().all(|card| card.keyword() == "HISTORY" && card.remark_text().ends_with("word")));
    }
}

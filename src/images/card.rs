//! One card of a FITS header: 80 characters, kept as they were.

use std::fmt::Write;

/// Characters in a card.
pub const CARD_LENGTH: usize = 80;

/// Longest text in quotation marks on one card; a quote within counts twice.
const LONGEST_TEXT: usize = 68;

/// Characters of a keyword, those of the HIERARCH convention included; the rest is left out.
const LONGEST_KEYWORD: usize = 40;

/// Text on one card of HISTORY or COMMENT.
const LONGEST_REMARK: usize = 72;

/// Where a number or a logical value ends, from the first character: column 30 of the standard's fixed format.
const FIXED_END: usize = 30;

/// What stands behind the equals sign.
#[derive(Clone, Debug, PartialEq)]
pub enum CardValue {
    /// Text, blanks at its end left out.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// Any other number; written with as many digits as bring the same number back (17 at most).
    Real(f64),
    /// T or F.
    Logical(bool),
    /// Nothing: the value is not known.
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

/// One card. It is the same 80 bytes that were read, so what is not understood is not lost either.
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
    /// From bytes as they stand in a file; what is missing is filled with blanks, what is beyond 80 left out.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        let mut image = [b' '; CARD_LENGTH];
        let length = bytes.len().min(CARD_LENGTH);
        image[..length].copy_from_slice(&bytes[..length]);
        Self { image }
    }

    /// The cards of a keyword with its value: several where a text is longer than a card (by CONTINUE).
    ///
    /// Keywords of more than eight characters, and those with a blank, are written by the HIERARCH convention. Characters that are not ASCII
    /// become `?`. A comment that does not fit is cut.
    pub fn with_value(keyword: &str, value: &CardValue, comment: &str) -> Vec<Self> {
        let mut keyword = plain(keyword).to_ascii_uppercase();
        keyword.truncate(LONGEST_KEYWORD);
        let head = if keyword.len() <= 8 && !keyword.contains(' ') {
            format!("{keyword:<8}= ")
        } else {
            format!("HIERARCH {keyword} = ")
        };
        let comment = plain(comment);
        let quoted = match value {
            CardValue::Text(text) => plain(text).replace('\'', "''"),
            CardValue::Integer(number) => return vec![Self::of_number(&head, &number.to_string(), &comment)],
            CardValue::Real(number) => return vec![Self::of_number(&head, &real_text(*number), &comment)],
            CardValue::Logical(true) => return vec![Self::of_number(&head, "T", &comment)],
            CardValue::Logical(false) => return vec![Self::of_number(&head, "F", &comment)],
            CardValue::Undefined => return vec![Self::of_number(&head, "", &comment)],
        };
        let room = CARD_LENGTH - head.len() - 2;
        if quoted.len() <= room {
            return vec![Self::closed(format!("{head}'{quoted:<8}'"), &comment)];
        }
        // Long texts: each card but the last ends in an ampersand.
        let mut cards = Vec::new();
        let mut rest = quoted.as_str();
        let mut start = head;
        loop {
            let room = (CARD_LENGTH - start.len() - 2).min(LONGEST_TEXT);
            if rest.len() <= room {
                cards.push(Self::closed(format!("{start}'{rest}'"), &comment));
                return cards;
            }
            let mut cut = room - 1;
            // A quote and its double stay together.
            if (rest[..cut].len() - rest[..cut].trim_end_matches('\'').len()) % 2 == 1 {
                cut -= 1;
            }
            cards.push(Self::from_bytes(format!("{start}'{}&'", &rest[..cut]).as_bytes()));
            rest = &rest[cut..];
            start = "CONTINUE  ".to_owned();
        }
    }

    /// The cards of a remark: HISTORY or COMMENT, 72 characters each, broken between words where that is possible.
    pub fn remark(keyword: &str, text: &str) -> Vec<Self> {
        let text = plain(text);
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
        Self::closed(format!("{head}{number:>width$}"), comment)
    }

    fn closed(mut text: String, comment: &str) -> Self {
        if !comment.is_empty() {
            let _ = write!(text, "{:1$} / {comment}", "", FIXED_END.saturating_sub(text.len()));
        }
        Self::from_bytes(text.as_bytes())
    }

    /// The 80 bytes.
    pub fn bytes(&self) -> &[u8; CARD_LENGTH] {
        &self.image
    }

    /// The 80 characters; bytes that are no ASCII are shown as `?`.
    pub fn text(&self) -> String {
        self.image.iter().map(|byte| if (b' '..=b'~').contains(byte) { char::from(*byte) } else { '?' }).collect()
    }

    /// The keyword, in capitals; that behind HIERARCH for such cards; empty for a blank one.
    pub fn keyword(&self) -> String {
        let text = self.text();
        if let Some(rest) = text.strip_prefix("HIERARCH ")
            && let Some((name, _)) = rest.split_once('=')
        {
            return name.trim().to_ascii_uppercase();
        }
        text[..8].trim_end().to_ascii_uppercase()
    }

    /// The value; `None` for cards that hold none (remarks, CONTINUE, blank ones) or nothing that can be read.
    pub fn value(&self) -> Option<CardValue> {
        self.split().0
    }

    /// The comment behind the value; empty where there is none.
    pub fn comment(&self) -> String {
        self.split().1
    }

    /// The text of a HISTORY, COMMENT or blank card; that in the quotation marks of a CONTINUE.
    pub fn remark_text(&self) -> String {
        self.text()[8..].trim_end().to_owned()
    }

    /// The field behind the keyword: text behind the equals sign, or that of a CONTINUE.
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
            // The closing quote is missing: what stands there is the text.
            text.push_str(rest);
            return (Some(CardValue::Text(text.trim_end().to_owned())), String::new());
        }
        let (value, rest) = field.find('/').map_or((field, ""), |slash| field.split_at(slash));
        (parse_plain(value.trim()), comment(rest))
    }

    /// Text in quotation marks with the blanks at its end, which count where a text goes on over several keywords (WAT).
    pub(super) fn padded_text(&self) -> Option<String> {
        let Some(CardValue::Text(text)) = self.value() else { return None };
        Some(format!("{text:<LONGEST_TEXT$}"))
    }
}

/// A value without quotation marks.
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

/// A number as FITS writes it: an exponent may be marked with D. `inf` and `nan` are none.
pub(super) fn parse_real(text: &str) -> Option<f64> {
    let text = text.trim();
    if !text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
        return None;
    }
    text.replace(['D', 'd'], "E").parse::<f64>().ok().filter(|number| number.is_finite())
}

/// The shortest text that gives the same number back, with a point.
fn real_text(number: f64) -> String {
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

/// Text with `?` in place of what is not ASCII.
pub(super) fn plain(text: &str) -> String {
    text.chars().map(|c| if (' '..='~').contains(&c) { c } else { '?' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(keyword: &str, value: impl Into<CardValue>, comment: &str) -> Card {
        let mut cards = Card::with_value(keyword, &value.into(), comment);
        assert_eq!(cards.len(), 1);
        cards.remove(0)
    }

    #[test]
    fn verif_what_is_written_is_read() {
        for number in
            [0.1 + 0.2, -1.0, 58_914.002_956_14, 6.626e-34, 1e300, -4.9e-324, 1e15, 123_456_789_012_345_680.0, 1e-4]
        {
            let card = one("CRVAL1", number, "a number");
            assert_eq!(card.value(), Some(CardValue::Real(number)), "{card:?}");
            assert_eq!(card.comment(), "a number");
        }
        assert_eq!(one("NAXIS", 2_i64, "").text().trim_end(), "NAXIS   =                    2");
        assert_eq!(one("SIMPLE", true, "is FITS").text().trim_end(), "SIMPLE  =                    T / is FITS");
        assert_eq!(one("OBJECT", "d'Arrest", "").value(), Some(CardValue::Text("d'Arrest".to_owned())));
        let long_name = one("MAGZERO_RMS", 1.5, "");
        assert_eq!(long_name.keyword(), "MAGZERO_RMS");
        assert_eq!(long_name.value(), Some(CardValue::Real(1.5)));
        assert_eq!(one("X", f64::NAN, "").value(), Some(CardValue::Undefined));
    }

    #[test]
    fn verif_values_as_others_write_them() {
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
            // CRPIX1=1565 has no equals sign in column 9: it holds no value.
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

//! FITS header: an ordered list of cards.

use std::ops::Range;

use super::card::{CARD_LENGTH, Card, CardValue, parse_real};

/// Cards of one header in their order, without END, including cards that cannot be parsed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    cards: Vec<Card>,
}

impl Header {
    /// Creates a header from cards.
    #[doc(hidden)]
    pub fn from_cards(cards: Vec<Card>) -> Self {
        Self { cards }
    }

    /// Parses a header from text: cards of 80 characters without separators, as in a file, or one card per line, up to
    /// END.
    pub fn from_text(text: &str) -> Self {
        let cards: Vec<Card> = if text.contains('\n') {
            text.lines().map(|line| Card::from_bytes(line.trim_end_matches('\r').as_bytes())).collect()
        } else {
            text.as_bytes().chunks(CARD_LENGTH).map(Card::from_bytes).collect()
        };
        let end = cards.iter().position(is_end).unwrap_or(cards.len());
        Self { cards: cards.into_iter().take(end).collect() }
    }

    /// Returns the cards in order.
    #[doc(hidden)]
    pub fn cards(&self) -> &[Card] {
        &self.cards
    }

    /// Returns the number of cards.
    pub fn len(&self) -> usize {
        self.cards.len()
    }

    /// Returns true if the header has no cards.
    pub fn is_empty(&self) -> bool {
        self.cards.is_empty()
    }

    /// Returns the index of the first card with this keyword and a value.
    pub fn position(&self, keyword: &str) -> Option<usize> {
        self.cards.iter().position(|card| has_keyword(card, keyword))
    }

    /// Returns the first card with this keyword and a value.
    #[doc(hidden)]
    pub fn card(&self, keyword: &str) -> Option<&Card> {
        self.position(keyword).map(|index| &self.cards[index])
    }

    /// Returns true if the header has a card with this keyword and a value.
    pub fn contains(&self, keyword: &str) -> bool {
        self.position(keyword).is_some()
    }

    /// Returns the value of a keyword; a long text is joined from its CONTINUE cards.
    #[doc(hidden)]
    pub fn value(&self, keyword: &str) -> Option<CardValue> {
        let index = self.position(keyword)?;
        let value = self.cards[index].value()?;
        let CardValue::Text(mut text) = value else { return Some(value) };
        let mut rest = self.cards[index + 1..].iter();
        while text.ends_with('&') {
            let Some(CardValue::Text(more)) =
                rest.next().filter(|card| card.keyword() == "CONTINUE").and_then(Card::value)
            else {
                break;
            };
            text.pop();
            text.push_str(&more);
        }
        Some(CardValue::Text(text))
    }

    /// Returns the text of a keyword without surrounding blanks; `None` if the value is not a text or is blank.
    pub fn text(&self, keyword: &str) -> Option<String> {
        match self.value(keyword)? {
            CardValue::Text(text) => Some(text.trim().to_owned()).filter(|text| !text.is_empty()),
            _ => None,
        }
    }

    /// Returns the number of a keyword. A number in quotation marks, as some observatories write it, is accepted.
    pub fn number(&self, keyword: &str) -> Option<f64> {
        match self.value(keyword)? {
            CardValue::Real(number) => Some(number),
            CardValue::Integer(number) => Some(number as f64),
            CardValue::Text(text) => parse_real(&text),
            CardValue::Logical(_) | CardValue::Undefined => None,
        }
    }

    /// Returns the integer of a keyword. A decimal fraction of zero is accepted.
    pub fn integer(&self, keyword: &str) -> Option<i64> {
        match self.value(keyword)? {
            CardValue::Integer(number) => Some(number),
            CardValue::Real(number) if number.fract() == 0.0 && number.abs() < 9e15 => Some(number as i64),
            _ => None,
        }
    }

    /// Returns the logical value of a keyword.
    pub fn logical(&self, keyword: &str) -> Option<bool> {
        match self.value(keyword)? {
            CardValue::Logical(value) => Some(value),
            _ => None,
        }
    }

    /// Returns the comment of a keyword; empty if there is none.
    pub fn comment(&self, keyword: &str) -> String {
        // The comment of a long text is on its last card.
        self.span(keyword).and_then(|span| self.cards[span].last().map(Card::comment)).unwrap_or_default()
    }

    /// Sets a keyword: replaces its card, or appends a card if the keyword is missing. If the comment is empty, the old
    /// comment is kept.
    #[doc(hidden)]
    pub fn set(&mut self, keyword: &str, value: &CardValue, comment: &str) {
        let Some(span) = self.span(keyword) else {
            self.cards.extend(Card::with_value(keyword, value, comment));
            return;
        };
        let kept = self.comment(keyword);
        let comment = if comment.is_empty() { kept.as_str() } else { comment };
        self.cards.splice(span, Card::with_value(keyword, value, comment));
    }

    /// Removes a keyword with its CONTINUE cards.
    pub fn remove(&mut self, keyword: &str) {
        while let Some(span) = self.span(keyword) {
            self.cards.drain(span);
        }
    }

    /// Appends cards.
    #[doc(hidden)]
    pub fn extend(&mut self, cards: impl IntoIterator<Item = Card>) {
        self.cards.extend(cards);
    }

    /// Inserts a HISTORY or COMMENT text after the last card of this keyword, or after all cards if there is none.
    pub fn add_remark(&mut self, keyword: &str, text: &str) {
        let last = self.cards.iter().rposition(|card| card.keyword() == keyword);
        let index = last.map_or(self.cards.len(), |index| index + 1);
        self.cards.splice(index..index, Card::remark(keyword, text));
    }

    /// Returns the index range of the first card of a keyword and its CONTINUE cards.
    fn span(&self, keyword: &str) -> Option<Range<usize>> {
        let index = self.position(keyword)?;
        let continued = self.cards[index + 1..].iter().take_while(|card| card.keyword() == "CONTINUE").count();
        Some(index..index + 1 + continued)
    }

    /// Returns the joined text of numbered keywords (`WAT1_001`, `WAT1_002`, ...), including trailing blanks of each
    /// part.
    pub(super) fn numbered_text(&self, stem: &str) -> String {
        (1..).map_while(|number| self.card(&format!("{stem}{number:03}")).and_then(Card::padded_text)).collect()
    }
}

/// Returns true for the END card.
pub(super) fn is_end(card: &Card) -> bool {
    card.bytes().starts_with(b"END     ")
}

/// Returns true for a card of this keyword with a value.
fn has_keyword(card: &Card, keyword: &str) -> bool {
    let bytes = card.bytes();
    if keyword.len() <= 8 {
        let (name, rest) = bytes.split_at(8);
        let is_same = name[..keyword.len()].eq_ignore_ascii_case(keyword.as_bytes())
            && name[keyword.len()..].iter().all(|byte| *byte == b' ');
        if is_same {
            return rest[0] == b'=';
        }
    }
    // The first byte alone excludes most cards.
    bytes[0] == b'H' && bytes.starts_with(b"HIERARCH ") && card.keyword().eq_ignore_ascii_case(keyword)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_long_texts_continue_on_further_cards() {
        let mut header = Header::default();
        let long = "it's ".repeat(60);
        header.set("LONG", &CardValue::Text(long.clone()), "long");
        header.set("NEXT", &1_i64.into(), "");
        assert!(header.len() > 5);
        assert_eq!(header.text("LONG").as_deref(), Some(long.trim()));
        header.set("LONG", &"short".into(), "");
        assert_eq!(header.len(), 2);
        assert_eq!(
            header.card("LONG").map(Card::text).unwrap_or_default().trim_end(),
            "LONG    = 'short   '           / long"
        );
        header.remove("LONG");
        assert_eq!((header.len(), header.integer("NEXT")), (1, Some(1)));
    }

    #[test]
    fn verif_text_ends_at_end() {
        let header = Header::from_text("A       = '20.5'\nB       = 3.0\nEND\nC       = 1\n");
        assert_eq!(header.len(), 2);
        assert_eq!((header.number("A"), header.integer("B"), header.number("C")), (Some(20.5), Some(3), None));
        let block: String = header.cards().iter().map(Card::text).collect();
        assert_eq!(Header::from_text(&block), header);
    }

    #[test]
    fn verif_remarks_of_one_keyword_are_adjacent() {
        let mut header = Header::from_text("A       = 1\nHISTORY one\nB       = 2\n");
        header.add_remark("HISTORY", "two");
        header.add_remark("COMMENT", "three");
        let keywords: Vec<String> = header.cards().iter().map(Card::keyword).collect();
        assert_eq!(keywords, ["A", "HISTORY", "HISTORY", "B", "COMMENT"]);
    }
}

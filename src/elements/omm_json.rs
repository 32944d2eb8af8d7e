//! OMM as JSON: an array, an object, objects around arrays (`{"data": [...]}`), or one object per line.
//!
//! A JSON library is not used, for two reasons: numbers must be kept as text until they are rounded once (the fast path
//! of a library may be wrong in the last bit), and an invalid record must not invalidate the rest of the file. An
//! object is a record if it has a [`Keyword`] among its keys; nested objects and arrays are searched.

use std::borrow::Cow;

use super::omm::{Fields, Keyword};
use super::record::{Parsed, excerpt};
use super::tle::Checksums;
use crate::error::Error;
use crate::message::Quoted;

/// Reads every record, at any level of nesting.
pub(super) fn parse(text: &str, checksums: Checksums) -> Parsed {
    let mut scanner = Scanner { text, at: 0 };
    let (mut parsed, mut records) = (Parsed::default(), 0_usize);
    parsed.sets.reserve(text.len() / 500);
    // Open objects: offset in the text, and the values read so far.
    let mut open: Vec<(usize, Fields<'_>)> = Vec::new();
    while let Some(token) = scanner.next() {
        match token {
            Token::ObjectStart(offset) if open.len() < 64 => open.push((offset, Fields::default())),
            Token::ObjectStart(offset) => {
                parsed.rejected.push((offset, syntax("objects nested more than 64 deep")));
                return parsed;
            }
            Token::ObjectEnd => {
                if let Some((offset, fields)) = open.pop()
                    && fields.is_record()
                {
                    records += 1;
                    let rejected_before = parsed.rejected.len();
                    fields.finish(offset, checksums, &mut parsed);
                    // A line may have all records.
                    for (_, reason) in &mut parsed.rejected[rejected_before..] {
                        *reason = Error::format(format!("record {records}{}: {reason}", fields.object()));
                    }
                }
            }
            // The answer of a server that has no records to give.
            Token::Member(key, value)
                if key.eq_ignore_ascii_case("error")
                    && is_error_text(&value)
                    && !open.last().is_some_and(|(_, fields)| fields.is_record()) =>
            {
                let offset = open.last().map_or(0, |(start, _)| *start);
                let text = Quoted::new(excerpt(value.as_bytes()));
                parsed.rejected.push((offset, Error::format(format!("error message instead of a record: {text}"))));
            }
            Token::Member(key, value) => {
                if let (Some((_, fields)), Some(keyword)) = (open.last_mut(), Keyword::parse(&key)) {
                    fields.set(keyword, value);
                }
            }
            Token::Broken(offset, what) => {
                let offset = open.last().map_or(offset, |(start, _)| *start);
                parsed.rejected.push((offset, syntax(&what)));
                open.clear();
                scanner.skip_to_next_object();
            }
        }
    }
    if let Some((offset, _)) = open.iter().rev().find(|(_, fields)| fields.is_record()) {
        parsed.rejected.push((*offset, syntax("the file ends inside this object")));
    }
    parsed
}

/// Returns true for a text, not for the values of answers without an error: null, false, 0 and the empty text.
fn is_error_text(value: &str) -> bool {
    !["", "null", "false"].contains(&value.trim()) && value.trim().parse::<f64>().is_err()
}

fn syntax(what: &str) -> Error {
    Error::format(format!("invalid JSON: {what}"))
}

/// Tokens of the scanner: starts and ends of objects, and members with a plain value. The scanner skips the brackets of
/// arrays and commas.
enum Token<'a> {
    ObjectStart(usize),
    ObjectEnd,
    Member(Cow<'a, str>, Cow<'a, str>),
    Broken(usize, String),
}

struct Scanner<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Scanner<'a> {
    fn peek(&mut self) -> Option<u8> {
        let bytes = self.text.as_bytes();
        while bytes.get(self.at)?.is_ascii_whitespace() {
            self.at += 1;
        }
        bytes.get(self.at).copied()
    }

    fn next(&mut self) -> Option<Token<'a>> {
        loop {
            let offset = self.at;
            match self.peek()? {
                b'{' => {
                    self.at += 1;
                    return Some(Token::ObjectStart(self.at - 1));
                }
                b'}' => {
                    self.at += 1;
                    return Some(Token::ObjectEnd);
                }
                b'[' | b']' | b',' => self.at += 1,
                b'"' => {
                    let Some(key) = self.string() else {
                        return Some(self.broken(offset, "a string without a closing quotation mark"));
                    };
                    if self.peek() != Some(b':') {
                        // The string is an element of an array.
                        continue;
                    }
                    self.at += 1;
                    match self.peek() {
                        // A member whose value is an object or array is scanned next.
                        Some(b'{' | b'[') => {}
                        Some(b'"') => {
                            let Some(value) = self.string() else {
                                return Some(self.broken(offset, "a string without a closing quotation mark"));
                            };
                            return Some(Token::Member(key, value));
                        }
                        _ => {
                            let value = self.bare();
                            if value.is_empty() {
                                return Some(self.broken(offset, &format!("{key:?} has no value")));
                            }
                            return Some(Token::Member(key, Cow::Borrowed(value)));
                        }
                    }
                }
                _ => {
                    let bare = self.bare();
                    if bare.parse::<f64>().is_err() && !matches!(bare, "null" | "true" | "false") {
                        let what =
                            format!("unexpected {:?}, expected a key, a value or a bracket", excerpt(bare.as_bytes()));
                        return Some(Token::Broken(offset, what));
                    }
                }
            }
        }
    }

    fn broken(&self, offset: usize, what: &str) -> Token<'a> {
        Token::Broken(offset, what.into())
    }

    /// Returns a number, `true`, `false` or `null`: the text before the next delimiter. Advances by at least one
    /// character.
    fn bare(&mut self) -> &'a str {
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| ",]}{[\":".contains(c) || c.is_whitespace()).unwrap_or(rest.len());
        let end = if end == 0 && !rest.starts_with([',', ']', '}', '{', '[', '"']) {
            rest.chars().next().map_or(0, char::len_utf8)
        } else {
            end
        };
        self.at += end;
        &rest[..end]
    }

    /// Returns the text of a string. JSON strings contain no line breaks, so a string ends on the same line.
    fn string(&mut self) -> Option<Cow<'a, str>> {
        let start = self.at + 1;
        let bytes = self.text.as_bytes();
        let mut at = start;
        let mut escaped = false;
        loop {
            match bytes.get(at)? {
                b'"' => break,
                b'\\' => {
                    escaped = true;
                    at += 2;
                }
                b'\n' | b'\r' => return None,
                _ => at += 1,
            }
        }
        self.at = at + 1;
        let raw = self.text.get(start..at)?;
        if !escaped {
            return Some(Cow::Borrowed(raw));
        }
        // Strings with escapes are decoded by the JSON library; invalid escapes are kept unchanged.
        Some(serde_json::from_str(&self.text[start - 1..at + 1]).map_or(Cow::Borrowed(raw), Cow::Owned))
    }

    /// Continues after an error at the next opening brace.
    fn skip_to_next_object(&mut self) {
        let start = (self.at + 1..=self.text.len()).find(|&at| self.text.is_char_boundary(at));
        let rest = start.map_or("", |start| &self.text[start..]);
        self.at = self.text.len() - rest.len() + rest.find('{').unwrap_or(rest.len());
    }
}

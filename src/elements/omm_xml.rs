//! OMM as XML: one `<omm>`, or several in an `<ndm>`.
//!
//! The text is split at the `<omm>` elements, and each is parsed separately, so that an invalid one does not affect the
//! others.

use std::borrow::Cow;

use quick_xml::Reader;
use quick_xml::events::Event;

use super::omm::{Fields, Keyword};
use super::record::{Parsed, excerpt, parse_in_chunks};
use super::tle::Checksums;
use super::tle_file::reject_elements;
use crate::error::Error;

/// Returns true if the text contains an `<omm>` element, with or without a name-space prefix.
pub(super) fn looks_like(text: &str) -> bool {
    next_start(text, 0).is_some()
}

/// Reads every message.
pub(super) fn parse(text: &str, checksums: Checksums) -> Parsed {
    let cut = |text: &str, from| next_start(text, from).unwrap_or(text.len());
    parse_in_chunks(text, cut, |piece| parse_piece(piece, checksums))
}

fn parse_piece(text: &str, checksums: Checksums) -> Parsed {
    let mut parsed = Parsed::default();
    let mut start = next_start(text, 0);
    while let Some(offset) = start {
        let next = next_start(text, offset + 1);
        let message = &text[offset..next.unwrap_or(text.len())];
        match parse_message(message) {
            Ok((fields, end)) => {
                if fields.is_empty() {
                    parsed.rejected.push((offset, Error::format("this message contains no elements")));
                } else {
                    fields.finish(offset, checksums, &mut parsed);
                }
                reject_elements(&message[end..], offset + end, &mut parsed);
            }
            Err(what) => parsed.rejected.push((offset, Error::format(format!("invalid XML: {what}")))),
        }
        start = next;
    }
    parsed
}

/// Returns the offset of the next `<omm ...>`, with or without a name-space prefix, at or after `from`.
fn next_start(text: &str, from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        at += text.get(at..)?.find("omm")?;
        let (before, after) = (&text[..at], &text[at + 3..]);
        if after.starts_with(|c: char| c == '>' || c == '/' || c.is_whitespace()) {
            // The search goes back to the opening bracket of this element. An end tag does not match, because `/`
            // follows its bracket. Prefixes are short; the limit on the search keeps the running time linear for
            // malicious input.
            let window = &before.as_bytes()[before.len().saturating_sub(64)..];
            let start = window.iter().rposition(|&byte| byte == b'<').map(|back| at - window.len() + back);
            let start = start.filter(|start| *start >= from);
            if let Some(start) = start
                && (start + 1 == at || is_prefix(&before[start + 1..]))
            {
                return Some(start);
            }
        }
        at += 3;
    }
}

/// Returns true for a name-space prefix such as `ndm:`.
fn is_prefix(text: &str) -> bool {
    let name = text.strip_suffix(':').unwrap_or_default();
    !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c))
}

/// Returns the values of one `<omm>` element, and the offset after its end.
fn parse_message(text: &str) -> Result<(Fields<'_>, usize), String> {
    let mut reader = Reader::from_str(text);
    let mut fields = Fields::default();
    let mut keyword = None;
    let mut value = String::new();
    loop {
        let event = reader.read_event().map_err(|error| excerpt(error.to_string().as_bytes()))?;
        match event {
            Event::Start(element) => {
                keyword = match element.try_get_attribute("parameter") {
                    Ok(Some(parameter)) if element.local_name().as_ref() == "USER_DEFINED" => {
                        Keyword::of_user(&parameter.value)
                    }
                    _ => Keyword::parse(element.local_name().as_ref()),
                };
                value.clear();
                if let Some(keyword) = keyword
                    && let Ok(Some(unit)) = element.try_get_attribute("units")
                {
                    fields.check_unit(keyword, element.local_name().as_ref(), &unit.value);
                }
            }
            Event::Text(text) if keyword.is_some() => {
                value.push_str(&text);
            }
            Event::CData(text) if keyword.is_some() => {
                value.push_str(&text);
            }
            // The XML parser reports `&amp;` and similar entities as separate events.
            Event::GeneralRef(reference) if keyword.is_some() => match reference.resolve_char_ref() {
                Ok(Some(character)) => value.push(character),
                _ => value.push_str(quick_xml::escape::resolve_predefined_entity(&reference).unwrap_or("?")),
            },
            Event::End(element) => {
                if element.local_name().as_ref() == "omm" {
                    return Ok((fields, reader.buffer_position() as usize));
                }
                if let Some(keyword) = keyword.take() {
                    fields.set(keyword, Cow::Owned(std::mem::take(&mut value)));
                }
            }
            Event::Eof => return Err("the file ends inside this message".into()),
            _ => {}
        }
    }
}

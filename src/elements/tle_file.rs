//! A text of TLEs: finds the element sets among names, comments and rubble.

use super::chunks::{next_line, parse_in_chunks};
use super::record::{Parsed, RecordError, excerpt};
use super::tle::{Checksums, parse_lines};

/// A line with its place in the text, without blanks at its end.
type Placed<'a> = (usize, &'a [u8]);

/// From this length on a line that begins with "1 " or "2 " is data, not a name.
const DATA_LENGTH: usize = 60;

/// Reads two-line, three-line and "0 NAME" sets, mixed as they come.
///
/// Blank lines and lines that begin with `#` are skipped; blanks before a data line are overlooked. What cannot be paired
/// is rejected on its own, and reading goes on with the next line.
pub(super) fn parse(text: &str, checksums: Checksums) -> Parsed {
    parse_in_chunks(text, after_next_set, |piece| parse_piece(piece.as_bytes(), checksums))
}

/// Offset behind the next line 1 with its line 2, from where nothing before matters.
fn after_next_set(text: &str, from: usize) -> usize {
    let mut lines = Lines { text: text.as_bytes(), at: next_line(text, from) };
    let mut after_first = false;
    while let Some((_, line)) = lines.next() {
        if after_first && line.starts_with(b"2 ") {
            return lines.at.min(text.len());
        }
        after_first = line.starts_with(b"1 ");
    }
    text.len()
}

fn parse_piece(text: &[u8], checksums: Checksums) -> Parsed {
    let mut parsed = Parsed::default();
    parsed.sets.reserve(text.len() / 140);
    let mut lines = Lines { text, at: 0 }.peekable();
    let (mut name, mut first): (Option<Placed>, Option<Placed>) = (None, None);
    while let Some((offset, line)) = lines.next() {
        if let Some((first_offset, first_line)) = first.take() {
            if line.starts_with(b"2 ") {
                let name_line = name.take().map_or(&[][..], |name| name.1);
                match parse_lines(name_line, first_line, line, checksums) {
                    Ok((set, overlooked)) => {
                        parsed.take(offset, Ok(set));
                        parsed.bad_checksums_accepted += usize::from(overlooked);
                    }
                    Err((1, error)) => parsed.rejected.push((first_offset, error)),
                    Err((_, error)) => parsed.rejected.push((offset, error)),
                }
                continue;
            }
            parsed.rejected.push((first_offset, RecordError::LineOneAlone));
            name = None;
        }
        let is_first = line.starts_with(b"1 ")
            && (line.len() >= DATA_LENGTH || lines.peek().is_some_and(|(_, next)| next.starts_with(b"2 ")));
        if is_first {
            first = Some((offset, line));
        } else if line.starts_with(b"2 ") && line.len() >= DATA_LENGTH {
            parsed.rejected.push((offset, RecordError::LineTwoAlone));
            name = None;
        } else if let Some((stray_offset, stray)) = name.replace((offset, line)) {
            parsed.rejected.push((stray_offset, RecordError::Stray { text: excerpt(stray) }));
        }
    }
    if let Some((offset, _)) = first {
        parsed.rejected.push((offset, RecordError::LineOneAlone));
    } else if let Some((offset, stray)) = name {
        parsed.rejected.push((offset, RecordError::Stray { text: excerpt(stray) }));
    }
    parsed
}

/// Whether the text holds a line 1 and a line 2 one after the other, or at least one line that can only be data.
pub(super) fn looks_like(text: &str) -> bool {
    Lines { text: text.as_bytes(), at: 0 }.any(|(_, line)| {
        line.len() >= DATA_LENGTH
            && line.len() < 200
            && (line.starts_with(b"1 ") || line.starts_with(b"2 "))
            && line[2..7].iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b' ')
    })
}

/// The lines that say something: not blank, no comment.
struct Lines<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = Placed<'a>;

    fn next(&mut self) -> Option<Placed<'a>> {
        while self.at < self.text.len() {
            let offset = self.at;
            let rest = &self.text[offset..];
            let length = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').unwrap_or(rest.len());
            self.at = offset + length + 1;
            let line = rest[..length].trim_ascii_end();
            // NUL bytes are what is left of files cut off by a crash.
            if line.is_empty() || line[0] == b'#' || line.iter().all(|&byte| byte == 0) {
                continue;
            }
            let line = match line.trim_ascii_start() {
                indented if indented.starts_with(b"1 ") || indented.starts_with(b"2 ") => indented,
                _ => line,
            };
            if !line.trim_ascii().is_empty() {
                return Some((offset, line));
            }
        }
        None
    }
}

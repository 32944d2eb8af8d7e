//! OMM as CSV: a line of column titles, then one record per line; also tables with the two lines of a TLE in columns.
//!
//! The text is read line by line: element sets contain no line breaks, and an unclosed quotation mark must not affect
//! the rest of the file. Titles may be in upper or lower case and in any order, and unknown columns are ignored. `;`
//! and tabs are also accepted as separators.

use std::borrow::Cow;

use super::omm::{Fields, Keyword};
use super::record::Parsed;
use super::record::{next_line, parse_in_chunks};
use super::tle::Checksums;
use crate::error::Error;

/// Returns true if the first line that is not blank has the required column titles.
pub(super) fn looks_like(text: &str) -> bool {
    let line = text.split(['\n', '\r']).find(|line| is_content(line));
    let Some(line) = line.filter(|line| line.len() < 10_000) else { return false };
    let has = |keyword| split(line, separator_of(line)).iter().any(|title| Keyword::parse(title) == Some(keyword));
    has(Keyword::NoradCatId) && has(Keyword::MeanMotion) || has(Keyword::TleLine1) && has(Keyword::TleLine2)
}

/// Reads every record.
pub(super) fn parse(text: &str, checksums: Checksums) -> Parsed {
    let titles = text.split(['\n', '\r']).find(|line| is_content(line)).unwrap_or_default();
    let separator = separator_of(titles);
    let columns: Vec<_> = split(titles, separator).iter().map(|title| Keyword::parse(title)).collect();
    parse_in_chunks(text, next_line, |piece| parse_piece(piece, separator, &columns, checksums))
}

fn parse_piece(text: &str, separator: char, columns: &[Option<Keyword>], checksums: Checksums) -> Parsed {
    let mut parsed = Parsed::default();
    let mut fields = Fields::default();
    let mut at = 0;
    for line in text.split_inclusive(['\n', '\r']) {
        let offset = at;
        at += line.len();
        let line = line.trim_end_matches(['\n', '\r']);
        if !is_content(line) {
            continue;
        }
        let cells = split(line, separator);
        // This is a line of titles. Concatenated files contain several.
        if cells
            .iter()
            .zip(columns)
            .filter(|(_, column)| column.is_some())
            .all(|(cell, column)| Keyword::parse(cell) == *column)
        {
            continue;
        }
        if cells.len() < columns.len() {
            let what = format!("{} cells under {} titles", cells.len(), columns.len());
            parsed.rejected.push((offset, Error::format(format!("invalid CSV: {what}"))));
            continue;
        }
        fields.clear();
        for (cell, column) in cells.into_iter().zip(columns) {
            if let Some(keyword) = column {
                fields.set(*keyword, cell);
            }
        }
        fields.finish(offset, checksums, &mut parsed);
    }
    parsed
}

fn is_content(line: &str) -> bool {
    let line = line.trim();
    !line.is_empty() && !line.starts_with('#')
}

/// Returns the most frequent separator in the line of titles.
fn separator_of(titles: &str) -> char {
    let count = |separator: char| titles.matches(separator).count();
    [',', ';', '\t'].into_iter().max_by_key(|&separator| (count(separator), separator == ',')).unwrap_or(',')
}

/// Splits a line into cells, with quoting as in RFC 4180.
fn split(line: &str, separator: char) -> Vec<Cow<'_, str>> {
    if !line.contains('"') {
        return line.split(separator).map(Cow::Borrowed).collect();
    }
    let mut cells = Vec::new();
    let mut rest = line;
    loop {
        if let Some(quoted) = rest.trim_start().strip_prefix('"')
            && let Some((cell, behind)) = quoted_cell(quoted)
            && (behind.trim().is_empty() || behind.trim_start_matches(' ').starts_with(separator))
        {
            cells.push(cell);
            match behind.split_once(separator) {
                Some((_, next)) => rest = next,
                None => return cells,
            }
        } else if let Some((cell, next)) = rest.split_once(separator) {
            cells.push(Cow::Borrowed(cell));
            rest = next;
        } else {
            cells.push(Cow::Borrowed(rest));
            return cells;
        }
    }
}

/// Returns the text up to the closing quotation mark and the rest after it; doubled marks are unescaped.
fn quoted_cell(text: &str) -> Option<(Cow<'_, str>, &str)> {
    let bytes = text.as_bytes();
    let mut at = 0;
    loop {
        at += bytes.get(at..)?.iter().position(|&byte| byte == b'"')?;
        if bytes.get(at + 1) != Some(&b'"') {
            let cell = &text[..at];
            let cell = if cell.contains('"') { Cow::Owned(cell.replace("\"\"", "\"")) } else { Cow::Borrowed(cell) };
            return Some((cell, &text[at + 1..]));
        }
        at += 2;
    }
}

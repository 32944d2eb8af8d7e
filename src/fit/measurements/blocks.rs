//! Reader of files of any length, plain or gzipped, that returns the head and then blocks of whole rows.

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::super::error;
use crate::elements::NoradId;
use crate::error::Error;
use crate::input::{self, Ecsv, TimeColumn};

/// Number of bytes per block.
const BLOCK: usize = 1 << 20;
/// Longest accepted row, bytes. It makes the reader reject files without line ends.
const LONGEST_ROW: usize = 1 << 24;
/// Column by which raw text of MMT-9 is recognised. The header of such a file is its last comment.
const MMT_MARK: &str = "StdMag";

/// Separator of columns.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Delimiter {
    /// Any number of blanks.
    Blanks,
    /// Any number of blanks, as in ECSV; cells may be quoted.
    QuotedBlanks,
    /// A comma, semicolon or tabulator; cells may be quoted.
    Byte(u8),
}

/// Head of a table: the names of the columns and information from comments.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Head {
    pub header: Vec<String>,
    pub delimiter: Delimiter,
    /// Units and time scales by column, if the file is ECSV.
    pub units: BTreeMap<String, String>,
    pub time_scales: BTreeMap<String, String>,
    /// NORAD number in a comment such as `# satellite: 64559 NAME`, unless another comment names a different catalogue.
    pub norad_id: Option<NoradId>,
}

/// Reader of blocks of whole rows.
pub(super) struct Blocks {
    source: Box<dyn BufRead + Send>,
    /// Bytes that were read after the last whole row; they begin the next block.
    rest: Vec<u8>,
    is_at_end: bool,
}

impl Blocks {
    /// Opens a file and reads its head.
    pub(super) fn open(path: &Path, name: &str) -> Result<(Head, Self), Error> {
        let unreadable = |error: io::Error| Error::cannot("read", name, error);
        let file = input::open(path).map_err(unreadable)?;
        Self::from_source(Box::new(file), name)
    }

    /// Decompresses the source if needed and reads its head.
    pub(super) fn from_source(source: Box<dyn Read + Send>, name: &str) -> Result<(Head, Self), Error> {
        let unreadable = |error: io::Error| Error::cannot("read", name, error);
        let mut raw = BufReader::with_capacity(BLOCK, source);
        let is_gzipped = raw.fill_buf().map_err(unreadable)?.starts_with(&[0x1f, 0x8b]);
        let mut source: Box<dyn BufRead + Send> = if is_gzipped {
            Box::new(BufReader::with_capacity(BLOCK, MultiGzDecoder::new(raw)))
        } else {
            Box::new(raw)
        };
        let (mut comments, mut head) = (Vec::<String>::new(), String::new());
        let (line, rest) = loop {
            let mut line = Vec::new();
            let length = source.by_ref().take(LONGEST_ROW as u64).read_until(b'\n', &mut line).map_err(unreadable)?;
            if length == 0 {
                return Err(error::empty_file(name));
            }
            let text = String::from_utf8_lossy(&line);
            head.push_str(text.trim_start_matches('\u{feff}'));
            let text = text.trim_start_matches('\u{feff}').trim();
            if let Some(comment) = text.strip_prefix('#') {
                comments.push(comment.trim().to_owned());
            } else if !text.is_empty() {
                break (text.to_owned(), line);
            }
        };
        let norad_id = norad_of(&comments);
        if input::is_ecsv(&head) {
            let invalid = |problem: String| Error::format(problem).in_file("cannot read", name);
            let ecsv = Ecsv::parse(&head).map_err(|error| invalid(error.to_string()))?;
            ecsv.check_utc().map_err(invalid)?;
            let scale = |time: TimeColumn<'_>| Some((time.name.to_owned(), time.scale_name?.to_owned()));
            let time_scales = ecsv.time_columns().into_iter().filter_map(scale).collect();
            let delimiter =
                if ecsv.delimiter == b' ' { Delimiter::QuotedBlanks } else { Delimiter::Byte(ecsv.delimiter) };
            let units = ecsv.units();
            let head = Head { header: ecsv.names, delimiter, units, time_scales, norad_id };
            return Ok((head, Self { source, rest: Vec::new(), is_at_end: false }));
        }
        let (units, time_scales) = Default::default();
        let (head, rest) = match comments.last().filter(|comment| comment.contains(MMT_MARK)) {
            Some(header) => {
                let header = header.split_whitespace().map(str::to_owned).collect();
                (Head { header, delimiter: Delimiter::Blanks, units, time_scales, norad_id }, rest)
            }
            None => {
                let count = |byte: u8| line.bytes().filter(|other| *other == byte).count();
                let delimiter = [b',', b';', b'\t'].into_iter().rev().max_by_key(|byte| count(*byte)).unwrap_or(b',');
                let mut reader =
                    csv::ReaderBuilder::new().has_headers(false).delimiter(delimiter).from_reader(line.as_bytes());
                let header = reader.records().next().and_then(Result::ok).unwrap_or_default();
                let header = header.iter().map(|cell| cell.trim().to_owned()).collect();
                (Head { header, delimiter: Delimiter::Byte(delimiter), units, time_scales, norad_id }, Vec::new())
            }
        };
        Ok((head, Self { source, rest, is_at_end: false }))
    }

    /// Returns the next whole rows; `None` after the last row.
    pub(super) fn next(&mut self) -> io::Result<Option<Vec<u8>>> {
        if self.is_at_end && self.rest.is_empty() {
            return Ok(None);
        }
        let mut block = std::mem::take(&mut self.rest);
        block.reserve(BLOCK);
        loop {
            let length = BLOCK as u64;
            let read = self.source.by_ref().take(length).read_to_end(&mut block)?;
            if read == 0 {
                self.is_at_end = true;
                return Ok((!block.is_empty()).then_some(block));
            }
            if let Some(end) = last_row_end(&block) {
                self.rest = block.split_off(end);
                return Ok(Some(block));
            }
            if block.len() > LONGEST_ROW {
                return Err(io::Error::other(format!("a row is longer than {LONGEST_ROW} bytes")));
            }
        }
    }
}

/// Returns the position after the last line end that is not inside quotation marks.
fn last_row_end(block: &[u8]) -> Option<usize> {
    if !block.contains(&b'"') {
        return block.iter().rposition(|byte| *byte == b'\n').map(|at| at + 1);
    }
    let (mut quoted, mut end) = (false, None);
    for (at, byte) in block.iter().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b'\n' if !quoted => end = Some(at + 1),
            _ => {}
        }
    }
    end
}

/// Returns the NORAD number in a comment `satellite: 64559 PADRE`, unless a comment `catalogue: ...` names another
/// catalogue.
fn norad_of(comments: &[String]) -> Option<NoradId> {
    let value = |key: &str| comments.iter().find_map(|comment| comment.strip_prefix(key)?.strip_prefix(':'));
    if value("catalogue").is_some_and(|catalogue| !catalogue.contains("NORAD")) {
        return None;
    }
    let number = value("satellite")?.split_whitespace().next()?.parse().ok()?;
    (number != 0).then_some(NoradId(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(text: &[u8]) -> (Head, Vec<Vec<u8>>) {
        let (head, mut blocks) =
            Blocks::from_source(Box::new(io::Cursor::new(text.to_vec())), "a test").expect("a head");
        let mut all = Vec::new();
        while let Some(block) = blocks.next().expect("a block") {
            all.push(block);
        }
        (head, all)
    }

    #[test]
    fn verif_blocks_hold_whole_rows_and_lose_nothing() {
        let row = |i: usize| format!("{i},\"two\nlines, {}\",{}\n", i % 7, "x".repeat(i % 50));
        let body: String = (0..100_000).map(row).collect();
        let (head, blocks) = blocks(format!("\u{feff}# a comment\n\n a , b,c\n{body}").as_bytes());
        assert_eq!(head.header, ["a", "b", "c"]);
        assert!(blocks.len() > 2);
        for block in &blocks {
            let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&block[..]);
            assert!(reader.records().all(|row| row.is_ok_and(|row| row.len() == 3)));
        }
        assert_eq!(blocks.concat(), body.as_bytes());
    }

    #[test]
    fn verif_the_head_of_raw_text() {
        let text = "# satellite: 64559 PADRE\n# catalogue: 1 NORAD\n#\n# Date Time StdMag Mag\n2026-07-03 1 2 3";
        let (head, all) = blocks(text.as_bytes());
        assert_eq!(head.header, ["Date", "Time", "StdMag", "Mag"]);
        assert_eq!((head.delimiter, head.norad_id), (Delimiter::Blanks, Some(NoradId(64559))));
        assert_eq!(all.concat(), b"2026-07-03 1 2 3");
        assert_eq!(norad_of(&["satellite: 7 X".into(), "catalogue: 2 McCants".into()]), None);
    }
}

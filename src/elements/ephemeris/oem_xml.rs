//! Orbit ephemeris messages (CCSDS 505.0-B) as XML: one `<oem>`, or several in an `<ndm>`.

use std::collections::HashMap;

use hifitime::Epoch;
use quick_xml::Reader;
use quick_xml::events::Event;

use super::builder::{Builder, Problem, number};
use super::data::Ephemeris;
use super::metadata::Metadata;

const STATE: [&str; 6] = ["X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT"];

/// Returns true if there is an `<oem>`, in any name space.
pub(in super::super) fn looks_like(text: &str) -> bool {
    ["<oem", ":oem"].iter().any(|tag| text.contains(tag))
}

/// Reads every segment.
pub(in super::super) fn parse(text: &str) -> Result<Vec<Ephemeris>, Problem> {
    let mut reader = Reader::from_str(text);
    let mut lines = Lines { text, offset: 0, line: 1 };
    let mut ephemerides = Vec::new();
    let mut metadata = Metadata::default();
    let mut segment: Option<(Builder, Option<Epoch>)> = None;
    // Values of the current state or covariance, by keyword.
    let mut values: HashMap<String, String> = HashMap::new();
    let (mut value, mut depth, mut start) = (String::new(), 0_usize, 1);
    loop {
        let event = reader.read_event().map_err(|error| {
            Problem::new(lines.at(reader.error_position() as usize), "XML", error, "a well-formed document")
        })?;
        let line = lines.at(reader.buffer_position() as usize);
        match event {
            Event::Start(element) => {
                depth += 1;
                value.clear();
                match element.local_name().as_ref() {
                    "metadata" => metadata = Metadata::default(),
                    "stateVector" | "covarianceMatrix" => {
                        values.clear();
                        start = line;
                    }
                    _ => {}
                }
            }
            Event::Text(text) => value.push_str(&text),
            Event::CData(text) => value.push_str(&text),
            Event::End(element) => {
                depth = depth.saturating_sub(1);
                let name = element.local_name();
                match (name.as_ref(), &mut segment) {
                    ("metadata", open) => *open = Some(metadata.builder(line)?),
                    ("stateVector", Some((builder, _))) => {
                        let mut numbers = [0.0; 6];
                        for (value, keyword) in numbers.iter_mut().zip(STATE) {
                            *value = number(start, keyword, text_of(start, keyword, &values)?)?;
                        }
                        let epoch = metadata.epoch(start, "EPOCH", text_of(start, "EPOCH", &values)?.trim())?;
                        builder.state(start, epoch, numbers)?;
                    }
                    ("covarianceMatrix", Some((builder, _))) => {
                        let mut terms = [0.0; super::builder::TERMS];
                        let pairs = (0..6).flat_map(|row| (0..=row).map(move |column| (row, column)));
                        for (term, (row, column)) in terms.iter_mut().zip(pairs) {
                            let keyword = format!("C{}_{}", STATE[row], STATE[column]);
                            *term = number(start, &keyword, text_of(start, &keyword, &values)?)?;
                        }
                        let epoch = metadata.epoch(start, "EPOCH", text_of(start, "EPOCH", &values)?.trim())?;
                        let axes = metadata.axes(start, values.get("COV_REF_FRAME").map(|name| name.trim()))?;
                        builder.covariance(start, epoch, axes, terms)?;
                    }
                    ("segment", open) => {
                        let (builder, stop) = open.take().ok_or_else(|| {
                            Problem::new(line, "metadata of the segment", "missing", "a <metadata> in each <segment>")
                        })?;
                        ephemerides.push(builder.finish(line, stop)?);
                    }
                    (keyword, None) => metadata.set(line, keyword, &value)?,
                    (keyword, Some(_)) => {
                        values.insert(keyword.to_owned(), std::mem::take(&mut value));
                    }
                }
            }
            Event::Eof if depth > 0 => {
                let allowed = "the end of the document (the file may be truncated)";
                return Err(Problem::new(line, "end of the file", "inside an element", allowed));
            }
            Event::Eof if ephemerides.is_empty() => {
                return Err(Problem::new(line, "number of segments", 0, "1 or more"));
            }
            Event::Eof => return Ok(ephemerides),
            _ => {}
        }
    }
}

fn text_of<'a>(line: usize, keyword: &str, values: &'a HashMap<String, String>) -> Result<&'a str, Problem> {
    values.get(keyword).map(String::as_str).ok_or_else(|| Problem::new(line, keyword, "missing", "a value"))
}

/// Line numbers of increasing offsets.
struct Lines<'a> {
    text: &'a str,
    offset: usize,
    line: usize,
}

impl Lines<'_> {
    fn at(&mut self, offset: usize) -> usize {
        let offset = offset.clamp(self.offset, self.text.len());
        self.line += self.text.as_bytes()[self.offset..offset].iter().filter(|&&byte| byte == b'\n').count();
        self.offset = offset;
        self.line
    }
}

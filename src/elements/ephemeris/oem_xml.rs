//! Orbit ephemeris messages (CCSDS 505.0-B) as XML: one `<oem>`, or several in an `<ndm>`.

use std::collections::BTreeMap;

use hifitime::Epoch;
use quick_xml::Reader;
use quick_xml::events::Event;

use super::super::record::excerpt;
use super::builder::{Builder, Problem, number};
use super::data::Ephemeris;
use super::metadata::{Metadata, time};

const STATE: [&str; 6] = ["X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT"];

/// Returns true if the text contains an `<oem>` element, with or without a name-space prefix.
pub(in super::super) fn looks_like(text: &str) -> bool {
    ["<oem", ":oem"].iter().any(|tag| {
        text.match_indices(tag).any(|(at, _)| {
            text[at + tag.len()..].starts_with(|next: char| next == '>' || next == '/' || next.is_whitespace())
        })
    })
}

/// Reads every segment of every `<oem>` element. Other messages in an `<ndm>` are skipped. The order of elements within
/// metadata, states and covariances is arbitrary.
pub(in super::super) fn parse(text: &str) -> Result<Vec<Ephemeris>, Problem> {
    let mut reader = Reader::from_str(text);
    let mut lines = Lines { text, offset: 0, line: 1 };
    let mut ephemerides = Vec::new();
    let (mut created, mut metadata) = (None, Metadata::default());
    let mut segment: Option<Builder> = None;
    // Values of the current metadata, state or covariance by keyword, with line numbers.
    let mut values: Values = BTreeMap::new();
    let (mut value, mut start) = (String::new(), 1);
    let mut open: Vec<String> = Vec::new();
    loop {
        let event = reader.read_event().map_err(|error| {
            // The message of the parser quotes a tag up to the end of the tag, or of the file if the tag is not closed.
            let what = excerpt(error.to_string().as_bytes());
            Problem::new(lines.at(reader.error_position() as usize), "XML", what, "a well-formed document")
        })?;
        let line = lines.at(reader.buffer_position() as usize);
        match event {
            Event::Start(element) => {
                let name = element.local_name().as_ref().to_owned();
                value.clear();
                match name.as_str() {
                    "oem" => created = None,
                    "segment" => segment = None,
                    "metadata" | "stateVector" | "covarianceMatrix" => {
                        values.clear();
                        start = line;
                    }
                    _ => {}
                }
                open.push(name);
            }
            Event::Text(text) => value.push_str(&text),
            Event::CData(text) => value.push_str(&text),
            // The XML parser reports `&amp;` and similar entities as separate events.
            Event::GeneralRef(reference) => match reference.resolve_char_ref() {
                Ok(Some(character)) => value.push(character),
                _ => {
                    let known = quick_xml::escape::resolve_predefined_entity(&reference);
                    let unknown = || {
                        let given = format!("&{};", &*reference);
                        Problem::new(line, "entity", given, "&amp; &lt; &gt; &apos; &quot; and numbers such as &#38;")
                    };
                    value.push_str(known.ok_or_else(unknown)?);
                }
            },
            Event::End(_) => {
                let Some(name) = open.pop() else { continue };
                // Elements of other messages are skipped.
                if !open.iter().any(|element| element == "oem") {
                    continue;
                }
                match (name.as_str(), &mut segment) {
                    ("metadata", segment) => {
                        metadata = Metadata::default();
                        for (keyword, (line, value)) in &values {
                            metadata.set(*line, keyword, value)?;
                        }
                        *segment = Some(metadata.builder(line, created)?);
                    }
                    ("stateVector", Some(builder)) => {
                        let mut numbers = [0.0; 6];
                        for (value, keyword) in numbers.iter_mut().zip(STATE) {
                            *value = number(start, keyword, text_of(start, keyword, &values)?)?;
                        }
                        builder.state(start, epoch_of(start, &metadata, &values)?, numbers)?;
                    }
                    ("covarianceMatrix", Some(builder)) => {
                        let mut terms = [0.0; super::builder::TERMS];
                        let pairs = (0..6).flat_map(|row| (0..=row).map(move |column| (row, column)));
                        for (term, (row, column)) in terms.iter_mut().zip(pairs) {
                            let keyword = format!("C{}_{}", STATE[row], STATE[column]);
                            *term = number(start, &keyword, text_of(start, &keyword, &values)?)?;
                        }
                        let axes = metadata.axes(start, values.get("COV_REF_FRAME").map(|(_, name)| name.trim()))?;
                        builder.covariance(start, epoch_of(start, &metadata, &values)?, axes, terms)?;
                    }
                    ("stateVector" | "covarianceMatrix", None) => {
                        let allowed = "a state after the <metadata> of its <segment>";
                        return Err(Problem::new(start, "element", format!("<{name}> before the metadata"), allowed));
                    }
                    ("segment", segment) => {
                        let builder = segment.take().ok_or_else(|| {
                            Problem::new(line, "metadata of the segment", "missing", "a <metadata> in each <segment>")
                        })?;
                        ephemerides.push(builder.finish(line, false)?);
                    }
                    ("CREATION_DATE", _) => created = Some(time(line, "CREATION_DATE", &value)?),
                    _ => {
                        values.insert(name, (line, std::mem::take(&mut value)));
                    }
                }
            }
            Event::Eof if !open.is_empty() => {
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

/// Text values by keyword, with line numbers.
type Values = BTreeMap<String, (usize, String)>;

fn epoch_of(line: usize, metadata: &Metadata, values: &Values) -> Result<Epoch, Problem> {
    metadata.epoch(line, "EPOCH", text_of(line, "EPOCH", values)?.trim())
}

fn text_of<'a>(line: usize, keyword: &str, values: &'a Values) -> Result<&'a str, Problem> {
    values.get(keyword).map(|(_, text)| text.as_str()).ok_or_else(|| Problem::new(line, keyword, "missing", "a value"))
}

/// Converts increasing offsets to line numbers.
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

//! Orbit ephemeris messages (CCSDS 502.0-B) as lines of `KEYWORD = value`, with lines of numbers for states and
//! covariances.

use super::super::record::excerpt;
use super::builder::{Builder, Problem, TERMS, number};
use super::data::Ephemeris;
use super::metadata::{Metadata, time};
use hifitime::Epoch;

/// The keyword at the start of a message.
pub(in super::super) const OPENING: &str = "CCSDS_OEM_VERS";

/// Returns true if one of the first lines starts an OEM.
pub(in super::super) fn looks_like(text: &str) -> bool {
    text.lines().take(40).any(opens)
}

/// Returns true for the first line of a message.
pub(in super::super) fn opens(line: &str) -> bool {
    line.trim_start().strip_prefix(OPENING).is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// Returns true for the last line of a message: a state or the end of the covariances.
pub(in super::super) fn closes(line: &str) -> bool {
    line == "COVARIANCE_STOP"
        || line.starts_with(|first: char| first.is_ascii_digit()) && line.split_whitespace().count() >= 7
}

/// Segment whose data are being read.
struct Segment {
    metadata: Metadata,
    builder: Builder,
}

/// Part of a message that is being read.
enum Part {
    Header,
    /// Keywords after META_START.
    Metadata(Metadata),
    /// Lines of states.
    Data(Segment),
    /// Covariances after COVARIANCE_START.
    Covariances(Segment, Option<Terms>),
}

/// Covariance whose elements are being read.
struct Terms {
    line: usize,
    epoch: Epoch,
    /// Name of the axes; `None` for those of the states.
    axes: Option<String>,
    terms: Vec<f64>,
}

impl Segment {
    /// Adds a complete covariance to the ephemeris.
    fn add(&mut self, covariance: Option<Terms>) -> Result<(), Problem> {
        let Some(Terms { line, epoch, axes, terms }) = covariance else { return Ok(()) };
        let terms: [f64; TERMS] = terms.try_into().map_err(|terms: Vec<f64>| {
            Problem::new(line, "number of terms of the covariance", terms.len(), "21 (the file may be truncated)")
        })?;
        self.builder.covariance(line, epoch, self.metadata.axes(line, axes.as_deref())?, terms)
    }
}

/// Reads every segment.
pub(in super::super) fn parse(text: &str) -> Result<Vec<Ephemeris>, Problem> {
    let mut ephemerides = Vec::new();
    let (mut part, mut created, mut last) = (Part::Header, None, 1);
    for (line, text) in (1..).zip(text.lines()) {
        let text = text.trim();
        if text.is_empty() || text.starts_with("COMMENT") {
            continue;
        }
        last = line;
        let pair = text.split_once('=').map(|(keyword, value)| (keyword.trim(), value.trim()));
        part = match (part, text, pair) {
            (Part::Header, "META_START", _) => Part::Metadata(Metadata::default()),
            (Part::Data(segment), "META_START", _) => {
                ephemerides.push(segment.builder.finish(line, false)?);
                Part::Metadata(Metadata::default())
            }
            (Part::Metadata(metadata), "META_STOP", _) => {
                let builder = metadata.builder(line, created)?;
                Part::Data(Segment { metadata, builder })
            }
            (Part::Data(segment), "COVARIANCE_START", _) => Part::Covariances(segment, None),
            (Part::Covariances(mut segment, covariance), "COVARIANCE_STOP", _) => {
                segment.add(covariance)?;
                Part::Data(segment)
            }
            (part, "META_START" | "META_STOP" | "COVARIANCE_START" | "COVARIANCE_STOP", _) => {
                return Err(Problem::new(line, "line", format!("{text} {}", part.location()), part.allowed()));
            }
            (Part::Header, _, Some((keyword, value))) => {
                if keyword == "CREATION_DATE" {
                    created = Some(time(line, keyword, value)?);
                }
                Part::Header
            }
            (Part::Metadata(mut metadata), _, Some((keyword, value))) => {
                metadata.set(line, keyword, value)?;
                Part::Metadata(metadata)
            }
            (Part::Data(mut segment), _, None) => {
                state(line, text, &mut segment)?;
                Part::Data(segment)
            }
            (Part::Covariances(mut segment, covariance), _, Some(("EPOCH", value))) => {
                segment.add(covariance)?;
                let epoch = segment.metadata.epoch(line, "EPOCH", value)?;
                Part::Covariances(segment, Some(Terms { line, epoch, axes: None, terms: Vec::new() }))
            }
            // The axes are stated after the time and before the elements.
            (Part::Covariances(segment, Some(mut covariance)), _, Some(("COV_REF_FRAME", value)))
                if covariance.terms.is_empty() =>
            {
                covariance.axes = Some(value.to_owned());
                Part::Covariances(segment, Some(covariance))
            }
            (Part::Covariances(segment, Some(mut covariance)), _, None) => {
                for field in text.split_whitespace() {
                    covariance.terms.push(number(line, "term of the covariance", field)?);
                }
                Part::Covariances(segment, Some(covariance))
            }
            (part, ..) => {
                let given = format!("{:?} {}", excerpt(text.as_bytes()), part.location());
                return Err(Problem::new(line, "line", given, part.allowed()));
            }
        };
    }
    let segment = match part {
        Part::Header => return Err(Problem::new(last, "number of segments", 0, "1 or more, each after META_START")),
        Part::Data(segment) => segment,
        part => {
            let allowed = format!("{} (the file may be truncated)", part.allowed());
            return Err(Problem::new(last, "end of the file", part.location(), allowed));
        }
    };
    let is_line_cut = !text.ends_with(['\n', '\r']);
    ephemerides.push(segment.builder.finish(last, is_line_cut)?);
    Ok(ephemerides)
}

impl Part {
    /// Returns the name of this part of the message, for error messages.
    fn location(&self) -> &'static str {
        match self {
            Part::Header => "before the metadata",
            Part::Metadata(_) => "inside the metadata",
            Part::Data(_) => "among the states",
            Part::Covariances(..) => "inside the covariances",
        }
    }

    /// Returns the lines that are accepted in this part, for error messages.
    fn allowed(&self) -> &'static str {
        match self {
            Part::Header => "KEYWORD = value, or META_START",
            Part::Metadata(_) => "KEYWORD = value, or META_STOP",
            Part::Data(_) => "a state, COVARIANCE_START, or META_START",
            Part::Covariances(..) => {
                "EPOCH = time, then COV_REF_FRAME = axes if they are not those of the states, then 21 terms; or COVARIANCE_STOP"
            }
        }
    }
}

/// Reads a line with a state: time, position, velocity, and optionally an acceleration, which is not used.
fn state(line: usize, text: &str, segment: &mut Segment) -> Result<(), Problem> {
    let fields: Vec<&str> = text.split_whitespace().collect();
    if fields.len() != 7 && fields.len() != 10 {
        let allowed = "7 (time, position, velocity) or 10 (with acceleration)";
        return Err(Problem::new(line, "number of fields of a state", fields.len(), allowed));
    }
    let mut numbers = [0.0; 6];
    for (value, field) in numbers.iter_mut().zip(&fields[1..]) {
        *value = number(line, "field of the state", field)?;
    }
    let epoch = segment.metadata.epoch(line, "time of the state", fields[0])?;
    segment.builder.state(line, epoch, numbers)
}

//! Orbit ephemeris messages (CCSDS 502.0-B) as lines of `KEYWORD = value`, states and covariances as lines of numbers.

use super::super::record::excerpt;
use super::builder::{Builder, Problem, TERMS, number};
use super::data::Ephemeris;
use super::metadata::Metadata;
use hifitime::Epoch;

/// The keyword at the start of a message.
const OPENING: &str = "CCSDS_OEM_VERS";

/// Returns true if one of the first lines starts an OEM.
pub(in super::super) fn looks_like(text: &str) -> bool {
    let opens =
        |line: &str| line.trim_start().strip_prefix(OPENING).is_some_and(|rest| rest.trim_start().starts_with('='));
    text.lines().take(40).any(opens)
}

/// Part of a message.
#[derive(PartialEq)]
enum Part {
    Header,
    Metadata,
    Data,
    Covariance,
}

/// Covariance under construction.
#[derive(Default)]
struct Terms {
    line: usize,
    epoch: Option<Epoch>,
    axes: Option<String>,
    terms: Vec<f64>,
}

impl Terms {
    /// Adds the covariance to its ephemeris, if there is one.
    fn add(&mut self, metadata: &Metadata, builder: &mut Builder) -> Result<(), Problem> {
        let Terms { line, epoch, axes, terms } = std::mem::take(self);
        // The axes are those of the covariance before if they are omitted.
        self.axes = axes.clone();
        let Some(epoch) = epoch else { return Ok(()) };
        let terms: [f64; TERMS] = terms.try_into().map_err(|terms: Vec<f64>| {
            Problem::new(line, "number of terms of the covariance", terms.len(), "21 (the file may be truncated)")
        })?;
        builder.covariance(line, epoch, metadata.axes(line, axes.as_deref())?, terms)
    }
}

/// Reads every segment.
pub(in super::super) fn parse(text: &str) -> Result<Vec<Ephemeris>, Problem> {
    let mut ephemerides = Vec::new();
    let mut part = Part::Header;
    let mut metadata = Metadata::default();
    let mut segment: Option<(Builder, Option<Epoch>)> = None;
    let mut terms = Terms::default();
    let mut last = 1;
    for (line, text) in (1..).zip(text.lines()) {
        let text = text.trim();
        if text.is_empty() || text.starts_with("COMMENT") {
            continue;
        }
        last = line;
        match (text, &mut segment) {
            ("META_START", open) => {
                if let Some((builder, stop)) = open.take() {
                    ephemerides.push(builder.finish(line, stop)?);
                }
                (metadata, part) = (Metadata::default(), Part::Metadata);
            }
            ("META_STOP", open) => {
                *open = Some(metadata.builder(line)?);
                part = Part::Data;
            }
            ("COVARIANCE_START", Some(_)) => part = Part::Covariance,
            ("COVARIANCE_STOP", Some((builder, _))) => {
                terms.add(&metadata, builder)?;
                part = Part::Data;
            }
            (_, open) => match (&part, open, text.split_once('=')) {
                (Part::Header, _, Some(_)) => {}
                (Part::Metadata, _, Some((keyword, value))) => metadata.set(line, keyword.trim(), value)?,
                (Part::Covariance, Some((builder, _)), Some((keyword, value))) => match keyword.trim() {
                    "EPOCH" => {
                        terms.add(&metadata, builder)?;
                        (terms.line, terms.epoch) = (line, Some(metadata.epoch(line, "EPOCH", value.trim())?));
                    }
                    "COV_REF_FRAME" => terms.axes = Some(value.trim().to_owned()),
                    _ => return Err(unexpected(line, text)),
                },
                (Part::Covariance, Some(_), None) => {
                    for field in text.split_whitespace() {
                        terms.terms.push(number(line, "term of the covariance", field)?);
                    }
                }
                (Part::Data, Some((builder, _)), None) => state(line, text, &metadata, builder)?,
                _ => return Err(unexpected(line, text)),
            },
        }
    }
    let cut = |what: &str| {
        Err(Problem::new(last, "end of the file", what, "the end of a segment (the file may be truncated)"))
    };
    match part {
        Part::Metadata => return cut("inside the metadata"),
        Part::Covariance => return cut("inside the covariances"),
        Part::Header | Part::Data => {}
    }
    let (builder, stop) = segment.ok_or_else(|| Problem::new(last, "number of segments", 0, "1 or more"))?;
    ephemerides.push(builder.finish(last, stop)?);
    Ok(ephemerides)
}

/// Reads a line of a state: time, position, velocity, and an acceleration that is not used.
fn state(line: usize, text: &str, metadata: &Metadata, builder: &mut Builder) -> Result<(), Problem> {
    let fields: Vec<&str> = text.split_whitespace().collect();
    if fields.len() != 7 && fields.len() != 10 {
        let allowed = "7 (time, position, velocity) or 10 (with acceleration)";
        return Err(Problem::new(line, "number of fields of a state", fields.len(), allowed));
    }
    let mut numbers = [0.0; 6];
    for (value, field) in numbers.iter_mut().zip(&fields[1..]) {
        *value = number(line, "field of the state", field)?;
    }
    builder.state(line, metadata.epoch(line, "time of the state", fields[0])?, numbers)
}

fn unexpected(line: usize, text: &str) -> Problem {
    let allowed = "KEYWORD = value, META_START, META_STOP, COVARIANCE_START, COVARIANCE_STOP, a state or a covariance";
    Problem::new(line, "line", format!("{:?}", excerpt(text.as_bytes())), allowed)
}

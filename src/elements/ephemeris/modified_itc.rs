//! Modified ITC: the text format in which SpaceX publishes ephemerides of Starlink satellites.
//!
//! A file has a header of three lines, a line with the axes of the covariances, then four lines for each state: time
//! (year, day of the year, hour, minute, second; UTC), position in km and velocity in km/s in the mean equator and
//! equinox of J2000, and the 21 elements of the covariance in three lines. The satellite is identified only by the file
//! name.

use hifitime::Epoch;

use super::super::element_set::NoradId;
use super::super::epoch::{digits, parse_iso};
use super::super::record::excerpt;
use super::builder::{Builder, Problem, TERMS, number};
use super::data::{CovarianceAxes, Ephemeris, EphemerisFrame, EphemerisObject};

/// Number of lines of one state with its covariance.
const RECORD_LINES: usize = 4;
/// Keywords of the header.
const CREATED: &str = "created:";
const START: &str = "ephemeris_start:";
const STOP: &str = "ephemeris_stop:";

/// Returns true if one of the first lines is a header line.
pub(in super::super) fn looks_like(text: &str) -> bool {
    text.lines().take(RECORD_LINES).any(|line| line.trim_start().starts_with(START))
}

/// Reads the ephemeris; `file` is the name of the file.
pub(in super::super) fn parse(file: &str, text: &str) -> Result<Vec<Ephemeris>, Problem> {
    let (object, name) = satellite(file)?;
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()).peekable();
    let (mut created, mut stated, mut axes) = (None, [None; 2], None);
    // The header ends before the first line that starts with a time.
    while let Some((line, header)) =
        lines.next_if(|(_, line)| !line.starts_with(|c: char| c.is_ascii_digit() && axes.is_some()))
    {
        created = header_time(line, header, CREATED)?.or(created);
        for (epoch, name) in stated.iter_mut().zip([START, STOP]) {
            *epoch = header_time(line, header, name)?.or(*epoch);
        }
        if !header.contains(':') {
            if header.trim() != "UVW" {
                return Err(Problem::new(
                    line,
                    "frame of the covariance",
                    format!("{:?}", excerpt(header.as_bytes())),
                    "UVW",
                ));
            }
            axes = Some(CovarianceAxes::Radial);
        }
    }
    let axes =
        axes.ok_or_else(|| Problem::new(1, "frame of the covariance", "missing", "a line UVW after the header"))?;
    let mut builder = Builder::new(object, name, EphemerisFrame::Eme2000, created).stated(stated);
    let mut last = 1;
    while let Some((line, state)) = lines.next() {
        let fields: Vec<&str> = state.split_whitespace().collect();
        let &[time, x, y, z, u, v, w] = fields.as_slice() else {
            return Err(Problem::new(line, "number of fields of a state", fields.len(), "7: time, position, velocity"));
        };
        let epoch = time_of(time).ok_or_else(|| {
            Problem::new(line, "time of the state", format!("{time:?}"), "YYYYDDDHHMMSS.SSS, year and day of the year")
        })?;
        let mut numbers = [0.0; 6];
        for (number_km, text) in numbers.iter_mut().zip([x, y, z, u, v, w]) {
            *number_km = number(line, "field of the state", text)?;
        }
        builder.state(line, epoch, numbers)?;
        let mut terms = Vec::with_capacity(TERMS);
        for _ in 1..RECORD_LINES {
            let Some((line, row)) = lines.next() else { break };
            last = line;
            for text in row.split_whitespace() {
                terms.push(number(line, "term of the covariance", text)?);
            }
        }
        let terms: [f64; TERMS] = terms.try_into().map_err(|terms: Vec<f64>| {
            let allowed = "21 on the three lines after the state (the file may be truncated)";
            Problem::new(line, "number of terms of the covariance", terms.len(), allowed)
        })?;
        builder.covariance(line, epoch, axes, terms)?;
    }
    Ok(vec![builder.finish(last, !text.ends_with(['\n', '\r']))?])
}

/// Returns the time after a keyword in a header line; `None` if the line lacks the keyword.
fn header_time(line: usize, header: &str, keyword: &str) -> Result<Option<Epoch>, Problem> {
    let Some((_, rest)) = header.split_once(keyword) else { return Ok(None) };
    let given: String = rest.split_whitespace().take(2).collect::<Vec<_>>().join(" ");
    let allowed = "a date and time such as 2023-02-01 11:24:42 UTC";
    let problem = || Problem::new(line, keyword.trim_end_matches(':'), format!("{given:?}"), allowed);
    parse_iso(&given).map(Some).ok_or_else(problem)
}

/// Returns catalogue number and name of the satellite from a file name,
/// `MEME_48430_STARLINK-2729_..._UNCLASSIFIED.txt`.
fn satellite(file: &str) -> Result<(EphemerisObject, &str), Problem> {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    let mut parts = name.split('_');
    let (first, number, satellite) = (parts.next(), parts.next(), parts.next());
    match (first, number.and_then(|number| digits(number.as_bytes())), satellite) {
        (Some("MEME"), Some(norad_id), Some(satellite)) if norad_id > 0 => {
            Ok((EphemerisObject::Norad(NoradId(norad_id)), satellite))
        }
        _ => {
            let allowed = "MEME_NUMBER_NAME_....txt as published, with the NORAD catalogue number";
            Err(Problem::new(1, "name of the file", format!("{name:?}"), allowed))
        }
    }
}

/// Parses `2023029112442.000`: year, day of the year, hour, minute, second.
fn time_of(text: &str) -> Option<Epoch> {
    if text.len() < 13 || !text.is_ascii() {
        return None;
    }
    let (year, day, hour, minute, second) = (&text[..4], &text[4..7], &text[7..9], &text[9..11], &text[11..]);
    parse_iso(&format!("{year}-{day}T{hour}:{minute}:{second}"))
}

//! Start and duration of an exposure, from the keywords of many observatories.

use hifitime::{Epoch, TimeUnits};

use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::seconds_between;

use super::super::header::Header;
use super::clocks::{
    LOOSE_START_S, READOUT_S, UNSTATED_START_S, has_second_clock, is_end_of_other, is_named, is_of_telescope,
    is_outvoted, is_shutter, use_finer, use_stated, use_stated_middles,
};
use super::comment::{AGREED_S, Comment, Role};
use super::instant::Instant;
use super::instants::Instants;
use super::length::{Length, length, stated_s};
use super::moment::{Keywords, unreadable};
use super::scale::{APPROXIMATE, scale, scale_name, timesys};
use super::start_doubts::{
    SHIFT_SLACK, START_SLACK_S, Start, about_times, comments_of, of_day_number, of_other_date, other_parts,
    same_as_local, sidereal, start_of, states_start, written_early, zone,
};

/// Error of the difference of two times with the same digits, seconds. One by a whole last digit is no rounding.
const EXACT_S: f64 = 0.01;

/// Part of the exposure time up to which a readout may be included in the end, if only one clock gives the start.
const READOUT_SHARE: f64 = 0.25;
/// Largest rounding error of an instant that is used, seconds: half of the last digit of days with four decimals is
/// 4.3 s, and times without seconds have 60 s.
const COARSE_S: f64 = 10.0;

/// Keyword of the time scale.
const TIMESYS: &str = "TIMESYS";

/// Source of a start or a duration that the caller gives.
const GIVEN: &str = "given";

/// Start and duration of an exposure.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureTime {
    /// Time at which the shutter opened.
    pub start: Epoch,
    /// Error (one sigma) of the start by its digits or by its comment, seconds: 0.29 s for whole seconds.
    pub start_sigma_s: f64,
    /// Time for which the shutter was open, seconds.
    pub duration_s: f64,
    /// Keywords that gave the start (`DATE-OBS`, `DATE-OBS + TIME-OBS`, ...).
    pub start_from: String,
    /// Keyword that gave the duration.
    pub duration_from: String,
    /// Sentences about keywords that differ from the start or the duration by seconds or minutes, and about values that
    /// can be read in two ways.
    pub remarks: Vec<String>,
}

/// Keywords that can give the start, for errors.
const START_KEYWORDS: &str =
    "DATE-BEG, DATE-OBS with a time in it or in TIME-OBS, UTC-OBS, UTSTART, ..., MJD-OBS, JD, ..., or --start";

impl ExposureTime {
    /// Reads the exposure from the headers of a frame, given in the order of precedence: first the header of the image,
    /// then the primary header.
    ///
    /// Dates are in the scale of TIMESYS (by default UTC). The first of several keywords is used, and dates with times
    /// take precedence over Julian dates. A comment can state that an instant is the middle or the end of the exposure.
    /// All keywords of the start must agree within a second plus their rounding, those of the middle and the end also
    /// within a tenth of the exposure time; differences of more than 5 s are stated in the remarks.
    ///
    /// # Errors
    /// Keywords are missing, invalid or contradictory; a comment states a local time or the time of an event after the
    /// exposure; a date is ambiguous; the only time is a day number with less than four decimals, or has no seconds;
    /// the exposure time is 0 or less, or that of one of several co-added exposures.
    pub fn from_headers(headers: &[&Header]) -> Result<Self, Error> {
        Self::with_given(headers, None, None)
    }

    /// Returns an exposure of which the caller gives the start and the duration (seconds).
    pub fn given(start: Epoch, duration_s: f64) -> Self {
        let [start_from, duration_from] = [GIVEN, GIVEN].map(str::to_owned);
        Self { start, start_sigma_s: 0.0, duration_s, start_from, duration_from, remarks: Vec::new() }
    }

    /// Reads the exposure as [`from_headers`](Self::from_headers), but a start or a duration (seconds) that is given
    /// replaces that of the headers.
    ///
    /// # Errors
    /// The errors of [`from_headers`](Self::from_headers) that concern what is not given.
    pub fn with_given(headers: &[&Header], start: Option<Epoch>, duration_s: Option<f64>) -> Result<Self, Error> {
        let keywords = Keywords(headers);
        let mut remarks = Vec::new();
        let (duration_s, duration_from) = match duration_s {
            Some(duration_s) => (duration_s, GIVEN.to_owned()),
            None => duration(keywords, &mut remarks)?,
        };
        let (start, start_sigma_s, start_from) = match start {
            Some(start) => (start, 0.0, GIVEN.to_owned()),
            None => {
                let start = self::start(keywords, duration_s, &mut remarks)?;
                (start.epoch, start.sigma_s(), start.from)
            }
        };
        let names = [&start_from, &duration_from].into_iter().flat_map(|from| from.split(" + "));
        let names =
            names.map(|name| name.split(" - ").next().unwrap_or(name)).chain((start_from != GIVEN).then_some(TIMESYS));
        remarks.extend(
            names
                .filter_map(|name| keywords.difference(name))
                .map(|sentence| format!("{sentence}; for another one specify --start and --exposure")),
        );
        Ok(Self { start, start_sigma_s, duration_s, start_from, duration_from, remarks })
    }
}

/// Returns the exposure time, seconds, and its keyword, after comparing it with the keywords of the end.
fn duration(keywords: Keywords<'_>, remarks: &mut Vec<String>) -> Result<(f64, String), Error> {
    let mut length = length(keywords)?;
    remarks.append(&mut length.remarks);
    let is_confirmed = span_is_confirmed(keywords, &length, remarks)?;
    match length.of_parts {
        Some(error) if !is_confirmed => Err(error),
        _ => Ok((length.seconds, length.keyword)),
    }
}

/// Compares the exposure time with the keywords of the end. Returns true if one of them confirms it.
fn span_is_confirmed(keywords: Keywords<'_>, length: &Length, remarks: &mut Vec<String>) -> Result<bool, Error> {
    // An invalid start is reported when the start is read.
    let Ok((instants, start)) = instants(keywords).and_then(|mut instants| {
        let start = chosen(keywords, &mut instants, length.seconds)?;
        Ok((instants, start))
    }) else {
        return Ok(false);
    };
    let ends = || instants.found.iter().filter(|instant| instant.role == Role::End);
    let is_of_one = length.coadds.is_none() && length.of_parts.is_none();
    let mut is_confirmed = false;
    for end in ends().filter(|end| !start.from.starts_with(&end.from)) {
        let span_s = seconds_between(start.epoch, end.epoch);
        let loose_s = if end.is_loose { READOUT_S + length.seconds } else { 0.0 };
        let digits_s = start.slack_s + end.slack_s;
        let slack_s = START_SLACK_S + digits_s + SHIFT_SLACK * length.seconds;
        let is_same = |other: &&Instant| seconds_between(end.epoch, other.epoch).abs() <= START_SLACK_S;
        let readout_s = digits_s
            + if is_of_one && has_second_clock(&instants, &start) {
                READOUT_S
            } else if ends().filter(is_same).any(|same| same.is_of_observation) {
                READOUT_S.min(length.seconds)
            } else {
                READOUT_S.min(READOUT_SHARE * length.seconds)
            };
        let late_s = span_s - length.seconds;
        // Not "-0.0".
        let shown_s = (10.0 * span_s).round() / 10.0 + 0.0;
        let given = format!("{} s, but it is {shown_s:.1} s from {} to {}", length.seconds, start.from, end.from);
        if is_end_of_other(&instants, &start, end, length.seconds) {
            remarks.push(format!(
                "{} is {:.1} s before the start of {}, perhaps the end of the exposure before: it is not used",
                end.from, -span_s, start.from
            ));
            continue;
        }
        if !(-slack_s..=readout_s.max(slack_s + loose_s)).contains(&late_s) {
            let allowed = if span_s > 0.0 {
                format!(
                    "an exposure without gaps; specify --exposure {span_s:.0}s for the whole span, or --start and \
                     --exposure for another part of it"
                )
            } else {
                "an end after the start; specify --start and --exposure".to_owned()
            };
            return Err(Error::invalid(length.keyword.clone(), given, allowed));
        }
        let stated_s = stated_s(length.seconds).max(start.step_s.max(end.step_s()) - EXACT_S);
        if late_s.abs() > stated_s + digits_s {
            let use_of = &length.keyword;
            let before = format!("{use_of} is {} s, but it is {shown_s:.1} s from {} to ", length.seconds, start.from);
            let after = format!(": {use_of} is used; for another span specify --exposure");
            state(remarks, &before, &end.from, [&after, &after]);
        }
        let is_equal = late_s <= slack_s.min(stated_s + digits_s + SHIFT_SLACK * length.seconds);
        // Ten times 1 s do not fit into 1.9 s.
        let is_of_all = length.coadds.is_some_and(|count| span_s + slack_s < count * length.seconds);
        is_confirmed |= !end.is_loose && (is_equal || is_of_all) && end.slack_s <= COARSE_S;
    }
    Ok(is_confirmed)
}

/// Adds a sentence about a keyword, or the keyword to the same sentence about others. The texts after one keyword and
/// after several are given.
fn state(remarks: &mut Vec<String>, before: &str, name: &str, [after_one, after_several]: [&str; 2]) {
    let end_of = |remark: &String| {
        let names = remark.strip_prefix(before)?;
        let names = names.strip_suffix(after_one).or_else(|| names.strip_suffix(after_several))?;
        Some(before.len() + names.len())
    };
    match remarks.iter_mut().find_map(|remark| Some((end_of(remark)?, remark))) {
        Some((end, remark)) => {
            remark.truncate(end);
            remark.push_str(&format!(", {name}{after_several}"));
        }
        None => remarks.push(format!("{before}{name}{after_one}")),
    }
}

/// Reads all instants in the scale of TIMESYS.
fn instants(keywords: Keywords<'_>) -> Result<Instants, Error> {
    // Times at the Sun or the barycentre differ by up to 500 s (FITS standard 4.0, section 9.2.3).
    let begins_with = |place: &str, words: &[&str]| {
        let place = place.to_ascii_uppercase();
        words.iter().any(|word| place.starts_with(word))
    };
    let position = keywords.text(&["TREFPOS"]).filter(|(_, place)| !begins_with(place, &["TOPO", "GEO", "LOCAL"]));
    // TIMEREF may also name a clock.
    let reference =
        || keywords.text(&["TIMEREF"]).filter(|(_, place)| begins_with(place, &["BARY", "HELIO", "SOLAR", "SSB"]));
    if let Some((keyword, place)) = position.or_else(reference) {
        let allowed = "TOPOCENTER or GEOCENTER (TIMEREF: LOCAL or GEOCENTRIC), or --start in UTC at the telescope";
        return Err(unreadable(keyword, &place, allowed));
    }
    Instants::read(keywords, scale(keywords)?)
}

/// Returns the start with the highest precedence, after checking that all instants in the header agree.
fn start(keywords: Keywords<'_>, duration_s: f64, remarks: &mut Vec<String>) -> Result<Start, Error> {
    let mut instants = instants(keywords)?;
    let first = chosen(keywords, &mut instants, duration_s)?;
    if let Some(error) = same_as_local(keywords, &instants, &first) {
        return Err(error);
    }
    let approximate = timesys(keywords).filter(|(_, name)| name.to_ascii_uppercase().contains(APPROXIMATE));
    for other in instants.found.iter().filter(|other| other.role != Role::End) {
        // A clock of the telescope is read some seconds before the shutter opens (ESO), that of the camera perhaps
        // after the exposure. Days may be cut off to the digit before.
        let is_time_of_day = other.value.find(':').is_some_and(|at| at < 3);
        let clock_s = if is_named(&first.from) && ((is_time_of_day && !other.is_role_stated) || is_of_telescope(other))
        {
            UNSTATED_START_S
        } else if is_shutter(&first.from) || other.from.starts_with("UT") {
            LOOSE_START_S
        } else {
            0.0
        };
        let early_s = clock_s + if other.is_loose { other.slack_s } else { 0.0 };
        // UT of Subaru is that of the start, with the comment "typical UTC at the exposure (middle".
        let is_read_early = other.is_loose && other.role == Role::Middle && states_start(keywords, &first);
        let early_s = early_s + if is_read_early { duration_s / 2.0 } else { 0.0 };
        let late_s = if other.is_loose || other.is_loose_clock { READOUT_S + duration_s } else { 0.0 };
        let other_start = start_of(other, duration_s);
        let shift_s = if first.from == other_start.from || (other.role == Role::Start && !first.from.contains(" - ")) {
            0.0
        } else {
            SHIFT_SLACK * duration_s
        };
        let difference_s = seconds_between(first.epoch, other_start.epoch);
        let side = if difference_s > 0.0 { "later" } else { "earlier" };
        let shown = format!("one {:.1} s {side}", difference_s.abs());
        let digits_s = first.slack_s + other.slack_s;
        let clock_s = if approximate.is_some() { LOOSE_START_S } else { 0.0 };
        let slack_s = START_SLACK_S + digits_s + shift_s + clock_s;
        if !(-slack_s - early_s..=slack_s + late_s).contains(&difference_s) {
            if is_outvoted(keywords, &instants, &first, other, duration_s) {
                let before = format!("the start is that of {}, with which the other clocks agree; ", first.from);
                let after = format!("{shown}, not used; for another one specify --start");
                let after = [format!(" gives {after}"), format!(" give {after}")];
                state(remarks, &before, &other_start.from, [&after[0], &after[1]]);
                continue;
            }
            let scale = scale(keywords)?.scale;
            let [first_start, second_start] =
                [first.epoch, other_start.epoch].map(|start| start.round(1.milliseconds()));
            return Err(Error::invalid(
                format!("start of {} ({scale})", first.from),
                format!(
                    "{first_start}, and {} ({scale}) gives {second_start}: {difference_s:.1} s apart",
                    other_start.from
                ),
                "one start; specify --start",
            ));
        }
        let step_s = first.step_s.max(other.step_s()) - EXACT_S;
        let is_loose = other.is_loose || other.is_loose_clock;
        let least_s = match other.role {
            Role::Start if approximate.is_none() && !is_loose => AGREED_S.max(step_s),
            Role::Start => START_SLACK_S,
            _ => stated_s(duration_s).min(START_SLACK_S).max(step_s),
        };
        if difference_s.abs() > least_s + digits_s + if other.is_loose { other.slack_s } else { 0.0 } {
            let before = format!("the start is that of {}; ", first.from);
            let after = format!("{shown}; for another one specify --start");
            let after = [format!(" gives {after}"), format!(" give {after}")];
            state(remarks, &before, &other_start.from, [&after[0], &after[1]]);
        }
    }
    if first.slack_s > AGREED_S {
        let from = &first.from;
        remarks.push(format!("the start of {from} is uncertain by {:.1} s, by its digits or comment", first.slack_s));
    }
    let readings = instants.readings.iter().filter(|(from, _)| first.from.split(" - ").next() == Some(from));
    let readings = readings.map(|(_, sentence)| format!("{sentence}; for another start specify --start"));
    let readings: Vec<String> = readings.collect();
    if approximate.is_none()
        && readings.is_empty()
        && let Some(comment) = comments_of(keywords, &first).into_iter().find(Comment::is_doubtful)
    {
        remarks.push(format!(
            "the start is that of {}, by its comment {:?} perhaps another instant; for another one specify --start",
            first.from,
            comment.text()
        ));
    }
    remarks.extend(readings);
    if instants.others.iter().any(|other| other.from == first.from) {
        let from = &first.from;
        remarks.push(format!("the start is that of {from}, by its name or comment; for another one specify --start"));
    }
    // A date that agrees shows that a number of days is that of the same part.
    let is_date = |instant: &Instant| !instant.is_loose && instant.role == Role::Start && instant.slack_s <= COARSE_S;
    let is_alone = !instants.found.iter().any(is_date);
    remarks.extend(of_day_number(keywords, &first).filter(|_| is_alone));
    remarks.extend(sidereal(keywords, &first, duration_s));
    remarks.extend(of_other_date(keywords, &first));
    remarks.extend(written_early(keywords, &first, duration_s));
    remarks.extend(about_times(keywords, &first));
    remarks.extend(other_parts(&instants, &first, duration_s));
    remarks.extend(zone(keywords, &instants, &first));
    remarks.extend(
        approximate.map(|(keyword, name)| format!("{keyword} is {name:?}: times are read as {}", scale_name(&name))),
    );
    Ok(first)
}

/// Returns the start with the highest precedence: a keyword of the start, then of the middle, then of the end.
fn chosen(keywords: Keywords<'_>, instants: &mut Instants, duration_s: f64) -> Result<Start, Error> {
    let order = [
        (Role::Start, false),
        (Role::Middle, false),
        (Role::Start, true),
        (Role::Middle, true),
        (Role::End, false),
        (Role::End, true),
    ];
    let find = |instants: &Instants, (role, is_loose): (Role, bool)| {
        let matches =
            |instant: &&Instant| instant.role == role && instant.is_loose == is_loose && instant.slack_s <= COARSE_S;
        instants.found.iter().find(matches).map(|instant| start_of(instant, duration_s))
    };
    if let Some(error) = instants.found.iter().find_map(|instant| day_problem(instant, duration_s)) {
        return Err(error);
    }
    use_stated_middles(instants, duration_s);
    let mut first = find(&*instants, order[0]);
    if first.is_none() {
        if let Some(error) = instants.unclear.take() {
            return Err(error);
        }
        let known = &*instants;
        let other = || known.others.iter().find(|other| other.is_loose && other.slack_s <= COARSE_S);
        first = order[1..].iter().find_map(|choice| find(known, *choice));
        first = first.or_else(|| other().map(|other| start_of(other, duration_s)));
    }
    if let Some(start) = &mut first {
        use_stated(keywords, instants, start);
        use_finer(instants, start);
    }
    if let Some(error) = instants.unusable(first.as_ref().map(|start| start.epoch)) {
        return Err(error);
    }
    // All instants are coarse if there are any.
    let coarse = || {
        let instant = instants.found.first()?;
        let given = format!("{:?}, uncertain by {:.0} s", instant.value, instant.slack_s);
        let allowed =
            "a time to 10 s (with seconds, or days with four decimals), in this or another keyword, or --start";
        Some(Error::invalid(instant.from.clone(), given, allowed))
    };
    let missing = || Error::invalid("start of the exposure", "missing", START_KEYWORDS);
    first.ok_or_else(|| coarse().or(instants.day_alone.take()).unwrap_or_else(missing))
}

/// Returns the error of a date and a time of day of different parts of the exposure that are perhaps on different days:
/// the start is on the day before, and nothing states that the date is that of the start; or the date is that of the
/// middle or the end, which is on the day after.
fn day_problem(instant: &Instant, duration_s: f64) -> Option<Error> {
    let (midnight, part) = instant.day?;
    let start = start_of(instant, duration_s);
    let is_before = start.epoch < midnight && part != Some(Role::Start) && part != Some(instant.role);
    let late_s = match part {
        Some(Role::Middle) => duration_s / 2.0,
        Some(Role::End) => duration_s,
        _ => 0.0,
    };
    let is_after = seconds_between(midnight, start.epoch) + late_s >= DAY_S;
    let given = match (is_before, is_after) {
        (true, _) => "on the day before the date, by the exposure time",
        (_, true) => "on the day before the date, which is that of the middle or the end",
        _ => return None,
    };
    let given = format!("{} {given}", start.epoch.round(1.milliseconds()));
    let allowed = "a date that its comment states to be that of the start, or --start";
    Some(Error::invalid(format!("start of {}", start.from), given, allowed))
}

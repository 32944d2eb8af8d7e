//! Choice between the clocks of a header that differ by seconds or minutes: numbers of days, times of day, and ends.

use crate::constants::DAY_S;
use crate::frames::seconds_between;

use super::comment::{AGREED_S, Comment, Role};
use super::instant::Instant;
use super::instant_keywords::{LOOSE_TIMES, names_start};
use super::instants::Instants;
use super::moment::{Keywords, is_spelling};
use super::start_doubts::{START_SLACK_S, Start, comments_of, start_of, states_start};

/// Time by which a clock of the telescope, or the command to open the shutter, may be before the start, seconds.
pub const LOOSE_START_S: f64 = 10.0;

/// Time by which a time of day that is not stated to be that of the start may be before a stated start (GSAOI and
/// Flamingos-2 of Gemini), seconds.
pub const UNSTATED_START_S: f64 = 25.0;

/// Largest accepted overhead, in addition to the exposure time, of keywords that may include the readout, seconds.
pub const READOUT_S: f64 = 60.0;

/// Differences that may be those of time zones: multiples of half an hour from one hour on, within some minutes,
/// seconds.
const ZONE_STEP_S: f64 = 1800.0;
const ZONE_SLACK_S: f64 = 120.0;

/// Largest difference of an unlabelled number of days from one clock whose comment states the start in UTC, seconds.
const LABELLED_S: f64 = 120.0;

/// Error of the difference of half an exposure, or of an exposure, from the start in another clock, seconds.
const PART_SLACK_S: f64 = 0.5;

/// Replaces a start by a later one within seconds that is the opening of the shutter, or whose name states the start if
/// that of the first clock does not: the first one is the time of the command (SHUTOPEN beside UTC-OBS at the CFHT,
/// UTSTART beside TIME-OBS at Gemini).
pub fn use_stated(keywords: Keywords<'_>, instants: &Instants, start: &mut Start) {
    if start.step_s == 0.0 || is_shutter(&start.from) {
        return;
    }
    // A date with a time of day in another keyword.
    let may_be_early = start.from.contains(" + ") && !states_start(keywords, start);
    let is_later = |other: &&Instant| {
        let late_s = seconds_between(start.epoch, other.epoch);
        let is_clock = other.role == Role::Start && other.slack_s <= AGREED_S && other.step_s() > 0.0;
        let is_other = late_s.abs() > AGREED_S + start.slack_s;
        let is_start = may_be_early && is_named(&other.from) && (-START_SLACK_S..=UNSTATED_START_S).contains(&late_s);
        let is_open = is_shutter(&other.from) && (START_SLACK_S + start.slack_s..=LOOSE_START_S).contains(&late_s);
        is_clock && ((is_start && is_other) || is_open)
    };
    let later: Vec<&Instant> = instants.found.iter().filter(is_later).collect();
    if let Some(other) = later.iter().find(|other| is_shutter(&other.from)).or(later.first()) {
        *start = start_of(other, 0.0);
    }
}

/// Makes a date the middle of the exposure if the comment of days with the same value states it, unless an end agrees
/// with the date as the start.
pub fn use_stated_middles(instants: &mut Instants, duration_s: f64) {
    for (date, days) in std::mem::take(&mut instants.middles) {
        let Some(at) = instants.found.iter().position(|known| known.from == date) else { continue };
        let known = &instants.found[at];
        let confirms = |end: &Instant| {
            let late_s = seconds_between(known.epoch, end.epoch) - duration_s;
            let slack_s = START_SLACK_S + known.slack_s + end.slack_s;
            end.role == Role::End && late_s.abs() <= slack_s.min(duration_s / 4.0)
        };
        if !instants.found.iter().any(confirms) {
            let sentence = format!("{date} is read as the middle, by the comment of {days}");
            instants.found[at].role = Role::Middle;
            instants.readings.push((date, sentence));
        }
    }
}

/// Returns true if a second clock, which is no number of days, agrees with the start: an end that is later than the
/// exposure time is that of the readout, not that of several exposures (48 s after 300 s at MegaCam of the CFHT).
pub fn has_second_clock(instants: &Instants, start: &Start) -> bool {
    instants.found.iter().any(|other| {
        let late_s = seconds_between(start.epoch, other.epoch);
        let is_clock = other.role == Role::Start && !other.is_days() && other.from != start.from;
        is_clock && late_s.abs() <= START_SLACK_S + start.slack_s + other.slack_s
    })
}

/// Replaces a start in whole seconds by one of the same second in another keyword with more digits.
pub fn use_finer(instants: &Instants, start: &mut Start) {
    if start.step_s != 1.0 || start.slack_s > AGREED_S || start.from.contains(" - ") {
        return;
    }
    let is_finer = |other: &&Instant| {
        let late_s = seconds_between(start.epoch, other.epoch);
        // Seconds are cut off or rounded.
        let is_same_second = (AGREED_S..1.0).contains(&late_s) || (-0.5..-AGREED_S).contains(&late_s);
        // UT may be that of another instant, and JD in the same second is not.
        let is_exact = !other.is_loose || other.is_days();
        let is_of_start = other.role == Role::Start && !other.is_loose_clock && is_exact;
        let is_digital = other.step_s() < 1.0 && other.slack_s <= AGREED_S;
        is_of_start && is_digital && is_same_second
    };
    let finer = || instants.found.iter().filter(is_finer);
    if let Some(finer) = finer().find(|other| !other.is_loose).or_else(|| finer().next()) {
        *start = start_of(finer, 0.0);
    }
}

/// Returns true if a number of days, or a clock of the telescope such as UT, differs from a start with which more
/// clocks and ends agree than with the other one, as in headers of Gemini. Differences by time zones, by half of the
/// exposure or by all of it, which may be those of another meaning, are never outvoted.
pub fn is_outvoted(
    keywords: Keywords<'_>,
    instants: &Instants,
    start: &Start,
    other: &Instant,
    duration_s: f64,
) -> bool {
    let late_s = |instant: &Instant| seconds_between(start.epoch, start_of(instant, duration_s).epoch);
    let apart_s = late_s(other).abs();
    if start.step_s == 0.0 || start.from.contains(" - ") || !(other.is_days() || is_of_telescope(other)) {
        return false;
    }
    let zones = (apart_s / ZONE_STEP_S).round();
    let is_zone = zones >= 2.0 && (apart_s - zones * ZONE_STEP_S).abs() <= ZONE_SLACK_S;
    if is_zone || apart_s > 0.5 * DAY_S {
        return false;
    }
    let is_end = |instant: &&Instant, readout_s: f64| {
        let digits_s = START_SLACK_S + start.slack_s + instant.slack_s;
        instant.role == Role::End && !instant.is_days() && (-digits_s..=readout_s + digits_s).contains(&late_s(instant))
    };
    let is_confirmed = instants.found.iter().any(|instant| is_end(&instant, 0.0));
    let is_part =
        [0.5, 1.0].into_iter().any(|part| (apart_s - part * duration_s).abs() <= PART_SLACK_S + other.slack_s);
    if is_part && !is_confirmed {
        return false;
    }
    let agrees = |instant: &&Instant| {
        let early_s = if is_of_universal(&instant.from) { LOOSE_START_S } else { START_SLACK_S };
        let slack_s = start.slack_s + instant.slack_s;
        is_end(instant, READOUT_S)
            || (instant.role == Role::Start
                && !instant.is_days()
                && instant.from != start.from
                && (-early_s - slack_s..=START_SLACK_S + slack_s).contains(&late_s(instant)))
    };
    // One Julian date may be computed from the other.
    let agrees_with_other = |instant: &&Instant| {
        let difference_s = late_s(instant) - late_s(other);
        let is_same_kind = instant.is_days() && other.is_days();
        instant.from != other.from && !is_same_kind && difference_s.abs() <= START_SLACK_S + instant.slack_s
    };
    let clocks: Vec<&Instant> = instants.found.iter().filter(agrees).collect();
    let is_universal = is_of_universal(&start.from)
        || clocks.iter().any(|clock| is_of_universal(&clock.from))
        || comments_of(keywords, start).iter().any(Comment::is_universal);
    // The comment of one clock, beside days without a statement.
    let is_labelled = comments_of(keywords, start)
        .iter()
        .any(|comment| comment.is_universal() && comment.role(None) == Ok(Some(Role::Start)));
    let is_labelled = is_labelled && apart_s <= LABELLED_S && other.is_days() && !other.is_role_stated;
    let votes = clocks.len() + usize::from(is_labelled);
    (is_universal || (is_part && is_confirmed)) && votes > instants.found.iter().filter(agrees_with_other).count()
}

/// Returns true if an end is before the start, and another end fits the start, or the end is a time of day and another
/// clock agrees with the start: it is the end of the exposure before, or a copy of the start.
pub fn is_end_of_other(instants: &Instants, start: &Start, end: &Instant, duration_s: f64) -> bool {
    let late_s = |instant: &Instant| seconds_between(start.epoch, start_of(instant, duration_s).epoch);
    let agrees = |other: &Instant| match other.role {
        Role::Start => {
            let is_near = (-UNSTATED_START_S..=START_SLACK_S).contains(&late_s(other));
            end.is_loose && !other.is_days() && other.from != start.from && is_near
        }
        Role::Middle => false,
        Role::End => late_s(other).abs() <= START_SLACK_S,
    };
    let is_before = seconds_between(start.epoch, end.epoch) < -START_SLACK_S;
    is_before && start.step_s > 0.0 && instants.found.iter().any(agrees)
}

/// Returns true for a start in a time of day that is perhaps read before the exposure, such as UT.
pub fn is_of_telescope(instant: &Instant) -> bool {
    instant.role == Role::Start && LOOSE_TIMES.iter().any(|name| is_spelling(name, &instant.from))
}

/// Returns true for the opening of the shutter.
pub fn is_shutter(from: &str) -> bool {
    is_spelling("SHUT-OPEN", from)
}

/// Returns true if the name of a keyword states the start.
pub fn is_named(from: &str) -> bool {
    from.split(" + ").any(names_start)
}

/// Returns true if the name of a keyword states universal time.
fn is_of_universal(from: &str) -> bool {
    from.split(" + ").any(|name| name.starts_with("UT"))
}

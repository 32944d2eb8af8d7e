//! Doubts about the start of an exposure: other cards of the header that it contradicts, as errors or sentences.

use hifitime::{Epoch, TimeScale, TimeUnits};

use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::{seconds_after, seconds_between};

use super::super::card::CardValue;
use super::comment::{AGREED_S, Comment, Role};
use super::instant::Instant;
use super::instant_keywords::{LAST_TIMES, LOOSE_DATES, OTHER_DATES, SIDEREAL_TIMES, names_start};
use super::instants::Instants;
use super::length::STATED_S;
use super::moment::{DateText, Keywords, is_spelling, parse_date, parse_time};
use super::observatory::{longitude_of_unknown_sense_deg, site_from_headers};
use super::scale::timesys;
use super::stacks::REMARKS;

/// Largest difference of the sidereal time that is not stated, seconds: it may be that of another part of the exposure,
/// or read some minutes before.
const SIDEREAL_SLACK_S: f64 = 600.0;

/// Largest difference between start times that are taken as consistent, in addition to their rounding, seconds.
pub const START_SLACK_S: f64 = 1.0;

/// Accepted shift of the middle or the end of the exposure by shutters and overheads, as a fraction of the exposure
/// time.
pub const SHIFT_SLACK: f64 = 0.1;

/// Beginnings of keywords of the zone of a local time or its offset from universal time, without hyphens.
const ZONES: &[&str] = &["TIMEZON", "TZN", "TZO", "UTOFF", "UTCOFF", "GMTOFF", "UTCDIF"];

/// Keywords of summer time, beginnings of others, and texts with which they state it.
const SUMMER_TIMES: &[&str] = &["DST", "DAYLTSAV"];
const SUMMER_TIME_STEMS: &[&str] = &["DAYLIGHT", "SUMMERT"];
const YES: &[&str] = &["T", "Y", "YES", "ON", "TRUE"];

/// Beginnings of keywords of the clock, whose value may be "local".
const CLOCKS: &[&str] = &["CLOCK", "CLK", "TIMETYP", "TIMEBAS", "TIMESRC"];

/// Keywords of errors of times, and of an offset (FITS standard 4.0, section 9.4).
const TIME_ERRORS: &[&str] = &["TIMEOFFS", "TIMSYER", "TIMRDER"];

/// Beginnings of names of cameras whose clock is set by hand, often to local time.
const HAND_SET_CAMERAS: &[&str] = &["canon", "nikon", "pentax", "fujifilm", "olympus", "dslr"];

/// Time within which the first and the last exposure of a stack are expected. Dates farther away concern something
/// else.
const LONGEST_STACK_S: f64 = 30.0 * DAY_S;

/// Longitude within which the zone of a site may be that of universal time, degrees.
const ZERO_ZONE_DEG: f64 = 22.5;

/// Start with the keyword that gave it, and the rounding error of its digits.
pub struct Start {
    pub epoch: Epoch,
    pub from: String,
    pub slack_s: f64,
    /// Last digit of the seconds as written, seconds.
    pub step_s: f64,
}

impl Start {
    /// Returns the error (one sigma) of the start, seconds: that of its comment, or of its digits, by which a time of day
    /// is cut or rounded and a number of days is rounded.
    pub fn sigma_s(&self) -> f64 {
        let is_days = self.step_s == 0.0;
        let slack_s = if is_days { self.slack_s / 3f64.sqrt() } else { self.slack_s };
        slack_s.hypot(self.step_s / 12f64.sqrt())
    }
}

/// Returns the start of an exposure of which an instant is known.
pub fn start_of(instant: &Instant, duration_s: f64) -> Start {
    let (back_s, what) = match instant.role {
        Role::Start => (0.0, ""),
        Role::Middle => (duration_s / 2.0, " - half of the exposure"),
        Role::End => (duration_s, " - the exposure"),
    };
    let mut epoch = seconds_after(instant.epoch, -back_s);
    // The end may be on the day after the date of the start.
    if instant.day.is_some_and(|(midnight, part)| part == Some(Role::Start) && epoch < midnight) {
        epoch = seconds_after(epoch, DAY_S);
    }
    Start { epoch, from: format!("{}{what}", instant.from), slack_s: instant.slack_s, step_s: instant.step_s() }
}

/// Returns the error of a start that is the same reading of the clock as a local time, unless the zone may be that of
/// universal time.
pub fn same_as_local(keywords: Keywords<'_>, instants: &Instants, start: &Start) -> Option<Error> {
    let seconds_of_day = |epoch: Epoch| {
        let (.., hours, minutes, seconds, nanoseconds) = epoch.to_gregorian_utc();
        3600.0 * f64::from(hours) + 60.0 * f64::from(minutes) + f64::from(seconds) + 1e-9 * f64::from(nanoseconds)
    };
    let clock_s = seconds_of_day(start.epoch);
    let (name, _) = instants.local_clocks.iter().find(|(_, local_s)| (local_s - clock_s).abs() < START_SLACK_S)?;
    let longitude_deg = site_from_headers(keywords.0).ok().flatten().map(|found| found.site.longitude_rad.to_degrees());
    let longitude_deg = longitude_deg.or_else(|| longitude_of_unknown_sense_deg(keywords));
    let is_zero_zone = keywords.number(&["TIMEZONE", "TIME-ZONE"], |_| true).map(|(_, hours, _)| hours == 0.0);
    // Without zone and longitude, a header that states UTC is believed: the clock of the computer was in UTC.
    let is_zero_zone = is_zero_zone.or(longitude_deg.map(|deg| deg.abs() < ZERO_ZONE_DEG));
    if is_zero_zone.unwrap_or_else(|| states_utc(keywords, start)) {
        return None;
    }
    let given =
        format!("{}, the same reading of the clock as the local time {name}", start.epoch.round(1.milliseconds()));
    let allowed = "a start in UTC and a local time of another zone, a site, TIMEZONE = 0, or --start";
    Some(Error::invalid(format!("start of {}", start.from), given, allowed))
}

/// Returns the comments of the keywords of the start.
pub fn comments_of(keywords: Keywords<'_>, start: &Start) -> Vec<Comment> {
    let names = start.from.split(" - ").next().unwrap_or_default().split(" + ");
    names.filter_map(|name| keywords.find(name)).map(|(header, name)| keywords.comment(header, &name)).collect()
}

/// Returns true if TIMESYS or the comment of a keyword of the start states UTC.
fn states_utc(keywords: Keywords<'_>, start: &Start) -> bool {
    let by_keyword = timesys(keywords).is_some_and(|(_, scale)| scale.trim().eq_ignore_ascii_case("UTC"));
    by_keyword || comments_of(keywords, start).iter().any(Comment::is_universal)
}

/// Returns true if the name or the comment of a keyword of the start states the start.
pub fn states_start(keywords: Keywords<'_>, start: &Start) -> bool {
    let is_stated = |comment: &Comment| matches!(comment.role(None), Ok(Some(Role::Start)));
    start.from.split(" + ").any(names_start) || comments_of(keywords, start).iter().any(is_stated)
}

/// Returns a sentence about a start in OBS-DATE, DATETIME or TIME if nothing states that it is in universal time.
pub fn of_other_date(keywords: Keywords<'_>, start: &Start) -> Option<String> {
    let name = start.from.split(" + ").next()?;
    let is_last = start.from.split(" + ").any(|part| LAST_TIMES.contains(&part));
    let is_doubtful = is_last || OTHER_DATES.iter().any(|other| is_spelling(other, name));
    let is_stated = timesys(keywords).is_some() || comments_of(keywords, start).iter().any(Comment::is_universal);
    (is_doubtful && !is_stated).then(|| {
        format!(
            "the start is that of {}, which is read as the date in UTC: if it is local or that of the evening, specify --start",
            start.from
        )
    })
}

/// Returns a sentence about a start in MJD or JD, without a statement of the part of the exposure.
pub fn of_day_number(keywords: Keywords<'_>, start: &Start) -> Option<String> {
    let is_alone = LOOSE_DATES.contains(&start.from.as_str()) && !states_start(keywords, start);
    is_alone.then(|| {
        let from = &start.from;
        format!("the start is that of {from}, which some programs write for the middle: if it is, specify --start")
    })
}

/// Returns a sentence about a sidereal time of the site that differs from that of the exposure by more than some
/// minutes: the start may be a local time.
pub fn sidereal(keywords: Keywords<'_>, start: &Start, duration_s: f64) -> Option<String> {
    let (name, text) = keywords.text(SIDEREAL_TIMES)?;
    let ([hours, minutes], seconds) = parse_time(&text)?;
    let longitude_deg = site_from_headers(keywords.0).ok().flatten()?.site.longitude_rad.to_degrees();
    let days = start.epoch.to_jde_utc_days() - 2_451_545.0;
    // Mean sidereal time of Greenwich (IAU 1982) without its small terms, which is exact to some seconds.
    let of_site_s = (240.0 * longitude_deg + 86_400.0 * (0.779_057_273 + 1.002_737_909_35 * days)).rem_euclid(DAY_S);
    let stated_s = f64::from(3600 * hours + 60 * minutes) + seconds;
    let late_s = (stated_s - of_site_s + 0.5 * DAY_S).rem_euclid(DAY_S) - 0.5 * DAY_S;
    (!(-SIDEREAL_SLACK_S..=SIDEREAL_SLACK_S + duration_s).contains(&late_s)).then(|| {
        format!(
            "the start is that of {}, but {name} is {text}, {:.2} h {} than the sidereal time of the site in the header at the \
             start: if the start is a local time, or the site another one, specify --start or the site",
            start.from,
            late_s.abs() / 3600.0,
            if late_s > 0.0 { "later" } else { "earlier" }
        )
    })
}

/// Returns a sentence about a file that was written before the end of the exposure, if nothing states that the start is
/// the start: its time may be that of the end, or of the writing.
pub fn written_early(keywords: Keywords<'_>, start: &Start, duration_s: f64) -> Option<String> {
    let (name, text, comment) = keywords.text_and_comment("DATE")?;
    if comment.is_local() || comment.role(None) == Ok(Some(Role::Start)) {
        return None;
    }
    let DateText::Moment(written) = parse_date(&text, TimeScale::UTC) else { return None };
    let late_s = seconds_between(start.epoch, written);
    let latest_s = (1.0 - SHIFT_SLACK) * duration_s - START_SLACK_S - start.slack_s;
    let is_early = (-START_SLACK_S - start.slack_s..latest_s).contains(&late_s);
    (is_early && !start.from.contains(" - ") && !states_start(keywords, start)).then(|| {
        format!(
            "the start is that of {}, but the file was written {:.1} s after it, before the end of the exposure ({name}): if it \
             is the time of the end, specify --start",
            start.from,
            late_s.max(0.0)
        )
    })
}

/// Returns a sentence about the first card that states an error of the times of the header, or in which part of the
/// exposure or in which zone they are.
pub fn about_times(keywords: Keywords<'_>, start: &Start) -> Option<String> {
    let card = keywords.cards().find(|card| match card.value() {
        None => REMARKS.contains(&card.keyword().as_str()) && Comment::new(&card.remark_text()).is_about_times(),
        Some(CardValue::Integer(_) | CardValue::Real(_)) => {
            let is_error =
                TIME_ERRORS.contains(&card.keyword().as_str()) || Comment::new(&card.comment()).is_of_clock_error();
            is_error && keywords.number(&[&card.keyword()], |number| number.abs() > AGREED_S).is_some()
        }
        _ => false,
    })?;
    let text = card.text();
    Some(format!(
        "the start is that of {}; for another one specify --start; the header has the card {:?}",
        start.from,
        text.trim_end()
    ))
}

/// Returns a sentence about the zone of a header, or the camera with a clock that is set by hand, if nothing states
/// that the start is in universal time.
pub fn zone(keywords: Keywords<'_>, instants: &Instants, start: &Start) -> Option<String> {
    // A scale, another clock of universal time, or a different local time show that the start is not local.
    if timesys(keywords).is_some()
        || comments_of(keywords, start).iter().any(Comment::is_universal)
        || instants.found.iter().any(|instant| instant.from.contains("UT"))
        || !instants.local_clocks.is_empty()
    {
        return None;
    }
    let camera = || {
        let (name, camera) = keywords.text(&["INSTRUME", "CAMERA"])?;
        let lower = camera.to_ascii_lowercase();
        HAND_SET_CAMERAS.iter().any(|maker| lower.starts_with(maker)).then_some((name, camera))
    };
    let of_card = keywords.cards().find_map(|card| {
        let name = card.keyword();
        let bare = name.replace(['-', '_', ' '], "");
        let is_summer_time =
            SUMMER_TIMES.contains(&&*bare) || SUMMER_TIME_STEMS.iter().any(|stem| bare.starts_with(stem));
        let is_zone = bare == "TZ"
            || is_summer_time
            || ZONES.iter().any(|zone| bare.starts_with(zone))
            || Comment::new(&card.comment()).is_of_zone()
            || (CLOCKS.iter().any(|clock| bare.starts_with(clock))
                && matches!(card.value(), Some(CardValue::Text(text)) if Comment::new(&text).is_local()));
        let value = match card.value().filter(|_| is_zone)? {
            CardValue::Integer(number) => number.to_string(),
            CardValue::Real(number) => number.to_string(),
            CardValue::Text(text) => text.trim().to_owned(),
            CardValue::Logical(true) => return Some((name, "T".to_owned())),
            _ => return None,
        };
        // Quarters of an hour, in hours or in seconds.
        let is_offset = |number: f64| {
            number != 0.0 && ((4.0 * number).fract() == 0.0 && number.abs() <= 14.0 || number % 900.0 == 0.0)
        };
        // UTC, Z and +00:00 are universal time, UTC-7 is not.
        let is_zero = value.chars().all(|c| "+-0:. Z".contains(c));
        let has_offset = value.contains(|c: char| matches!(c, '1'..='9'));
        let is_zone = !is_zero && (has_offset || !Comment::new(&value).is_universal());
        let is_yes = YES.contains(&&*value.to_ascii_uppercase());
        let is_local = match value.parse::<f64>() {
            Ok(number) if is_summer_time => number != 0.0,
            Ok(number) => is_offset(number),
            Err(_) => {
                if is_summer_time {
                    is_yes
                } else {
                    is_zone
                }
            }
        };
        is_local.then_some((name, value))
    });
    let (name, value) = of_card.or_else(camera)?;
    Some(format!("{} is read as UTC, and {name} is {value}: if it is a local time, specify --start", start.from))
}

/// Returns sentences about starts, middles and ends in keywords of other names that do not fit the exposure.
pub fn other_parts(instants: &Instants, start: &Start, duration_s: f64) -> Vec<String> {
    let sentence = |other: &Instant| {
        let (part, expected_s) = match other.role {
            Role::Start => ("start", 0.0),
            Role::Middle => ("middle", duration_s / 2.0),
            Role::End => ("end", duration_s),
        };
        let late_s = seconds_between(start.epoch, other.epoch) - expected_s;
        let least_s = match other.role {
            Role::Start => AGREED_S + start.step_s.max(other.step_s()),
            _ => STATED_S + SHIFT_SLACK * duration_s,
        };
        let slack_s = least_s + start.slack_s + other.slack_s;
        (slack_s..LONGEST_STACK_S).contains(&late_s.abs()).then(|| {
            let side = if late_s > 0.0 { "later" } else { "earlier" };
            format!(
                "{} is {:.1} s {side} than the {part} of the exposure, by the start of {}: for another exposure specify \
                 --start and --exposure",
                other.from,
                late_s.abs(),
                start.from
            )
        })
    };
    // A start that is that of a known keyword was compared with it.
    let is_known = |other: &&Instant| {
        let is_same = |known: &Instant| {
            seconds_between(known.epoch, other.epoch).abs() <= AGREED_S + known.slack_s + other.slack_s
        };
        instants.found.iter().any(|known| known.role == other.role && is_same(known))
    };
    instants.others.iter().filter(|other| !is_known(other)).filter_map(sentence).collect()
}

//! Instants in keywords of other names, such as OBS-END, MIDMJD, UTC-LAST and GPS_SUTC, found by their names and comments.

use hifitime::Epoch;

use crate::constants::DAY_S;
use crate::frames::{epoch_from_jd, epoch_from_mjd};

use super::super::card::{Card, CardValue};
use super::comment::{Comment, FRAMES, Role};
use super::instant::Instant;
use super::instant_keywords::{
    CLOCKS, DATES, END_TIMES, ENDS, GPS_TIMES, JULIAN_DATES, LOOSE_DATES, LOOSE_TIMES, MIDDLES, MODIFIED_DATES,
    OTHER_STARTS, OUTERMOST, SHUTTER, SIDEREAL_TIMES, TIMES,
};
use super::moment::{DateText, Keywords, bare, is_spelling, late_day, near, parse_date, resolution};
use super::scale::DateScale;

/// Parts of names of times that are not those of this exposure, or that are local.
const OF_OTHERS: &[&str] = &["GUID", "PREV", "CAL", "SEQ", "NIGHT", "PROG", "LOC", "SID", "TREND"];

/// Words of the start before or after those of [`CLOCKS`] or the following ones in names of keywords, as in OBSSTART.
const STARTS: &[&str] = &["START", "STRT", "STR", "BEGIN", "BEG", "OPEN"];
const STARTED: &[&str] =
    &["T", "TU", "SHUT", "SHUTTER", "FRAME", "IMAGE", "IMG", "INT", "CAM", "CCD", "EXPOSURE", "GPS"];

/// Reads dates, times and day numbers in other keywords whose name or comment states the start, the middle, the end, or
/// the first or last of several exposures. `start` is that of the known keywords, to which a time of day without a date
/// belongs. A start with a date is loose.
pub fn other_instants(keywords: Keywords<'_>, dates: DateScale, start: Option<Epoch>) -> Vec<Instant> {
    let known = [
        DATES,
        TIMES,
        LOOSE_TIMES,
        MODIFIED_DATES,
        JULIAN_DATES,
        OTHER_STARTS,
        LOOSE_DATES,
        MIDDLES,
        ENDS,
        END_TIMES,
        SIDEREAL_TIMES,
    ]
    .concat();
    let is_other = |card: &&Card| {
        let name = card.keyword();
        let may_be_date = match card.value() {
            Some(CardValue::Text(text)) => text.contains([':', '-', '/']),
            // Modified Julian dates since 1930.
            Some(CardValue::Real(days)) => days > 26_000.0,
            _ => false,
        };
        may_be_date && !known.iter().any(|keyword| is_spelling(keyword, &name))
    };
    keywords.cards().filter(is_other).filter_map(|card| instant_of(card, dates, start)).collect()
}

/// Returns the part of the exposure that a name states.
fn part_in_name(name: &str) -> Option<Role> {
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    if has(&["MID"]) || (has(&["MEAN", "AVG"]) && has(&["JD", "DATE", "TIME", "UT", "OBS"])) {
        Some(Role::Middle)
    } else if has(&["END", "STOP", "CLOS", "FIN"]) {
        Some(Role::End)
    } else {
        let bare = bare(name);
        let of_start = |word: &str| {
            let rest = bare.strip_prefix(word).or_else(|| bare.strip_suffix(word));
            rest.is_some_and(|rest| CLOCKS.contains(&rest) || STARTED.contains(&rest))
        };
        // Not ESO OBS START, that of the observation block.
        (!name.contains(' ') && STARTS.iter().any(|word| of_start(word))).then_some(Role::Start)
    }
}

fn instant_of(card: &Card, dates: DateScale, start: Option<Epoch>) -> Option<Instant> {
    let name = card.keyword();
    let bare = bare(&name);
    let gps = GPS_TIMES.iter().find(|(known, _)| is_spelling(known, &name)).map(|(_, role)| *role);
    let named = gps.or_else(|| part_in_name(&name));
    let outermost = OUTERMOST.iter().find(|(_, word)| {
        let rest = bare.strip_prefix(word).or_else(|| bare.strip_suffix(word));
        rest.is_some_and(|rest| CLOCKS.contains(&rest))
    });
    let comment = Comment::new(&card.comment());
    // "UTC of the last frame"
    let is_of_other = OF_OTHERS.iter().any(|word| bare.contains(word))
        || comment.has("guide guider guiding previous calibration processing reduction proprietary release");
    let is_last = comment.has_pair("last final", FRAMES) && !is_of_other;
    let outermost = outermost.map(|(role, _)| *role).or((bare == SHUTTER).then_some(Role::Start));
    let outermost = outermost.or(is_last.then_some(Role::End));
    let of_comment = if is_last { Ok(None) } else { comment.role(named) };
    let role = outermost.or(of_comment.ok()?).filter(|_| of_comment.is_ok() && comment.scale().is_ok())?;
    // BJD_TDB, JD_TT
    let in_name = Comment::new(&name);
    let is_of_exposure =
        named.or(outermost).is_some() || comment.has("exposure exp observation obs frame integration shutter");
    if is_of_other || !is_of_exposure || in_name.role(Some(role)).is_err() || in_name.scale() != Ok(None) {
        return None;
    }
    let scale = dates.of(&comment);
    let days = |epoch: Epoch| Instant { slack_s: resolution(card) * DAY_S, ..Instant::new(epoch, name.clone(), role) };
    let is_loose = role == Role::Start && outermost.is_none();
    match card.value()? {
        CardValue::Text(text) => {
            let (epoch, is_loose) = match parse_date(&text, scale) {
                DateText::Moment(epoch) => (epoch, is_loose),
                DateText::Day(day) if role == Role::End => (late_day(start?, day, scale)?, false),
                _ if bare.contains("UT") || bare.contains("TIME") || comment.has("ut utc time") => {
                    (near(start?, &text, scale)?, false)
                }
                _ => return None,
            };
            Some(Instant { value: text, is_loose, ..Instant::new(epoch, name, role) })
        }
        CardValue::Real(number) if number > 1e6 => {
            Some(Instant { is_loose, ..days(epoch_from_jd(number, scale).ok()?) })
        }
        CardValue::Real(number) if name.contains("MJD") || comment.has("mjd") => {
            Some(Instant { is_loose, ..days(epoch_from_mjd(number, scale).ok()?) })
        }
        _ => None,
    }
}

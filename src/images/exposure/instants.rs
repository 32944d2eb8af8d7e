//! Instants in a header: start, middle or end of the exposure, by the name of the keyword and by its comment.

use hifitime::{Epoch, TimeScale};

use crate::frames::{epoch_from_jd, epoch_from_mjd};

use super::super::error::ImagesError;
use super::comment::{Comment, Role};
use super::moment::{DateText, Keywords, at, parse_date, parse_time, resolution};

/// Keywords with the date and time of the start, in order of precedence.
const DATES: &[&str] = &["DATE-BEG", "DATE-OBS", "DATE-STR"];

/// Keywords with the time of day of the start, used together with a date.
const TIMES: &[&str] =
    &["TIME-BEG", "UTC-OBS", "TIME-OBS", "UT-OBS", "UTSTART", "UT-STR", "UTC-STR", "UTSHUT", "TAIHMS"];

/// Keywords with a time of day that is not the start at some observatories. They are used only if no keyword of
/// [`TIMES`] exists.
const LOOSE_TIMES: &[&str] = &["UT", "UTC", "UTIME"];

/// Keywords with the modified Julian date of the start.
const MODIFIED_DATES: &[&str] = &["MJD-BEG", "MJD-OBS", "MJD-STR", "MJDSTART"];

/// Keywords with the Julian date of the start.
const JULIAN_DATES: &[&str] = &["JDSTART", "JD-BEG", "JD-STR", "JD-OBS"];

/// Keywords of dates that are used only if no other keyword gives the start.
const LOOSE_DATES: &[&str] = &["MJD", "JD"];

/// Keywords of the middle and of the end of the exposure.
const MIDDLES: &[&str] = &["DATE-AVG", "MJD-AVG", "MJD-MID", "DATE-MID"];
const ENDS: &[&str] = &["DATE-END", "MJD-END", "JDEND"];

/// Keywords with the time of day of the end. At some observatories it includes the readout, so that they only show that
/// an exposure time is far too short.
const END_TIMES: &[&str] = &["TIME-END", "TIMEEND", "UT-END", "UTEND", "UTC-END", "UTCEND", "UTSTOP"];

/// Keywords whose names state that they refer to the start.
const NAMED_STARTS: &[&str] =
    &["DATE-BEG", "DATE-STR", "MJD-BEG", "MJD-STR", "MJDSTART", "JDSTART", "JD-BEG", "JD-STR"];

/// Largest difference between two instants that are computed from the same clock, seconds.
const SAME_CLOCK_S: f64 = 1.0;

/// One instant of a header.
pub struct Instant {
    pub epoch: Epoch,
    /// Keyword, or several keywords joined.
    pub from: String,
    /// Rounding error of its digits, seconds.
    pub slack_s: f64,
    pub role: Role,
    /// True for keywords that are used only if no other keyword gives the start.
    pub is_loose: bool,
}

/// Instants of a header in order of precedence, and the reasons why others are not used.
#[derive(Default)]
pub struct Instants {
    pub found: Vec<Instant>,
    /// Error of a date with a year of two digits, or with an ambiguous order.
    pub unclear: Option<ImagesError>,
    /// Keyword and value of a date without a time.
    pub day_alone: Option<(String, String)>,
    /// Error of an instant that its comment makes unusable, such as a local time.
    unusable: Option<ImagesError>,
    /// Instants in local time, read as if they were UTC.
    local: Vec<Epoch>,
}

impl Instants {
    /// Reads all instants. Dates are in `scale`; `is_stated` is true if TIMESYS states it.
    ///
    /// # Errors
    /// A date or a time that cannot be parsed.
    pub fn read(keywords: Keywords<'_>, scale: TimeScale, is_stated: bool) -> Result<Self, ImagesError> {
        let mut reader = Reader { keywords, scale, is_stated, instants: Self::default() };
        for keyword in DATES {
            reader.date(keyword)?;
        }
        for keyword in MODIFIED_DATES.iter().chain(JULIAN_DATES) {
            reader.days(keyword, Role::Start, false)?;
        }
        // SDSS writes the seconds of TAI since MJD 0.
        if let Some((from, seconds, _)) = keywords.number(&["TAI"], |seconds| seconds > 1e9) {
            let epoch = epoch_from_mjd(seconds / crate::constants::DAY_S, TimeScale::TAI).ok();
            let instant = |epoch| Instant { epoch, from, slack_s: 0.01, role: Role::Start, is_loose: false };
            reader.instants.found.extend(epoch.map(instant));
        }
        for keyword in LOOSE_DATES {
            reader.days(keyword, Role::Start, true)?;
        }
        for (names, role) in [(MIDDLES, Role::Middle), (ENDS, Role::End)] {
            for keyword in names {
                if keyword.starts_with("DATE") {
                    reader.named_date(keyword, role)
                } else {
                    reader.days(keyword, role, false)?
                }
            }
        }
        for keyword in END_TIMES {
            reader.end_time(keyword);
        }
        Ok(reader.instants)
    }

    /// Returns the error that concerns the first unusable instant, unless `chosen` comes from another clock.
    pub fn unusable(&mut self, chosen: Option<Epoch>) -> Option<ImagesError> {
        let is_same = |chosen: Epoch| {
            self.local.iter().any(|local| crate::frames::seconds_between(*local, chosen).abs() < SAME_CLOCK_S)
        };
        if chosen.is_some_and(|chosen| !is_same(chosen)) { None } else { self.unusable.take() }
    }
}

struct Reader<'a> {
    keywords: Keywords<'a>,
    scale: TimeScale,
    is_stated: bool,
    instants: Instants,
}

impl Reader<'_> {
    /// Reads a keyword of [`DATES`], with a time of day in another keyword if it has none.
    fn date(&mut self, keyword: &str) -> Result<(), ImagesError> {
        let Some((from, value, comment)) = self.keywords.text_and_comment(keyword) else { return Ok(()) };
        let usual = Role::Start;
        match parse_date(&value, self.scale_of(&comment)) {
            DateText::Moment(epoch) => self.add(epoch, from, &value, 0.0, usual, false, &[comment]),
            DateText::Day(day) => {
                if !self.time_of(day, &from, &comment)? && self.instants.day_alone.is_none() {
                    self.instants.day_alone = Some((from, value));
                }
            }
            DateText::Unclear if self.instants.unclear.is_none() => {
                let given = format!("the ambiguous date {value:?}");
                self.instants.unclear = Some(ImagesError::invalid(from, given, "yyyy-mm-dd, or --start"));
            }
            DateText::Unclear => {}
            DateText::Unreadable => {
                let allowed = "a date such as 2024-08-14T00:30:00.5, or 2024-08-14 with a time in another keyword";
                return Err(unreadable(from, &value, allowed));
            }
        }
        Ok(())
    }

    /// Combines a date with the time of day in another keyword. Returns false if there is none.
    fn time_of(&mut self, day: [u32; 3], date: &str, of_date: &Comment) -> Result<bool, ImagesError> {
        let mut has_time = false;
        for keyword in TIMES.iter().chain(LOOSE_TIMES) {
            let Some((name, value, comment)) = self.keywords.text_and_comment(keyword) else { continue };
            let scale = if name == "TAIHMS" { TimeScale::TAI } else { self.scale_of(&comment) };
            let known = self.instants.found.len();
            // Some observatories write date and time in these keywords.
            if let DateText::Moment(epoch) = parse_date(&value, scale) {
                self.add(epoch, name, &value, 0.0, Role::Start, false, &[comment]);
            } else {
                let epoch = parse_time(&value).and_then(|(clock, seconds)| at(day, clock, seconds, scale));
                let epoch = epoch.ok_or_else(|| unreadable(name.clone(), &value, "a time such as 00:30:00.5"))?;
                // The comment of the time determines the role, and that of the date if it states none.
                let comments = [comment, of_date.clone()];
                self.add(epoch, format!("{date} + {name}"), &value, 0.0, Role::Start, false, &comments);
            }
            has_time = true;
            // If the time is unusable, for example local, another keyword may give it.
            if self.instants.found.len() > known {
                // If the local time is on the other side of midnight, the date may be the local one.
                let found = self.instants.found[known].epoch;
                let is_far =
                    |local: &Epoch| crate::frames::seconds_between(*local, found).abs() > 0.5 * crate::constants::DAY_S;
                if self.instants.local.iter().any(is_far) {
                    self.instants.found.truncate(known);
                }
                break;
            }
        }
        Ok(has_time)
    }

    /// Reads a date of the middle or the end; a date without a time is ignored.
    fn named_date(&mut self, keyword: &str, role: Role) {
        let Some((from, value, comment)) = self.keywords.text_and_comment(keyword) else { return };
        if let DateText::Moment(epoch) = parse_date(&value, self.scale_of(&comment)) {
            self.add(epoch, from, &value, 0.0, role, false, &[comment]);
        }
    }

    /// Reads the time of day of the end, which is within a day after the first instant of the start.
    fn end_time(&mut self, keyword: &str) {
        let Some((from, value, comment)) = self.keywords.text_and_comment(keyword) else { return };
        let start = self.instants.found.iter().find(|instant| instant.role == Role::Start).map(|instant| instant.epoch);
        let (Some(start), Some((clock, seconds))) = (start, parse_time(&value)) else { return };
        let scale = self.scale_of(&comment);
        let (year, month, day, ..) = start.to_gregorian(scale);
        let Ok(year) = u32::try_from(year) else { return };
        let Some(mut end) = at([year, month.into(), day.into()], clock, seconds, scale) else { return };
        if crate::frames::seconds_between(start, end) < -0.5 * crate::constants::DAY_S {
            end = crate::frames::seconds_after(end, crate::constants::DAY_S);
        }
        self.add(end, from, &value, 0.0, Role::End, true, &[comment]);
    }

    /// Reads a Julian date or a modified Julian date.
    fn days(&mut self, keyword: &str, role: Role, is_loose: bool) -> Result<(), ImagesError> {
        let Some((header, from)) = self.keywords.find(keyword) else { return Ok(()) };
        let comment = Comment::new(&header.comment(&from));
        let scale = self.scale_of(&comment);
        let is_julian = keyword.starts_with("JD");
        let value = header.card(&from).map(|card| card.text()[9..].trim().to_owned()).unwrap_or_default();
        let epoch = header.number(&from).and_then(|number| {
            if is_julian { epoch_from_jd(number, scale).ok() } else { epoch_from_mjd(number, scale).ok() }
        });
        let Some(epoch) = epoch else {
            let allowed = if is_julian {
                "a Julian date between 1900 and 2200"
            } else {
                "a modified Julian date between 1900 and 2200"
            };
            return Err(unreadable(from, &value, allowed));
        };
        let slack_s = header.card(&from).map_or(0.0, resolution) * crate::constants::DAY_S;
        let value = header.number(&from).map_or(value, |number| number.to_string());
        self.add(epoch, from, &value, slack_s, role, is_loose, &[comment]);
        Ok(())
    }

    /// Returns the scale of a date: that of TIMESYS, or else the one that its comment states.
    fn scale_of(&self, comment: &Comment) -> TimeScale {
        if self.is_stated { self.scale } else { comment.scale().unwrap_or(self.scale) }
    }

    /// Adds an instant, with the role that the first comment with a role states, or else the usual one. Instants that a
    /// comment makes unusable are kept as errors.
    #[expect(clippy::too_many_arguments, reason = "fields of one instant")]
    fn add(
        &mut self,
        epoch: Epoch,
        from: String,
        value: &str,
        slack_s: f64,
        usual: Role,
        is_loose: bool,
        comments: &[Comment],
    ) {
        let is_named = usual != Role::Start || NAMED_STARTS.iter().any(|name| *name == from.replace('_', "-"));
        let role = comments.iter().try_fold(None, |role: Option<Role>, comment| {
            let stated = comment.role(is_named.then_some(usual));
            stated.map(|stated| role.or(stated)).map_err(|problem| (comment, problem))
        });
        match role {
            Ok(role) => {
                self.instants.found.push(Instant { epoch, from, slack_s, role: role.unwrap_or(usual), is_loose })
            }
            Err((comment, problem)) => {
                if comment.is_local() {
                    self.instants.local.push(epoch);
                }
                let given = format!("{value:?}, {problem} by its comment {:?}", comment.text());
                let allowed =
                    "the start of the exposure in UTC, in this or another keyword (DATE-BEG, MJD-OBS, ...), or --start";
                self.instants.unusable.get_or_insert(ImagesError::invalid(from, given, allowed));
            }
        }
    }
}

pub(super) fn unreadable(keyword: String, value: &str, allowed: &str) -> ImagesError {
    ImagesError::invalid(keyword, format!("{value:?}"), allowed)
}

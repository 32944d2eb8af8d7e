//! Local time of tables, plots and the page: an offset from UTC, or a time zone of the IANA database.

use std::path::PathBuf;
use streakcast::ErrorKind;

use anyhow::anyhow;
use clap::{ArgMatches, Args};
use hifitime::{Epoch, TimeScale};
use jiff::Timestamp;
use jiff::tz::{Offset, TimeZone};
use streakcast::config::Config;
use streakcast::frames::{parse_instant, seconds_after};
use streakcast::message::Quoted;

/// Largest offset of a local clock from UTC, hours.
const MAX_UTC_OFFSET_H: f64 = 14.0;

/// Local time with a fixed offset from UTC, or with that of a time zone, which can change in the course of a year.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalTime(TimeZone);

/// Time zone of local times.
#[derive(Clone, Args)]
pub struct ZoneArguments {
    /// Local time: time zone (Europe/Madrid) or hours ahead of UTC (+01:00); UTC if omitted, and mean solar time of
    /// the site in serve and in plots along time
    #[arg(long, visible_alias = "utc-offset", value_name = "ZONE", allow_hyphen_values = true, value_parser = local_time)]
    pub time_zone: Option<LocalTime>,
}

impl ZoneArguments {
    /// Returns the time zone of the flag, or else that of the configuration.
    pub fn or_of(&self, config: &Config) -> anyhow::Result<Option<LocalTime>> {
        let of_key = |text: &str| local_time(text).map_err(|error| anyhow!("time_zone is '{text}', {error}"));
        match &self.time_zone {
            Some(zone) => Ok(Some(zone.clone())),
            None => config.time_zone.as_deref().map(of_key).transpose(),
        }
    }
}

impl LocalTime {
    /// Returns local time minus UTC at a time, hours.
    pub fn ahead_of_utc_h(&self, epoch: Epoch) -> f64 {
        // Saturates for times that jiff does not support (before the year -9999 and after 9999).
        let second = Timestamp::from_second(epoch.to_unix_seconds().floor() as i64).unwrap_or(Timestamp::MAX);
        f64::from(self.0.to_offset(second).seconds()) / 3600.0
    }

    /// Returns the changes of local time minus UTC after `from` and before `to`: time, and the new value, hours.
    pub fn changes(&self, from: Epoch, to: Epoch) -> Vec<(Epoch, f64)> {
        let time =
            |epoch: Epoch| Timestamp::from_second(epoch.to_unix_seconds().floor() as i64).unwrap_or(Timestamp::MAX);
        let following = self.0.following(time(from)).take_while(|change| change.timestamp() < time(to));
        following
            .map(|change| {
                let second = change.timestamp().as_second() as f64;
                (Epoch::from_unix_seconds(second), f64::from(change.offset().seconds()) / 3600.0)
            })
            .collect()
    }

    /// Returns a time as local date and time, rounded to `step_s`, with its offset from UTC: `2026-08-14 23:30:00
    /// +02:00`; without seconds if the step is a minute.
    pub fn text(&self, epoch: Epoch, step_s: f64) -> String {
        let seconds = (epoch.to_unix_seconds() / step_s).round() * step_s;
        let moment = Timestamp::from_second(seconds as i64).unwrap_or(Timestamp::MAX).to_zoned(self.0.clone());
        moment.strftime(if step_s < 60.0 { "%Y-%m-%d %H:%M:%S %:z" } else { "%Y-%m-%d %H:%M %:z" }).to_string()
    }
}

/// Returns the time zone of the flag of a verb, or else that of the configuration file or the home file.
pub fn of_matches(mut matches: &ArgMatches) -> Option<LocalTime> {
    while let Some((_, inner)) = matches.subcommand() {
        matches = inner;
    }
    let of_flag = matches.try_get_one::<LocalTime>("time_zone").ok().flatten().cloned();
    let files = ["file", "home"].into_iter().filter_map(|id| matches.try_get_one::<PathBuf>(id).ok().flatten());
    let of_file = |file: &PathBuf| local_time(&Config::read(file).ok()?.time_zone?).ok();
    of_flag.or_else(|| files.into_iter().find_map(of_file))
}

/// Returns the error of a time without a time scale with the same time in a time zone. Other errors are returned
/// unchanged.
pub fn with_offset(error: anyhow::Error, zone: &LocalTime) -> anyhow::Error {
    let without_scale =
        error.downcast_ref::<streakcast::Error>().filter(|error| error.kind() == ErrorKind::NoTimeScale);
    let Some((place, given)) = without_scale.and_then(|error| Some((error.place(), error.given()?))) else {
        return error;
    };
    let place = if place.is_empty() { String::new() } else { format!("{place}: ") };
    let given = given.trim();
    // A Julian date has no offset.
    let (Ok(local), Err(_)) = (parse_instant(given, Some(TimeScale::UTC)), given.parse::<f64>()) else { return error };
    let utc = |ahead_h: f64| seconds_after(local, -3600.0 * ahead_h);
    // Offsets a day before and after: both are those of the time where clocks are set back, and neither where they are
    // set forward.
    let mut offsets: Vec<f64> = [24.0, -24.0].map(|hours| zone.ahead_of_utc_h(utc(hours))).to_vec();
    offsets.dedup();
    offsets.retain(|offset_h| zone.ahead_of_utc_h(utc(*offset_h)) == *offset_h);
    // An offset follows a time of day.
    let midnight = if given.contains([':', 'T']) { "" } else { "T00:00" };
    let given = Quoted::new(given);
    let with_offset = |offset_h: &f64| {
        let text = zone.text(utc(*offset_h), 1.0);
        format!("{given}{midnight}{}", text.rsplit(' ').next().unwrap_or_default())
    };
    let local = match &offsets[..] {
        [] => "another local time (clocks are set forward at this one),".to_owned(),
        [one] => format!("{} for local time in the given time zone,", with_offset(one)),
        several => {
            let several: Vec<String> = several.iter().map(with_offset).collect();
            format!("{} for local time in the given time zone, which has this one twice,", several.join(" or "))
        }
    };
    anyhow!(
        "{place}time '{given}' has no time scale; allowed: {local} a time that ends in Z (UTC), or any time with --time-scale utc, \
         tai or tt"
    )
}

/// Parses a time zone by its name in the IANA database (`Europe/Madrid`), or an offset from UTC in hours ahead
/// (`+01:00`, `-4:30`, `+5`, `5.75`, `Z`). The database is that compiled into the program.
pub fn local_time(text: &str) -> Result<LocalTime, String> {
    let hours = if text.eq_ignore_ascii_case("z") { Some(0.0) } else { signed_hours(text) };
    let zone = match hours {
        Some(hours) if (-MAX_UTC_OFFSET_H..=MAX_UTC_OFFSET_H).contains(&hours) => {
            Offset::from_seconds((hours * 3600.0).round() as i32).ok().map(TimeZone::fixed)
        }
        Some(_) => None,
        None => TimeZone::get(text).ok(),
    };
    zone.map(LocalTime).ok_or_else(|| {
        "not a time zone; allowed: a name of the IANA database, for example Europe/Madrid, or hours ahead of UTC from \
         -14:00 to +14:00, for example +01:00 or -4.5"
            .to_owned()
    })
}

fn signed_hours(text: &str) -> Option<f64> {
    let (sign, rest) = match (text.strip_prefix('+'), text.strip_prefix(['-', '\u{2212}'])) {
        (Some(rest), _) => (1.0, rest),
        (_, Some(rest)) => (-1.0, rest),
        _ => (1.0, text),
    };
    let (hours, minutes) = rest.split_once(':').unwrap_or((rest, "0"));
    let whole = |text: &str| text.parse::<u8>().ok().filter(|_| text.bytes().all(|byte| byte.is_ascii_digit()));
    if let Some(hours) = whole(hours) {
        return Some(sign * (f64::from(hours) + f64::from(whole(minutes).filter(|minutes| *minutes < 60)?) / 60.0));
    }
    // A number with a decimal point has no minutes part.
    let is_decimal = rest.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    rest.parse::<f64>().ok().filter(|_| is_decimal).map(|hours| sign * hours)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Local time minus UTC at noon UTC of a date, hours.
    fn offset_h(text: &str, (year, month, day): (i32, u8, u8)) -> Option<f64> {
        local_time(text).ok().map(|zone| zone.ahead_of_utc_h(Epoch::from_gregorian_utc_at_noon(year, month, day)))
    }

    #[test]
    fn offsets_of_clocks() {
        for (text, hours) in [
            ("+01:00", 1.0),
            ("-4", -4.0),
            ("5:45", 5.75),
            ("Z", 0.0),
            ("-03:30", -3.5),
            ("+14:00", 14.0),
            ("-4.5", -4.5),
        ] {
            assert_eq!(offset_h(text, (2026, 7, 1)), Some(hours), "{text}");
        }
        for text in ["", "+", "+15:00", "+1:60", "1:2:3", "+-1", "1.5:30", "inf", "1e0", "14.1", "Europe", "Atlantis"] {
            assert!(local_time(text).is_err(), "{text}");
        }
    }

    /// Summer time in the European Union ends at 01:00 UTC on the last Sunday of October (Directive 2000/84/EC).
    #[test]
    fn changes_of_the_clocks_within_a_night() {
        let zone = local_time("Europe/Zurich").unwrap();
        let noon = |day| Epoch::from_gregorian_utc_at_noon(2026, 10, day);
        let change = Epoch::from_gregorian_utc_hms(2026, 10, 25, 1, 0, 0);
        assert_eq!(zone.changes(noon(24), noon(25)), [(change, 1.0)]);
        assert!(zone.changes(noon(25), noon(26)).is_empty());
        assert!(local_time("+02:00").unwrap().changes(noon(24), noon(25)).is_empty());
    }

    /// Offsets of summer and of standard time, also in the hours after a change of the clocks.
    #[test]
    fn times_without_scale_are_shown_with_their_offset() {
        let zone = local_time("Europe/Zurich").unwrap();
        for (given, with_offset_of) in [
            ("2026-04-25T22:00", "2026-04-25T22:00+02:00"),
            ("2026-01-25 22:00:30", "2026-01-25 22:00:30+01:00"),
            ("2026-03-29T03:30", "2026-03-29T03:30+02:00"),
            ("2026-03-29T01:30", "2026-03-29T01:30+01:00"),
        ] {
            let error = parse_instant(given, None).unwrap_err();
            let text = with_offset(error.into(), &zone).to_string();
            assert!(text.contains(&format!("allowed: {with_offset_of} for local time")), "{text}");
        }
        for (given, words) in [
            ("2026-10-25T02:30", "allowed: 2026-10-25T02:30+02:00 or 2026-10-25T02:30+01:00 for local time"),
            ("2026-03-29T02:30", "clocks are set forward"),
        ] {
            let error = parse_instant(given, None).unwrap_err();
            let text = with_offset(error.into(), &zone).to_string();
            assert!(text.contains(words), "{text}");
        }
        for other in ["61000.5", "x"] {
            let error = parse_instant(other, None).unwrap_err();
            assert_eq!(with_offset(anyhow!(error.clone()), &zone).to_string(), error.to_string());
        }
    }

    /// The rules of these zones are published by their governments; Chile's summer time is that of the southern
    /// hemisphere.
    #[test]
    fn zones_change_to_summer_time() {
        for (name, january_h, july_h) in [
            ("Europe/Madrid", 1.0, 2.0),
            ("atlantic/canary", 0.0, 1.0),
            ("America/Santiago", -3.0, -4.0),
            ("Pacific/Honolulu", -10.0, -10.0),
            ("Asia/Kathmandu", 5.75, 5.75),
        ] {
            assert_eq!(offset_h(name, (2026, 1, 15)), Some(january_h), "{name}");
            assert_eq!(offset_h(name, (2026, 7, 15)), Some(july_h), "{name}");
        }
    }
}

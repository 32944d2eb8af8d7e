//! System clock, and command line words that stand for the present time.

use std::ffi::OsString;
use std::time::SystemTime;

use hifitime::Epoch;
use streakcast::config::Config;
use streakcast::frames::{EopTable, Orientation, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::output::format_utc;
use streakcast::schedule::evening_mjd;

/// Returns the present time.
pub fn now() -> Epoch {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    // Unix time has days of 86,400 s, without leap seconds.
    Epoch::from_unix_seconds(since_1970.as_secs_f64())
}

/// Replaces `now` after `--start`, `--end` and `--times` by the present time in whole seconds, and `-` after
/// `--schedule` by the path of standard input.
pub fn expand(words: impl IntoIterator<Item = OsString>, now: Epoch) -> Vec<OsString> {
    let value_of = |flag: &str, value: &str| match (flag, value) {
        ("--start" | "--end" | "--times", "now") => Some(format_utc(now, 0)),
        ("--schedule", "-") => Some("/dev/stdin".to_owned()),
        _ => None,
    };
    let mut expanded: Vec<OsString> = Vec::new();
    for word in words {
        let is_flag = |word: &&OsString| word.to_str().is_some_and(|word| word.starts_with('-'));
        // `--times` takes several values.
        let times = expanded.iter().rfind(is_flag).filter(|flag| *flag == "--times");
        let flag = times.or(expanded.last()).and_then(|flag| flag.to_str());
        let other = word.to_str().and_then(|text| match text.split_once('=') {
            Some((flag, value)) => value_of(flag, value).map(|value| format!("{flag}={value}")),
            None => value_of(flag?, text),
        });
        expanded.push(other.map_or(word, OsString::from));
    }
    expanded
}

/// Replaces the night `tonight` by the date of its evening: of the present night if the Sun is below the horizon of the
/// site, and of the next one if it is above.
///
/// # Errors
/// The site of the configuration is missing or invalid.
pub fn set_tonight<'a>(nights: impl IntoIterator<Item = &'a mut String>, config: &Config) -> anyhow::Result<()> {
    for night in nights {
        if night == "tonight" {
            *night = tonight(&config.site()?, now());
        }
    }
    Ok(())
}

fn tonight(site: &Site, now: Epoch) -> String {
    let observer = Observer::new(site.clone());
    let state = observer.state(&Orientation::at(now, &EopTable::embedded()));
    let is_day = state.sun_altitude_azimuth_rad(now).is_some_and(|(altitude, _)| altitude > 0.0);
    // By day, the time twelve hours later belongs to the next night, both before and after noon.
    date_of(evening_mjd(if is_day { seconds_after(now, 43_200.0) } else { now }, site.longitude_rad))
}

/// Returns the date of an evening, for example 2024-08-13, from its MJD.
pub fn date_of(evening_mjd: i64) -> String {
    let mut text = format_utc(Epoch::from_mjd_utc(evening_mjd as f64), 0);
    text.truncate(10);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_tonight_is_the_night_that_is_or_comes() {
        // San Francisco, 8 h behind UTC. The Sun rises at 7 h and sets at 17 h.
        let site = Site::new_deg("San Francisco", 37.8, -122.4, 0.0).unwrap();
        for (day, hour, evening) in
            [(26, 2, "11-25"), (26, 14, "11-25"), (26, 16, "11-26"), (26, 23, "11-26"), (27, 6, "11-26")]
        {
            let now = Epoch::from_gregorian_utc_hms(2026, 11, day, hour, 0, 0);
            assert_eq!(tonight(&site, now), format!("2026-{evening}"), "{now}");
        }
    }

    #[test]
    fn verif_words_for_the_time_and_standard_input() {
        let now = Epoch::from_gregorian_utc_hms(2026, 11, 25, 13, 5, 7);
        let words = "streakcast passes --start now --end=now --schedule - --schedule=- --name now -o - --start 2026-01-01 --times 2026-01-01 now -o now";
        let expanded = expand(words.split(' ').map(OsString::from), now);
        let text = expanded.iter().map(|word| word.to_str().unwrap()).collect::<Vec<_>>().join(" ");
        let at = "2026-11-25T13:05:07Z";
        assert_eq!(
            text,
            format!(
                "streakcast passes --start {at} --end={at} --schedule /dev/stdin --schedule=/dev/stdin --name now -o - --start 2026-01-01 --times 2026-01-01 {at} -o now"
            )
        );
    }
}

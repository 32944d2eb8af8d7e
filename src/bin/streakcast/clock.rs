//! System clock, and command line words that stand for the present time.

use std::ffi::OsString;
use std::time::SystemTime;

use hifitime::Epoch;
use streakcast::config::Config;
use streakcast::frames::{EopTable, Orientation, mjd_utc, parse_instant, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::output::format_utc;
use streakcast::schedule::evening_mjd;

use crate::local_time::LocalTime;

/// Word for the present night, or the next one by day.
pub const TONIGHT: &str = "tonight";

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
        ("--start" | "--end", "now") => Some(format_utc(now, 0)),
        ("--times", list) if list.split(',').any(|time| time == "now") => {
            let times = list.split(',').map(|time| if time == "now" { format_utc(now, 0) } else { time.to_owned() });
            Some(times.collect::<Vec<_>>().join(","))
        }
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
        if night == TONIGHT {
            *night = night_at(&config.site()?, now());
        }
    }
    Ok(())
}

/// Replaces the date of an evening by that of local mean time, and `tonight` by such a date. Returns a remark where the
/// civil date may be another one and `zone` is omitted, or where `zone` does not fit the longitude.
///
/// # Errors
/// The site of the configuration is missing or invalid.
pub fn set_night(
    night: &mut Option<String>,
    config: &Config,
    zone: Option<&LocalTime>,
) -> anyhow::Result<Option<String>> {
    let remark = match zone {
        Some(zone) => {
            let noon = night.as_deref().and_then(noon_of).unwrap_or_else(now);
            // A missing or invalid site is reported below.
            let remark = config.site().ok().and_then(|site| zone_remark(zone, &site, noon));
            if night.as_deref() != Some(TONIGHT) {
                set_civil_night(night, config, zone)?;
            }
            remark
        }
        None => date_line_remark(night.as_deref(), config).map(|remark| format!("{remark}; specify --time-zone")),
    };
    set_tonight(night, config)?;
    Ok(remark)
}

/// Replaces the date of an evening by that of local mean time, by which nights are counted, where the civil date of a
/// time zone differs from it by a day: beyond the date line, for example in Tonga.
///
/// # Errors
/// The site of the configuration is missing or invalid.
pub fn set_civil_night(night: &mut Option<String>, config: &Config, zone: &LocalTime) -> anyhow::Result<()> {
    // An invalid date is reported when the night is computed.
    if let Some(noon) = night.as_deref().and_then(noon_of) {
        *night = Some(date_of(mean_evening_mjd(noon, &config.site()?, Some(zone))));
    }
    Ok(())
}

/// Returns the MJD of the evening in local mean time, from noon UTC of its date in a time zone.
pub fn mean_evening_mjd(noon: Epoch, site: &Site, zone: Option<&LocalTime>) -> i64 {
    mjd_utc(noon).floor() as i64 - zone.map_or(0, |zone| civil_days(noon, site, zone))
}

/// Returns the date of an evening in a time zone, from that of local mean time.
pub fn civil_date(mean_night: &str, site: &Site, zone: Option<&LocalTime>) -> String {
    match (noon_of(mean_night), zone) {
        (Some(noon), Some(zone)) => date_of(noon.to_mjd_utc_days().floor() as i64 + civil_days(noon, site, zone)),
        _ => mean_night.to_owned(),
    }
}

/// Returns noon UTC of a date; `None` for another text.
fn noon_of(date: &str) -> Option<Epoch> {
    parse_instant(&format!("{date}T12:00:00Z"), None).ok()
}

/// Returns the civil date minus the date of local mean time, days.
fn civil_days(noon: Epoch, site: &Site, zone: &LocalTime) -> i64 {
    let mean_h = site.longitude_rad.to_degrees() / 15.0;
    ((zone.ahead_of_utc_h(noon) - mean_h) / 24.0).round() as i64
}

/// Returns a remark about a time zone whose time differs by hours from that of the Sun at a site: zone or longitude may
/// be wrong. `None` if they agree.
pub fn zone_remark(zone: &LocalTime, site: &Site, epoch: Epoch) -> Option<String> {
    /// Largest difference of civil and solar time, hours. In the west of China it is 3.1 h; beyond the date line a day
    /// is added.
    const LARGEST_H: f64 = 3.5;
    let signed_deg = (site.longitude_rad.to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
    let (zone_h, mean_h) = (zone.ahead_of_utc_h(epoch), signed_deg / 15.0);
    let apart_h = ((zone_h - mean_h + 12.0).rem_euclid(24.0) - 12.0).abs();
    (apart_h > LARGEST_H).then(|| {
        format!(
            "the time zone is UTC{zone_h:+.1} h, but solar time at the longitude {signed_deg:.4} deg is UTC{mean_h:+.1} h: one \
             of them may be wrong"
        )
    })
}

/// Returns a remark about the date of a night at sites whose civil date may be that of the other side of the date line.
pub fn date_line_remark(night: Option<&str>, config: &Config) -> Option<String> {
    let (night, site) = (night?, config.site().ok()?);
    let (latitude_deg, longitude_deg) = (site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees());
    // Kiribati, Tonga, Samoa, Tokelau, Wallis, the Chathams and the Kermadecs; Chukotka; the western Aleutians.
    let is_west = longitude_deg < -165.0 && !(16.0..64.0).contains(&latitude_deg)
        || (-162.0..-149.0).contains(&longitude_deg) && (-12.0..6.0).contains(&latitude_deg);
    let is_east = longitude_deg > 171.5 && latitude_deg > 50.0;
    (is_west || is_east).then(|| {
        format!(
            "night {night} is the evening of this date in local mean time (UTC{:+.1} h); the civil date may differ by a day \
             beyond the date line",
            longitude_deg / 15.0
        )
    })
}

/// Returns the date of the evening of the night at a time, or by day of the next night.
pub fn night_at(site: &Site, now: Epoch) -> String {
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

    /// Evenings in Tonga (UTC+13 at 175.2° W), in the Line Islands (UTC+14 at 157° W), on the western Aleutians (UTC-10
    /// at 174° E), and in Hawaii and New Zealand, where the civil date is that of the longitude.
    #[test]
    fn nights_beyond_the_date_line() {
        for (lon, lat, zone, mean_night, is_stated) in [
            (-175.2, -21.2, "Pacific/Tongatapu", "2026-08-21", true),
            (-157.4, 1.9, "Pacific/Kiritimati", "2026-08-21", true),
            (174.1, 52.7, "America/Adak", "2026-08-23", true),
            (-155.5, 19.8, "Pacific/Honolulu", "2026-08-22", false),
            (170.5, -44.0, "Pacific/Auckland", "2026-08-22", false),
            (2.0, 41.0, "Europe/Madrid", "2026-08-22", false),
        ] {
            let config = Config::from_toml(&format!("lat = {lat:?}\nlon = {lon:?}"), "t.toml").unwrap();
            let mut night = Some("2026-08-22".to_owned());
            set_civil_night(&mut night, &config, &crate::local_time::local_time(zone).unwrap()).unwrap();
            assert_eq!(night.as_deref(), Some(mean_night), "{zone}");
            let local = crate::local_time::local_time(zone).unwrap();
            assert_eq!(civil_date(mean_night, &config.site().unwrap(), Some(&local)), "2026-08-22", "{zone}");
            assert_eq!(date_line_remark(Some("2026-08-22"), &config).is_some(), is_stated, "{zone}");
        }
    }

    #[test]
    fn verif_tonight_is_the_night_that_is_or_comes() {
        // San Francisco, 8 h behind UTC. The Sun rises at 7 h and sets at 17 h.
        let site = Site::new_deg("San Francisco", 37.8, -122.4, 0.0).unwrap();
        for (day, hour, evening) in
            [(26, 2, "11-25"), (26, 14, "11-25"), (26, 16, "11-26"), (26, 23, "11-26"), (27, 6, "11-26")]
        {
            let now = Epoch::from_gregorian_utc_hms(2026, 11, day, hour, 0, 0);
            assert_eq!(night_at(&site, now), format!("2026-{evening}"), "{now}");
        }
    }

    #[test]
    fn verif_words_for_the_time_and_standard_input() {
        let now = Epoch::from_gregorian_utc_hms(2026, 11, 25, 13, 5, 7);
        let words = "streakcast passes --start now --end=now --schedule - --schedule=- --name now -o - --start 2026-01-01 --times 2026-01-01 now -o now --times=now,2026-01-01";
        let expanded = expand(words.split(' ').map(OsString::from), now);
        let text = expanded.iter().map(|word| word.to_str().unwrap()).collect::<Vec<_>>().join(" ");
        let at = "2026-11-25T13:05:07Z";
        assert_eq!(
            text,
            format!(
                "streakcast passes --start {at} --end={at} --schedule /dev/stdin --schedule=/dev/stdin --name now -o - --start 2026-01-01 --times 2026-01-01 {at} -o now --times={at},2026-01-01"
            )
        );
    }
}

//! Passes as an iCalendar (RFC 5545): one event a pass, in UTC, which every calendar shows in local time.
//!
//! Lines end in CR LF and are folded at 75 octets (section 3.1), text is escaped (section 3.3.11), and an event's UID is the same in every run.

use hifitime::Epoch;

use super::pass_table::PassRow;
use super::readable::compass;
use crate::geometry::Site;
use crate::output::format_utc;
use crate::passes::TrackPoint;

/// Octets of a line, its end apart.
const LINE: usize = 75;

/// A night without a pass, and why.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct EmptyNight<'a> {
    /// First moment asked about.
    pub start: Epoch,
    /// Last moment asked about.
    pub end: Epoch,
    /// In words, as [`Forecast::why_empty`](super::Forecast::why_empty).
    pub why: &'a str,
}

/// The visible passes as a calendar; `made` is when, and `alarm_s` how long before an event an alarm goes off, where one is wanted.
///
/// An event lasts from the whole second in which the visible part begins to the one after it ends. A calendar must hold one component at least (RFC
/// 5545, section 3.6): of an `empty` night that is one event over all of the time, which takes none of it, with the reason in words.
pub fn calendar<'a>(
    rows: impl IntoIterator<Item = PassRow<'a>>,
    site: &Site,
    made: Epoch,
    alarm_s: Option<f64>,
    empty: Option<EmptyNight<'_>>,
) -> String {
    let mut text = String::new();
    let mut line = |content: String| fold(&mut text, &content);
    line("BEGIN:VCALENDAR".into());
    line("VERSION:2.0".into());
    line(format!("PRODID:-//streakcast//streakcast {}//EN", env!("CARGO_PKG_VERSION")));
    line("CALSCALE:GREGORIAN".into());
    line("METHOD:PUBLISH".into());
    for row in rows {
        let Some(seen) = &row.pass.visible else { continue };
        let light = row.peak().and_then(|peak| peak.brightness.as_ref());
        let magnitude = light.map_or("no magnitude".to_owned(), |light| {
            format!("mag {:.1} \u{b1} {:.1}", light.magnitude.0, light.sigma_mag)
        });
        line("BEGIN:VEVENT".into());
        line(format!("UID:{}-{}@streakcast", row.pass.norad_id, stamp(row.pass.culmination.epoch)));
        line(format!("DTSTAMP:{}", stamp(made)));
        line(format!("DTSTART:{}", stamp(seen.begin.epoch)));
        line(format!("DTEND:{}", stamp(crate::frames::seconds_after(seen.end.epoch, 1.0))));
        line(format!("SUMMARY:{}", escaped(&format!("{} {magnitude}", row.name()))));
        let mut told = vec![
            point("starts", &seen.begin),
            point("highest", &seen.highest),
            format!("{} ({})", point("ends", &seen.end), row.ends_by().unwrap_or_default()),
        ];
        told.extend(row.peak().map(|peak| point("brightest", peak)));
        told.extend(light.map(|light| format!("magnitude from {}", light.source)));
        told.push(format!("elements {:.1} days old", row.pass.element_age_days));
        line(format!("DESCRIPTION:{}", escaped(&told.join("\n"))));
        line(format!("LOCATION:{}", escaped(&site.name)));
        line(format!("GEO:{:.6};{:.6}", site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees()));
        line("TRANSP:TRANSPARENT".into());
        if let Some(alarm_s) = alarm_s {
            line("BEGIN:VALARM".into());
            line("ACTION:DISPLAY".into());
            line(format!("TRIGGER:-PT{:.0}S", alarm_s.max(0.0)));
            line(format!("DESCRIPTION:{}", escaped(&row.name())));
            line("END:VALARM".into());
        }
        line("END:VEVENT".into());
    }
    if let Some(EmptyNight { start, end, why }) = empty {
        line("BEGIN:VEVENT".into());
        line(format!("UID:none-{}-{}@streakcast", stamp(start), stamp(end)));
        line(format!("DTSTAMP:{}", stamp(made)));
        line(format!("DTSTART:{}", stamp(start)));
        line(format!("DTEND:{}", stamp(crate::frames::seconds_after(end, 1.0))));
        line(format!("SUMMARY:{}", escaped(&format!("No satellite to be seen over {}", site.name))));
        line(format!("DESCRIPTION:{}", escaped(why)));
        line(format!("LOCATION:{}", escaped(&site.name)));
        line("TRANSP:TRANSPARENT".into());
        line("END:VEVENT".into());
    }
    line("END:VCALENDAR".into());
    text
}

fn point(what: &str, point: &TrackPoint) -> String {
    let (altitude_rad, azimuth_rad) = (point.altitude_rad.unwrap_or(f64::NAN), point.azimuth_rad.unwrap_or(f64::NAN));
    let clock = format_utc(point.epoch, 0);
    format!("{what} {} UTC, altitude {:.0}\u{b0}, {}", &clock[11..19], altitude_rad.to_degrees(), compass(azimuth_rad))
}

/// `20240814T003000Z`, whole seconds cut.
fn stamp(epoch: Epoch) -> String {
    // A second that is cut and not rounded: 23:59:59.9 is still that day.
    format_utc(epoch, 9).chars().take(19).filter(|mark| !matches!(mark, '-' | ':')).chain(['Z']).collect()
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for mark in text.chars() {
        match mark {
            '\\' | ';' | ',' => out.extend(['\\', mark]),
            '\n' => out.push_str("\\n"),
            mark if mark.is_control() => out.push(' '),
            mark => out.push(mark),
        }
    }
    out
}

/// Appends a content line, broken between characters where it is longer than 75 octets; what follows begins with a blank that counts.
fn fold(text: &mut String, content: &str) {
    let mut room = LINE;
    for mark in content.chars() {
        if mark.len_utf8() > room {
            text.push_str("\r\n ");
            room = LINE - 1;
        }
        text.push(mark);
        room -= mark.len_utf8();
    }
    text.push_str("\r\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_folded_between_characters_and_unfold_to_themselves() {
        for content in ["short".to_owned(), "x".repeat(75), "x".repeat(76), "\u{b0}".repeat(200), "a\u{b1}".repeat(60)]
        {
            let mut text = String::new();
            fold(&mut text, &content);
            assert!(text.ends_with("\r\n"));
            assert!(text.split("\r\n").all(|line| line.len() <= LINE), "{text:?}");
            assert_eq!(text.trim_end().replace("\r\n ", ""), content);
        }
    }

    #[test]
    fn text_is_escaped_and_seconds_are_cut() {
        assert_eq!(escaped("a;b,c\\d\ne\u{7}"), "a\\;b\\,c\\\\d\\ne ");
        assert_eq!(stamp(Epoch::from_gregorian_utc(2024, 8, 14, 23, 59, 59, 999_000_000)), "20240814T235959Z");
    }
}

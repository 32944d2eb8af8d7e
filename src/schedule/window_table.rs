//! Clear windows as tables and in the formats of observatory schedulers.

use hifitime::{Duration, Epoch, TimeScale};
use serde_json::{Value as Json, json};

use crate::frames::{seconds_after, seconds_between};
use crate::output::{Column, Kind, Table, csv_cell, format_utc};
use crate::passes::Sky;

use super::targets::ListedTarget;
use super::windows::{ClearWindow, TargetWindows};

/// One target with its windows.
#[derive(Copy, Clone)]
pub struct FoundWindows<'a> {
    /// Row of the target list.
    pub listed: &'a ListedTarget,
    /// Windows of the target; `None` if the row is invalid.
    pub found: Option<&'a TargetWindows>,
    /// True for a telescope in orbit.
    pub is_in_orbit: bool,
}

impl FoundWindows<'_> {
    /// Returns the windows; none for an invalid row.
    pub fn windows(&self) -> &[ClearWindow] {
        self.found.map_or(&[], |found| &found.windows)
    }

    /// Returns the reason why the target has no window, or why some starts are unknown; `None` if it has all windows.
    pub fn reason(&self) -> Option<String> {
        match (&self.listed.target, self.found) {
            (Err(reason), _) => Some(reason.clone()),
            (Ok(_), Some(found)) if found.observable.is_empty() => {
                let state = match self.is_in_orbit {
                    true => "above the Earth's limb and within the limits of the telescope",
                    false => "above the lowest altitude in the dark",
                };
                Some(match found.longest_s > 0.0 {
                    true => format!(
                        "the exposure of {} s is longer than the time of the range in which the target is {state}: {:.0} s without a break",
                        self.duration_s(),
                        found.longest_s.floor()
                    ),
                    false => format!("never {state}"),
                })
            }
            (Ok(_), Some(TargetWindows { windows, unknown: None, .. })) => {
                windows.is_empty().then(|| "never clear".to_owned())
            }
            (Ok(_), Some(TargetWindows { windows, unknown: Some(why), .. })) => {
                let what = if windows.is_empty() { "unknown" } else { "some starts are unknown" };
                Some(format!("{what}: {why}"))
            }
            (Ok(_), None) => None,
        }
    }

    fn duration_s(&self) -> f64 {
        self.listed.target.as_ref().map_or(f64::NAN, |target| target.exposure.duration_s)
    }
}

/// Returns a table with one row for each window.
///
/// Columns: `name, unique_id, first_start_utc, last_start_utc, length_s, ra_deg, dec_deg, exposure_s,
/// elements_age_days, late_s`. The last two are medians over all satellites of `sky`, whose positions determine the
/// windows.
pub fn window_table(all: &[FoundWindows<'_>], sky: &Sky) -> Table {
    let rows = all.iter().flat_map(|target| {
        target.windows().iter().map(move |window| {
            let known = sky.predictability(window.first, None);
            let pointing = target.listed.target.as_ref().map(|target| target.exposure.pointing).ok();
            vec![
                target.listed.name.as_str().into(),
                target.listed.unique_id.as_str().into(),
                window.first.into(),
                window.last.into(),
                seconds_between(window.first, window.last).into(),
                pointing.map(|pointing| pointing.longitude_rad().to_degrees()).into(),
                pointing.map(|pointing| pointing.latitude_rad().to_degrees()).into(),
                target.duration_s().into(),
                Some(known.element_age_days).filter(|age_days| age_days.is_finite()).into(),
                known.late_s.into(),
            ]
        })
    });
    let time = |name, description| Column { kind: Kind::Time { decimals: 3 }, ..Column::time(name, description) };
    Table {
        columns: vec![
            Column::new("name", Kind::Text, "The list's name of the target."),
            Column::new(
                "unique_id",
                Kind::Text,
                "Identifier of the target in the scheduler; the name if the list has none.",
            ),
            time("first_start_utc", "Earliest shutter opening of the window."),
            time("last_start_utc", "Latest shutter opening of the window."),
            Column::real("length_s", "s", 3, "Latest less earliest shutter opening."),
            Column::real("ra_deg", "deg", 7, "Right ascension of the field's centre, ICRS."),
            Column::real("dec_deg", "deg", 7, "Declination of the field's centre."),
            Column::real("exposure_s", "s", 3, "Length of the exposure."),
            Column::real("elements_age_days", "d", 2, "Median age of the elements of all satellites at the window."),
            Column::real(
                "late_s",
                "s",
                2,
                "Median lateness of all satellites at the window: 68 % are early or late by at most this time.",
            ),
        ],
        rows: rows.collect(),
    }
}

/// Returns a table with one row for each target.
///
/// Columns: `name, unique_id, n_windows, clear_s, observable_s, n_dodged, reason`.
pub fn window_target_table(all: &[FoundWindows<'_>]) -> Table {
    let sum_s = |windows: &[ClearWindow]| -> f64 {
        windows.iter().map(|window| seconds_between(window.first, window.last)).sum()
    };
    let rows = all.iter().map(|target| {
        vec![
            target.listed.name.as_str().into(),
            target.listed.unique_id.as_str().into(),
            target.windows().len().into(),
            sum_s(target.windows()).into(),
            target.found.map(|found| sum_s(&found.observable)).into(),
            target.found.map_or(0, |found| found.blocking_passes.len()).into(),
            target.reason().into(),
        ]
    });
    Table {
        columns: vec![
            Column::new("name", Kind::Text, "The list's name of the target."),
            Column::new("unique_id", Kind::Text, "Identifier of the target in the scheduler."),
            Column::new("n_windows", Kind::Integer, "Windows found."),
            Column::real("clear_s", "s", 3, "Total length of the windows."),
            Column::real(
                "observable_s",
                "s",
                3,
                "Total length of the shutter openings allowed by the altitudes of target and Sun.",
            ),
            Column::new("n_dodged", Kind::Integer, "Number of passes that block observable times."),
            Column::new(
                "reason",
                Kind::Text,
                "Reason why there is no window, or why some starts are unknown and omitted.",
            ),
        ],
        rows: rows.collect(),
    }
}

/// File format of windows for an observatory scheduler.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum SchedulerFormat {
    /// JSON `windows` of requests for the observation portal of Las Cumbres Observatory (LCO). Each window is long
    /// enough for one request with its overhead. The windows of a request are at least 1 s apart, because the scheduler
    /// joins windows that overlap or touch.
    Lco,
    /// Absolute time constraints of an ESO p2 observation block; the block starts inside one of them.
    EsoP2,
    /// File `custom.csv` of AstroQ with allowed intervals.
    AstroQ,
}

impl SchedulerFormat {
    /// Returns the format with this command line name: `lco`, `eso-p2` or `astroq`.
    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "lco" => Some(SchedulerFormat::Lco),
            "eso-p2" => Some(SchedulerFormat::EsoP2),
            "astroq" => Some(SchedulerFormat::AstroQ),
            _ => None,
        }
    }

    /// Returns the text of the file, and the targets without a window. The file omits these targets, because the
    /// schedulers treat a target without windows as unconstrained.
    ///
    /// `overhead_s` is the time from the start of a request or block to the opening of its shutter (slew, acquisition).
    /// Windows are rounded inwards to the resolution of the format (seconds for LCO and AstroQ, minutes for p2); those
    /// that become empty are omitted.
    pub fn text<'a>(self, all: &[FoundWindows<'a>], overhead_s: f64) -> (String, Vec<&'a ListedTarget>) {
        let (with, without): (Vec<_>, Vec<_>) = all
            .iter()
            .map(|target| (target.listed, self.spans(target, overhead_s)))
            .partition(|(_, spans)| !spans.is_empty());
        (self.written(&with), without.into_iter().map(|(listed, _)| listed).collect())
    }

    fn spans(self, target: &FoundWindows<'_>, overhead_s: f64) -> Vec<(Epoch, Epoch)> {
        let duration_s = target.duration_s();
        match self {
            SchedulerFormat::Lco => apart(&spans(target, [-overhead_s, duration_s], 1.0), overhead_s + duration_s),
            SchedulerFormat::EsoP2 => spans(target, [-overhead_s, -overhead_s], 60.0),
            SchedulerFormat::AstroQ => spans(target, [0.0, duration_s], 1.0),
        }
    }

    fn written(self, all: &[(&ListedTarget, Vec<(Epoch, Epoch)>)]) -> String {
        let json = |spans: &[(Epoch, Epoch)], [from, to]: [&str; 2], text: &dyn Fn(Epoch) -> String| {
            spans.iter().map(|(first, last)| json!({from: text(*first), to: text(*last)})).collect::<Vec<Json>>()
        };
        match self {
            SchedulerFormat::Lco => pretty(&json!({ "requests": all.iter().map(|(listed, spans)| {
                json!({"name": listed.name, "windows": json(spans, ["start", "end"], &|epoch| format_utc(epoch, 0))})
            }).collect::<Vec<_>>() })),
            SchedulerFormat::EsoP2 => {
                pretty(&json!(all.iter().map(|(listed, spans)| {
                let minutes = |epoch: Epoch| format_utc(epoch, 0).chars().take(16).collect::<String>();
                let constraints = json(spans, ["from", "to"], &minutes);
                json!({"name": listed.name, "obId": listed.unique_id, "absoluteTimeConstraints": constraints})
            }).collect::<Vec<_>>()))
            }
            SchedulerFormat::AstroQ => {
                let mut text = "unique_id,starname,start,stop\n".to_owned();
                for (listed, spans) in all {
                    for (start, stop) in spans {
                        let cells = [&listed.unique_id, &listed.name].map(|cell| csv_cell(cell));
                        let time = |epoch| format_utc(epoch, 0).trim_end_matches('Z').to_owned();
                        text += &format!("{},{},{},{}\n", cells[0], cells[1], time(*start), time(*stop));
                    }
                }
                text
            }
        }
    }
}

/// Returns the windows that last at least `least_s`, in order and at least 1 s apart.
///
/// If a window begins less than 1 s after the end of the one before it, its start is moved later. If one of the two
/// windows is too short to lose that time and still last longer than `least_s`, the shorter window is omitted instead.
fn apart(windows: &[(Epoch, Epoch)], least_s: f64) -> Vec<(Epoch, Epoch)> {
    let worth_s = |(start, end): (Epoch, Epoch)| seconds_between(start, end) - least_s;
    let mut found: Vec<(Epoch, Epoch)> = Vec::with_capacity(windows.len());
    'next: for &window in windows.iter().filter(|window| worth_s(**window) >= 0.0) {
        while let Some(&before) = found.last() {
            let free = seconds_after(before.1, 1.0);
            let shared_s = seconds_between(window.0, free);
            if shared_s <= 0.0 {
                break;
            }
            if worth_s(before).min(worth_s(window)) > shared_s {
                found.push((free, window.1));
                continue 'next;
            }
            if worth_s(window) <= worth_s(before) {
                continue 'next;
            }
            found.pop();
        }
        found.push(window);
    }
    found
}

/// Returns windows with `first_add_s` and `last_add_s` (seconds) added to their starts and ends, rounded inwards to
/// multiples of `step_s` in UTC.
fn spans(target: &FoundWindows<'_>, [first_add_s, last_add_s]: [f64; 2], step_s: f64) -> Vec<(Epoch, Epoch)> {
    let nanoseconds = |seconds: f64| (seconds * 1e9).round() as i128;
    let utc = |epoch: Epoch, add_s: f64| {
        epoch.to_duration_in_time_scale(TimeScale::UTC).total_nanoseconds() + nanoseconds(add_s)
    };
    let epoch = |steps: i128| {
        Epoch::from_duration(Duration::from_total_nanoseconds(steps * nanoseconds(step_s)), TimeScale::UTC)
    };
    let step = nanoseconds(step_s);
    target
        .windows()
        .iter()
        .map(|window| {
            let first = -(-utc(window.first, first_add_s)).div_euclid(step);
            (epoch(first), epoch(utc(window.last, last_add_s).div_euclid(step)))
        })
        .filter(|(start, end)| seconds_between(*start, *end) > 0.0)
        .collect()
}

fn pretty(document: &Json) -> String {
    serde_json::to_string_pretty(document).unwrap_or_default() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Direction;
    use crate::frames::parse_instant;
    use crate::passes::Exposure;
    use crate::schedule::WindowTarget;

    fn utc(text: &str) -> Epoch {
        parse_instant(text, None).unwrap()
    }

    #[test]
    fn windows_are_rounded_inwards_and_extended_by_overheads() {
        let exposure = Exposure {
            id: "a".into(),
            start: utc("2000-01-01T00:00:00Z"),
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(1.0, 0.5),
            rotation_rad: 0.0,
        };
        let listed = ListedTarget {
            name: "a, b".into(),
            unique_id: "7".into(),
            target: Ok(WindowTarget { exposure, band: None }),
        };
        let windows = [
            ("2024-08-14T01:00:00.200Z", "2024-08-14T01:05:00.800Z"),
            ("2024-08-14T02:00:10Z", "2024-08-14T02:00:10.5Z"),
        ];
        let found = TargetWindows {
            windows: windows.iter().map(|(a, b)| ClearWindow { first: utc(a), last: utc(b) }).collect(),
            ..TargetWindows::default()
        };
        let all = [FoundWindows { listed: &listed, found: Some(&found), is_in_orbit: false }];
        let json =
            |shape: SchedulerFormat, overhead_s| serde_json::from_str::<Json>(&shape.text(&all, overhead_s).0).unwrap();
        let lco = json(SchedulerFormat::Lco, 0.0);
        assert_eq!(
            lco["requests"][0]["windows"],
            json!([{"start": "2024-08-14T01:00:01Z", "end": "2024-08-14T01:05:30Z"}, {"start": "2024-08-14T02:00:10Z", "end": "2024-08-14T02:00:40Z"}])
        );
        assert_eq!(json(SchedulerFormat::Lco, 90.0)["requests"][0]["windows"][0]["start"], "2024-08-14T00:58:31Z");
        assert_eq!(
            json(SchedulerFormat::EsoP2, 60.0)[0]["absoluteTimeConstraints"],
            json!([{"from": "2024-08-14T01:00", "to": "2024-08-14T01:04"}])
        );
        assert_eq!(
            SchedulerFormat::AstroQ.text(&all, 0.0).0,
            "unique_id,starname,start,stop\n7,\"a, b\",2024-08-14T01:00:01,2024-08-14T01:05:30\n7,\"a, b\",2024-08-14T02:00:10,2024-08-14T02:00:40\n"
        );
    }

    /// The clear starts of a 30 s exposure are 40 s apart. With an overhead of 90 s the windows would overlap; the
    /// scheduler would join them and expose in between.
    #[test]
    fn requests_with_overheads_stay_clear_wherever_they_lie() {
        let at = |seconds: f64| seconds_after(utc("2024-08-14T01:00:00Z"), seconds);
        let clear = [[0.0, 100.0], [140.0, 141.0], [180.4, 400.0], [440.0, 700.3], [760.0, 800.0]];
        let listed = ListedTarget {
            name: "a".into(),
            unique_id: "a".into(),
            target: Ok(WindowTarget {
                exposure: Exposure {
                    id: "a".into(),
                    start: at(0.0),
                    duration_s: 30.0,
                    pointing: Direction::from_lon_lat_rad(1.0, 0.5),
                    rotation_rad: 0.0,
                },
                band: None,
            }),
        };
        let found = TargetWindows {
            windows: clear.map(|[first, last]| ClearWindow { first: at(first), last: at(last) }).to_vec(),
            ..TargetWindows::default()
        };
        let never = TargetWindows::default();
        let all =
            [&found, &never].map(|found| FoundWindows { listed: &listed, found: Some(found), is_in_orbit: false });
        let (text, left_out) = SchedulerFormat::Lco.text(&all, 90.0);
        let document: Json = serde_json::from_str(&text).unwrap();
        assert_eq!((document["requests"].as_array().unwrap().len(), left_out.len()), (1, 1));
        let windows = document["requests"][0]["windows"].as_array().unwrap();
        let seconds = |time: &Json| seconds_between(at(0.0), utc(time.as_str().unwrap()));
        let mut before_s = f64::NEG_INFINITY;
        for window in windows {
            let (start_s, end_s) = (seconds(&window["start"]), seconds(&window["end"]));
            assert!(start_s > before_s && end_s - start_s >= 120.0, "{text}");
            before_s = end_s;
            // The shutter opens 90 s after the start of a request of 120 s.
            for step in 0..=((end_s - start_s - 120.0) as usize) {
                let opens_s = start_s + 90.0 + step as f64;
                assert!(clear.iter().any(|[first, last]| (*first..=*last).contains(&opens_s)), "{opens_s}: {text}");
            }
        }
        assert_eq!(windows.len(), 3, "{text}");
    }
}

//! The table of passes that observers know: date, magnitude, start, highest point and end with time, altitude and direction.

use hifitime::Epoch;

use super::pass_table::PassRow;
use crate::frames::seconds_after;
use crate::output::{Column, Kind, Table, Value, format_utc};
use crate::passes::TrackPoint;

const COLUMNS: [Column; 16] = [
    Column::new("date", Kind::Text, "Local date of the start."),
    Column::new("satellite", Kind::Text, "Name."),
    Column::real("magnitude", "mag", 1, "At the brightest moment."),
    Column::real("sigma", "mag", 1, "One sigma of it."),
    Column::new("start", Kind::Text, "Local time at which it can first be seen."),
    Column::new("start_altitude", Kind::Text, "Altitude there."),
    Column::new("start_azimuth", Kind::Text, "Direction there."),
    Column::new("highest", Kind::Text, "Local time of the highest visible point."),
    Column::new("highest_altitude", Kind::Text, "Altitude there."),
    Column::new("highest_azimuth", Kind::Text, "Direction there."),
    Column::new("end", Kind::Text, "Local time at which it can last be seen."),
    Column::new("end_altitude", Kind::Text, "Altitude there."),
    Column::new("end_azimuth", Kind::Text, "Direction there."),
    Column::new("ends_by", Kind::Text, "set, shadow or dawn."),
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::new("mag_source", Kind::Text, "What the magnitude rests on."),
];

/// Passes for eyes, times by a clock that is `utc_offset_s` ahead of UTC; passes of which nothing can be seen have the times of rise and set.
pub fn readable_table<'a>(rows: impl IntoIterator<Item = PassRow<'a>>, utc_offset_s: f64) -> Table {
    Table { columns: COLUMNS.to_vec(), rows: rows.into_iter().map(|row| cells(&row, utc_offset_s)).collect() }
}

fn cells(row: &PassRow<'_>, utc_offset_s: f64) -> Vec<Value> {
    let pass = row.pass;
    let (begin, highest, end) = match &pass.visible {
        Some(seen) => (Some(&seen.begin), &seen.highest, Some(&seen.end)),
        None => (pass.rise.as_ref(), &pass.culmination, pass.set.as_ref()),
    };
    let clock = |epoch: Epoch| local(epoch, utc_offset_s).1;
    let three = |point: Option<&TrackPoint>| -> [Value; 3] {
        let altitude = |point: &TrackPoint| Some(format!("{:.0}\u{b0}", point.altitude_rad?.to_degrees()));
        [
            point.map(|point| clock(point.epoch)).into(),
            point.and_then(altitude).into(),
            point.and_then(|point| point.azimuth_rad).map(compass).into(),
        ]
    };
    let light = row.peak().and_then(|peak| peak.brightness.as_ref());
    let date = local(begin.unwrap_or(highest).epoch, utc_offset_s).0;
    let mut cells: Vec<Value> = vec![
        date.into(),
        row.name().into(),
        light.map(|light| light.magnitude.0).into(),
        light.map(|light| light.sigma_mag).into(),
    ];
    cells.extend([begin, Some(highest), end].into_iter().flat_map(three));
    cells.push(row.ends_by().unwrap_or("not visible").into());
    cells.push(i64::from(pass.norad_id.0).into());
    cells.push(light.map(|light| light.source.to_string()).into());
    cells
}

/// Date and time of day on a clock that is ahead of UTC.
fn local(epoch: Epoch, utc_offset_s: f64) -> (String, String) {
    let text = format_utc(seconds_after(epoch, utc_offset_s), 0);
    (text.chars().take(10).collect(), text.chars().skip(11).take(8).collect())
}

/// The nearest of the sixteen points of the compass.
pub fn compass(azimuth_rad: f64) -> &'static str {
    const POINTS: [&str; 16] =
        ["N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE", "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"];
    let point = (azimuth_rad.rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU * 16.0).round();
    POINTS[point as usize % 16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_the_compass() {
        for (degrees, point) in [
            (0.0, "N"),
            (11.2, "N"),
            (11.3, "NNE"),
            (95.0, "E"),
            (236.0, "SW"),
            (284.0, "WNW"),
            (359.0, "N"),
            (-90.0, "W"),
        ] {
            assert_eq!(compass(f64::to_radians(degrees)), point, "{degrees}");
        }
    }

    #[test]
    fn clocks_ahead_of_utc_turn_the_date() {
        let epoch = Epoch::from_gregorian_utc(2022, 1, 21, 23, 30, 0, 600_000_000);
        assert_eq!(local(epoch, 3600.0), ("2022-01-22".to_owned(), "00:30:01".to_owned()));
        assert_eq!(local(epoch, -4.5 * 3600.0), ("2022-01-21".to_owned(), "19:00:01".to_owned()));
    }
}

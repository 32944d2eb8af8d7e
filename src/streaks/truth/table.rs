//! Truth tables of injected streaks, with one row per streak or per point, and injection catalogues for Rubin's
//! pipelines.

use super::super::drawn::{DrawnStreak, StreakPoint};
use super::super::light::SourceName;
use crate::images::{effective_magnitude, surface_brightness_mag_arcsec2};
use crate::output::{Column, Kind, Table, Value};

/// Streak with the other data of its row in the truth table.
#[derive(Copy, Clone, Debug)]
pub struct TruthRow<'a> {
    /// Number of the streak in the file, from 1.
    pub number: usize,
    /// The streak.
    pub streak: &'a DrawnStreak<'a>,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Light of the streak above the saturation level or the range of the frame's type, in the frame's unit.
    pub clipped_counts: f64,
    /// Seed of noise and random streaks.
    pub seed: u64,
}

/// Column with the function that returns the value of its cell.
struct Field {
    column: Column,
    value: fn(&TruthRow<'_>) -> Value,
}

const fn field(column: Column, value: fn(&TruthRow<'_>) -> Value) -> Field {
    Field { column, value }
}

static FIELDS: &[Field] = &[
    field(Column::new("streak", Kind::Integer, "Number of the streak in this file, from 1."), |row| row.number.into()),
    field(Column::new("hdu", Kind::Integer, "HDU of the chip, counted from 0."), |row| row.streak.hdu.into()),
    field(Column::new("chip", Kind::Text, "Name of the HDU."), |row| row.streak.chip.into()),
    field(
        Column::new("norad_id", Kind::Integer, "NORAD catalogue number; empty for streaks that are not of satellites."),
        |row| match &row.streak.source.name {
            SourceName::Satellite { norad_id, .. } => i64::from(norad_id.0).into(),
            SourceName::Random(_) | SourceName::Chosen(_) => Value::Null,
        },
    ),
    field(
        Column::new(
            "name",
            Kind::Text,
            "Name in the element set, id in the table of streaks, or number of the random streak.",
        ),
        |row| row.streak.source.name.to_string().into(),
    ),
    field(Column::new("part", Kind::Text, "whole, or chassis and array separately."), |row| row.streak.part.into()),
    field(Column::new("mag_source", Kind::Text, "Source of the magnitude."), |row| {
        row.streak.source.mag_source.as_str().into()
    }),
    field(Column::real("element_age_days", "d", 4, "Time of the exposure less epoch of the elements."), |row| {
        row.streak.source.element_age_days.into()
    }),
    field(Column::time("enter_utc", "Entry into the chip, or end of the umbra."), |row| {
        end(row, 0, |point| point.epoch.into())
    }),
    field(Column::time("exit_utc", "Exit from the chip, or start of the umbra."), |row| {
        end(row, 1, |point| point.epoch.into())
    }),
    field(Column::real("x1_pix", "pix", 3, "Column of the first end; the first pixel's centre is 1."), |row| {
        end(row, 0, |point| point.at.fits()[0].into())
    }),
    field(Column::real("y1_pix", "pix", 3, "Row of the first end."), |row| {
        end(row, 0, |point| point.at.fits()[1].into())
    }),
    field(Column::real("x2_pix", "pix", 3, "Column of the last end."), |row| {
        end(row, 1, |point| point.at.fits()[0].into())
    }),
    field(Column::real("y2_pix", "pix", 3, "Row of the last end."), |row| {
        end(row, 1, |point| point.at.fits()[1].into())
    }),
    field(
        Column::real("ra1_deg", "deg", 7, "Right ascension of the first end, ICRS astrometric topocentric."),
        |row| end(row, 0, |point| ra_deg(row, point)),
    ),
    field(Column::real("dec1_deg", "deg", 7, "Declination of the first end."), |row| {
        end(row, 0, |point| dec_deg(row, point))
    }),
    field(Column::real("ra2_deg", "deg", 7, "Right ascension of the last end."), |row| {
        end(row, 1, |point| ra_deg(row, point))
    }),
    field(Column::real("dec2_deg", "deg", 7, "Declination of the last end."), |row| {
        end(row, 1, |point| dec_deg(row, point))
    }),
    field(Column::real("length_pix", "pix", 3, "Length over the chip, without parts in the umbra."), |row| {
        row.streak.length_pix.into()
    }),
    field(Column::real("angle_deg", "deg", 4, "Direction of motion from the x axis towards the y axis."), |row| {
        row.streak.angle_deg().into()
    }),
    field(Column::real("position_angle_deg", "deg", 4, "Direction of motion from north through east."), |row| {
        row.streak.position_angle_deg().into()
    }),
    field(Column::real("angular_rate_deg_s", "deg / s", 6, "Mean angular speed relative to the stars."), |row| {
        (row.streak.rate_arcsec_s / 3600.0).into()
    }),
    field(
        Column::real(
            "width_pix",
            "pix",
            3,
            "Full width at half maximum across the streak: seeing, defocus, size, pixel.",
        ),
        |row| row.streak.width_pix.into(),
    ),
    field(Column::real("width_arcsec", "arcsec", 3, "Full width at half maximum across the streak."), |row| {
        row.streak.width_arcsec.into()
    }),
    field(
        Column::real("magnitude", "mag", 3, "Apparent magnitude without motion half way; empty without light."),
        |row| row.streak.middle.and_then(|point| point.magnitude).into(),
    ),
    field(Column::real("magnitude_peak", "mag", 3, "Brightest magnitude over the chip."), |row| {
        row.streak.peak_magnitude.into()
    }),
    field(
        Column::real(
            "effective_magnitude",
            "mag",
            3,
            "Magnitude of a star with the surface brightness of the streak half way in the same exposure.",
        ),
        |row| spread(row, effective_magnitude),
    ),
    field(
        Column::real(
            "surface_brightness_mag_arcsec2",
            "mag / arcsec2",
            3,
            "Surface brightness of the streak half way, averaged over the exposure.",
        ),
        |row| {
            spread(row, |magnitude, width, rate, exposure_s| {
                surface_brightness_mag_arcsec2(magnitude, width, rate, exposure_s)
            })
        },
    ),
    field(
        Column::real("counts", "", 3, "Sum of the light on the chip in the frame's unit, before noise and detector."),
        |row| row.streak.patch.sum().into(),
    ),
    field(
        Column::real(
            "clipped_counts",
            "",
            3,
            "Part of counts above the saturation level or the range of the frame's type; the frame does not have it.",
        ),
        |row| row.clipped_counts.into(),
    ),
    field(Column::real("range_km", "km", 3, "Distance half way; empty if the width of the image was given."), |row| {
        row.streak.range_km.into()
    }),
    field(Column::real("size_m", "m", 3, "Diameter of the light; empty if the width of the image was given."), |row| {
        row.streak.size_m.into()
    }),
    field(Column::real("total_magnitude", "mag", 3, "Magnitude of a star with the same counts."), |row| {
        row.streak.total_magnitude().into()
    }),
    field(
        Column::real(
            "zero_point_mag",
            "mag",
            4,
            "Magnitude of a star with an image that sums to 1 in the frame's unit.",
        ),
        |row| row.streak.zero_point_mag.into(),
    ),
    field(Column::new("seed", Kind::Integer, "Seed of noise and random streaks."), |row| {
        i64::try_from(row.seed).unwrap_or(i64::MAX).into()
    }),
];

fn end(row: &TruthRow<'_>, which: usize, value: impl Fn(&StreakPoint) -> Value) -> Value {
    row.streak.ends().map_or(Value::Null, |ends| value(ends[which]))
}

fn ra_deg(row: &TruthRow<'_>, point: &StreakPoint) -> Value {
    row.streak.is_on_sky.then(|| point.direction.longitude_rad().to_degrees()).into()
}

fn dec_deg(row: &TruthRow<'_>, point: &StreakPoint) -> Value {
    row.streak.is_on_sky.then(|| point.direction.latitude_rad().to_degrees()).into()
}

/// Returns a value computed from magnitude, width, rate and exposure time at the middle of the streak.
fn spread(row: &TruthRow<'_>, function: impl Fn(f64, f64, f64, f64) -> f64) -> Value {
    let magnitude = row.streak.middle.and_then(|point| point.magnitude);
    magnitude
        .map(|magnitude| function(magnitude, row.streak.width_arcsec, row.streak.frame_rate_arcsec_s, row.exposure_s))
        .into()
}

/// Returns the rows of the truth, numbered from 1 in the order of the streaks.
///
/// `clipped_counts` are those of each streak.
pub fn truth_rows<'a>(
    streaks: &'a [DrawnStreak<'a>],
    clipped_counts: &[f64],
    exposure_s: f64,
    seed: u64,
) -> Vec<TruthRow<'a>> {
    let row = |((streak, clipped_counts), number): ((&'a DrawnStreak<'a>, &f64), usize)| TruthRow {
        number,
        streak,
        exposure_s,
        clipped_counts: *clipped_counts,
        seed,
    };
    streaks.iter().zip(clipped_counts).zip(1..).map(row).collect()
}

/// Returns the table of streaks, with one row per streak.
pub fn truth_table(rows: &[TruthRow<'_>]) -> Table {
    Table {
        columns: FIELDS.iter().map(|field| field.column).collect(),
        rows: rows.iter().map(|row| FIELDS.iter().map(|field| (field.value)(row)).collect()).collect(),
    }
}

/// Returns the table of points along the streaks, with one row per point.
pub fn points_table(rows: &[TruthRow<'_>]) -> Table {
    let columns = vec![
        Column::new("streak", Kind::Integer, "Number of the streak in this file, from 1."),
        Column::time("utc", "Time of reception."),
        Column::real("x_pix", "pix", 3, "Column; the first pixel's centre is 1."),
        Column::real("y_pix", "pix", 3, "Row."),
        Column::real("ra_deg", "deg", 7, "Right ascension, ICRS astrometric topocentric."),
        Column::real("dec_deg", "deg", 7, "Declination."),
        Column::real("magnitude", "mag", 4, "Apparent magnitude without motion; empty without light."),
        Column::real("counts_s", "1 / s", 4, "Light per second in the frame's unit."),
    ];
    let point = |row: &TruthRow<'_>, point: &StreakPoint| {
        let [x, y] = point.at.fits();
        vec![
            row.number.into(),
            point.epoch.into(),
            x.into(),
            y.into(),
            ra_deg(row, point),
            dec_deg(row, point),
            point.magnitude.into(),
            point.rate.into(),
        ]
    };
    let rows = rows
        .iter()
        .flat_map(|row| row.streak.points.iter().map(move |streak_point| point(row, streak_point)))
        .collect();
    Table { columns, rows }
}

/// Returns the catalogue of trails for Rubin's `source_injection`. Trails have constant brightness; `beta` is their
/// angle in degrees from the x axis towards the y axis of the chip, and `mag` the magnitude of each pixel of their
/// length, because `source_injection` multiplies the flux of `mag` by `trail_length`. A catalogue cannot represent
/// defocus or changes of brightness along a streak.
pub fn trail_table(rows: &[TruthRow<'_>]) -> Table {
    let columns = vec![
        Column::new("injection_id", Kind::Integer, "Number of the streak in the truth."),
        Column::real("ra", "deg", 7, "Right ascension of the middle, ICRS."),
        Column::real("dec", "deg", 7, "Declination of the middle."),
        Column::new("source_type", Kind::Text, "Trail."),
        Column::real("mag", "mag", 4, "Magnitude of each pixel of the trail's length over the whole exposure."),
        Column::real("trail_length", "pix", 3, "Length, pixels."),
        Column::real("beta", "deg", 4, "Angle from the x axis of the frame towards the y axis."),
    ];
    let trail = |row: &TruthRow<'_>| {
        let streak = row.streak;
        let (middle, angle_deg) = (streak.middle.filter(|_| streak.is_on_sky)?, streak.angle_deg()?);
        // As in make_galsim_trail of lsst.source.injection: sum of the counts = flux(mag) × length.
        let mag = streak.zero_point_mag - 2.5 * (streak.patch.sum() / streak.length_pix).log10();
        Some(vec![
            row.number.into(),
            middle.frame_direction.longitude_rad().to_degrees().into(),
            middle.frame_direction.latitude_rad().to_degrees().into(),
            "Trail".into(),
            mag.into(),
            streak.length_pix.into(),
            // A line has no sense of direction, so the angle is reduced to [0, 180) degrees.
            angle_deg.rem_euclid(180.0).into(),
        ])
    };
    Table { columns, rows: rows.iter().filter_map(trail).collect() }
}

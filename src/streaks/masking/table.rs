//! Tables of corridors and of satellites that are left out, and region files.

use std::fmt::{self, Write};

use super::super::frame::TargetFrame;
use super::super::regions::{Region, region_text};
use super::satellites::{FrameMask, LeftOutReason, LeftOutSatellite, MaskedStreak, StreakOrigin};
use crate::frames::{Direction, Gcrs};
use crate::output::{Column, Kind, Table, TableField, Value};

/// Polygon of a corridor, with its frame.
struct PolygonRow<'a> {
    image: &'a str,
    hdu: usize,
    streak: &'a MaskedStreak,
    polygon: &'a [Direction<Gcrs>],
}

const fn text(name: &'static str, description: &'static str) -> Column {
    Column::new(name, Kind::Text, description)
}

/// Returns the columns of corridors.
fn fields<'a>() -> Vec<TableField<PolygonRow<'a>>> {
    vec![
        TableField::new(text("image", "File of the frame."), |row| row.image.into()),
        TableField::new(Column::new("hdu", Kind::Integer, "HDU of the chip, from 0."), |row| row.hdu.into()),
        TableField::new(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |row| {
            i64::from(row.streak.norad_id.0).into()
        }),
        TableField::new(text("name", "Name of the satellite."), |row| Value::nonempty(&row.streak.name)),
        TableField::new(text("origin", "Source of the position: predicted or measured."), |row| {
            match row.streak.origin {
                StreakOrigin::Predicted => "predicted",
                StreakOrigin::Measured => "measured",
            }
            .into()
        }),
        TableField::new(
            Column::time("mid_utc", "Time at which the satellite is nearest to the middle of the chip."),
            |row| row.streak.epoch.into(),
        ),
        TableField::new(
            Column::real("probability", "", 4, "Probability that the satellite is in the frame; 1 if measured."),
            |row| row.streak.probability.into(),
        ),
        TableField::new(Column::real("coverage", "", 4, "Probability that the streak is in the corridor."), |row| {
            row.streak.coverage.into()
        }),
        TableField::new(Column::real("late_from_s", "s", 3, "Smallest delay in the corridor."), |row| {
            row.streak.late_s[0].into()
        }),
        TableField::new(Column::real("late_to_s", "s", 3, "Largest delay in the corridor."), |row| {
            row.streak.late_s[1].into()
        }),
        TableField::new(
            Column::real(
                "across_arcsec",
                "arcsec",
                2,
                "Largest distance from the track in the corridor, without the light.",
            ),
            |row| (row.streak.across_rad.to_degrees() * 3600.0).into(),
        ),
        TableField::new(Column::real("width_arcsec", "arcsec", 2, "Greatest full width of the masked light."), |row| {
            row.streak.width_arcsec.into()
        }),
        TableField::new(
            Column::real("magnitude", "mag", 2, "Predicted magnitude at mid_utc; empty with --width."),
            |row| row.streak.brightness.as_ref().map(|(light, _)| light.magnitude.0).into(),
        ),
        TableField::new(
            Column::real("magnitude_bright", "mag", 2, "Magnitude for which the width is computed, if predicted."),
            |row| row.streak.brightness.as_ref().map(|(_, bright)| *bright).into(),
        ),
        TableField::new(text("mag_source", "Source of the magnitude."), |row| {
            row.streak.brightness.as_ref().map(|(light, _)| light.source.to_string()).into()
        }),
        TableField::new(
            Column::real("peak_to_noise", "", 2, "Light of the brightest pixel, in multiples of the noise of a pixel."),
            |row| row.streak.peak_to_noise.into(),
        ),
        TableField::new(Column::real("element_age_days", "d", 3, "Age of the elements."), |row| {
            row.streak.element_age_days.into()
        }),
        TableField::new(Column::new("pixels", Kind::Integer, "Masked pixels of the satellite on the chip."), |row| {
            row.streak.area.pixels().into()
        }),
        TableField::new(
            text(
                "s_region",
                "Polygon of the corridor (STC-S, as in ObsCore): right ascension and declination, deg, ICRS, \
                 anticlockwise on the sky.",
            ),
            |row| {
                let mut region = "POLYGON ICRS".to_owned();
                for corner in row.polygon {
                    let [ra_deg, dec_deg] = degrees(corner);
                    // Writing to a text does not fail.
                    let _ = write!(region, " {ra_deg:.6} {dec_deg:.6}");
                }
                region.into()
            },
        ),
    ]
}

fn degrees(direction: &Direction<Gcrs>) -> [f64; 2] {
    [direction.longitude_rad().to_degrees().rem_euclid(360.0), direction.latitude_rad().to_degrees()]
}

fn rows<'a>(frame: &'a TargetFrame, image: &'a str, mask: &'a FrameMask) -> impl Iterator<Item = PolygonRow<'a>> {
    mask.streaks.iter().flat_map(move |streak| {
        let hdu = frame.chips[streak.chip].chip.hdu;
        streak.polygons.iter().map(move |polygon| PolygonRow { image, hdu, streak, polygon })
    })
}

/// Returns the corridors of a frame, one row for each polygon; `image` is the name of the frame. A bent corridor has
/// several polygons.
pub fn corridor_table(frame: &TargetFrame, image: &str, mask: &FrameMask) -> Table {
    Table::from_records(&fields(), rows(frame, image, mask))
}

/// Returns the satellites that are left out of the mask of a frame, with the reasons.
pub fn left_out_table(image: &str, left_out: &[LeftOutSatellite]) -> Table {
    let columns = vec![
        text("image", "File of the frame."),
        Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
        text("name", "Name of the satellite."),
        text("reason", "Reason why it is left out."),
    ];
    let row = |satellite: &LeftOutSatellite| {
        vec![
            image.into(),
            i64::from(satellite.norad_id.0).into(),
            Value::nonempty(&satellite.name),
            satellite.reason.to_string().into(),
        ]
    };
    Table { columns, rows: left_out.iter().map(row).collect() }
}

impl fmt::Display for LeftOutReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Faint { peak_to_noise, magnitude } => {
                write!(f, "too faint: at {magnitude:.1} mag, the brightest pixel is {peak_to_noise:.2} of the noise")
            }
            Self::UnknownMagnitude => f.write_str("unknown magnitude"),
            Self::UnknownPosition(reason) => f.write_str(reason),
            Self::NoElements => f.write_str("measured, but without an element set"),
        }
    }
}

/// Returns a region file of SAOImage DS9 with the polygons of several frames.
pub fn region_file<'a>(frames: impl IntoIterator<Item = (&'a TargetFrame, &'a str, &'a FrameMask)>) -> String {
    let regions = frames.into_iter().flat_map(|(frame, image, mask)| {
        rows(frame, image, mask).map(move |PolygonRow { hdu, streak, polygon, .. }| Region {
            corners: polygon.iter().map(degrees).collect(),
            name: streak.norad_id.or_name(&streak.name),
            tag: format!("{image} HDU {hdu}"),
        })
    });
    region_text("mask", "icrs", 6, regions)
}

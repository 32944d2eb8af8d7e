//! `fit reduce`: photometry as pixels of the body frame, or point by point.

use streakcast::fit::RawWeights;
use streakcast::output::Section;

use super::arguments::FitReduceArguments;
use super::points::{provenance, read};
use crate::failure::Outcome;
use crate::output::{Answer, Output};
use crate::screen::{Shown, Style, rounded, shown};

const PIXELS_ON_SCREEN: &[Shown] = &[
    shown("layer", "layer"),
    shown("cell", "cell"),
    rounded("sun_latitude_deg", "Sun deg", 1),
    rounded("observer_longitude_deg", "longitude deg", 1),
    rounded("observer_latitude_deg", "latitude deg", 1),
    rounded("mode_mag", "mode", 2),
    rounded("iqr_mag", "IQR", 2),
    shown("count", "n"),
    shown("kept", "kept"),
];
const POINTS_ON_SCREEN: &[Shown] = &[
    shown("utc", "UTC"),
    shown("norad_id", "NORAD"),
    shown("group", "group"),
    rounded("standard_magnitude", "mag at 1000 km", 2),
    rounded("sun_latitude_deg", "Sun deg", 1),
    rounded("observer_longitude_deg", "longitude deg", 1),
    rounded("observer_latitude_deg", "latitude deg", 1),
];

pub fn reduce(typed: FitReduceArguments) -> anyhow::Result<Outcome> {
    let output = Output::new(typed.output.format.as_deref(), typed.output.output)?;
    #[cfg(feature = "plot")]
    if let Some(picture) = &typed.picture {
        streakcast::plot::PictureFormat::of(picture)?;
        crate::output::check(picture)?;
    }
    let placed = read(&typed.photometry, &typed.reduction, &RawWeights::default())?;
    let dropped = placed.measurements.dropped.table();
    let provenance = provenance(&typed.photometry, &typed.reduction, &placed);
    let (table, name, columns) = match &placed.reduction {
        Some(pixels) => (pixels.table(), "pixels", PIXELS_ON_SCREEN),
        None => (placed.measurements.table(), "measurements", POINTS_ON_SCREEN),
    };
    #[cfg(feature = "plot")]
    if let Some(path) = &typed.picture {
        super::report::pixels_picture(path, placed.reduction.as_ref(), typed.layer)?;
    }
    output.write(&Answer {
        sections: vec![Section { name, table: &table }, Section { name: "dropped", table: &dropped }],
        main: &table,
        provenance: &provenance,
        style: Style { columns, bold_row: None },
    })?;
    Ok(Outcome::Done)
}

//! Photometry as typed, made into points of a fit.

use std::fs;

use anyhow::anyhow;
use streakcast::catalogue::{Catalogue, Keep, ReadOptions as CatalogueOptions, StationRule};
use streakcast::catalogue::History;
use streakcast::fit::{
    FitPoint, FitSettings, Form, Loss, RawWeights, TwoPanelForm, points_of_measurements, points_of_pixels,
};
use streakcast::frames::EopTable;
use streakcast::measured::{
    ColumnMap, DensityMode, DropCounts, Format, Measurements, Place, Placement, ReadOptions, RecordReader, ReduceOptions,
    Reduction, Selection, measure, reduce,
};
use streakcast::photometry::{BrightnessModel, Earthshine, ModelKind, ModelLibrary};
use streakcast::setup::Setup;

use crate::fit_arguments::{FormArguments, LossName, ModeName, PhotometryArguments, ReductionArguments};
use crate::notices::Notices;
use crate::verbs::judged::begin;
use crate::verbs::map::{model_of, site_of};

/// Photometry in its geometry.
pub struct Placed {
    pub measurements: Measurements,
    /// Pixels, unless single measurements were asked for.
    pub reduction: Option<Reduction>,
    /// Points to be fitted.
    pub points: Vec<FitPoint>,
    pub notices: Notices,
}

pub fn read(typed: &PhotometryArguments, reduction: &ReductionArguments) -> anyhow::Result<Placed> {
    let setup = Setup { threads: typed.threads, quiet: Some(typed.quiet), ..typed.place.setup() };
    let notices = begin(&setup)?;
    let columns = typed.columns.as_ref().map(|path| {
        let text = fs::read_to_string(path).map_err(|error| anyhow!("columns {}: {error}", path.display()))?;
        Ok::<_, anyhow::Error>(ColumnMap::from_text(&text)?)
    });
    let options = ReadOptions {
        format: typed.format_name.as_deref().map(Format::by_name).transpose()?,
        columns: columns.transpose()?,
        site: site_of(&setup)?,
        filters: typed.filter.clone(),
        keep_duplicates: typed.keep_duplicates,
    };
    let history = if typed.elements.is_empty() {
        None
    } else {
        let catalogue =
            Catalogue::read(&typed.elements, &CatalogueOptions { keep: Keep::All, ..CatalogueOptions::default() })?;
        Some(History::new(catalogue.into_element_sets()))
    };
    let placement = match &history {
        Some(history) => Placement {
            place: Place::Elements { fit_offset_s: typed.fit_offset_s },
            max_element_age_days: typed.max_element_age_days,
            eop: EopTable::embedded(),
            ..Placement::elements(history)
        },
        None => Placement::recorded(typed.height_km),
    };
    let station = typed.on_station.then(|| StationRule {
        min_height_km: typed.station_height_km,
        max_rate_m_day: typed.station_rate_m_day,
        ..StationRule::default()
    });
    let selection = Selection {
        least_grazing_height_km: Some(typed.least_grazing_km),
        station,
        correct_sun_distance: typed.sun_distance,
        ..Selection::default()
    };
    let mut reader = RecordReader::open(&typed.photometry, &options)?;
    let measurements = measure(&mut reader, &placement, &selection)?;
    tell(&notices, &measurements.dropped, measurements.points.len());
    let (pixels, points) = if reduction.raw_points {
        if !(reduction.scatter_mag > 0.0 && reduction.scatter_mag.is_finite()) {
            return Err(anyhow!("scatter-mag {}; allowed: more than 0", reduction.scatter_mag));
        }
        let weights = RawWeights { scatter_mag: reduction.scatter_mag, by_group: !reduction.equal_weights };
        (None, points_of_measurements(&measurements, &weights))
    } else {
        let pixels = reduce(&measurements.points, reduce_options(reduction))?;
        let points = points_of_pixels(&pixels);
        notices.say(&format!(
            "{} points in {} pixels, {} of them kept ({} points or more, spread of {} mag or less)",
            pixels.points,
            pixels.pixels.len(),
            points.len(),
            reduction.min_count,
            reduction.max_iqr
        ));
        (Some(pixels), points)
    };
    Ok(Placed { measurements, reduction: pixels, points, notices })
}

fn reduce_options(typed: &ReductionArguments) -> ReduceOptions {
    ReduceOptions {
        layer_width_rad: typed.layer_deg.to_radians(),
        nside: typed.nside,
        fold: !typed.no_fold,
        mode: match typed.mode {
            ModeName::HalfSample => DensityMode::HalfSample,
            ModeName::Kernel => DensityMode::Kernel,
        },
        least_count: typed.min_count,
        most_iqr_mag: typed.max_iqr,
    }
}

/// How many rows were used, and why others were not.
fn tell(notices: &Notices, dropped: &DropCounts, used: usize) {
    notices.say(&format!("{used} measurements, {} rows left out", dropped.total()));
    for (reason, count, example) in dropped.iter() {
        let first = example.map(|one| format!(" (first: {one})")).unwrap_or_default();
        notices.say(&format!("  {count} {}{first}", reason.name().replace('_', " ")));
    }
}

/// The model whose form is fitted.
pub struct Fitted {
    pub model: std::sync::Arc<BrightnessModel>,
    pub form: TwoPanelForm,
    pub settings: FitSettings,
}

/// What is fitted, and how.
pub fn form(typed: &FormArguments, raw_points: bool) -> anyhow::Result<Fitted> {
    let model = model_of(&ModelLibrary::embedded(), &typed.model)?;
    let parts = model.file().filter(|file| file.kind == ModelKind::TwoPanel);
    let Some((shape, mut coefficients)) = parts.and_then(|file| Some((file.shape?, file.coefficients?))) else {
        return Err(anyhow!(
            "model {} has no shape to fit; allowed are models of kind two_panel (streakcast model list)",
            typed.model
        ));
    };
    let mut held = Vec::new();
    let mut shape = shape;
    for entry in &typed.hold {
        let parsed = entry.split_once('=').and_then(|(name, value)| Some((name.trim(), value.trim().parse::<f64>().ok()?)));
        let (name, value) = parsed.ok_or_else(|| anyhow!("hold {entry}; allowed: NAME=NUMBER, as c1=0"))?;
        let place = match name {
            "c1" => &mut coefficients.c1,
            "c2" => &mut coefficients.c2,
            "c3" => &mut coefficients.c3,
            "c4" => &mut coefficients.c4,
            "c5" => &mut coefficients.c5,
            "n_sail" => &mut coefficients.n_sail,
            "n_base" => &mut coefficients.n_base,
            "panel_offset_deg" => &mut shape.panel_offset_deg,
            _ => return Err(anyhow!("hold {name}; allowed: c1 to c5, n_sail, n_base, panel_offset_deg")),
        };
        *place = value;
        held.push(name.to_owned());
    }
    let (band, system) = model.band();
    let form = TwoPanelForm {
        shape,
        coefficients,
        earthshine: if typed.no_earthshine { Earthshine::Off } else { Earthshine::Computed },
        blocking: true,
        sun_magnitude: band.sun_magnitude(system),
    };
    for parameter in form.parameters().iter().filter(|parameter| held.contains(&parameter.name)) {
        if !(parameter.least..=parameter.greatest).contains(&parameter.value) {
            let (least, greatest) = (parameter.least, parameter.greatest);
            return Err(anyhow!("hold {}={}; allowed: {least} to {greatest}", parameter.name, parameter.value));
        }
    }
    let mut free = typed.free.clone();
    if free.is_empty() {
        free = streakcast::fit::COEFFICIENTS.iter().map(|&name| name.to_owned()).collect();
    }
    free.retain(|name| !held.contains(name));
    let loss = match typed.loss {
        Some(LossName::Squares) => Loss::Squares,
        Some(LossName::SoftL1) => Loss::SoftL1,
        Some(LossName::Student) => Loss::Student(4.0),
        None if raw_points => Loss::SoftL1,
        None => Loss::Squares,
    };
    Ok(Fitted { model, form, settings: FitSettings { free, loss, ..FitSettings::default() } })
}

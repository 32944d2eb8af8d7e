//! Photometry as typed, made into points of a fit.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use anyhow::anyhow;
use streakcast::catalogue::{Catalogue, Keep, NoradId, ReadOptions as CatalogueOptions, StationRule};
use streakcast::fit::{
    FitPoint, FitSettings, Form, Loss, PANEL_OFFSET, PanelsForm, Parameter, RawWeights, TwoPanelForm,
    points_of_measurements, points_of_pixels,
};
use streakcast::frames::EopTable;
use streakcast::measured::{
    ColumnMap, DensityMode, DropCounts, DropReason, Format, Measurements, Place, Placement, ReadOptions, RecordReader,
    ReduceOptions, Reduction, Selection, measure, reduce,
};
use streakcast::photometry::{Earthshine, ModelFile, ModelLibrary};
use streakcast::setup::Setup;

use crate::fit_arguments::{
    FormArguments, LossName, ModeName, PhotometryArguments, ReductionArguments, WeightArguments,
};
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

impl Placed {
    /// The measurements behind pixels, and how these are made of them: what is held out of fits to pixels.
    pub fn tracks(&self) -> Option<(&Measurements, ReduceOptions)> {
        self.reduction.as_ref().map(|reduction| (&self.measurements, reduction.options))
    }
}

pub fn read(
    typed: &PhotometryArguments,
    reduction: &ReductionArguments,
    weights: &RawWeights,
) -> anyhow::Result<Placed> {
    let setup = Setup { threads: typed.threads, quiet: Some(typed.quiet), ..typed.place.setup() };
    let notices = begin(&setup)?;
    if !(0.01..=180.0).contains(&reduction.layer_deg) {
        return Err(anyhow!("layer-deg {}; allowed: 0.01 to 180", reduction.layer_deg));
    }
    if typed.height_km.is_some() && !typed.elements.is_empty() {
        return Err(anyhow!("--height-km and --elements: the geometry comes from one of them"));
    }
    let columns = typed.columns.as_ref().map(|said| {
        // A file, or the pairs themselves.
        let text = if said.contains('=') {
            said.clone()
        } else {
            fs::read_to_string(said).map_err(|error| anyhow!("columns {said}: {error}"))?
        };
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
        Some(catalogue.into_history())
    };
    let placement = match &history {
        Some(history) => Placement {
            place: Place::Elements { fit_offset_s: typed.fit_offset_s },
            max_element_age_days: typed.max_element_age_days,
            eop: EopTable::embedded(),
            identified: typed.identified.as_deref().map(identified).transpose()?.unwrap_or_default(),
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
        (None, points_of_measurements(&measurements, weights))
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
    if points.is_empty() {
        return Err(nothing_left(&measurements, pixels.as_ref()));
    }
    Ok(Placed { measurements, reduction: pixels, points, notices })
}

/// How single measurements are weighed, as typed.
pub fn weights(typed: &WeightArguments) -> anyhow::Result<RawWeights> {
    if !(typed.scatter_mag > 0.0 && typed.scatter_mag.is_finite()) {
        return Err(anyhow!("scatter-mag {}; allowed: more than 0", typed.scatter_mag));
    }
    Ok(RawWeights { scatter_mag: typed.scatter_mag, by_group: !typed.equal_weights })
}

/// Tracks and the satellites they are of; rows without a number are tracks that nobody identified.
fn identified(path: &Path) -> anyhow::Result<HashMap<String, NoradId>> {
    let unreadable = |error: csv::Error| anyhow!("identified {}: {error}", path.display());
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).map_err(unreadable)?;
    let headers = reader.headers().map_err(unreadable)?.clone();
    let column = |name: &str| {
        let found = headers.iter().position(|header| header.trim() == name);
        found.ok_or_else(|| anyhow!("identified {}: no column {name}; needed are track and norad", path.display()))
    };
    let (track, norad) = (column("track")?, column("norad")?);
    let mut tracks = HashMap::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(unreadable)?;
        let (track, text) =
            (record.get(track).unwrap_or_default().trim(), record.get(norad).unwrap_or_default().trim());
        if text.is_empty() {
            continue;
        }
        let number: u32 = text.parse().map_err(|_| {
            anyhow!(
                "identified {}: row {}: norad {text}; allowed: a catalogue number, or nothing",
                path.display(),
                row + 1
            )
        })?;
        if number > 0 {
            tracks.insert(track.to_owned(), NoradId(number));
        }
    }
    Ok(tracks)
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
        least_tracks: typed.min_tracks,
        most_iqr_mag: typed.max_iqr,
    }
}

/// Why no point is left, and which option may help.
fn nothing_left(measurements: &Measurements, pixels: Option<&Reduction>) -> anyhow::Error {
    let most = measurements.dropped.iter().max_by_key(|(_, count, _)| *count);
    match (measurements.points.len(), pixels, most) {
        (0, _, Some((reason, count, _))) => anyhow!(
            "no measurement is left: {} rows left out, {count} of them for {}{}",
            measurements.dropped.total(),
            reason.name().replace('_', " "),
            remedy(reason)
        ),
        (0, ..) => anyhow!("no measurement is left: the tables hold none"),
        (n, ..) => anyhow!(
            "no pixel is left of {n} measurements; allowed by --min-count, --max-iqr and --min-tracks, or point by point with --raw-points"
        ),
    }
}

fn remedy(reason: DropReason) -> &'static str {
    match reason {
        DropReason::NoGeometry => " (distance and phase need --height-km, others a site or --elements)",
        DropReason::NoElements => " (the rows must name a satellite that --elements hold)",
        DropReason::StaleElements => " (see --max-element-age-days)",
        DropReason::WrongFilter => " (see --filter)",
        _ => "",
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
pub struct Chosen {
    pub file: ModelFile,
    pub form: FittedForm,
    pub settings: FitSettings,
}

/// One of the forms that model files have room for.
pub enum FittedForm {
    TwoPanel(TwoPanelForm),
    Panels(PanelsForm),
}

impl FittedForm {
    pub fn as_form(&self) -> &dyn Form {
        match self {
            Self::TwoPanel(form) => form,
            Self::Panels(form) => form,
        }
    }

    /// The paper's form with this one's sizes, where it has any.
    pub fn as_two_panels(&self) -> Option<TwoPanelForm> {
        match self {
            Self::TwoPanel(form) => Some(form.clone()),
            Self::Panels(form) => form.as_two_panels(),
        }
    }

    /// The same, to be owned.
    pub fn boxed(&self) -> Box<dyn Form> {
        match self {
            Self::TwoPanel(form) => Box::new(form.clone()),
            Self::Panels(form) => Box::new(form.clone()),
        }
    }
}

/// What is fitted, and how.
pub fn form(typed: &FormArguments, raw_points: bool) -> anyhow::Result<Chosen> {
    let model = model_of(&ModelLibrary::embedded(), &typed.model)?;
    let file = model.file().cloned().ok_or_else(|| anyhow!("model {} has no file", typed.model))?;
    let (band, system) = model.band();
    let sun_magnitude = band.sun_magnitude(system);
    let earthshine = if typed.no_earthshine { Earthshine::Off } else { Earthshine::Computed };
    let form = match (file.shape, file.coefficients, &file.panels) {
        (Some(shape), Some(coefficients), _) => {
            FittedForm::TwoPanel(TwoPanelForm { shape, coefficients, earthshine, blocking: true, sun_magnitude })
        }
        (_, _, Some(spec)) => FittedForm::Panels(PanelsForm { spec: spec.clone(), earthshine, sun_magnitude }),
        _ => {
            let wanted = "allowed are models of kind two_panel or panels (streakcast model list)";
            return Err(anyhow!("model {} has nothing to fit; {wanted}", typed.model));
        }
    };
    let parameters = form.as_form().parameters();
    let known = || parameters.iter().map(|parameter| parameter.name.as_str()).collect::<Vec<_>>().join(", ");
    let mut held = Vec::new();
    for entry in &typed.hold {
        let parsed =
            entry.split_once('=').and_then(|(name, value)| Some((name.trim(), value.trim().parse::<f64>().ok()?)));
        let (name, value) = parsed.ok_or_else(|| anyhow!("hold {entry}; allowed: NAME=NUMBER, as c1=0"))?;
        let found = parameters.iter().find(|parameter| parameter.name == name);
        let parameter = found.ok_or_else(|| anyhow!("hold {name}: no such parameter; allowed: {}", known()))?;
        if !(parameter.least..=parameter.greatest).contains(&value) {
            return Err(anyhow!("hold {name}={value}; allowed: {} to {}", parameter.least, parameter.greatest));
        }
        held.push((name.to_owned(), value));
    }
    let mut free = typed.free.clone();
    if free.is_empty() {
        let fitted = |parameter: &&Parameter| parameter.name != PANEL_OFFSET;
        free = parameters.iter().filter(fitted).map(|parameter| parameter.name.clone()).collect();
    }
    free.retain(|name| held.iter().all(|(other, _)| other != name));
    let loss = match typed.loss {
        Some(LossName::Squares) => Loss::Squares,
        Some(LossName::SoftL1) => Loss::SoftL1,
        Some(LossName::Student) => Loss::Student(4.0),
        None if raw_points => Loss::SoftL1,
        None => Loss::Squares,
    };
    Ok(Chosen { file, form, settings: FitSettings { free, held, loss, ..FitSettings::default() } })
}

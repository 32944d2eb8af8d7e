//! `fit reduce`: reduces photometry to pixels of the body frame or to single points. `fit identify`: finds the
//! satellite of each track.

use anyhow::anyhow;
use streakcast::fit::RawWeights;
use streakcast::fit::measurements::{
    AcceptanceLimits, AssociationOptions, RecordReader, Records, identification_table, identify_tracks,
};
use streakcast::frames::EopTable;
use streakcast::output::Provenance;

use super::arguments::{FitIdentifyArguments, FitReduceArguments};
use super::photometry;
use super::points::{provenance, read};
use crate::failure::Outcome;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

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
    if let Some(picture) = &typed.picture {
        streakcast::plot::PictureFormat::from_extension(picture)?;
        crate::output::check(picture)?;
    }
    let input = read(&typed.photometry, &typed.reduction, &RawWeights::default())?;
    let dropped = input.measurements.dropped.table();
    let provenance = provenance(&typed.photometry, &typed.reduction, &input);
    let (table, name, columns) = match &input.reduction {
        Some(pixels) => (pixels.table(), "pixels", PIXELS_ON_SCREEN),
        None => (input.measurements.table(), "measurements", POINTS_ON_SCREEN),
    };
    if let Some(path) = &typed.picture {
        super::report::pixels_picture(path, input.reduction.as_ref(), typed.layer, &input.notices)?;
    }
    output.write(&VerbResult::new(name, &table, columns, &provenance).with("dropped", &dropped), &input.notices)?;
    Ok(Outcome::Done)
}

const ON_SCREEN: &[Shown] = &[
    shown("track", "track"),
    shown("norad", "NORAD"),
    shown("best", "best"),
    rounded("range_rms_km", "range km", 2),
    rounded("phase_rms_deg", "phase deg", 2),
    rounded("offset_s", "delay s", 1),
    rounded("element_age_days", "elements d", 1),
    shown("next", "next"),
    rounded("lead", "lead", 1),
];

pub fn identify(typed: FitIdentifyArguments) -> anyhow::Result<Outcome> {
    let output = Output::new(typed.output.format.as_deref(), typed.output.output.clone())?;
    for (name, value) in [
        ("max-offset-s", typed.max_offset_s),
        ("max-element-age-days", typed.max_element_age_days),
        ("max-range-rms-km", typed.max_range_rms_km),
        ("max-phase-rms-deg", typed.max_phase_rms_deg),
        ("least-lead", typed.least_lead),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(anyhow!("{name} is {value}; allowed: 0 or more"));
        }
    }
    let config = photometry::config(&typed.tables);
    let notices = begin(&config)?;
    let history = photometry::history_of(&typed.elements)?;
    let options = photometry::read_options(&typed.tables, &config)?;
    let mut reader = RecordReader::open(&typed.tables.photometry, &options)?;
    let records = Records::collect(&mut reader)?;
    let options = AssociationOptions {
        max_offset_s: typed.max_offset_s,
        max_element_age_days: typed.max_element_age_days,
        ..AssociationOptions::default()
    };
    let limits = AcceptanceLimits {
        max_range_rms_km: typed.max_range_rms_km,
        max_phase_rms_rad: typed.max_phase_rms_deg.to_radians(),
        least_lead: typed.least_lead,
    };
    let tracks = identify_tracks(&records, &history, &EopTable::embedded(), &options, &limits);
    let sure = tracks.iter().filter(|track| track.is_sure).count();
    notices.info(&format!("{sure} of {} tracks identified", tracks.len()));
    let table = identification_table(&tracks);
    let mut provenance = Provenance::new();
    for (name, paths) in [("photometry", &typed.tables.photometry), ("elements", &typed.elements)] {
        provenance.state(name, photometry::names(paths));
    }
    provenance.state("max_offset_s", typed.max_offset_s);
    provenance.state("max_element_age_days", typed.max_element_age_days);
    provenance.state("max_range_rms_km", typed.max_range_rms_km);
    provenance.state("max_phase_rms_deg", typed.max_phase_rms_deg);
    provenance.state("least_lead", typed.least_lead);
    output.write(&VerbResult::new("tracks", &table, ON_SCREEN, &provenance), &notices)?;
    Ok(if sure > 0 { Outcome::Done } else { Outcome::No })
}

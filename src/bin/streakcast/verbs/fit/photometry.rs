//! Reads photometry as given by the flags: tables, geometry and selection.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use streakcast::config::{Config, RunConfig};
use streakcast::elements::{History, Keep, NoradId, ReadOptions as CatalogueOptions, Satellites, StationRule};
use streakcast::fit::measurements::{
    ColumnMap, Format, OrbitRadius, PhotometryOptions, Placement, PositionSource, Selection,
};
use streakcast::frames::EopTable;
use streakcast::input::{self, TableRows};
use streakcast::output::Provenance;

use super::arguments::{PhotometryArguments, TableArguments};
use crate::verbs::map::site_of;

pub fn config(typed: &TableArguments) -> Config {
    let run = RunConfig { threads: typed.threads, quiet: Some(typed.quiet), ..RunConfig::default() };
    Config { site: typed.site.clone(), run, ..Config::default() }
}

pub fn read_options(typed: &TableArguments, config: &Config) -> anyhow::Result<PhotometryOptions> {
    let columns = typed.columns.as_ref().map(|given| {
        // Text with an equals sign is a list of pairs; other text is a file name.
        if given.contains('=') {
            return Ok::<_, anyhow::Error>(ColumnMap::from_text(given)?);
        }
        let failed = |error: &dyn std::fmt::Display| anyhow!("columns {given}: {error}");
        let text = input::read_to_string(given.as_ref()).map_err(|error| failed(&error))?;
        ColumnMap::from_text(&text).map_err(|error| failed(&error))
    });
    Ok(PhotometryOptions {
        format: typed.format_name.as_deref().map(Format::by_name).transpose()?,
        columns: columns.transpose()?,
        site: site_of(config)?,
        filters: typed.filter.clone(),
        keep_duplicates: typed.keep_duplicates,
    })
}

/// Reads the element sets, if any are given.
pub fn history(typed: &PhotometryArguments) -> anyhow::Result<Option<History>> {
    if typed.elements.is_empty() {
        return Ok(None);
    }
    if typed.height_km.is_some() {
        return Err(anyhow!("--height-km and --elements exclude each other; specify one of them"));
    }
    history_of(&typed.elements).map(Some)
}

/// Reads all element sets of the files.
pub fn history_of(paths: &[PathBuf]) -> anyhow::Result<History> {
    let options = CatalogueOptions { keep: Keep::All, ..CatalogueOptions::default() };
    let satellites = Satellites::read(paths, &options)?;
    if let Some(ephemeris) = satellites.ephemerides.first() {
        return Err(anyhow!("{} is an ephemeris; allowed: element sets", ephemeris.file));
    }
    Ok(satellites.into_history())
}

pub fn placement<'h>(typed: &PhotometryArguments, history: Option<&'h History>) -> anyhow::Result<Placement<'h>> {
    let Some(history) = history else { return Ok(Placement::recorded(typed.height_km)) };
    let source = match typed.elements_radius {
        true => PositionSource::Recorded { radius: Some(OrbitRadius::Elements) },
        false => PositionSource::Elements { fit_offset_s: typed.fit_offset_s },
    };
    Ok(Placement {
        source,
        max_element_age_days: typed.max_element_age_days,
        eop: EopTable::embedded(),
        identified: typed.identified.as_deref().map(identified).transpose()?.unwrap_or_default(),
        ..Placement::elements(history)
    })
}

pub fn selection(typed: &PhotometryArguments) -> Selection {
    let station = typed.on_station.then(|| StationRule {
        min_height_km: typed.station_height_km,
        max_rate_m_day: typed.station_rate_m_day,
        ..StationRule::default()
    });
    Selection {
        drop_penumbra_flag: !typed.keep_penumbra_flag,
        least_grazing_height_km: Some(typed.least_grazing_km),
        least_altitude_rad: Some(typed.least_altitude_deg.to_radians()),
        station,
        max_range_difference_km: Some(typed.max_range_difference_km),
        max_phase_difference_rad: typed.max_phase_difference_deg.map(f64::to_radians),
        correct_sun_distance: typed.sun_distance,
    }
}

/// Returns the names of files, separated by commas.
pub fn names(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<String>>().join(", ")
}

/// Adds the files and all thresholds, including defaults, to the provenance.
pub fn state(typed: &PhotometryArguments, provenance: &mut Provenance) {
    provenance.state("photometry", names(&typed.tables.photometry));
    if !typed.elements.is_empty() {
        provenance.state("elements", names(&typed.elements));
        provenance.state("max_element_age_days", typed.max_element_age_days);
        provenance.state("elements_radius", typed.elements_radius);
    }
    if let Some(limit_s) = typed.fit_offset_s {
        provenance.state("fit_offset_s", limit_s);
    }
    if let Some(height_km) = typed.height_km {
        provenance.state("height_km", height_km);
    }
    provenance.state("least_grazing_km", typed.least_grazing_km);
    provenance.state("least_altitude_deg", typed.least_altitude_deg);
    provenance.state("max_range_difference_km", typed.max_range_difference_km);
    if let Some(limit_deg) = typed.max_phase_difference_deg {
        provenance.state("max_phase_difference_deg", limit_deg);
    }
    provenance.state("keep_penumbra_flag", typed.keep_penumbra_flag);
    if typed.on_station {
        provenance.state("station_height_km", typed.station_height_km);
        provenance.state("station_rate_m_day", typed.station_rate_m_day);
    }
    provenance.state("sun_distance_taken_out", typed.sun_distance);
}

/// Reads the table of the satellite of each track. Rows without a catalogue number are omitted.
fn identified(path: &Path) -> anyhow::Result<HashMap<String, NoradId>> {
    let shown = path.display();
    let read_error = |error: std::io::Error| anyhow!("identified {shown}: {error}");
    let rows = TableRows::open(path).map_err(read_error)?;
    let column = |name| rows.column(name, "track, norad").map_err(read_error);
    let (track, norad) = (column("track")?, column("norad")?);
    let mut tracks = HashMap::new();
    for row in rows {
        let row = row.map_err(read_error)?;
        if row.text(norad).is_empty() {
            continue;
        }
        let number = row.parsed(norad, "a catalogue number, or an empty cell").map_err(read_error)?;
        if number > 0 {
            tracks.insert(row.text(track).to_owned(), NoradId(number));
        }
    }
    Ok(tracks)
}

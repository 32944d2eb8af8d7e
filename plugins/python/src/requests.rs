//! Forecasts of nights, ephemerides and identification of streaks: JSON documents are converted to requests of the
//! library, and results to tables.

#[cfg(unix)]
use std::path::PathBuf;

#[cfg(unix)]
use hifitime::Epoch;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use streakcast::Watch;
use streakcast::config::{EphemerisConfig, ForecastConfig, IdentifyConfig, IdentifySettings};
#[cfg(unix)]
use streakcast::config::{StreakTables, identify_streaks as identify_tables};
use streakcast::forecast::{
    EphemerisRow, ForecastRequest, PassColumns, Selection, ephemeris as compute_ephemeris, ephemeris_table,
    forecast as compute_forecast, night_table, pass_table,
};
use streakcast::identify::streak_table;
use streakcast::output::{Column, Kind, Table};

use crate::columns::columns;
use crate::engine::Engine;
use crate::failure;
use crate::sky_cache::SkyCache;
use streakcast::Error;

/// Column for the night of each pass.
const NIGHT: Column =
    Column::new("night", Kind::Integer, "Row of the table of nights that the pass belongs to, from 0.");

/// Returns the visible passes of one or several nights: `passes` and `nights` as columns, and `warnings`. Each request
/// is a JSON document.
#[pyfunction]
pub fn forecast<'py>(py: Python<'py>, requests: Vec<String>, engine: Py<Engine>) -> PyResult<Bound<'py, PyDict>> {
    let configs: Vec<ForecastConfig> =
        requests.iter().map(|text| serde_json::from_str(text).map_err(failure::json)).collect::<PyResult<_>>()?;
    let engine = engine.get();
    let Nights { passes, nights, warnings } = failure::without_lock(py, |watch| {
        // All requests are checked before the first night is computed.
        let resolved = configs
            .iter()
            .map(|forecast| forecast.resolve(&engine.setup, 0).map_err(exception))
            .collect::<PyResult<Vec<_>>>()?;
        resolved.iter().try_fold(Nights::new(), |nights, (request, selection)| {
            nights.with(engine.sky_cache.get(), request, selection, watch)
        })
    })?;
    let result = PyDict::new(py);
    result.set_item("passes", columns(py, &passes)?)?;
    result.set_item("nights", columns(py, &nights)?)?;
    result.set_item("warnings", warnings)?;
    Ok(result)
}

/// Tables of several nights, concatenated.
struct Nights {
    passes: Table,
    nights: Table,
    warnings: Vec<String>,
}

impl Nights {
    fn new() -> Self {
        Self { passes: Table::default(), nights: Table::default(), warnings: Vec::new() }
    }

    fn with(
        mut self,
        sky_cache: &SkyCache,
        request: &ForecastRequest,
        selection: &Selection,
        watch: &Watch,
    ) -> PyResult<Self> {
        let prepared = sky_cache.over(request.start, request.end, watch)?;
        let sky = &prepared.sky;
        prepared.check_known(request.start, request.end, None).map_err(failure::unknown)?;
        let found = compute_forecast(sky, request, selection).map_err(exception)?;
        let rows = found.rows(sky);
        let night = i64::try_from(self.nights.rows.len()).unwrap_or_default();
        let columns =
            PassColumns { p_brighter: request.max_magnitude.is_some(), more: true, samples: request.samples > 0 };
        let passes = pass_table(rows, columns);
        let night_row = night_table(&found, found.why_empty(sky, request).as_deref());
        self.passes.columns = [&[NIGHT], passes.columns.as_slice()].concat();
        self.passes.rows.extend(passes.rows.into_iter().map(|row| [vec![night.into()], row].concat()));
        self.nights.columns = night_row.columns;
        self.nights.rows.extend(night_row.rows);
        let has_passes = found.found.has_passes();
        let left_out = prepared.left_out_warning_of_times(&found.found.left_out, request.start, has_passes);
        let left_out = left_out.map_err(failure::setup)?;
        let warnings = [
            left_out,
            prepared.unknown_part_warning(request.start, request.end),
            selection.unknown_warning(sky.elements()),
            found.prior_warning(sky, request.max_magnitude),
            found.fitted_range_warning(),
        ];
        let warnings = warnings.into_iter().flatten();
        self.warnings.extend(warnings.map(|warning| failure::as_arguments(&warning)));
        Ok(self)
    }
}

/// Returns the positions of satellites at given times as columns, and warnings.
#[pyfunction]
pub fn ephemeris<'py>(
    py: Python<'py>,
    request: &str,
    engine: Py<Engine>,
) -> PyResult<(Bound<'py, PyList>, Vec<String>)> {
    let given: EphemerisConfig = serde_json::from_str(request).map_err(failure::json)?;
    let engine = engine.get();
    let (table, warnings) = failure::without_lock(py, |watch| {
        let request = given.resolve(&engine.setup).map_err(exception)?;
        let (first, last) = request.span().map_err(exception)?;
        let prepared = engine.sky_cache.get().over(first, last, watch)?;
        let elements = prepared.sky.elements();
        let found = compute_ephemeris(&prepared.sky, &request).map_err(exception)?;
        let rows = found.points.iter().map(|point| EphemerisRow { point, elements: &elements[point.element_index] });
        let left_out = prepared.left_out_warning_of_times(&found.left_out, first, !found.points.is_empty());
        let left_out = left_out.map_err(failure::setup)?;
        let warnings = [left_out, request.selection.unknown_warning(elements)].into_iter().flatten();
        Ok((ephemeris_table(rows), warnings.map(|warning| failure::as_arguments(&warning)).collect()))
    })?;
    Ok((columns(py, &table)?, warnings))
}

/// Returns the candidates for a measured streak: `candidates` and `streak` as columns, `unknown_probability`,
/// `n_candidates`, `warnings`, and `remarks` about the frame.
#[pyfunction]
#[pyo3(signature = (request, engine, include_dark, top))]
pub fn identify<'py>(
    py: Python<'py>,
    request: &str,
    engine: Py<Engine>,
    include_dark: Option<bool>,
    top: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let identify: IdentifyConfig = serde_json::from_str(request).map_err(failure::json)?;
    let engine = engine.get();
    let (plan, done) = failure::without_lock(py, |watch| {
        let plan = identify.resolve(&engine.setup).map_err(exception)?;
        let (first, last) = plan.span();
        let prepared = engine.sky_cache.get().over(first, last, watch)?;
        let settings = IdentifySettings { include_dark, top };
        let done = plan.identify(&engine.setup, &prepared, &settings).map_err(exception)?;
        Ok((plan, done))
    })?;
    let result = identified(py, &done.candidates, &streak_table([&plan.streak]), &plan.remarks)?;
    result.set_item("unknown_probability", done.found.unknown_probability)?;
    result.set_item("n_candidates", done.found.candidates.len())?;
    let warnings = failure::all_as_arguments(done.found.unknown_observer.iter().chain(&done.left_out));
    result.set_item("warnings", warnings)?;
    Ok(result)
}

/// Returns the candidates and the streaks as columns, and the remarks.
fn identified<'py>(
    py: Python<'py>,
    candidates: &Table,
    streaks: &Table,
    remarks: &[String],
) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    result.set_item("candidates", columns(py, candidates)?)?;
    result.set_item("streak", columns(py, streaks)?)?;
    result.set_item("remarks", failure::all_as_arguments(remarks))?;
    Ok(result)
}

/// Returns the candidates for the streaks of tables: `candidates` and `streak` as columns, `warnings` about the
/// satellites, `row_warnings`, and `remarks`. Names of frames in the tables are relative to `folder`, or to the folder
/// of each table.
#[cfg(unix)]
#[pyfunction]
#[pyo3(signature = (request, tables, folder, engine, include_dark, top))]
pub fn identify_streaks<'py>(
    py: Python<'py>,
    request: &str,
    tables: Vec<PathBuf>,
    folder: Option<PathBuf>,
    engine: Py<Engine>,
    include_dark: Option<bool>,
    top: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let identify: IdentifyConfig = serde_json::from_str(request).map_err(failure::json)?;
    let engine = engine.get();
    let done = failure::without_lock(py, |watch| {
        let tables = StreakTables { paths: &tables, folder: folder.as_deref() };
        let settings = IdentifySettings { include_dark, top };
        let sky = |first: Epoch, last: Epoch| engine.sky_cache.get().prepared_over(first, last);
        identify_tables(tables, &identify, &engine.setup, &settings, Some(&sky), watch).map_err(exception)
    })?;
    let result = identified(py, &done.candidates, &done.streaks, &done.remarks)?;
    let left_out = done.left_out.iter().filter_map(|(warning, _)| warning.as_ref());
    result.set_item("warnings", failure::all_as_arguments(left_out))?;
    result.set_item("row_warnings", failure::all_as_arguments(&done.warnings))?;
    Ok(result)
}

/// Converts an error of the library, with the name of the Python argument.
fn exception(error: Error) -> PyErr {
    let text = error.to_string();
    failure::request(match error.what() {
        Some("sun-altitude-deg") => text.replacen("sun-altitude-deg", "max_sun_altitude", 1),
        // Flags are written as arguments later.
        Some(what) if !what.contains(' ') && !what.starts_with("--") => text.replacen(what, &what.replace('-', "_"), 1),
        _ => text,
    })
}

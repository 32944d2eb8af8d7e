//! Forecasts of nights and measured streaks: documents to the library's questions, tables back.

use hifitime::Epoch;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use streakcast::config::{Config, ForecastConfig, IdentifyConfig, ConfigError};
use streakcast::forecast::{
    ForecastError, ForecastRequest, PassRow, Selection, forecast as ask, night_table, pass_table,
};
use streakcast::frames::seconds_after;
use streakcast::identify::{CandidateRow, IdentifyOptions, candidate_table, identify_streak, streak_table};
use streakcast::output::{Column, Kind, Table};

use crate::columns::columns;
use crate::failure;
use crate::skies::{Skies, setup_of};

/// Which night a pass belongs to, where several were asked about.
const NIGHT: Column =
    Column::new("night", Kind::Integer, "Row of the table of nights that the pass belongs to, from 0.");

/// Visible passes of one or several nights: `passes` and `nights` as columns, and `warnings`. Each question is a JSON document.
#[pyfunction]
#[pyo3(signature = (questions, setup, config, skies))]
pub fn forecast<'py>(
    py: Python<'py>,
    questions: Vec<String>,
    setup: &str,
    config: Option<&str>,
    skies: Py<Skies>,
) -> PyResult<Bound<'py, PyDict>> {
    let given: Vec<ForecastConfig> =
        questions.iter().map(|text| serde_json::from_str(text).map_err(failure::asked)).collect::<PyResult<_>>()?;
    let setup = setup_of(setup, config)?;
    let Nights { passes, nights, warnings } = failure::without_lock(py, || {
        // All of it is looked at before the first night is asked about.
        let asked = given
            .iter()
            .map(|forecast| forecast.resolve(&setup, 0).map_err(exception))
            .collect::<PyResult<Vec<_>>>()?;
        asked
            .iter()
            .try_fold(Nights::new(), |nights, (request, selection)| nights.with(skies.get(), request, selection))
    })?;
    let answer = PyDict::new(py);
    answer.set_item("passes", columns(py, &passes)?)?;
    answer.set_item("nights", columns(py, &nights)?)?;
    answer.set_item("warnings", warnings)?;
    Ok(answer)
}

/// Nights that were asked about, one below the other.
struct Nights {
    passes: Table,
    nights: Table,
    warnings: Vec<String>,
}

impl Nights {
    fn new() -> Self {
        Self { passes: Table::default(), nights: Table::default(), warnings: Vec::new() }
    }

    fn with(mut self, skies: &Skies, request: &ForecastRequest, selection: &Selection) -> PyResult<Self> {
        let prepared = skies.over(request.start, request.end).map_err(failure::setup)?;
        let sky = &prepared.sky;
        let found = ask(sky, request, selection).map_err(|error| exception(error.into()))?;
        let rows =
            found.found.passes.iter().map(|pass| PassRow { pass, elements: &sky.elements()[pass.element_index] });
        let night = i64::try_from(self.nights.rows.len()).unwrap_or_default();
        let passes = pass_table(rows, true, request.samples > 0);
        let night_row = night_table(&found, found.why_empty(sky, request).as_deref());
        self.passes.columns = [&[NIGHT], passes.columns.as_slice()].concat();
        self.passes.rows.extend(passes.rows.into_iter().map(|row| [vec![night.into()], row].concat()));
        self.nights.columns = night_row.columns;
        self.nights.rows.extend(night_row.rows);
        let left_out = prepared.left_out_warning(&found.found.left_out, request.start).map_err(failure::setup)?;
        let unknown = selection.unknown_warning(sky.elements());
        let told = [left_out, unknown, found.prior_warning(sky, request.max_magnitude)].into_iter().flatten();
        self.warnings.extend(told.map(|warning| failure::as_arguments(&warning)));
        Ok(self)
    }
}

/// Whose streak it is: `candidates` and `streak` as columns, `unknown_probability`, `n_candidates` and `warnings`.
#[pyfunction]
#[pyo3(signature = (said, setup, config, skies, include_dark, top))]
pub fn identify<'py>(
    py: Python<'py>,
    said: &str,
    setup: &str,
    config: Option<&str>,
    skies: Py<Skies>,
    include_dark: bool,
    top: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let given: IdentifyConfig = serde_json::from_str(said).map_err(failure::asked)?;
    let setup: Config = setup_of(setup, config)?;
    let (tables, found, warning) = failure::without_lock(py, || {
        let plan = given.resolve(&setup).map_err(exception)?;
        let streak = &plan.streak;
        let (start, end): (Epoch, Epoch) = (streak.start(), seconds_after(streak.start(), streak.duration_s()));
        let prepared = skies.get().over(start, end).map_err(failure::setup)?;
        prepared.check_altitude("streak", &plan.exposure()).map_err(exception)?;
        let options = IdentifyOptions { include_dark, photometry: setup.photometry().map_err(failure::setup)? };
        let found = identify_streak(&prepared.sky, streak, &options).map_err(failure::asked)?;
        let rows = found.candidates.iter().take(top).map(|candidate| CandidateRow {
            candidate,
            elements: &prepared.sky.elements()[candidate.element_index],
            photometry: &options.photometry,
        });
        let tables = (candidate_table(rows), streak_table(streak));
        let warning = prepared.left_out_warning(&found.left_out, start).map_err(failure::setup)?;
        Ok((tables, found, warning))
    })?;
    let answer = PyDict::new(py);
    answer.set_item("candidates", columns(py, &tables.0)?)?;
    answer.set_item("streak", columns(py, &tables.1)?)?;
    answer.set_item("unknown_probability", found.unknown_probability)?;
    answer.set_item("n_candidates", found.candidates.len())?;
    answer.set_item("warnings", PyList::new(py, warning.map(|warning| failure::as_arguments(&warning)))?)?;
    Ok(answer)
}

/// The library's error by the names of the arguments here.
fn exception(error: ConfigError) -> PyErr {
    match error {
        error if !error.is_of_request() => failure::setup(error),
        ConfigError::Forecast(ForecastError::OutOfRange { what, given, unit, allowed }) => {
            let name = if what == "sun-altitude-deg" { "max_sun_altitude".to_owned() } else { what.replace('-', "_") };
            failure::asked(format!("{name} {given}{unit}; allowed: {allowed}"))
        }
        other => failure::asked(failure::as_arguments(&other.to_string())),
    }
}

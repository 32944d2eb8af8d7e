//! Learned offsets of satellites from arrays of measured and predicted magnitudes.

use std::collections::BTreeMap;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use streakcast::elements::{Generation, NoradId};
use streakcast::learn::{PassPoint, group_passes};
use streakcast::output::Provenance;

use crate::exposures::{Column, epoch_of};
use crate::failure;
use crate::sky_cache::setup_of;

/// Returns the text of a learned file. The columns have one length; NaN in `sigma_mag` is an unknown error.
#[pyfunction]
#[pyo3(signature = (setup, kind, norad_id, jd1, jd2, residual_mag, sigma_mag))]
pub fn learn(
    py: Python<'_>,
    setup: &str,
    kind: &str,
    norad_id: Vec<u32>,
    jd1: Column<'_>,
    jd2: Column<'_>,
    residual_mag: Column<'_>,
    sigma_mag: Column<'_>,
) -> PyResult<String> {
    let known = || Generation::ALL.map(Generation::name).join(", ");
    let kind = Generation::by_name(kind)
        .ok_or_else(|| PyValueError::new_err(format!("kind is '{kind}'; allowed: {}", known())))?;
    let models = setup_of(setup, None)?.model_choice().map_err(failure::setup)?;
    if models.of_kind(kind).is_none() {
        return Err(PyValueError::new_err(format!(
            "kind '{kind}' has no brightness model; allowed: another kind, or model"
        )));
    }
    let (jd1, jd2) = (jd1.as_slice()?, jd2.as_slice()?);
    let (residual_mag, sigma_mag) = (residual_mag.as_slice()?, sigma_mag.as_slice()?);
    let point = |row: usize| PassPoint {
        epoch: epoch_of(jd1[row], jd2[row]),
        residual_mag: residual_mag[row],
        sigma_mag: Some(sigma_mag[row]).filter(|sigma| sigma.is_finite()),
    };
    let points: Vec<_> = norad_id.iter().enumerate().map(|(row, id)| (NoradId(*id), kind, point(row))).collect();
    failure::without_lock(py, |watch| {
        let mut provenance = Provenance::new();
        provenance.state("kind", kind.name());
        provenance.state("measurements", points.len());
        let stated = provenance.entries().map(|(name, value)| (name.to_owned(), value.clone())).collect();
        let learned = streakcast::learn::learn(&group_passes(points), &BTreeMap::new(), &models, stated, watch);
        Ok(learned.map_err(failure::request)?.file.to_json())
    })
}

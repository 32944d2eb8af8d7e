//! Comparisons as a table.

use crate::output::{Column, Kind, Table};

use super::comparison::Comparison;

const COLUMNS: [Column; 15] = [
    Column::new("model", Kind::Text, "Name of the model."),
    Column::new(
        "satellites",
        Kind::Text,
        "Whose brightness it is, by the model's name; empty where that tells nothing.",
    ),
    Column::new("kind", Kind::Text, "Kind of reference: mean, phase curve, photometry, none."),
    Column::new("reference", Kind::Text, "Whose numbers or data."),
    Column::new("n", Kind::Integer, "Geometries or measurements compared."),
    Column::real("model_mean_mag", "mag", 3, "Mean of the model over them, at 1000 km."),
    Column::real("model_sd_mag", "mag", 3, "Standard deviation of the model over them."),
    Column::real("reference_mean_mag", "mag", 3, "Mean of the reference, at 1000 km."),
    Column::real("reference_sd_mag", "mag", 3, "Standard deviation of the reference; empty where none was published."),
    Column::real("difference_mag", "mag", 3, "Mean of reference minus model."),
    Column::real("rms_mag", "mag", 3, "Root mean square of reference minus model; empty against a mean."),
    Column::real("core_mag", "mag", 3, "1.4826 times the median absolute deviation of reference minus model."),
    Column::real("sigma_mag", "mag", 3, "One sigma of a single prediction, as the model states it."),
    Column::real(
        "within_one_sigma",
        "",
        3,
        "Share within that sigma; against a mean, share of the model within the published standard deviation of it.",
    ),
    Column::new("verdict", Kind::Text, "ok, off, or no data."),
];

/// One row a comparison.
pub fn comparison_table(comparisons: &[Comparison]) -> Table {
    let row = |one: &Comparison| {
        let is_compared = one.model_mean_mag.is_some();
        vec![
            one.model.as_str().into(),
            one.satellites.into(),
            one.kind.name().into(),
            one.reference.into(),
            is_compared.then_some(one.n).into(),
            one.model_mean_mag.into(),
            one.model_sd_mag.into(),
            one.reference_mean_mag.into(),
            one.reference_sd_mag.into(),
            one.difference_mag.into(),
            one.rms_mag.into(),
            one.core_mag.into(),
            one.sigma_mag.into(),
            one.within_one_sigma.into(),
            one.verdict.name().into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: comparisons.iter().map(row).collect() }
}

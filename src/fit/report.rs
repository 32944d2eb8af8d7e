//! Reports and tables about fits.

use std::fmt::Write;

use pulldown_cmark::{Options, Parser, html};

use super::cross_validation::FormScore;
use super::form::Parameter;
use super::paper_tests::{LayerOffset, PairedModels};
use super::posterior::{Marginal, Posterior};
use super::solve::Fit;
use crate::output::{Column, Kind, Table, Value};

/// Report that consists of parts in the order in which they are added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    text: String,
}

impl Report {
    /// Creates a report with this title.
    pub fn new(title: &str) -> Self {
        Self { text: format!("# {title}\n") }
    }

    /// Adds a heading of the second level.
    pub fn section(&mut self, title: &str) {
        let _ = write!(self.text, "\n## {title}\n");
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = write!(self.text, "\n{}\n", plain(text));
    }

    /// Adds a list.
    pub fn list(&mut self, items: impl IntoIterator<Item = String>) {
        self.text.push('\n');
        for item in items {
            let _ = writeln!(self.text, "- {}", plain(&item));
        }
    }

    /// Adds a table. Numbers have the decimals of their columns.
    pub fn table(&mut self, table: &Table) {
        self.text.push('\n');
        let cell = |text: &str| plain(text).replace('|', "\\|");
        let heads = table.columns.iter().map(|column| cell(column.name));
        let _ = writeln!(self.text, "| {} |", heads.collect::<Vec<_>>().join(" | "));
        let rules = table.columns.iter().map(|column| match column.kind {
            Kind::Real { .. } | Kind::Small { .. } | Kind::Integer => "---:",
            _ => "---",
        });
        let _ = writeln!(self.text, "| {} |", rules.collect::<Vec<_>>().join(" | "));
        for row in &table.rows {
            let cells = table.columns.iter().zip(row).map(|(column, value)| cell(&column.text(value)));
            let _ = writeln!(self.text, "| {} |", cells.collect::<Vec<_>>().join(" | "));
        }
    }

    /// Adds a picture, given by the name of its file in the folder of the report.
    pub fn picture(&mut self, caption: &str, file: &str) {
        let _ = write!(self.text, "\n![{caption}](<{file}>)\n");
    }

    /// Returns the report as Markdown.
    pub fn to_markdown(&self) -> &str {
        &self.text
    }

    /// Returns the report as one HTML page. A picture is embedded if `picture` returns a data URL for its name.
    pub fn to_html(&self, picture: impl Fn(&str) -> Option<String>) -> String {
        let events = Parser::new_ext(&self.text, Options::ENABLE_TABLES).map(|event| match event {
            pulldown_cmark::Event::Start(pulldown_cmark::Tag::Image { link_type, dest_url, title, id }) => {
                let inlined = picture(&dest_url).map_or_else(|| dest_url.clone(), Into::into);
                pulldown_cmark::Event::Start(pulldown_cmark::Tag::Image { link_type, dest_url: inlined, title, id })
            }
            other => other,
        });
        let mut body = String::new();
        html::push_html(&mut body, events);
        let title = self.text.lines().next().unwrap_or_default().trim_start_matches("# ").to_owned();
        let mut escaped = String::new();
        // The title is escaped because it may contain names chosen by users.
        let _ = pulldown_cmark_escape::escape_html(&mut escaped, &title);
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
             <title>{escaped}</title>\n<style>{STYLE}</style></head>\n<body>\n{body}</body></html>\n"
        )
    }
}

/// Escapes markup in text that comes from outside the program.
fn plain(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222}\
table{border-collapse:collapse;font-variant-numeric:tabular-nums;display:block;overflow-x:auto}\
th,td{border:1px solid #bbb;padding:.2rem .6rem}img{max-width:100%}";

const PARAMETERS: [Column; 7] = [
    Column::new("parameter", Kind::Text, "Name of the parameter."),
    Column::real("value", "", 6, "Fitted or held value."),
    Column::real("sigma", "", 6, "One sigma; empty if it is held or at a bound."),
    Column::real("least", "", 4, "Lower bound."),
    Column::real("greatest", "", 4, "Upper bound."),
    Column::new("state", Kind::Text, "free, held, or at bound."),
    Column::new("points_behind", Kind::Integer, "Number of points that depend on it: |p dm/dp| > 0.1 mag."),
];

/// Returns a table with one row per parameter. `points_behind` has one number for each free parameter, in their order.
pub fn parameter_table(fit: &Fit, points_behind: &[usize]) -> Table {
    let row = |(i, parameter): (usize, &Parameter)| {
        let index = fit.free.iter().position(|&free| free == i);
        let state = match index {
            None => "held",
            Some(_) if fit.uncertainty.at_bound.contains(&i) => "at bound",
            Some(_) => "free",
        };
        let behind = index.and_then(|k| points_behind.get(k)).map(|count| Value::Integer(*count as i64));
        vec![
            parameter.name.as_str().into(),
            parameter.value.into(),
            fit.uncertainty.sigma(i).into(),
            parameter.least.into(),
            parameter.greatest.into(),
            state.into(),
            behind.unwrap_or(Value::Null),
        ]
    };
    Table { columns: PARAMETERS.to_vec(), rows: fit.parameters.iter().enumerate().map(row).collect() }
}

const SCORES: [Column; 10] = [
    Column::new("model", Kind::Text, "Form of brightness law."),
    Column::new("parameters", Kind::Integer, "Free parameters."),
    Column::new("n", Kind::Integer, "Number of points."),
    Column::real("rms_mag", "mag", 4, "Root mean square of the residuals, in sample."),
    Column::real("core_mag", "mag", 4, "1.4826 times their median absolute deviation, in sample."),
    Column::real("aic", "", 1, "Akaike's criterion: n ln(RMS^2) + 2k of squares, sum of losses + 2k of a robust loss."),
    Column::real("held_out_rms_mag", "mag", 4, "Root mean square of the points held out."),
    Column::real("held_out_core_mag", "mag", 4, "Core of the points held out."),
    Column::real("sigma_mag", "mag", 3, "Sigma that contains 68.3 % of the points held out."),
    Column::real("within_one_sigma", "", 3, "Fraction of each fold within the sigma of the other folds."),
];

/// Returns a table with one row per form.
pub fn form_score_table(scores: &[FormScore]) -> Table {
    let row = |score: &FormScore| {
        vec![
            score.name.as_str().into(),
            Value::Integer(score.parameters as i64),
            Value::Integer(score.held_out.n as i64),
            score.in_sample.rms_mag.into(),
            score.in_sample.core_mag.into(),
            score.aic.into(),
            score.held_out.rms_mag.into(),
            score.held_out.core_mag.into(),
            score.sigma_68_mag.into(),
            score.within_one_sigma.into(),
        ]
    };
    Table { columns: SCORES.to_vec(), rows: scores.iter().map(row).collect() }
}

const OFFSETS: [Column; 6] = [
    Column::real("sun_latitude_from_deg", "deg", 2, "Lower end of the layer, Sun above the chassis plane."),
    Column::real("sun_latitude_to_deg", "deg", 2, "Upper end of the layer."),
    Column::new("n", Kind::Integer, "Number of points in the layer."),
    Column::real("panel_offset_deg", "deg", 4, "Panel offset angle fitted to this layer."),
    Column::real("panel_offset_sigma_deg", "deg", 4, "One sigma of the offset."),
    Column::real("rms_mag", "mag", 4, "Root mean square of the residuals."),
];

/// Returns a table of panel offsets by layer of the Sun's latitude (table 2 of Lu 2024).
pub fn offset_table(offsets: &[LayerOffset]) -> Table {
    let row = |layer: &LayerOffset| {
        vec![
            layer.sun_latitude_deg[0].into(),
            layer.sun_latitude_deg[1].into(),
            Value::Integer(layer.n as i64),
            layer.panel_offset_deg.into(),
            layer.sigma_deg.into(),
            layer.rms_mag.into(),
        ]
    };
    Table { columns: OFFSETS.to_vec(), rows: offsets.iter().map(row).collect() }
}

const PAIRED_MODELS: [Column; 7] = [
    Column::new("model", Kind::Text, "One of the two models."),
    Column::new("n", Kind::Integer, "Points of both models."),
    Column::new("parameters", Kind::Integer, "Free parameters."),
    Column::real("rms_mag", "mag", 4, "Root mean square of the residuals."),
    Column::real("aic", "", 1, "Akaike's criterion: n ln(RMS^2) + 2k of squares, sum of losses + 2k of a robust loss."),
    Column::real("t", "", 3, "Student's t of the difference of the mean residuals (paired)."),
    Column::real("p", "", 6, "Probability of a t at least as large if both means are equal."),
];

/// Returns a table of pairs of models (sections 4.2 and 4.3 of Lu 2024), with two rows per pair.
pub fn paired_model_table(pairs: &[&PairedModels]) -> Table {
    let rows = pairs.iter().flat_map(|pair| {
        (0..2).map(|k| {
            vec![
                pair.names[k].into(),
                Value::Integer(pair.n as i64),
                Value::Integer(pair.parameters[k] as i64),
                pair.rms_mag[k].into(),
                pair.aic[k].into(),
                pair.test.map(|test| test.t).into(),
                pair.test.map(|test| test.p).into(),
            ]
        })
    });
    Table { columns: PAIRED_MODELS.to_vec(), rows: rows.collect() }
}

const MARGINALS: [Column; 10] = [
    Column::new("parameter", Kind::Text, "Name of the parameter."),
    Column::real("q16", "", 6, "Quantile 0.16 of the draws."),
    Column::real("median", "", 6, "Quantile 0.5."),
    Column::real("q84", "", 6, "Quantile 0.84."),
    Column::real("mean", "", 6, "Mean."),
    Column::real("sigma", "", 6, "Standard deviation."),
    Column::real("fit_value", "", 6, "Value of the fit."),
    Column::real("fit_sigma", "", 6, "One sigma of the fit, which allows for errors that tracks share."),
    Column::real("autocorrelation_steps", "", 1, "Steps per independent draw."),
    Column::new("is_trusted", Kind::Boolean, "True if the chain is longer than 50 autocorrelation times."),
];

/// Returns a table with one row per free parameter, which includes the value and the sigma of the fit.
pub fn marginal_table(posterior: &Posterior, fit: &Fit) -> Table {
    let row = |(m, &i): (&Marginal, &usize)| {
        vec![
            m.name.as_str().into(),
            m.quantiles[0].into(),
            m.quantiles[1].into(),
            m.quantiles[2].into(),
            m.mean.into(),
            m.sigma.into(),
            fit.parameters[i].value.into(),
            fit.uncertainty.sigma(i).into(),
            m.autocorrelation.steps.into(),
            Value::Boolean(m.autocorrelation.is_trusted),
        ]
    };
    Table { columns: MARGINALS.to_vec(), rows: posterior.marginals.iter().zip(&fit.free).map(row).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Column, Value};

    #[test]
    fn verif_both_forms_hold_the_table_and_html_escapes() {
        let mut report = Report::new("Fit of <a & b>");
        report.section("Numbers");
        report.table(&Table {
            columns: vec![Column::new("name", Kind::Text, "A name."), Column::real("x_mag", "mag", 2, "A number.")],
            rows: vec![vec!["a|b".into(), Value::Real(1.234)]],
        });
        report.paragraph("Data: <script>alert(1)</script> & more");
        report.picture("residuals", "a r.png");
        assert!(
            report.to_markdown().contains("| name | x_mag |\n| --- | ---: |\n| a\\|b | 1.23 |"),
            "{}",
            report.to_markdown()
        );
        let page = report.to_html(|name| (name == "a r.png").then(|| "data:image/png;base64,AA".to_owned()));
        assert!(page.contains("<title>Fit of &lt;a &amp; b&gt;</title>"), "{page}");
        assert!(!page.contains("<script>") && page.contains("&lt;script&gt;alert(1)"), "{page}");
        assert!(page.contains("<td>a|b</td>") && page.contains("src=\"data:image/png;base64,AA\""), "{page}");
    }
}

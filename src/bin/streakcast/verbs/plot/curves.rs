//! Points along passes, read from the output of `forecast`: a table of light curves, or passes with samples.

use anyhow::{anyhow, bail};
use serde_json::Value;
use streakcast::frames::mjd_utc;
use streakcast::frames::parse_moment;
use streakcast::plot::SkyTrack;

use super::columns::Columns;

/// Suffix of the names of simulated satellites.
pub const SYNTHETIC: &str = " (synthetic)";

/// Returns the sentence for a caption that some satellites are simulated; empty if all are real.
pub fn shells_caption(names: &[&str]) -> &'static str {
    if names.iter().any(|name| name.ends_with(SYNTHETIC)) { "Satellites of shells are simulated." } else { "" }
}

/// Names of the JSON arrays that may contain points.
pub const SECTIONS: &[&str] = &["light_curves", "passes"];

/// Pass with its points.
pub struct Curve {
    pub norad_id: String,
    /// True for a simulated satellite.
    pub is_synthetic: bool,
    /// Ranges of the first and the last point, km.
    pub range_km: [f64; 2],
    /// False where the geometry is outside that of the fitted measurements; empty if the table does not state it.
    pub in_fitted_range: Vec<bool>,
    pub track: SkyTrack,
}

impl Curve {
    /// Returns the brightest magnitude; NaN if no point has a magnitude.
    pub fn brightest(&self) -> f64 {
        self.track.magnitude.iter().copied().fold(f64::NAN, f64::min)
    }
}

/// Returns the passes of a table in its order. If `norad` is not empty, only passes of these satellites are returned.
///
/// # Errors
/// The table has no points, or no pass of one of the given satellites.
pub fn curves(columns: &Columns, norad: &[u32]) -> anyhow::Result<Vec<Curve>> {
    let all = if columns.is_empty() {
        Vec::new()
    } else if columns.has("samples") {
        of_samples(columns)?
    } else if ["utc", "altitude_deg", "azimuth_deg", "norad_id"].iter().all(|name| columns.has(name)) {
        of_rows(columns)?
    } else {
        bail!(
            "table {} has no points along passes; allowed: output of forecast with --light-curves FILE, or as JSON with --samples N",
            columns.origin()
        );
    };
    let selected: Vec<String> = norad.iter().map(u32::to_string).collect();
    let known: std::collections::BTreeSet<String> = all.iter().map(|curve| curve.norad_id.clone()).collect();
    if let Some(absent) = selected.iter().find(|id| !known.contains(*id)) {
        let shown: Vec<&str> = known.iter().take(10).map(String::as_str).collect();
        let more = if known.len() > shown.len() { ", ..." } else { "" };
        return Err(anyhow!(
            "norad {absent} has no pass in table {}; allowed: {}{more}",
            columns.origin(),
            shown.join(", ")
        ));
    }
    Ok(all.into_iter().filter(|curve| selected.is_empty() || selected.contains(&curve.norad_id)).collect())
}

/// Reads a table with one row per point. Rows with the same satellite and culmination are one pass.
fn of_rows(columns: &Columns) -> anyhow::Result<Vec<Curve>> {
    let ids = columns.texts("norad_id")?;
    let culminations = if columns.has("culmination_utc") { columns.texts("culmination_utc")? } else { ids.clone() };
    let names = if columns.has("name") { columns.texts("name")? } else { vec![""; ids.len()] };
    let time_mjd = columns.moments("utc")?;
    let [azimuth, altitude, range] = ["azimuth_deg", "altitude_deg", "range_km"].map(|name| columns.numbers(name));
    let (azimuth, altitude, range) = (azimuth?, altitude?, range?);
    let (magnitude, sigma) = (columns.numbers("magnitude")?, columns.numbers("magnitude_sigma")?);
    let sigma_s = columns.numbers_or_nan("along_track_sigma_s")?;
    let in_fitted_range = columns.fitted()?;
    let rows: Vec<usize> = (0..ids.len()).collect();
    let same_pass = |a: &usize, b: &usize| (ids[*a], culminations[*a]) == (ids[*b], culminations[*b]);
    let curve = |rows: &[usize]| {
        let (first, last) = (rows[0], rows[rows.len() - 1]);
        let of = |column: &[f64]| column[first..=last].to_vec();
        Curve {
            norad_id: ids[first].to_owned(),
            is_synthetic: names[first].ends_with(SYNTHETIC),
            range_km: [range[first], range[last]],
            in_fitted_range: in_fitted_range.get(first..=last).map_or_else(Vec::new, <[bool]>::to_vec),
            track: SkyTrack {
                name: display_name(names[first], ids[first]),
                time_mjd: of(&time_mjd),
                azimuth_deg: of(&azimuth),
                altitude_deg: of(&altitude),
                magnitude: of(&magnitude),
                sigma_mag: of(&sigma),
                time_sigma_s: sigma_s[first],
            },
        }
    };
    Ok(rows.chunk_by(same_pass).map(curve).collect())
}

/// Reads a table with one row per pass, and the points of the pass as JSON in a cell.
fn of_samples(columns: &Columns) -> anyhow::Result<Vec<Curve>> {
    let (ids, names) = (columns.texts("norad_id")?, columns.texts("name")?);
    let sigma_s = columns.numbers_or_nan("along_track_sigma_s")?;
    let rows = ids.iter().zip(&names).zip(columns.texts("samples")?).enumerate();
    rows.map(|(row, ((id, name), samples))| {
        let fail = |problem: &str| anyhow!("table {}, pass {}: samples {problem}", columns.origin(), row + 1);
        let points: Vec<Value> =
            serde_json::from_str(samples).map_err(|_| fail("are not a list of points; allowed: output of forecast"))?;
        let number = |name: &str| -> Vec<f64> {
            points.iter().map(|point| point.get(name).and_then(Value::as_f64).unwrap_or(f64::NAN)).collect()
        };
        let is_fitted = |point: &Value| point.get("in_fitted_range").and_then(Value::as_bool).unwrap_or(true);
        let moment = |point: &Value| {
            let text = point.get("utc").and_then(Value::as_str)?;
            parse_moment(text, None).ok().map(mjd_utc)
        };
        let time_mjd = points.iter().map(moment).collect::<Option<Vec<f64>>>();
        let range = number("range_km");
        let ends = [range.first(), range.last()].map(|end| end.copied().unwrap_or(f64::NAN));
        Ok(Curve {
            norad_id: (*id).to_owned(),
            is_synthetic: name.ends_with(SYNTHETIC),
            range_km: ends,
            in_fitted_range: points.iter().map(is_fitted).collect(),
            track: SkyTrack {
                name: display_name(name, id),
                time_mjd: time_mjd.ok_or_else(|| fail("lack a time utc, for example 2024-08-14T00:30:00.000Z"))?,
                azimuth_deg: number("azimuth_deg"),
                altitude_deg: number("altitude_deg"),
                magnitude: number("magnitude"),
                sigma_mag: number("magnitude_sigma"),
                time_sigma_s: sigma_s[row],
            },
        })
    })
    .collect()
}

fn display_name(name: &str, id: &str) -> String {
    if name.is_empty() || name == id { format!("NORAD {id}") } else { name.trim_end_matches(SYNTHETIC).to_owned() }
}

//! Passes in the columns of SCORE, the IAU CPS's archive of satellite photometry: to be held against what is measured, or completed by it.
//!
//! Nothing is invented: what only a measurement has (its time error, instrument, mode, observer, limiting magnitude) stays empty, and the comment says
//! that the row is predicted. Such a file is not meant to be uploaded as it is.

use super::pass_table::PassRow;
use crate::geometry::Site;
use crate::output::format_utc;
use crate::photometry::PhotometryOptions;

/// The header as SCORE has it.
const HEADER: &str = "satellite_name,norad_cat_id,observation_time_utc,observation_time_uncertainty_sec,apparent_magnitude,apparent_magnitude_uncertainty,observer_latitude_deg,observer_longitude_deg,observer_altitude_m,limiting_magnitude,instrument,observing_mode,observing_filter,observer_email,observer_orcid,satellite_right_ascension_deg,satellite_declination_deg,sigma_2_ra,sigma_ra_sigma_dec,sigma_2_dec,range_to_satellite_km,range_to_satellite_uncertainty_km,range_rate_of_satellite_km_per_sec,range_rate_of_satellite_uncertainty_km_per_sec,comments,data_archive_link,mpc_code";

/// One row for each pass that has a magnitude, at its brightest moment (a row without one would say that nothing was seen).
pub fn score_report<'a>(
    rows: impl IntoIterator<Item = PassRow<'a>>,
    site: &Site,
    photometry: &PhotometryOptions,
) -> String {
    let mut text = format!("{HEADER}\n");
    for row in rows {
        let Some((peak, light)) = row.peak().and_then(|peak| Some((peak, peak.brightness.as_ref()?))) else { continue };
        let comment = format!(
            "predicted by streakcast {}, not observed: {} {} by {}, elements {:.1} days old",
            env!("CARGO_PKG_VERSION"),
            photometry.band,
            photometry.system,
            light.source,
            row.pass.element_age_days,
        );
        let cells = [
            row.name(),
            row.pass.norad_id.to_string(),
            format_utc(peak.epoch, 3),
            String::new(),
            format!("{:.3}", light.magnitude.0),
            format!("{:.3}", light.sigma_mag),
            format!("{:.6}", site.latitude_rad.to_degrees()),
            format!("{:.6}", site.longitude_rad.to_degrees()),
            format!("{:.1}", site.height_m),
            String::new(),
            String::new(),
            String::new(),
            photometry.band.to_string(),
            String::new(),
            String::new(),
            format!("{:.6}", peak.direction.longitude_rad().to_degrees()),
            format!("{:.6}", peak.direction.latitude_rad().to_degrees()),
            String::new(),
            String::new(),
            String::new(),
            format!("{:.3}", peak.range_km),
            String::new(),
            String::new(),
            String::new(),
            comment,
            String::new(),
            site.mpc_code.clone().unwrap_or_default(),
        ];
        let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

/// A cell of CSV.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

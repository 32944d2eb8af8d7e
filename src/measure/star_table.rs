//! Tables of stars with known magnitudes.

use std::path::Path;

use serde::Deserialize;

use super::error::MeasureError;
use crate::frames::{Direction, Gcrs};
use crate::input;

/// Columns and ranges of a table, for errors.
const FORM: &str =
    "CSV with ra_deg, dec_deg (-90 to 90), mag (-30 to 60) and, optionally, mag_sigma (0 to 10) and band";

/// Star of known magnitude.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CatalogueStar {
    /// Direction at the time of the frame (ICRS).
    pub direction: Direction<Gcrs>,
    /// Magnitude.
    pub magnitude: f64,
    /// Error (one sigma) of the magnitude, mag; 0 if unknown.
    pub sigma_mag: f64,
}

/// Table of stars with known magnitudes, in one band or several.
#[derive(Clone, Debug)]
pub struct StarTable {
    /// File, for errors.
    origin: String,
    /// Stars with their bands; an empty name is any band.
    stars: Vec<(CatalogueStar, String)>,
}

impl StarTable {
    /// Reads a CSV table with the columns `ra_deg`, `dec_deg`, `mag` (or `magnitude`) and, optionally, `mag_sigma` and
    /// `band`. Other columns are ignored, as are lines that begin with `#`.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing, or a value is out of range.
    pub fn read(path: &Path) -> Result<Self, MeasureError> {
        #[derive(Deserialize)]
        struct Row {
            ra_deg: f64,
            dec_deg: f64,
            #[serde(alias = "magnitude")]
            mag: f64,
            #[serde(alias = "magnitude_sigma")]
            mag_sigma: Option<f64>,
            band: Option<String>,
        }
        let origin = format!("table of stars {}", path.display());
        let text = input::read_to_string(path)
            .map_err(|error| MeasureError::invalid(origin.clone(), format!("not readable ({error})"), FORM))?;
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
        let mut stars = Vec::new();
        for (index, row) in reader.deserialize::<Row>().enumerate() {
            let row = row.map_err(|error| MeasureError::invalid(origin.clone(), format!("invalid ({error})"), FORM))?;
            let sigma_mag = row.mag_sigma.unwrap_or(0.0);
            let is_valid = row.ra_deg.is_finite()
                && row.dec_deg.abs() <= 90.0
                && (-30.0..=60.0).contains(&row.mag)
                && (0.0..=10.0).contains(&sigma_mag);
            if !is_valid {
                let Row { ra_deg, dec_deg, mag, .. } = row;
                let given = format!("at ra {ra_deg}, dec {dec_deg}, mag {mag} +- {sigma_mag}");
                return Err(MeasureError::invalid(format!("{origin}: star {}", index + 1), given, FORM));
            }
            let direction = Direction::from_lon_lat_rad(row.ra_deg.to_radians(), row.dec_deg.to_radians());
            let band = row.band.as_deref().map_or(String::new(), band_name);
            stars.push((CatalogueStar { direction, magnitude: row.mag, sigma_mag }, band));
        }
        if stars.is_empty() {
            return Err(MeasureError::invalid(origin, "empty", FORM));
        }
        Ok(Self { origin, stars })
    }

    /// Returns the stars in the band of a filter and the stars without a band. The band is the first word of the
    /// filter: `g DECam SDSS` is the band `g`.
    ///
    /// # Errors
    /// The table has bands and none is that of the filter, or the filter is unknown and the table has several bands.
    pub fn in_band(&self, filter: Option<&str>) -> Result<Vec<CatalogueStar>, MeasureError> {
        let mut bands: Vec<&str> = self.stars.iter().map(|(_, band)| band.as_str()).collect();
        bands.sort_unstable();
        bands.dedup();
        let filter = filter.map(band_name);
        let wanted = match &filter {
            Some(filter) => filter.as_str(),
            // A table in one band needs no filter in the header.
            None if bands.len() == 1 => bands[0],
            None => {
                let allowed = format!("--band, or FILTER in the header; bands of the table: {}", bands.join(", "));
                return Err(MeasureError::invalid(
                    format!("band of the frame for the {}", self.origin),
                    "missing",
                    allowed,
                ));
            }
        };
        let is_in_band = |band: &str| band.is_empty() || band == wanted;
        let found: Vec<CatalogueStar> =
            self.stars.iter().filter(|(_, band)| is_in_band(band)).map(|(star, _)| *star).collect();
        if found.is_empty() {
            let what = format!("band of the frame for the {}", self.origin);
            return Err(MeasureError::invalid(what, format!("'{wanted}'"), format!("{}, by --band", bands.join(", "))));
        }
        Ok(found)
    }
}

/// Returns the first word of the name of a filter, without primes.
fn band_name(filter: &str) -> String {
    filter.split_whitespace().next().unwrap_or_default().trim_end_matches('\'').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<StarTable, MeasureError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        StarTable::read(file.path())
    }

    #[test]
    fn stars_are_selected_by_band() {
        let stars =
            table("# of the night\nra_deg,dec_deg,mag,mag_sigma,band\n1,2,10,0.02,g\n1,2,9,,r\n3,4,11,,\n").unwrap();
        let g = stars.in_band(Some("g DECam SDSS c0001")).unwrap();
        assert_eq!(g.iter().map(|star| star.magnitude).collect::<Vec<_>>(), [10.0, 11.0]);
        assert_eq!((g[0].sigma_mag, g[1].sigma_mag), (0.02, 0.0));
        assert_eq!(stars.in_band(Some("r'")).unwrap().len(), 2);
        assert!(stars.in_band(None).unwrap_err().to_string().contains("g, r"));
        let one = table("ra_deg,dec_deg,magnitude\n1,2,10\n").unwrap();
        assert_eq!((one.in_band(None).unwrap().len(), one.in_band(Some("g")).unwrap().len()), (1, 1));
        let only_v = table("ra_deg,dec_deg,mag,band\n1,2,10,V\n").unwrap();
        assert_eq!(only_v.in_band(None).unwrap().len(), 1);
        assert!(only_v.in_band(Some("g")).unwrap_err().to_string().contains("'g'; allowed: V"));
    }

    #[test]
    fn invalid_tables_are_named() {
        for (text, part) in [
            ("ra_deg,dec_deg\n1,2\n", "mag"),
            ("ra_deg,dec_deg,mag\n", "empty"),
            ("ra_deg,dec_deg,mag\n1,2,10\n1,92,10\n", "star 2"),
            ("ra_deg,dec_deg,mag\n1,2,nan\n", "star 1"),
            ("ra_deg,dec_deg,mag,mag_sigma\n1,2,10,-1\n", "-1"),
            ("ra_deg,dec_deg,mag\n1,2,bright\n", "invalid"),
        ] {
            let message = table(text).unwrap_err().to_string();
            assert!(message.contains(part) && message.contains("allowed: CSV with ra_deg"), "{message}");
        }
        assert!(StarTable::read(Path::new("/missing.csv")).unwrap_err().to_string().contains("missing.csv"));
    }
}

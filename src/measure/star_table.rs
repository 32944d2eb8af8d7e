//! Tables of stars with known magnitudes.

use std::path::Path;

use crate::error::Error;
use crate::frames::{Direction, Gcrs};
use crate::input::TableRows;
use crate::units::{DEGREES, MAGNITUDES};

/// Columns and ranges of a table, for errors.
const FORM: &str = "CSV with ra_deg, dec_deg (-90 to 90), mag (-30 to 60) and, optionally, mag_sigma (0 to 10), band and colour (-10 to 20)";

/// Star of known magnitude.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CatalogueStar {
    /// Direction at the time of the frame (ICRS).
    pub direction: Direction<Gcrs>,
    /// Magnitude.
    pub magnitude: f64,
    /// Error (one sigma) of the magnitude, mag; 0 if unknown.
    pub sigma_mag: f64,
    /// Colour, mag; `None` if unknown.
    pub colour: Option<f64>,
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
    /// Reads a CSV or ECSV table with the columns `ra_deg`, `dec_deg`, `mag` (or `magnitude`) and, optionally,
    /// `mag_sigma`, `band` and `colour` (or `color`, or `bp_rp` as in Gaia's tables); numbers in other units are
    /// converted. Other columns are ignored, as are lines that begin with `#`.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing, or a value is out of range.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let origin = format!("table of stars {}", path.display());
        let failed = |error: std::io::Error| {
            Error::about_file("table of stars", path, format!("is invalid ({error})")).allowing(FORM)
        };
        let rows = TableRows::open(path).map_err(failed)?;
        let column = |names: &[&'static str], unit| rows.numbers(names, unit, FORM).map_err(failed);
        let ra = column(&["ra_deg", "ra"], &DEGREES)?;
        let dec = column(&["dec_deg", "dec"], &DEGREES)?;
        let mag = column(&["mag", "magnitude"], &MAGNITUDES)?;
        let sigma = rows.optional_numbers(&["mag_sigma", "magnitude_sigma"], &MAGNITUDES).map_err(failed)?;
        let colour = rows.optional_numbers(&["colour", "color", "bp_rp"], &MAGNITUDES).map_err(failed)?;
        let band_column = rows.find("band");
        let mut stars = Vec::new();
        for row in rows {
            let row = row.map_err(failed)?;
            let number = |column, range| row.number_in(column, range).map_err(failed);
            let [ra_deg, dec_deg] = [number(ra, [f64::MIN, f64::MAX])?, number(dec, [-90.0, 90.0])?];
            let mag = number(mag, [-30.0, 60.0])?;
            // An empty cell is an unknown error.
            let sigma_mag = match sigma {
                Some(column) if !row.text(column).is_empty() => number(column, [0.0, 10.0])?,
                _ => 0.0,
            };
            let colour = match colour {
                Some(column) if !row.text(column).is_empty() => Some(number(column, [-10.0, 20.0])?),
                _ => None,
            };
            let direction = Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians());
            let band = band_column.map_or(String::new(), |column| band_name(row.text(column)));
            stars.push((CatalogueStar { direction, magnitude: mag, sigma_mag, colour }, band));
        }
        if stars.is_empty() {
            return Err(Error::about_file("table of stars", path, "is empty").allowing(FORM));
        }
        Ok(Self { origin, stars })
    }

    /// Returns the table with the stars whose colour is between two limits. Stars of unknown colour are left out.
    ///
    /// # Errors
    /// No star of the table has such a colour.
    pub fn in_colours(mut self, [bluest, reddest]: [f64; 2]) -> Result<Self, Error> {
        let is_in_range = |colour: f64| (bluest..=reddest).contains(&colour);
        let (all, known) = (self.stars.len(), self.stars.iter().filter(|(star, _)| star.colour.is_some()).count());
        self.stars.retain(|(star, _)| star.colour.is_some_and(is_in_range));
        if self.stars.is_empty() {
            let what = format!("number of stars with a colour of {bluest} to {reddest} mag in the {}", self.origin);
            let given = format!("0 of {all}, of which {known} have a colour");
            return Err(Error::invalid(what, given, "1 or more, with a column colour, color or bp_rp"));
        }
        Ok(self)
    }

    /// Returns the stars in the band of a filter and the stars without a band. The band is the first word of the
    /// filter: `g DECam SDSS` is the band `g`.
    ///
    /// # Errors
    /// The table has bands and none is that of the filter, or the filter is unknown and the table has several bands.
    pub fn in_band(&self, filter: Option<&str>) -> Result<Vec<CatalogueStar>, Error> {
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
                return Err(Error::invalid(format!("band of the frame for the {}", self.origin), "missing", allowed));
            }
        };
        let is_in_band = |band: &str| band.is_empty() || band == wanted;
        let found: Vec<CatalogueStar> =
            self.stars.iter().filter(|(_, band)| is_in_band(band)).map(|(star, _)| *star).collect();
        if found.is_empty() {
            let what = format!("band of the frame for the {}", self.origin);
            return Err(Error::invalid(what, format!("'{wanted}'"), format!("{}, by --band", bands.join(", "))));
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

    fn table(text: &str) -> Result<StarTable, Error> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        StarTable::read(file.path())
    }

    #[test]
    fn units_are_those_of_the_columns() {
        let header = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: ra, unit: hourangle, datatype: float64}\n\
             # - {name: dec, unit: rad, datatype: float64}\n# - {name: mag, unit: mmag, datatype: float64}\n";
        let stars = table(&format!("{header}ra dec mag\n2 0.1 9500\n")).unwrap().in_band(None).unwrap();
        assert!((stars[0].direction.longitude_rad() - 30_f64.to_radians()).abs() < 1e-12);
        assert!((stars[0].direction.latitude_rad() - 0.1).abs() < 1e-12 && (stars[0].magnitude - 9.5).abs() < 1e-12);
        let error = table(&format!("{header}ra_deg dec mag\n2 0.1 9500\n").replace("name: ra,", "name: ra_deg,"));
        let message = error.unwrap_err().to_string();
        assert!(message.contains("column ra_deg is in 'hourangle'; allowed: deg"), "{message}");
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
        let single = table("ra_deg,dec_deg,magnitude\n1,2,10\n").unwrap();
        assert_eq!((single.in_band(None).unwrap().len(), single.in_band(Some("g")).unwrap().len()), (1, 1));
        let only_v = table("ra_deg,dec_deg,mag,band\n1,2,10,V\n").unwrap();
        assert_eq!(only_v.in_band(None).unwrap().len(), 1);
        assert!(only_v.in_band(Some("g")).unwrap_err().to_string().contains("'g'; allowed: V"));
    }

    #[test]
    fn stars_are_selected_by_colour() {
        let text = "ra_deg,dec_deg,mag,bp_rp\n1,2,10,0.8\n1,2,11,1.6\n1,2,12,\n1,2,13,0.6\n";
        let mags = |limits| -> Vec<f64> {
            let stars = table(text).unwrap().in_colours(limits).unwrap().in_band(None).unwrap();
            stars.iter().map(|star| star.magnitude).collect()
        };
        assert_eq!((mags([0.6, 1.0]), mags([1.0, 2.0])), (vec![10.0, 13.0], vec![11.0]));
        let message = table(text).unwrap().in_colours([2.0, 3.0]).unwrap_err().to_string();
        assert!(message.contains("0 of 4, of which 3 have a colour; allowed: 1 or more"), "{message}");
        let without = table("ra_deg,dec_deg,mag\n1,2,10\n").unwrap().in_colours([0.0, 1.0]).unwrap_err().to_string();
        assert!(without.contains("of which 0 have a colour"), "{without}");
    }

    #[test]
    fn invalid_tables_are_named() {
        for (text, part) in [
            ("ra_deg,dec_deg\n1,2\n", "mag"),
            ("ra_deg,dec_deg,mag\n", "empty"),
            ("ra_deg,dec_deg,mag\n1,2,10\n1,92,10\n", "line 3: dec_deg is '92'"),
            ("ra_deg,dec_deg,mag\n1,2,nan\n", "line 2: mag is 'nan'"),
            ("ra_deg,dec_deg,mag,mag_sigma\n1,2,10,-1\n", "-1"),
            ("ra_deg,dec_deg,mag\n1,2,bright\n", "mag is 'bright'"),
        ] {
            let message = table(text).unwrap_err().to_string();
            assert!(message.contains(part) && message.contains("allowed: CSV with ra_deg"), "{message}");
        }
        assert!(StarTable::read(Path::new("/missing.csv")).unwrap_err().to_string().contains("missing.csv"));
    }
}

//! Site of a telescope, from the header of its frame.

use crate::geometry::Site;

use super::super::error::ImagesError;
use super::super::header::Header;
use super::moment::Keywords;

/// Position of the observatory, m, in the International Terrestrial Reference Frame (FITS standard 4.0, section 9.2.3).
const CARTESIAN: [&str; 3] = ["OBSGEO-X", "OBSGEO-Y", "OBSGEO-Z"];
/// Geodetic latitude and longitude, degrees, east positive, and height above the ellipsoid, m.
const GEODETIC: [&str; 3] = ["OBSGEO-B", "OBSGEO-L", "OBSGEO-H"];
/// Keywords with names of sites, in order of precedence.
const NAMES: [&str; 4] = ["INSTRUME", "TELESCOP", "OBSERVAT", "OBSERVATORY"];

/// Description of the keywords, for errors.
pub const SITE_KEYWORDS: &str = "OBSGEO-X, -Y, -Z; OBSGEO-B, -L, -H; or a known site in INSTRUME, TELESCOP or OBSERVAT";

/// Returns the site in the headers of a frame; `None` if they have no site. The headers are given in the order of
/// precedence: first the header of the image, then the primary header.
///
/// OBSGEO-X, -Y and -Z take precedence over OBSGEO-B, -L and -H. Without these, the site is the first known site among
/// the names of instrument, telescope and observatory. SITELONG, OBS-LONG and similar keywords are not read: no
/// standard defines their sign and unit, and both signs are in use.
///
/// # Errors
/// A position that is not on the Earth.
pub fn site_from_headers(headers: &[&Header]) -> Result<Option<Site>, ImagesError> {
    let keywords = Keywords(headers);
    let names = || NAMES.iter().filter_map(|keyword| keywords.text(&[keyword]).map(|(_, name)| name));
    let numbers = |names: [&str; 3]| -> Option<[f64; 3]> {
        let [Some((_, a, _)), Some((_, b, _)), Some((_, c, _))] = names.map(|name| keywords.number(&[name], |_| true))
        else {
            return None;
        };
        Some([a, b, c])
    };
    let name = keywords.text(&["TELESCOP", "OBSERVAT"]).map_or("site of the header".to_owned(), |(_, name)| name);
    let (keywords, given, site) = match (numbers(CARTESIAN), numbers(GEODETIC)) {
        (Some(at_m), _) => (CARTESIAN, at_m, Site::from_itrs_m(&name, at_m)),
        (None, Some([lat, lon, height])) => (GEODETIC, [lat, lon, height], Site::new_deg(&name, lat, lon, height)),
        (None, None) => return Ok(names().find_map(|name| Site::by_name(&name).ok())),
    };
    site.map(Some).map_err(|_| {
        let [a, b, c] = given;
        let allowed =
            "a position on the Earth, in metres or degrees, or another site with --site, --mpc or --lat and --lon";
        ImagesError::invalid(keywords.join(", "), format!("{a}, {b}, {c}"), allowed)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn site(text: &str) -> Result<Option<Site>, ImagesError> {
        site_from_headers(&[&Header::from_text(text), &Header::from_text("OBSERVAT= 'Paranal'\n")])
    }

    /// Coordinates of Rubin Observatory in both forms, as in the headers of LSSTCam, where X, Y and Z are given to
    /// centimetres.
    #[test]
    fn valid_positions_are_read_before_names() {
        let cartesian =
            "TELESCOP= 'Simonyi'\nOBSGEO-X= 1818938.94\nOBSGEO-Y= -5208470.95\nOBSGEO-Z= -3195172.08\nOBSGEO-L= 0\n";
        let geodetic = "OBSGEO_B= -30.244639\nOBSGEO_L= 289.250583\nOBSGEO_H= 2663.0\nOBSGEO-X= 1\n";
        for text in [cartesian, geodetic] {
            let site = site(text).unwrap().unwrap();
            assert!((site.latitude_rad.to_degrees() + 30.244_639).abs() < 1e-7, "{site:?}");
            assert!((site.longitude_rad.to_degrees() + 70.749_417).abs() < 1e-6, "{site:?}");
            assert!((site.height_m - 2663.0).abs() < 0.01, "{site:?}");
        }
        assert_eq!(site(cartesian).unwrap().unwrap().name, "Simonyi");
        let error = site("OBSGEO-X= 0.0\nOBSGEO-Y= 0.0\nOBSGEO-Z= 0.0\n").unwrap_err().to_string();
        assert!(error.contains("OBSGEO-X, OBSGEO-Y, OBSGEO-Z") && error.contains("0, 0, 0"), "{error}");
        assert!(site("OBSGEO-B= 91\nOBSGEO-L= 3\nOBSGEO-H= 0\n").is_err());
    }

    /// Headers of the DECam and the UK Schmidt: longitudes with the wrong sign, or counted to the west.
    #[test]
    fn names_are_read_and_longitudes_of_unknown_sign_are_not() {
        let decam = "OBS-LONG= 70.81489\nOBS-LAT = -30.16606\nTELESCOP= 'CTIO 4.0-m telescope'\nINSTRUME= 'DECam'\n";
        assert_eq!(site(decam).unwrap().unwrap().mpc_code.as_deref(), Some("W84"));
        let schmidt = "SITELAT = -31.277\nSITELONG= 210.934\nTELESCOP= 'UK Schmidt - Doubl'\n";
        // The site is that of the name in the primary header.
        assert_eq!(site(schmidt).unwrap().unwrap().name, "Paranal");
        assert_eq!(site_from_headers(&[&Header::from_text(schmidt)]).unwrap(), None);
    }
}

//! Positions of observatories and codes of the Minor Planet Center in headers.

use crate::error::Error;
use crate::geometry::Site;

use super::super::comment::Comment;
use super::super::moment::Keywords;
use super::super::moment::unreadable;
use super::names::name_of_telescope;

/// Position of the observatory, m, in the International Terrestrial Reference Frame (FITS standard 4.0, section 9.2.3).
const CARTESIAN: [&str; 3] = ["OBSGEO-X", "OBSGEO-Y", "OBSGEO-Z"];
/// Beginning of these keywords and the following.
pub(super) const OBSGEO: &str = "OBSGEO";
/// Geodetic latitude and longitude, degrees, east positive, and height above the ellipsoid, m.
pub(super) const GEODETIC: [&str; 3] = ["OBSGEO-B", "OBSGEO-L", "OBSGEO-H"];
/// Keywords of codes of the Minor Planet Center.
const MPC_CODES: &[&str] = &["MPC-CODE", "OBS-CODE", "IAU-CODE"];
/// Largest height without a unit, m. Higher ones may be in feet.
const HIGHEST_M: f64 = 9000.0;
/// Name of a site whose header has only its position.
pub const UNNAMED_SITE: &str = "site of the header";

/// Keywords that give a site, and the site.
pub(super) type StatedSite = (String, Site);

/// Returns the positions of the headers, with the keywords that give them: [`CARTESIAN`] before [`GEODETIC`].
///
/// # Errors
/// A number is invalid, or a position is not on the Earth.
pub(super) fn positions(keywords: Keywords<'_>) -> Result<Vec<StatedSite>, Error> {
    let name = name_of_telescope(keywords).unwrap_or_else(|| UNNAMED_SITE.to_owned());
    let mut sites = Vec::new();
    for names in [CARTESIAN, GEODETIC] {
        let [Some(a), Some(b), Some(c)] = names.map(|name| coordinate(keywords, name)) else { continue };
        let [a, b, c] = [a?, b?, c?];
        if [a, b, c] == [0.0; 3] {
            let allowed = "the position of the telescope, or for example --site, --mpc or --lat and --lon";
            return Err(Error::invalid(names.join(", "), "0, 0, 0", allowed));
        }
        let site = if names == CARTESIAN { Site::from_itrs_m(&name, [a, b, c]) } else { Site::new_deg(&name, a, b, c) };
        let site = site.map_err(|_| {
            let allowed = "a position on the Earth, in metres or degrees, or another site with --site, --mpc or --lat \
                           and --lon, or for a telescope in orbit --observer-elements";
            Error::invalid(names.join(", "), format!("{a}, {b}, {c}"), allowed)
        })?;
        sites.push((format!("{}, ...", names[0]), site));
    }
    Ok(sites)
}

/// Returns the sites of codes of the Minor Planet Center with their keywords, and an unknown code with its keyword.
pub(super) fn codes(keywords: Keywords<'_>) -> (Vec<StatedSite>, Option<(String, String)>) {
    let (mut sites, mut unknown) = (Vec::new(), None);
    for keyword in MPC_CODES {
        let number = keywords.number(&[keyword], |_| true).map(|(name, number, _)| (name, format!("{number:03}")));
        let Some((name, code)) = keywords.text(&[keyword]).or(number) else { continue };
        match Site::from_mpc(&code) {
            Ok(site) => sites.push((format!("{name} {code:?}"), site)),
            // Codes have digits, "none" has not.
            Err(_) if !code.contains(|c: char| c.is_ascii_digit()) => {}
            Err(_) => unknown = Some((name, code)),
        }
    }
    (sites, unknown)
}

/// Returns a sentence about a position or a code that differs between the headers.
pub(super) fn difference_of_positions(keywords: Keywords<'_>) -> Option<String> {
    CARTESIAN.iter().chain(&GEODETIC).chain(MPC_CODES).find_map(|name| keywords.difference(name))
}

/// Returns a number of [`CARTESIAN`] or [`GEODETIC`], in metres or degrees, with the unit that its comment states. It
/// may be a text such as `30 14 40 S` or `2663 m`.
pub(super) fn coordinate(keywords: Keywords<'_>, name: &str) -> Option<Result<f64, Error>> {
    let (header, keyword) = keywords.find(name)?;
    let is_angle = name == GEODETIC[0] || name == GEODETIC[1];
    let (value, text) = match (header.number(&keyword), header.text(&keyword)) {
        (Some(value), _) => (value, header.comment(&keyword)),
        // "unknown"
        (None, Some(text)) if !text.contains(|c: char| c.is_ascii_digit()) => return None,
        (None, Some(text)) if is_angle => {
            let Some(value) = degrees(&text) else {
                let allowed = "degrees such as -30.2446, -30:14:40 or '30 14 40 S', or for example --site";
                return Some(Err(unreadable(keyword, &text, allowed)));
            };
            (value, header.comment(&keyword))
        }
        (None, text) => {
            let text = text?;
            let (number, unit) = text.split_at(text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len()));
            let Ok(number) = number.trim().parse() else {
                return Some(Err(unreadable(keyword, &text, "a number of metres, or for example --site")));
            };
            (number, format!("[{unit}]"))
        }
    };
    let comment = Comment::new(&text);
    let bracket =
        text.trim_start().strip_prefix('[').and_then(|rest| rest.split_once(']')).map(|(unit, _)| unit.trim());
    let units: [(f64, &str); 4] = if is_angle {
        [
            (1.0, "deg degree degrees"),
            (1f64.to_degrees(), "rad radian radians"),
            (1.0 / 60.0, "arcmin"),
            (15.0, "h hour hours"),
        ]
    } else {
        [
            (1.0, "m meter meters metre metres"),
            (1e3, "km kilometer kilometers kilometre kilometres"),
            (0.3048, "ft foot feet"),
            (1e-2, "cm"),
        ]
    };
    let stated = Comment::new(bracket.unwrap_or(&text));
    // "1h22m" is already converted.
    let is_converted = is_angle && header.text(&keyword).is_some_and(|text| is_in_hours(&text));
    let factor = units.iter().find(|(_, words)| stated.has(words)).map(|(factor, _)| *factor);
    let factor = if is_converted { Some(1.0) } else { factor };
    // Positive to the west, unless the comment also names the other side, as in "east positive, west negative".
    let is_reversed = value > 0.0
        && ((name == GEODETIC[1] && comment.has("west w") && !comment.has("east e"))
            || (name == GEODETIC[0] && comment.has("south s") && !comment.has("north n")));
    let is_too_high = name == GEODETIC[2] && factor.is_none() && value > HIGHEST_M;
    Some(match factor.or(bracket.is_none().then_some(1.0)) {
        Some(factor) if !is_reversed && !is_too_high => Ok(factor * value),
        _ => {
            let allowed = "degrees to the north and east, and at most 9000 m or a height with its unit, or for example --site, \
                           --mpc or --lat and --lon";
            Err(Error::invalid(keyword, format!("{value} (comment {text:?})"), allowed))
        }
    })
}

fn is_in_hours(text: &str) -> bool {
    text.split_once('h').is_some_and(|(before, _)| before.ends_with(|c: char| c.is_ascii_digit()))
}

/// Parses an angle such as `-30.24`, `-30:14:40`, `30d14m40s`, `30 14 40 S`, `W110` or `-7h20m`, degrees.
pub(super) fn degrees(text: &str) -> Option<f64> {
    let text = text.trim();
    let last = text.rsplit(|c: char| !c.is_ascii_alphabetic()).next().unwrap_or_default().to_ascii_lowercase();
    let is_side =
        ["south", "w", "west"].contains(&&*last) || text.ends_with('S') || (last == "s" && !text.contains(['d', 'm']));
    let is_negative = is_side || text.starts_with(['-', 'S', 's', 'W', 'w']);
    let unit = if is_in_hours(text) { 15.0 } else { 1.0 };
    let mut parts = text.split(|c: char| !c.is_ascii_digit() && c != '.').filter(|part| !part.is_empty());
    let whole: f64 = parts.next()?.parse().ok()?;
    let rest: Option<Vec<f64>> = parts.take(2).map(|part| part.parse().ok()).collect();
    let value = whole + rest?.iter().zip([60.0, 3600.0]).map(|(part, unit)| part / unit).sum::<f64>();
    Some(if is_negative { -unit * value } else { unit * value })
}

#[cfg(test)]
mod tests {
    use super::super::site_from_headers;
    use super::*;
    use crate::images::header::Header;

    fn found(headers: &[&Header]) -> Result<Option<Site>, Error> {
        site_from_headers(headers).map(|found| found.map(|found| found.site))
    }

    /// A longitude in hours is converted once, and a text without digits is no coordinate.
    #[test]
    fn texts_of_coordinates() {
        let of = |longitude: &str| {
            let found =
                found(&[&Header::from_text(&format!("OBSGEO-B= 30.0\nOBSGEO-L= {longitude}\nOBSGEO-H= 1000.0\n"))]);
            found.unwrap().unwrap().longitude_rad.to_degrees()
        };
        for longitude in ["'1h22m' / longitude in hours", "'1h22m' / [h]", "'1h22m'", "1.36666666667 / [h]"] {
            assert!((of(longitude) - 20.5).abs() < 1e-6, "{longitude}");
        }
        for text in ["OBSGEO-B= 'unknown'", "OBSGEO-L= 'n/a'\nOBSGEO-H= 'n/a'"] {
            let found = found(&[&Header::from_text(&format!("{text}\nTELESCOP= 'Gemini-North'"))]);
            assert!(found.is_ok_and(|site| site.is_some()), "{text}");
        }
    }

    #[test]
    fn positions_are_read_in_all_forms() {
        for text in [
            "OBSGEO-B= '30:00:00'\nOBSGEO-L= '-110 00 00'\nOBSGEO-H= '1000'\n",
            "OBSGEO-B= '30 00 00 N'\nOBSGEO-L= '110 00 00 W'\nOBSGEO-H= '1000 m'\n",
            "OBSGEO-B= 'N30'\nOBSGEO-L= 'W110'\nOBSGEO-H= '3280.84 ft'\n",
            "OBSGEO-B= '30:00 North'\nOBSGEO-L= '110:00 West'\nOBSGEO-H= 1000\n",
            "OBSGEO-B= 30.0\nOBSGEO-L= -7.3333333 / hours\nOBSGEO-H= 1000\n",
            "OBSGEO-B= '30d00m00s'\nOBSGEO-L= '-7h20m00s'\nOBSGEO-H= 1000\n",
            "OBSGEO-X= '-1891071.3'\nOBSGEO-Y= '-5195675.8 m'\nOBSGEO-Z= '3170.8737 km'\n",
        ] {
            let site = found(&[&Header::from_text(text)]).unwrap().unwrap();
            assert!((site.latitude_rad.to_degrees() - 30.0).abs() < 1e-4, "{text}: {site:?}");
            assert!((site.longitude_rad.to_degrees() + 110.0).abs() < 1e-4, "{text}: {site:?}");
            assert!((site.height_m - 1000.0).abs() < 1.0, "{text}: {site:?}");
        }
        for text in [
            "OBSGEO-B= '95 here'\nOBSGEO-L= 3\nOBSGEO-H= 0\n",
            "OBSGEO-B= 30\nOBSGEO-L= 3\nOBSGEO-H= '5 furlongs'\n",
            "OBSGEO-B= 30\nOBSGEO-L= '110:00:00' / west\nOBSGEO-H= 0\n",
            "OBSGEO-B= 30\nOBSGEO-L= 3\nOBSGEO-H= 13796\n",
            "OBSERVAT= 'CTIO'\nOBSGEO-B= 19.8\n",
            "OBSERVAT= 'CTIO'\nMPCCODE = 568\n",
        ] {
            assert!(found(&[&Header::from_text(text)]).is_err(), "{text}");
        }
        for (text, name) in [
            ("MPC_CODE= '807'\n", "Cerro Tololo"),
            ("OBSERVAT= 'CTIO'\nLAT-OBS = 30.17 / South\nLONGITUD= '70.81 West'\n", "Cerro Tololo"),
            ("TELESCOP= 'ATLAS'\nSITELAT = -30.47\n", "ATLAS Chile"),
            ("OBSERVAT= 'Gemini'\nLATITUDE= '+19:49:26'\n", "Gemini North"),
        ] {
            assert_eq!(found(&[&Header::from_text(text)]).unwrap().unwrap().name, name, "{text}");
        }
    }

    /// Units and senses that the comments of OBSGEO keywords state.
    #[test]
    fn units_of_positions_are_read() {
        let of = |latitude: &str, longitude: &str, height: &str| {
            let text = format!("OBSGEO-B= {latitude}\nOBSGEO-L= {longitude}\nOBSGEO-H= {height}\n");
            found(&[&Header::from_text(&text)])
        };
        for (latitude, longitude, height) in [
            ("0.5235988 / [rad]", "-1.9198622 / [rad]", "1000.0"),
            ("30.0 / [deg] latitude (north)", "-110.0 / [deg] East positive, West negative", "1.0 / [km]"),
            ("30.0", "250.0 / degrees", "3280.84 / height in feet"),
        ] {
            let site = of(latitude, longitude, height).unwrap().unwrap();
            assert!((site.latitude_rad.to_degrees() - 30.0).abs() < 1e-5, "{site:?}");
            assert!((site.longitude_rad.to_degrees() + 110.0).abs() < 1e-5, "{site:?}");
            assert!((site.height_m - 1000.0).abs() < 0.01, "{site:?}");
        }
        for (latitude, longitude, height) in [
            ("30.0", "110.0 / [deg] West longitude", "1000.0"),
            ("30.0 / South", "110.0", "1000.0"),
            ("30.0 / [gon]", "110.0", "1000.0"),
        ] {
            let error = of(latitude, longitude, height).unwrap_err().to_string();
            assert!(error.contains("--site") && error.contains("OBSGEO"), "{error}");
        }
        let km = Header::from_text(
            "OBSGEO-X= 1818.93894 / [km]\nOBSGEO-Y= -5208.47095 / [km]\nOBSGEO-Z= -3195.17208 / [km]\n",
        );
        let site = found(&[&km]).unwrap().unwrap();
        assert!((site.height_m - 2663.0).abs() < 0.1, "{site:?}");
    }
}

//! Site of a telescope, from the header of its frame.

use crate::error::Error;
use crate::geometry::Site;

use super::super::header::Header;
use super::comment::Comment;
use super::instants::unreadable;
use super::moment::Keywords;

/// Position of the observatory, m, in the International Terrestrial Reference Frame (FITS standard 4.0, section 9.2.3).
const CARTESIAN: [&str; 3] = ["OBSGEO-X", "OBSGEO-Y", "OBSGEO-Z"];
/// Beginning of these keywords and the following.
const OBSGEO: &str = "OBSGEO";
/// Geodetic latitude and longitude, degrees, east positive, and height above the ellipsoid, m.
const GEODETIC: [&str; 3] = ["OBSGEO-B", "OBSGEO-L", "OBSGEO-H"];
/// Cameras of one telescope. Other instruments have names of sites elsewhere: FAST is a spectrograph in Arizona, and a
/// radio telescope in China.
const CAMERAS: [&str; 6] = ["DECam", "HSC", "Hyper Suprime-Cam", "DESI", "ZTF", "Tomo-e Gozen"];
/// Keywords with names of sites, in order of precedence.
const NAMES: [&str; 7] = ["INSTRUME", "TELESCOP", "OBSERVAT", "OBSERVATORY", "SITENAME", "SITE", SITE_CODE];
/// Keyword of codes such as `coj` (Las Cumbres Observatory). Numbers are no codes of the Minor Planet
/// Center in this keyword, because they have another meaning in other headers.
const SITE_CODE: &str = "SITEID";
/// Telescopes in orbits about the Earth; those about the Sun have no element sets.
const IN_ORBIT: [&str; 5] = ["HST", "NEOSSat", "WISE", "CHEOPS", "SWIFT"];
/// Keywords of codes of the Minor Planet Center.
const MPC_CODES: &[&str] = &["MPC-CODE", "OBS-CODE", "IAU-CODE"];
/// Codes of the sites of the Las Cumbres Observatory.
const LAS_CUMBRES: [&str; 7] = ["coj", "cpt", "elp", "lsc", "ogg", "tfn", "tlv"];
/// Keywords of latitude and longitude that do not give the site, because no standard defines the sign and the unit of
/// the longitude. They must agree with the name of the site in one of the usual senses.
const LATITUDES: &[&str] = &[
    "SITE-LAT",
    "OBS-LAT",
    "LAT-OBS",
    "LATITUD",
    "LATITUDE",
    "GEO-LAT",
    "TEL-LAT",
    "LAT",
    "ESO TEL GEOLAT",
    "OBSGEO-B",
];
const LONGITUDES: &[&str] = &[
    "SITE-LONG",
    "SITE-LON",
    "OBS-LONG",
    "OBS-LON",
    "LONG-OBS",
    "LON-OBS",
    "LONGITUD",
    "LONGITUDE",
    "GEO-LON",
    "GEO-LONG",
    "TEL-LONG",
    "TEL-LON",
    "LON",
    "LONG",
    "ESO TEL GEOLON",
    "OBSGEO-L",
];
/// Largest height without a unit, m. Higher ones may be in feet.
const HIGHEST_M: f64 = 9000.0;
/// Largest accepted difference of these from the site, degrees.
const ROUGH_DEG: f64 = 0.5;

/// Description of the keywords, for errors.
pub const SITE_KEYWORDS: &str =
    "OBSGEO-X, -Y, -Z; OBSGEO-B, -L, -H; MPC-CODE; or a known site in INSTRUME, TELESCOP or OBSERVAT";

/// Site in the headers of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct HeaderSite {
    /// The site.
    pub site: Site,
    /// Sentence about a longitude that fits the site only if it is counted to the west or in hours, or about an unknown
    /// code of the Minor Planet Center.
    pub remark: Option<String>,
}

/// Largest distance of two sites of a header that is not stated, km: satellites 500 km away move by 40 arcsec.
const STATED_KM: f64 = 0.1;
/// Largest distance of two sites of a header, km, such as a mountain and a telescope on it: satellites 500 km away move
/// by 0.3 deg.
const LARGEST_KM: f64 = 3.0;
/// Names in headers of the telescopes at several sites, in lower case and without blanks, with the sites: a mountain,
/// which is also a name of one of its telescopes, and a survey.
const SHARED_NAMES: [(&str, &[&str]); 4] = [
    ("cerropachon", &["Rubin Observatory", "Gemini South", "SOAR"]),
    ("pachon", &["Rubin Observatory", "Gemini South", "SOAR"]),
    ("catalinaskysurvey", &["Catalina Sky Survey", "Mount Lemmon Survey"]),
    ("css", &["Catalina Sky Survey", "Mount Lemmon Survey"]),
];

/// Name of a site whose header has only its position.
pub const UNNAMED_SITE: &str = "site of the header";

/// Returns the site in the headers of a frame; `None` if they have no site. The headers are given in the order of
/// precedence: first the header of the image, then the primary header.
///
/// OBSGEO-X, -Y and -Z take precedence over OBSGEO-B, -L and -H. Without these, the site is the first known site among
/// the names of instrument, telescope and observatory. SITELONG, OBS-LONG and similar keywords do not give the
/// site, because no standard defines their sign and unit, and both signs are in use; they must not contradict it.
///
/// # Errors
/// A position that is not on the Earth; names and positions more than 3 km apart; SITELAT, SITELONG, ... of another
/// place; or a name that fits several sites, such as ATLAS, without a keyword that decides between them. Names of
/// several sites and parts of names do not contradict a position: they are also those of mounts.
pub fn site_from_headers(headers: &[&Header]) -> Result<Option<HeaderSite>, Error> {
    let keywords = Keywords(headers);
    let mut names = ["TELESCOP", "OBSERVAT"].iter().filter_map(|name| keywords.text(&[name]));
    let name = names.find(|(_, text)| !is_no_site(text)).map_or(UNNAMED_SITE.to_owned(), |(_, name)| name);
    // Sites with the keywords that give them, in order of precedence.
    let mut stated: Vec<(String, Site)> = Vec::new();
    for names in [CARTESIAN, GEODETIC] {
        let [Some(a), Some(b), Some(c)] = names.map(|name| coordinate(keywords, name)) else { continue };
        let [a, b, c] = [a?, b?, c?];
        let site = if names == CARTESIAN { Site::from_itrs_m(&name, [a, b, c]) } else { Site::new_deg(&name, a, b, c) };
        let site = site.map_err(|_| {
            let allowed =
                "a position on the Earth, in metres or degrees, or another site with --site, --mpc or --lat and --lon";
            Error::invalid(names.join(", "), format!("{a}, {b}, {c}"), allowed)
        })?;
        if [a, b, c] == [0.0; 3] {
            let allowed = "the position of the telescope, or for example --site, --mpc or --lat and --lon";
            return Err(Error::invalid(names.join(", "), "0, 0, 0", allowed));
        }
        stated.push((format!("{}, ...", names[0]), site));
    }
    // Codes and their keywords.
    let mut unknown: Option<(String, String)> = None;
    for keyword in MPC_CODES {
        let number = keywords.number(&[keyword], |_| true).map(|(name, number, _)| (name, format!("{number:03}")));
        let Some((name, code)) = keywords.text(&[keyword]).or(number) else { continue };
        match Site::from_mpc(&code) {
            Ok(site) => stated.push((format!("{name} {code:?}"), site)),
            // Codes have digits, "none" has not.
            Err(_) if !code.contains(|c: char| c.is_ascii_digit()) => {}
            Err(_) => unknown = Some((name, code)),
        }
    }
    let is_position = !stated.is_empty();
    // Names of several sites, and of sites that are part of an unknown name.
    let mut networks: Vec<(String, Vec<&Site>)> = Vec::new();
    let mut hints: Vec<(String, Vec<&Site>)> = Vec::new();
    // The primary header and that of the image may have different names.
    for (keyword, text) in
        NAMES.iter().flat_map(|keyword| keywords.texts(keyword).into_iter().map(move |text| (*keyword, text)))
    {
        // WISE in capitals is the telescope in space, and Wise a site on the Earth.
        if text == "WISE" || is_no_site(&text) {
            continue;
        }
        if keyword == SITE_CODE && !LAS_CUMBRES.iter().any(|code| code.eq_ignore_ascii_case(&text)) {
            continue;
        }
        if keyword == NAMES[0] && !CAMERAS.iter().any(|camera| camera.eq_ignore_ascii_case(&text)) {
            continue;
        }
        let shown = format!("{keyword} {text:?}");
        let candidates =
            if keyword == SITE_CODE { Site::with_key(&text).into_iter().collect() } else { candidates(&text) };
        match candidates.as_slice() {
            // "CTIO 1.0 meter telescope": the first word must not contradict another name.
            [] => {
                let word = text.split([' ', ',', '/']).next().unwrap_or_default();
                hints.extend(Site::with_key(word).map(|site| (shown, vec![site])));
            }
            [site] => stated.push((shown, (*site).clone())),
            // The latitude and the longitude decide between the sites of a network.
            sites => match sites.iter().filter(|site| compared(keywords, site, true).is_ok()).collect::<Vec<_>>()[..] {
                [site] => stated.push((shown, (*site).clone())),
                _ => networks.push((shown, sites.to_vec())),
            },
        }
    }
    // "Gemini" and "Cerro Pachon" have one site in common.
    if let ([], [(from, sites), others @ ..]) = (&stated[..], &networks[..]) {
        let is_near = |site: &Site, sites: &[&Site]| sites.iter().any(|other| site.distance_km(other) <= STATED_KM);
        let common = sites.iter().filter(|site| others.iter().all(|(_, sites)| is_near(site, sites)));
        if let [site] = common.collect::<Vec<_>>()[..] {
            stated.push((from.clone(), (*site).clone()));
        }
    }
    let Some((first_from, first)) = stated.first() else {
        return match (networks.first(), unknown) {
            (None, None) => Ok(None),
            (None, Some((name, code))) => {
                let allowed =
                    "a known code of the Minor Planet Center, or for example --site, --mpc or --lat and --lon";
                Err(Error::unknown(name, &code, allowed))
            }
            (Some((from, sites)), _) => {
                let names: Vec<&str> = sites.iter().map(|site| site.name.as_str()).collect();
                let given = format!("one of several sites: {}", names.join(", "));
                Err(Error::invalid(from.clone(), given, "the name of one site, or for example --site or --mpc"))
            }
        };
    };
    let others = stated[1..].iter().map(|(from, site)| (from, site.distance_km(first), true));
    let near_km = |sites: &[&Site]| sites.iter().map(|site| site.distance_km(first)).fold(f64::INFINITY, f64::min);
    // Mounts have names of observatories, too, such as Gemini and Atlas: they do not contradict a position.
    let of_names = networks.iter().chain(&hints).map(|(from, sites)| (from, near_km(sites), !is_position));
    let others: Vec<(&String, f64, bool)> = others.chain(of_names).collect();
    let other = others.iter().find(|(_, distance_km, _)| *distance_km > STATED_KM).map(|(from, distance_km, _)| {
        let digits = usize::from(*distance_km < 10.0);
        format!(
            "the site is that of {first_from}, {distance_km:.digits$} km from that of {from}; for another one specify --site"
        )
    });
    match others.iter().find(|(_, distance_km, is_contradiction)| *is_contradiction && *distance_km > LARGEST_KM) {
        Some((from, distance_km, _)) => {
            let given = format!("{distance_km:.0} km from that of {from}");
            let allowed = format!("one site within {LARGEST_KM} km, or for example --site, --mpc or --lat and --lon");
            Err(Error::invalid(format!("site of {first_from}"), given, allowed))
        }
        None => {
            let is_named = stated.iter().any(|(from, _)| !from.starts_with(OBSGEO)) || !networks.is_empty();
            let remark = compared(keywords, first, is_named).map_err(|given| {
                let allowed = "the coordinates of this site, or for example --site, --mpc or --lat and --lon";
                Error::invalid(format!("site of {first_from}"), given, allowed)
            })?;
            let unknown = unknown.map(|(name, code)| {
                format!("{name} {code:?} is no known code of the Minor Planet Center: it is not used")
            });
            let mut site = first.clone();
            // The name is not that of this position.
            if first_from.starts_with(OBSGEO) && other.is_some() {
                site.name = UNNAMED_SITE.to_owned();
            }
            let positions = || CARTESIAN.iter().chain(&GEODETIC).chain(MPC_CODES);
            let difference = || positions().find_map(|name| keywords.difference(name));
            let remarks: Vec<String> = [remark, other, unknown].into_iter().flatten().collect();
            let remarks = if remarks.is_empty() { difference().into_iter().collect() } else { remarks };
            Ok(Some(HeaderSite { site, remark: (!remarks.is_empty()).then(|| remarks.join("; ")) }))
        }
    }
}

/// Returns true for a text in place of the name of a site: "NOT SET" and "Not connected" of mounts (NOT alone is the
/// Nordic Optical Telescope), WISE in capitals, the telescope in space, and Vista in small letters, a mount.
fn is_no_site(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let is_denied = lower.strip_prefix("not ").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()));
    is_denied || text == "WISE" || text == "Vista"
}

/// Returns the sites that a name in a header can mean.
fn candidates(name: &str) -> Vec<&'static Site> {
    let key: String = name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    match SHARED_NAMES.iter().find(|(shared, _)| *shared == key) {
        Some((_, names)) => names.iter().filter_map(|name| Site::with_key(name)).collect(),
        None => Site::candidates(name),
    }
}

/// Returns a sentence about what gives no site: a telescope in orbit, or the latitude and the longitude in keywords
/// that no standard defines, which are not used without the name of a site; `None` if the headers have neither.
pub fn unused_coordinates(headers: &[&Header]) -> Option<String> {
    let keywords = Keywords(headers);
    let telescope = keywords.text(&["TELESCOP"]).map(|(_, name)| name).unwrap_or_default();
    if IN_ORBIT.iter().any(|name| telescope.eq_ignore_ascii_case(name)) {
        return Some(format!("TELESCOP {telescope:?} is in orbit: specify --observer-elements with its elements"));
    }
    let found = |names: &[&str]| {
        names.iter().find_map(|name| {
            let (header, keyword) = keywords.find(name)?;
            let value = header.number(&keyword).or_else(|| degrees(&header.text(&keyword)?))?;
            (value != 0.0).then_some((keyword, (1e5 * value).round() / 1e5))
        })
    };
    let ((latitude, latitude_deg), (longitude, longitude_deg)) = (found(LATITUDES)?, found(LONGITUDES)?);
    Some(format!(
        "{latitude} {latitude_deg} and {longitude} {longitude_deg} are not used, because no standard defines whether the \
         longitude is counted to the east: specify --lat {latitude_deg} --lon {longitude_deg}, or --lon {} if it is \
         counted to the west, and --height",
        -longitude_deg
    ))
}

/// Returns a number of [`CARTESIAN`] or [`GEODETIC`], in metres or degrees, with the unit that its comment states. It
/// may be a text such as `30 14 40 S` or `2663 m`.
fn coordinate(keywords: Keywords<'_>, name: &str) -> Option<Result<f64, Error>> {
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

/// Returns the longitude in keywords that no standard defines: its size is certain, its sign is not.
pub(super) fn longitude_of_unknown_sense_deg(keywords: Keywords<'_>) -> Option<f64> {
    let number = keywords.number(LONGITUDES, |_| true).map(|(_, value, _)| value);
    let value = number.or_else(|| degrees(&keywords.text(LONGITUDES)?.1))?;
    Some((value + 180.0).rem_euclid(360.0) - 180.0)
}

/// Compares the site with the latitude and the longitude in keywords that no standard defines. Returns a sentence if
/// the longitude fits only to the west or in hours, and its comment does not say so. Zeros and text without numbers are
/// ignored.
///
/// # Errors
/// The reason why the latitude or the longitude is that of another place in any usual sense, or in the sense that its
/// comment states, unless the site has a name (DECam writes 70.81 as "east longitude").
fn compared(keywords: Keywords<'_>, site: &Site, is_named: bool) -> Result<Option<String>, String> {
    // Latitude and longitude of an incomplete position.
    let is_complete = GEODETIC.iter().all(|name| coordinate(keywords, name).is_some());
    let stated = |names: &[&str]| {
        names.iter().filter(|name| !(is_complete && name.starts_with(OBSGEO))).find_map(|name| {
            let (header, keyword) = keywords.find(name)?;
            let number = header.number(&keyword);
            let value = number.or_else(|| degrees(&header.text(&keyword)?)).filter(|value| *value != 0.0)?;
            let shown = number
                .map_or_else(|| format!("{:?}", header.text(&keyword).unwrap_or_default()), |_| value.to_string());
            Some((value, format!("{keyword} is {shown}"), keywords.comment(header, &keyword)))
        })
    };
    let is_far = |a_deg: f64, b_deg: f64| ((a_deg - b_deg + 180.0).rem_euclid(360.0) - 180.0).abs() > ROUGH_DEG;
    let (latitude_deg, longitude_deg) = (site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees());
    let named = format!("at latitude {latitude_deg:.2} and longitude {longitude_deg:.2} deg");
    if let Some((value, given, comment)) = stated(LATITUDES)
        && is_far(value, latitude_deg)
        && (is_far(-value, latitude_deg) || !comment.has("south s"))
    {
        return Err(format!("{named}, but {given}"));
    }
    let Some((value, given, comment)) = stated(LONGITUDES) else { return Ok(None) };
    let senses = [
        (value, ""),
        (-value, "counted to the west"),
        (15.0 * value, "in hours"),
        (-15.0 * value, "in hours, counted to the west"),
    ];
    let Some((_, sense)) = senses.iter().find(|(sense_deg, _)| !is_far(*sense_deg, longitude_deg)) else {
        return Err(format!("{named}, but {given}"));
    };
    // "East is negative" is counted to the west.
    let is_negated = comment.has("negative neg") && !comment.has("west w");
    let (is_east, is_west) = (comment.has("east e") && !is_negated, comment.has("west w") || is_negated);
    if sense.is_empty() || (is_west && !is_east) {
        return Ok(None);
    }
    if is_east && !is_west && !is_named {
        return Err(format!("{named}, but {given} (comment {:?})", comment.text()));
    }
    Ok(Some(format!("{given}, which is read as {sense}, as it fits the site (longitude {longitude_deg:.2} deg)")))
}

fn is_in_hours(text: &str) -> bool {
    text.split_once('h').is_some_and(|(before, _)| before.ends_with(|c: char| c.is_ascii_digit()))
}

/// Parses an angle such as `-30.24`, `-30:14:40`, `30d14m40s`, `30 14 40 S`, `W110` or `-7h20m`, degrees.
fn degrees(text: &str) -> Option<f64> {
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
    use super::*;

    fn found(headers: &[&Header]) -> Result<Option<Site>, Error> {
        site_from_headers(headers).map(|found| found.map(|found| found.site))
    }

    fn site(text: &str) -> Result<Option<Site>, Error> {
        found(&[&Header::from_text(text), &Header::from_text("OBSERVAT= 'CTIO'\n")])
    }

    fn remark(text: &str) -> Result<String, String> {
        let found = site_from_headers(&[&Header::from_text(text)]).map_err(|error| error.to_string())?;
        Ok(found.and_then(|found| found.remark).unwrap_or_default())
    }

    /// Names of different sites in the headers of the image and of the file are an error, and other positions are
    /// stated.
    #[test]
    fn valid_sites_of_two_headers_are_compared() {
        let read = |image: &str, primary: &str| {
            let [image, primary] = [image, primary].map(Header::from_text);
            let found = site_from_headers(&[&image, &primary]).map_err(|error| error.to_string())?;
            Ok::<String, String>(found.and_then(|found| found.remark).unwrap_or_default())
        };
        let error = read("TELESCOP= 'VST'", "TELESCOP= 'Subaru'").unwrap_err();
        assert!(error.contains("TELESCOP \"VST\"") && error.contains("TELESCOP \"Subaru\""), "{error}");
        assert_eq!(read("TELESCOP= 'Subaru'", "TELESCOP= 'Subaru'"), Ok(String::new()));
        assert_eq!(read("TELESCOP= 'Subaru'", "TELESCOP= 'my telescope'"), Ok(String::new()));
        let position = "OBSGEO-B= 30.0\nOBSGEO-L= -110.0\nOBSGEO-H= 1000.0\n";
        let remark = read(position, &position.replace("30.0", "31.0"));
        assert!(remark.is_ok_and(|remark| remark.contains("OBSGEO-B is 30 in the header of the image, and 31")));
    }

    #[test]
    fn unknown_codes_are_stated() {
        for code in ["'Z99'", "999.5"] {
            assert!(
                remark(&format!("OBSERVAT= 'CTIO'\nMPC-CODE= {code}")).unwrap().contains("is no known code"),
                "{code}"
            );
        }
        for code in ["'807'", "'none'"] {
            assert_eq!(remark(&format!("OBSERVAT= 'CTIO'\nMPC-CODE= {code}")).unwrap(), "", "{code}");
        }
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

    /// Longitudes to the west or in hours beside a position or a name.
    #[test]
    fn longitudes_in_other_senses_are_stated() {
        let position = "OBSGEO-B= 30.0\nOBSGEO-L= -110.0\nOBSGEO-H= 1000.0\n";
        for (text, expected) in [
            (format!("{position}LONGITUD= 110.0"), "LONGITUD is 110, which is read as counted to the west"),
            (
                format!("{position}SITELONG= '+110 00 00'"),
                "SITELONG is \"+110 00 00\", which is read as counted to the west",
            ),
            ("OBSERVAT= 'Palomar'\nLONGITUD= '07:47:27'".to_owned(), "read as in hours, counted to the west"),
            ("OBSERVAT= 'CTIO'\nOBS-LONG= 70.81489 / [deg] east longitude".to_owned(), "counted to the west"),
            (format!("{position}LONGITUD= 110.0 / [deg W]"), ""),
            (format!("{position}LONGITUD= -110.0"), ""),
            (format!("{position}LONGITUD= 250.0"), ""),
        ] {
            let remark = remark(&text).unwrap();
            assert!(remark.contains(expected) && remark.is_empty() == expected.is_empty(), "{text}: {remark}");
        }
        let error = remark(&format!("{position}LONGITUD= 110.0 / [deg] east positive")).unwrap_err();
        assert!(error.contains("LONGITUD is 110 (comment"), "{error}");
    }

    #[test]
    fn codes_of_las_cumbres_are_sites() {
        for (code, name) in
            [("coj", "LCO Siding Spring"), ("tlv", "Wise Observatory"), ("ogg", "Faulkes Telescope North")]
        {
            let header = Header::from_text(&format!("TELESCOP= '1m0-09'\nSITEID  = '{code}'\n"));
            assert_eq!(found(&[&header]).unwrap().unwrap().name, name);
        }
        assert_eq!(found(&[&Header::from_text("SITEID  = '703'\n")]).unwrap(), None);
        let error = site("SITEID  = 'cpt'\n").unwrap_err().to_string();
        assert!(error.contains("km from that of SITEID"), "{error}");
    }

    /// Coordinates of Rubin Observatory in both forms, as in the headers of LSSTCam, where X, Y and Z are given to
    /// centimetres.
    #[test]
    fn valid_positions_are_read_before_names() {
        let cartesian =
            "TELESCOP= 'Simonyi'\nOBSGEO-X= 1818938.94\nOBSGEO-Y= -5208470.95\nOBSGEO-Z= -3195172.08\nOBSGEO-L= 0\n";
        let geodetic = "OBSGEO_B= -30.244639\nOBSGEO_L= 289.250583\nOBSGEO_H= 2663.0\nOBSGEO-X= 1\n";
        for text in [cartesian, geodetic] {
            let site = found(&[&Header::from_text(text)]).unwrap().unwrap();
            assert!((site.latitude_rad.to_degrees() + 30.244_639).abs() < 1e-7, "{site:?}");
            assert!((site.longitude_rad.to_degrees() + 70.749_417).abs() < 1e-6, "{site:?}");
            assert!((site.height_m - 2663.0).abs() < 0.01, "{site:?}");
        }
        assert_eq!(found(&[&Header::from_text(cartesian)]).unwrap().unwrap().name, "Simonyi");
        // Cerro Tololo is 10 km from it.
        assert!(site(cartesian).unwrap_err().to_string().contains("10 km from that of OBSERVAT \"CTIO\""));
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
        assert_eq!(found(&[&Header::from_text(schmidt)]).unwrap(), None);
        for (telescope, name) in [("ESO-NTT", "La Silla"), ("ESO-VLT-U4", "Paranal"), ("NASA IRTF", "IRTF")] {
            let header = Header::from_text(&format!("TELESCOP= '{telescope}'\n"));
            assert_eq!(found(&[&header]).unwrap().unwrap().name, name);
        }
        // The primary header names another observatory.
        let error = site(schmidt).unwrap_err().to_string();
        assert!(error.contains("SITELAT is -31.277"), "{error}");
        for fits in [
            "SITELONG= '-70:48:53'\n",
            "OBS-LONG= '04:43:15'\n",
            "LONGITUD= 289.2\n",
            "SITELAT = '30 10 S'\n",
            "SITELAT = 0.0\n",
        ] {
            assert_eq!(site(fits).unwrap().unwrap().name, "Cerro Tololo", "{fits}");
        }
        for far in ["SITELONG= -155.5\n", "LATITUDE= 19.8\n", "SITELAT = '+30:10:00'\n", "SITENAME= 'Siding Spring'\n"]
        {
            assert!(site(far).is_err(), "{far}");
        }
    }

    /// Networks of telescopes at several sites, and keywords that contradict each other.
    #[test]
    fn contradictory_and_ambiguous_sites_are_errors() {
        let of = |text: &str| found(&[&Header::from_text(text)]);
        let error = |text: &str| of(text).unwrap_err().to_string();
        let atlas = error("TELESCOP= 'ATLAS'\n");
        assert!(atlas.contains("ATLAS Chile") && atlas.contains("--mpc"), "{atlas}");
        assert!(error("OBSERVAT= 'Gemini'\n").contains("Gemini South"));
        let decided = of("TELESCOP= 'ATLAS'\nOBSERVAT= 'Sutherland'\n").unwrap().unwrap();
        assert!((decided.longitude_rad.to_degrees() - 20.81).abs() < 0.01, "{decided:?}");
        for text in [
            "TELESCOP= 'ATLAS'\nOBSERVAT= 'Paranal'\n",
            "TELESCOP= 'VLT'\nOBSERVAT= 'La Silla'\n",
            "TELESCOP= 'Rubin'\nOBSGEO-B= -30.24\nOBSGEO-L= 70.75\nOBSGEO-H= 2663\n",
            "OBSGEO-X= 1818938.94\nOBSGEO-Y= -5208470.95\nOBSGEO-Z= -3195172.08\nOBSGEO-B= 30.2\nOBSGEO-L= -70.7\nOBSGEO-H= 2663\n",
        ] {
            let error = error(text);
            assert!(error.contains(" km from that of ") && error.contains("--site"), "{error}");
        }
        for text in [
            "TELESCOP= 'CTIO 1.0 meter telescope'\nOBSERVAT= 'KPNO'\n",
            "TELESCOP= 'Bok 2.3m'\nSITENAME= 'Siding Spring'\n",
        ] {
            assert!(error(text).contains(" km from that of TELESCOP"), "{text}");
        }
        assert_eq!(of("TELESCOP= 'Bok 2.3m'\nOBSERVAT= 'KPNO'\n").unwrap().unwrap().name, "Kitt Peak");
        assert_eq!(of("TELESCOP= 'Bok 2.3m'\n").unwrap(), None);
        for text in ["TELESCOP= 'T17 iTelescope'\n", "SITE    = 'Dome 2'\n", "TELESCOP= 'South 0.4m'\n"] {
            assert_eq!(of(&format!("{text}OBSERVAT= 'KPNO'\n")).unwrap().unwrap().name, "Kitt Peak", "{text}");
        }
        assert!(error("OBSERVAT= 'LCO'\n").contains("Las Campanas"));
        assert_eq!(of("TELESCOP= 'Magellan'\nOBSERVAT= 'LCO'\n").unwrap().unwrap().name, "Las Campanas");
        // The telescope in space, and the observatory on the Earth.
        assert_eq!(of("TELESCOP= 'WISE'\n").unwrap(), None);
        assert_eq!(of("OBSERVAT= 'Wise'\n").unwrap().unwrap().name, "Wise Observatory");
        for keywords in ["OBSLAT  = '56 23 00'\n", "LAT     = 56.4\n", "HIERARCH ESO TEL GEOLAT = 56.4\n"] {
            let error = error(&format!("OBSERVAT= 'Perth'\n{keywords}"));
            assert!(error.contains("at latitude -32.01"), "{error}");
        }
        assert!(error("OBSGEO-B= 0.0\nOBSGEO-L= 0.0\nOBSGEO-H= 0.0\n").contains("0, 0, 0"));
        assert_eq!(of("TELESCOP= 'VST'\nOBSERVAT= 'Paranal'\n").unwrap().unwrap().name, "VST");
        assert!(error("TELESCOP= 'SPECULOOS'\n").contains("SPECULOOS North"));
        assert!(error("OBSERVAT= 'Lowell Observatory'\n").contains("Anderson Mesa"));
        // Instruments with the name or the code of another site.
        for instrument in ["FAST", "AO", "DOT"] {
            assert_eq!(of(&format!("INSTRUME= '{instrument}'\n")).unwrap(), None, "{instrument}");
        }
        assert_eq!(of("INSTRUME= 'DECam'\n").unwrap().unwrap().name, "CTIO Blanco");
    }

    /// Texts of mounts are no sites, and parts of names and names of several sites do not contradict a position.
    #[test]
    fn names_of_mounts_are_no_sites() {
        let position = "OBSGEO-B= 35.0\nOBSGEO-L= 138.0\nOBSGEO-H= 700.0\n";
        for (text, name, is_stated) in [
            ("NOT SET", UNNAMED_SITE, false),
            ("Not connected", UNNAMED_SITE, false),
            ("Vista", UNNAMED_SITE, false),
            ("Atlas EQ-G", UNNAMED_SITE, true),
            ("Gemini", UNNAMED_SITE, true),
            ("Gemini Telescope .NET", "Gemini Telescope .NET", false),
            ("My telescope", "My telescope", false),
        ] {
            let header = Header::from_text(&format!("{position}TELESCOP= '{text}'"));
            let found = site_from_headers(&[&header]).unwrap().unwrap();
            let stated = found.remark.is_some_and(|remark| remark.contains("km from that of TELESCOP"));
            assert_eq!((&*found.site.name, stated), (name, is_stated), "{text}");
            assert!((found.site.latitude_rad.to_degrees() - 35.0).abs() < 1e-9);
        }
        assert_eq!(found(&[&Header::from_text("TELESCOP= 'NOT SET'\n")]).unwrap(), None);
        assert!(
            remark(&format!("{position}TELESCOP= 'NOT'")).unwrap_err().contains("km from that of TELESCOP \"NOT\"")
        );
        let code = "MPC-CODE= '703'\nTELESCOP= 'Atlas EQ-G'\n";
        assert!(remark(code).unwrap().contains("km from that of TELESCOP"));
    }

    /// Telescopes of one mountain are stated, and sites more than 3 km apart are errors.
    #[test]
    fn sites_that_differ_are_stated_or_errors() {
        let kitt_peak = remark("TELESCOP= 'Bok'\nOBSERVAT= 'KPNO'\n").unwrap();
        assert!(
            kitt_peak.starts_with("the site is that of TELESCOP \"Bok\", 0.7 km from that of OBSERVAT"),
            "{kitt_peak}"
        );
        assert_eq!(remark("INSTRUME= 'DECam'\nOBSERVAT= 'CTIO'\n").unwrap(), "");
        for text in [
            "OBSERVAT= 'Mount Lemmon'\nMPC-CODE= '703'\n",
            "OBSERVAT= 'Rubin Observatory'\nOBSGEO-B= -30.169\nOBSGEO-L= -70.8063\nOBSGEO-H= 2215\n",
        ] {
            assert!(remark(text).unwrap_err().contains("allowed: one site within 3 km"), "{text}");
        }
        // Gemini South, 1.2 km from the Rubin Observatory.
        let gemini = "OBSERVAT= 'Rubin Observatory'\nOBSGEO-B= -30.240639\nOBSGEO-L= -70.73655\nOBSGEO-H= 2715.4\n";
        let header = Header::from_text(gemini);
        let found = site_from_headers(&[&header]).unwrap().unwrap();
        assert_eq!(found.site.name, UNNAMED_SITE);
        assert!(found.remark.unwrap().contains("1.3 km from that of OBSERVAT"));
        let of = |text: &str| site_from_headers(&[&Header::from_text(text)]);
        for (text, name) in [
            ("TELESCOP= 'Gemini'\nOBSERVAT= 'Cerro Pachon'\n", "Gemini South"),
            ("TELESCOP= 'SOAR'\nOBSERVAT= 'Cerro Pachon'\n", "SOAR"),
            ("TELESCOP= 'ATLAS'\nOBSERVAT= 'Mauna Loa'\n", "ATLAS Mauna Loa"),
        ] {
            let found = of(text).unwrap().unwrap();
            assert_eq!((&*found.site.name, found.remark), (name, None), "{text}");
        }
        for name in ["Cerro Pachon", "Catalina Sky Survey"] {
            assert!(
                of(&format!("OBSERVAT= '{name}'\n")).unwrap_err().to_string().contains("one of several sites"),
                "{name}"
            );
        }
    }

    #[test]
    fn unused_coordinates_are_named_with_both_readings() {
        let of = |text: &str| unused_coordinates(&[&Header::from_text(text)]);
        let sentence = of("SITELAT = 30.0\nSITELONG= '-110:30:00'\n").unwrap();
        assert!(sentence.starts_with("SITELAT 30 and SITELONG -110.5 are not used"), "{sentence}");
        assert!(sentence.contains("--lat 30 --lon -110.5, or --lon 110.5 if"), "{sentence}");
        assert!(of("LAT-OBS = -30.0\nLONG-OBS= 70.0\n").unwrap().contains("--lon 70, or --lon -70 if"));
        assert_eq!(of("SITELAT = 30.0\n"), None);
        assert!(of("TELESCOP= 'HST'\n").unwrap().contains("--observer-elements"));
        assert!(of("TELESCOP= 'NEOSSat'\nSITELAT = 30.0\nSITELONG= 10.0\n").unwrap().contains("is in orbit"));
        assert_eq!(of("SITELAT = 0.0\nSITELONG= 0.0\n"), None);
    }

    /// Positions as text, codes of the Minor Planet Center, and coordinates that decide between the sites of a network.
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

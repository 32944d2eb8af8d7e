//! Latitudes and longitudes in keywords that no standard defines.

use crate::geometry::Site;
use crate::images::header::Header;

use super::super::moment::Keywords;
use super::positions::{GEODETIC, OBSGEO, coordinate, degrees};

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
/// Largest accepted difference of these from the site, degrees.
const ROUGH_DEG: f64 = 0.5;
/// Largest difference that is not stated, degrees on the Earth: 2 km.
const STATED_DEG: f64 = 0.02;

/// Returns a sentence about the latitude and the longitude, which are not used without the name of a site; `None` if the
/// headers lack one of them.
pub fn unused_coordinates(headers: &[&Header]) -> Option<String> {
    let keywords = Keywords(headers);
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

/// Returns the longitude in keywords that no standard defines: its size is certain, its sign is not.
pub fn longitude_of_unknown_sense_deg(keywords: Keywords<'_>) -> Option<f64> {
    let number = keywords.number(LONGITUDES, |_| true).map(|(_, value, _)| value);
    let value = number.or_else(|| degrees(&keywords.text(LONGITUDES)?.1))?;
    Some((value + 180.0).rem_euclid(360.0) - 180.0)
}

/// Compares the site with the latitude and the longitude in keywords that no standard defines. Returns sentences about
/// those that differ by more than [`STATED_DEG`], and about a longitude that fits only to the west or in hours, if its
/// comment does not say so. Zeros and text without numbers are ignored.
///
/// # Errors
/// The reason why the latitude or the longitude is that of another place in any usual sense, or in the sense that its
/// comment states, unless the site has a name (DECam writes 70.81 as "east longitude").
pub(super) fn compared(keywords: Keywords<'_>, site: &Site, is_named: bool) -> Result<Vec<String>, String> {
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
    let apart_deg = |a_deg: f64, b_deg: f64| ((a_deg - b_deg + 180.0).rem_euclid(360.0) - 180.0).abs();
    let (latitude_deg, longitude_deg) = (site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees());
    let named = format!("at latitude {latitude_deg:.2} and longitude {longitude_deg:.2} deg");
    let mut remarks = Vec::new();
    let mut remark = |given: &str, apart_deg: f64| {
        if apart_deg > STATED_DEG {
            remarks.push(format!("{given}, {apart_deg:.2} deg from the site ({named})"));
        }
    };
    if let Some((value, given, comment)) = stated(LATITUDES) {
        let difference_deg = match apart_deg(value, latitude_deg) {
            north_deg if north_deg > ROUGH_DEG && comment.has("south s") => apart_deg(-value, latitude_deg),
            north_deg => north_deg,
        };
        if difference_deg > ROUGH_DEG {
            return Err(format!("{named}, but {given}"));
        }
        remark(&given, difference_deg);
    }
    let Some((value, given, comment)) = stated(LONGITUDES) else { return Ok(remarks) };
    let senses = [
        (value, ""),
        (-value, "counted to the west"),
        (15.0 * value, "in hours"),
        (-15.0 * value, "in hours, counted to the west"),
    ];
    let senses = senses.map(|(sense_deg, sense)| (apart_deg(sense_deg, longitude_deg), sense));
    let nearest = senses.into_iter().min_by(|one, other| one.0.total_cmp(&other.0));
    let (difference_deg, sense) = nearest.unwrap_or_default();
    if difference_deg > ROUGH_DEG {
        return Err(format!("{named}, but {given}"));
    }
    remark(&given, difference_deg * site.latitude_rad.cos());
    // "East is negative" is counted to the west.
    let is_negated = comment.has("negative neg") && !comment.has("west w");
    let (is_east, is_west) = (comment.has("east e") && !is_negated, comment.has("west w") || is_negated);
    if sense.is_empty() || (is_west && !is_east) {
        return Ok(remarks);
    }
    if is_east && !is_west && !is_named {
        return Err(format!("{named}, but {given} (comment {:?})", comment.text()));
    }
    remarks.push(format!("{given}, which is read as {sense}, as it fits the site (longitude {longitude_deg:.2} deg)"));
    Ok(remarks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unused_coordinates_are_named_with_both_readings() {
        let of = |text: &str| unused_coordinates(&[&Header::from_text(text)]);
        let sentence = of("SITELAT = 30.0\nSITELONG= '-110:30:00'\n").unwrap();
        assert!(sentence.starts_with("SITELAT 30 and SITELONG -110.5 are not used"), "{sentence}");
        assert!(sentence.contains("--lat 30 --lon -110.5, or --lon 110.5 if"), "{sentence}");
        assert!(of("LAT-OBS = -30.0\nLONG-OBS= 70.0\n").unwrap().contains("--lon 70, or --lon -70 if"));
        assert_eq!(of("SITELAT = 30.0\n"), None);
        assert_eq!(of("SITELAT = 0.0\nSITELONG= 0.0\n"), None);
    }
}

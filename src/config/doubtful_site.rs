//! Coordinates of a site that are probably wrong: zeros, exchanged numbers, and wrong signs.

use std::f64::consts::{PI, TAU};

use crate::geometry::Site;

/// Largest difference in latitude and longitude between coordinates of the same site, degrees.
const SAME_SITE_DEG: f64 = 0.2;
/// Largest latitude and longitude that are taken as zeros, degrees.
const ZERO_DEG: f64 = 0.01;

/// Returns what is doubtful about the coordinates of a site, and the remedy; `None` if nothing is found.
pub fn doubtful_site(site: &Site) -> Option<(String, String)> {
    let (latitude_deg, longitude_deg) = (site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees());
    let signed_deg = if longitude_deg > 180.0 { longitude_deg - 360.0 } else { longitude_deg };
    if latitude_deg.abs() < ZERO_DEG && signed_deg.abs() < ZERO_DEG {
        let finding = "latitude and longitude are 0: the Gulf of Guinea".to_owned();
        return Some((finding, "specify the coordinates of the telescope".to_owned()));
    }
    if let Some((meant, latitude_deg, longitude_deg)) = swapped(site) {
        let finding = format!("latitude and longitude are those of {} in the opposite order", meant.name);
        return Some((
            finding,
            format!("if that site is meant, specify --lat={latitude_deg:.4} --lon={longitude_deg:.4}"),
        ));
    }
    let (meant, [latitude_sign, longitude_sign]) = mirrored(site)?;
    let (latitude, longitude) = (latitude_sign * latitude_deg, longitude_sign * signed_deg);
    let wrong = match (latitude_sign < 0.0, longitude_sign < 0.0) {
        (true, true) => format!("latitude {latitude_deg:.4} deg and longitude {signed_deg:.4} deg are"),
        (true, false) => format!("latitude {latitude_deg:.4} deg is"),
        _ => format!("longitude {signed_deg:.4} deg is"),
    };
    let those = if wrong.ends_with("are") { "those" } else { "that" };
    let finding = format!("{wrong} {those} of {} with the opposite sign", meant.name);
    Some((
        finding,
        format!("if that site is meant, specify --lat={latitude:.4} --lon={longitude:.4}: north and east are positive"),
    ))
}

/// Returns the known observatory at these coordinates.
fn near(latitude_rad: f64, longitude_rad: f64) -> Option<&'static Site> {
    Site::all().find(|known| {
        let turn_deg = ((known.longitude_rad - longitude_rad).to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
        (known.latitude_rad - latitude_rad).to_degrees().abs() < SAME_SITE_DEG && turn_deg.abs() < SAME_SITE_DEG
    })
}

/// Returns a known observatory whose latitude is the longitude of the site, and the reverse, with the coordinates of
/// the site in the other order, degrees; `None` if there is one at the site itself.
fn swapped(site: &Site) -> Option<(&'static Site, f64, f64)> {
    let longitude_rad = (site.longitude_rad + PI).rem_euclid(TAU) - PI;
    if near(site.latitude_rad, site.longitude_rad).is_some() {
        return None;
    }
    let meant = near(longitude_rad, site.latitude_rad)?;
    Some((meant, longitude_rad.to_degrees(), site.latitude_rad.to_degrees()))
}

/// Returns a known observatory at the coordinates of the site with other signs, and the factors of latitude and
/// longitude; `None` if there is one at the site itself.
fn mirrored(site: &Site) -> Option<(&'static Site, [f64; 2])> {
    if near(site.latitude_rad, site.longitude_rad).is_some() {
        return None;
    }
    [[1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
        .into_iter()
        .find_map(|signs| Some((near(signs[0] * site.latitude_rad, signs[1] * site.longitude_rad)?, signs)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_that_are_probably_wrong_are_found() {
        let doubt = |latitude_deg: f64, longitude_deg: f64| {
            doubtful_site(&Site::new_deg("here", latitude_deg, longitude_deg, 0.0).unwrap())
        };
        for (latitude_deg, longitude_deg, finding, remedy) in [
            (0.0, 0.0, "latitude and longitude are 0", "the coordinates of the telescope"),
            (-30.2446, 70.7494, "longitude 70.7494 deg is that of", "--lat=-30.2446 --lon=-70.7494"),
            (30.2446, -70.7494, "latitude 30.2446 deg is that of", "--lat=-30.2446 --lon=-70.7494"),
            (
                30.2446,
                70.7494,
                "latitude 30.2446 deg and longitude 70.7494 deg are those of",
                "--lat=-30.2446 --lon=-70.7494",
            ),
            (-70.7494, -30.2446, "in the opposite order", "--lat=-30.2446 --lon=-70.7494"),
        ] {
            let (found, advice) = doubt(latitude_deg, longitude_deg).unwrap();
            assert!(found.contains(finding) && advice.contains(remedy), "{found}; {advice}");
        }
        // A known observatory, longitudes of both conventions, and places far from any observatory.
        for (latitude_deg, longitude_deg) in [(-30.2446, -70.7494), (-30.2446, 289.2506), (45.0, -30.0), (0.0, 20.0)] {
            assert_eq!(doubt(latitude_deg, longitude_deg), None, "{latitude_deg} {longitude_deg}");
        }
    }
}

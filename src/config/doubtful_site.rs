//! Coordinates of a site that are probably wrong: zeros, exchanged numbers, and longitudes of the wrong sign.

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
    let meant = mirrored(site)?;
    let finding = format!("longitude {signed_deg:.4} deg is that of {} with the opposite sign", meant.name);
    Some((finding, format!("if that site is meant, specify --lon={:.4}: east is positive", -signed_deg)))
}

/// Returns the known observatory at these coordinates.
fn near(latitude_rad: f64, longitude_rad: f64) -> Option<&'static Site> {
    Site::all().find(|known| {
        let turn_deg = ((known.longitude_rad - longitude_rad).to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
        (known.latitude_rad - latitude_rad).to_degrees().abs() < SAME_SITE_DEG && turn_deg.abs() < SAME_SITE_DEG
    })
}

/// Returns a known observatory whose latitude is the longitude of the site, and the reverse, with the coordinates of the
/// site in the other order, degrees; `None` if there is one at the site itself.
fn swapped(site: &Site) -> Option<(&'static Site, f64, f64)> {
    let longitude_rad = (site.longitude_rad + PI).rem_euclid(TAU) - PI;
    if near(site.latitude_rad, site.longitude_rad).is_some() {
        return None;
    }
    let meant = near(longitude_rad, site.latitude_rad)?;
    Some((meant, longitude_rad.to_degrees(), site.latitude_rad.to_degrees()))
}

/// Returns a known observatory with the same latitude and the opposite longitude; `None` if there is one at the site
/// itself.
fn mirrored(site: &Site) -> Option<&'static Site> {
    if near(site.latitude_rad, site.longitude_rad).is_some() {
        return None;
    }
    near(site.latitude_rad, -site.longitude_rad)
}

//! Columns of the tables that only the API has.

use streakcast::output::{Column, Kind};

/// Altitudes and azimuths of pointing and Sun.
pub const POINTING: [Column; 5] = [
    Column::time("utc", "Time."),
    Column::real("altitude_deg", "deg", 4, "Altitude of the field's centre, without refraction."),
    Column::real("azimuth_deg", "deg", 4, "Its azimuth from north through east."),
    Column::real("sun_altitude_deg", "deg", 4, "Altitude of the Sun, without refraction."),
    Column::real("sun_azimuth_deg", "deg", 4, "Its azimuth."),
];

/// Crossings of the field before, during and after the exposure.
pub const AROUND: [Column; 6] = [
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::new("name", Kind::Text, "Name in the element set."),
    Column::real("enter_s", "s", 3, "Entry into the field, after the exposure's opening; negative before it."),
    Column::real("exit_s", "s", 3, "Exit from the field."),
    Column::real("magnitude_peak", "mag", 3, "Brightest magnitude inside the field."),
    Column::real("probability", "", 4, "Probability that it crosses the field in that interval."),
];

/// Altitudes of the Sun in a night.
pub const SUN: [Column; 3] = [
    Column { kind: Kind::Time { decimals: 0 }, ..Column::time("utc", "Time.") },
    Column::real("sun_altitude_deg", "deg", 3, "Altitude of the Sun, without refraction."),
    Column::real("sun_azimuth_deg", "deg", 3, "Its azimuth from north through east."),
];

/// Exposures of the schedule; the times and pointings of those that are invalid are null.
pub const SCHEDULED: [Column; 8] = [
    Column::new("id", Kind::Text, "Identifier of the exposure in the schedule."),
    Column::new("row", Kind::Integer, "Row in the file, from 0."),
    Column::time("start_utc", "Shutter opening."),
    Column::real("duration_s", "s", 3, "Length of the exposure."),
    Column::real("ra_deg", "deg", 7, "Right ascension of the field's centre, ICRS."),
    Column::real("dec_deg", "deg", 7, "Declination of the field's centre."),
    Column::real("rotation_deg", "deg", 4, "Position angle of the field's y axis."),
    Column::new("band", Kind::Text, "Band as the schedule writes it."),
];

/// The nights of the schedule.
pub const NIGHTS: [Column; 2] = [
    Column::new("night", Kind::Text, "The evening's local date."),
    Column::new("exposures", Kind::Integer, "Exposures in it."),
];

/// The telescope's site.
pub const SITE: [Column; 5] = [
    Column::new("name", Kind::Text, "Name of the site."),
    Column::new("mpc_code", Kind::Text, "Its observatory code."),
    Column::real("latitude_deg", "deg", 6, "Geodetic latitude, WGS84."),
    Column::real("longitude_deg", "deg", 6, "Longitude, east positive."),
    Column::real("height_m", "m", 1, "Height above the ellipsoid."),
];

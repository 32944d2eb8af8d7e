//! Physical constants, each with its source.

/// Astronomical unit, km (IAU 2012 Resolution B2).
pub const AU_KM: f64 = 149_597_870.7;
/// Speed of light, km/s (SI).
pub const SPEED_OF_LIGHT_KM_S: f64 = 299_792.458;
/// Earth's equatorial radius, km (WGS84).
pub const EARTH_EQUATORIAL_RADIUS_KM: f64 = 6378.137;
/// Earth's flattening (WGS84).
pub const EARTH_FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Sun's nominal radius, km (IAU 2015 Resolution B3).
pub const SUN_RADIUS_KM: f64 = 695_700.0;
/// Nominal total solar irradiance at 1 au, W/m² (IAU 2015 Resolution B3). It varies by 0.1 % in the solar cycle.
pub const SOLAR_IRRADIANCE_W_M2: f64 = 1361.0;
/// Earth's rate of rotation with respect to the stars, rad/s: 1.00273781191135448 revolutions per day of UT1 (IERS
/// Conventions 2010, eq. 5.15).
pub const EARTH_ROTATION_RAD_S: f64 = 1.002_737_811_911_354_5 * std::f64::consts::TAU / 86_400.0;
/// Seconds in a day.
pub const DAY_S: f64 = 86_400.0;
/// Longest accepted exposure, s: a day, longer than any night. Memory and time of a search grow with the exposure, so
/// that an exposure without a bound would exhaust them.
pub const LONGEST_EXPOSURE_S: f64 = DAY_S;
/// Accepted rotations of a field, degrees.
pub const ROTATIONS_DEG: std::ops::RangeInclusive<f64> = -360.0..=360.0;
/// Earth's gravitational parameter in WGS72, km³/s²: the value that SGP4 and the element sets use (Hoots and Roehrich
/// 1980, Spacetrack Report 3).
pub const WGS72_MU_KM3_S2: f64 = 398_600.8;

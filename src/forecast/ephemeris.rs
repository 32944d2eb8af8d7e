//! Ephemerides of selected satellites, and their table.

use hifitime::Epoch;

use super::selection::Selection;
use super::selection::empty_selection;
use crate::elements::ElementSet;
use crate::error::Error;
use crate::frames::utc_jd;
use crate::orbit::LeftOut;
use crate::output::{Column, Kind, Table, TableField, Value};
use crate::passes::{EphemerisPoint, Sky};
use crate::photometry::PhotometryOptions;

/// Request for the topocentric positions of satellites at given times.
#[derive(Clone, Debug, PartialEq)]
pub struct EphemerisRequest {
    /// Times, in any order.
    pub times: Vec<Epoch>,
    /// Satellites to include.
    pub selection: Selection,
    /// Lowest altitude of a position, radians, without refraction; `None` includes positions below the horizon.
    pub min_altitude_rad: Option<f64>,
    /// Band, magnitude system and extinction of the magnitudes.
    pub photometry: PhotometryOptions,
}

impl EphemerisRequest {
    /// Returns the earliest and the latest time.
    ///
    /// # Errors
    /// There are no times.
    pub fn span(&self) -> Result<(Epoch, Epoch), Error> {
        let times = || self.times.iter().copied();
        let none = || Error::invalid("number of times", format_args!("{}", 0.0), "1 or more");
        times().min().zip(times().max()).ok_or_else(none)
    }
}

/// Topocentric positions of the selected satellites.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Ephemeris {
    /// Positions, grouped by satellite in the order of the catalogue; within a satellite in the order of the times.
    pub points: Vec<EphemerisPoint>,
    /// Satellites whose position cannot be computed at one of the times.
    pub left_out: Vec<LeftOut>,
}

/// Computes the topocentric positions of the selected satellites.
///
/// # Errors
/// No satellite is selected; a lowest altitude is given for an observer in orbit; the errors of [`Sky::ephemeris`].
pub fn ephemeris(sky: &Sky, request: &EphemerisRequest) -> Result<Ephemeris, Error> {
    let selected = request.selection.among(sky.elements());
    let is_selected = |index: &usize| selected.contains(&sky.elements()[*index]);
    let indices: Vec<usize> = (0..sky.elements().len()).filter(is_selected).collect();
    if indices.is_empty() {
        let (satellites, selection) = (sky.elements().len(), request.selection.description());
        return Err(empty_selection(satellites, &selection));
    }
    let (mut points, left_out) = sky.ephemeris(&indices, &request.times, Some(&request.photometry))?;
    if let Some(lowest_rad) = request.min_altitude_rad {
        // An observer in orbit has no horizon.
        if let Some(epoch) = request.times.first() {
            sky.sun_altaz(*epoch)?;
        }
        points.retain(|position| position.point.altitude_rad.is_some_and(|altitude_rad| altitude_rad >= lowest_rad));
    }
    Ok(Ephemeris { points, left_out })
}

/// Position with the element set of its satellite.
#[derive(Copy, Clone)]
pub struct EphemerisRow<'a> {
    /// Topocentric position.
    pub point: &'a EphemerisPoint,
    /// Element set of the satellite.
    pub elements: &'a ElementSet,
}

/// Number of decimals of angles in degrees: a resolution of 0.4 mas.
const DEGREES: usize = 7;

fn fields<'a>() -> [TableField<EphemerisRow<'a>>; 26] {
    let field = TableField::<EphemerisRow<'a>>::new;
    [
        field(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |row| {
            i64::from(row.point.norad_id.0).into()
        }),
        field(Column::new("name", Kind::Text, "Name in the element set."), |row| Value::nonempty(&row.elements.name)),
        field(Column::time("utc", "Time of reception."), |row| row.point.point.epoch.into()),
        field(Column::real("julian_date_utc", "d", 8, "Time of reception as a Julian date, UTC."), |row| {
            let (day, fraction) = utc_jd(row.point.point.epoch);
            (day + fraction).into()
        }),
        field(Column::real("ra_deg", "deg", DEGREES, "Right ascension, ICRS astrometric topocentric."), |row| {
            row.point.point.direction.longitude_rad().to_degrees().into()
        }),
        field(Column::real("dec_deg", "deg", DEGREES, "Declination."), |row| {
            row.point.point.direction.latitude_rad().to_degrees().into()
        }),
        field(
            Column::real("ra_cos_dec_rate_deg_s", "deg / s", 8, "Rate of right ascension times cosine of declination."),
            |row| row.point.ra_cos_dec_rate_rad_s.to_degrees().into(),
        ),
        field(Column::real("dec_rate_deg_s", "deg / s", 8, "Rate of declination."), |row| {
            row.point.dec_rate_rad_s.to_degrees().into()
        }),
        field(Column::real("altitude_deg", "deg", DEGREES, "Altitude without refraction and aberration."), |row| {
            row.point.point.altitude_rad.map(f64::to_degrees).into()
        }),
        field(Column::real("azimuth_deg", "deg", DEGREES, "Azimuth from north through east."), |row| {
            row.point.point.azimuth_rad.map(f64::to_degrees).into()
        }),
        field(Column::real("altitude_rate_deg_s", "deg / s", 8, "Rate of altitude."), |row| {
            row.point.altitude_rate_rad_s.map(f64::to_degrees).into()
        }),
        field(
            Column::real("azimuth_cos_altitude_rate_deg_s", "deg / s", 8, "Rate of azimuth times cosine of altitude."),
            |row| row.point.azimuth_cos_altitude_rate_rad_s.map(f64::to_degrees).into(),
        ),
        field(Column::real("range_km", "km", 4, "Distance from the observer."), |row| row.point.point.range_km.into()),
        field(Column::real("range_rate_km_s", "km / s", 7, "Rate of the distance."), |row| {
            row.point.range_rate_km_s.into()
        }),
        field(Column::real("elongation_deg", "deg", 4, "Sun-observer-satellite angle."), |row| {
            row.point.elongation_rad.to_degrees().into()
        }),
        field(Column::real("phase_angle_deg", "deg", 4, "Sun-satellite-observer angle."), |row| {
            row.point.point.geometry.phase_angle_rad().to_degrees().into()
        }),
        field(Column::new("illumination", Kind::Text, "sunlit, penumbra or umbra."), |row| {
            row.point.point.illumination.name().into()
        }),
        field(Column::real("lit_fraction", "", 4, "Fraction of the Sun's light that arrives."), |row| {
            row.point.point.illumination.lit_fraction().into()
        }),
        field(
            Column::real(
                "magnitude",
                "mag",
                3,
                "Apparent magnitude; empty in the umbra and where no lit surface is visible.",
            ),
            |row| row.point.point.brightness.as_ref().map(|light| light.magnitude.0).into(),
        ),
        field(Column::real("magnitude_sigma", "mag", 3, "One sigma of the magnitude."), |row| {
            row.point.point.brightness.as_ref().map(|light| light.sigma_mag).into()
        }),
        field(Column::new("mag_source", Kind::Text, "Source of the magnitude."), |row| {
            row.point.point.brightness.as_ref().map(|light| light.source.to_string()).into()
        }),
        field(Column::time("element_epoch_utc", "Epoch of the element set."), |row| row.elements.epoch.into()),
        field(
            Column::real("element_age_days", "d", 3, "Time less element epoch; negative if the elements are newer."),
            |row| row.point.element_age_days.into(),
        ),
        field(
            Column::real(
                "along_track_sigma_s",
                "s",
                2,
                "Lateness: half width that holds 68 % of the delays along the track, early or late; empty if it is unknown.",
            ),
            |row| row.point.is_known.then_some(row.point.uncertainty.along_track_s).into(),
        ),
        field(
            Column::real("cross_track_sigma_deg", "deg", 4, "One-sigma error across the track as an angle."),
            |row| row.point.cross_track_sigma_rad().to_degrees().into(),
        ),
        field(
            Column::new(
                "position_source",
                Kind::Text,
                "Source of the positions: `element set`, or `ephemeris` with the name of the file.",
            ),
            |row| row.point.position_source.to_string().into(),
        ),
    ]
}

/// Returns positions as a table, in their order.
pub fn ephemeris_table<'a>(rows: impl IntoIterator<Item = EphemerisRow<'a>>) -> Table {
    Table::from_records(&fields(), rows)
}

//! What the cells of a row say: numbers within bounds, moments, and where the satellite stood.

use hifitime::{Epoch, TimeScale};

use crate::elements::parse_iso;
use crate::frames::{epoch_from_jd, epoch_from_mjd, mjd_utc};

use super::column_map::Field;
use super::dropped::DropReason;
use super::record::Sighting;
use super::rows::Layout;

/// Why a row gives no record.
pub(super) struct Refused {
    pub reason: DropReason,
    pub field: Field,
    pub expected: &'static str,
}

/// The cell at a place.
pub(super) type Cell<'a> = &'a dyn Fn(usize) -> Option<&'a [u8]>;

pub(super) fn refused(field: Field, expected: &'static str) -> Refused {
    Refused { reason: DropReason::Unparsable, field, expected }
}

impl Layout {
    /// What stands in a column; `None` where there is no such column or nothing in the cell.
    pub(super) fn text<'a>(&self, cell: Cell<'a>, field: Field) -> Option<&'a str> {
        let bytes = cell(self.places[field as usize]?)?.trim_ascii();
        // Not Unicode: no number, no time, no name that could be asked for.
        (!bytes.is_empty()).then(|| std::str::from_utf8(bytes).unwrap_or("?"))
    }

    /// A finite number within bounds; `None` where there is no such column or nothing in the cell.
    pub(super) fn number(
        &self,
        cell: Cell,
        field: Field,
        [least, greatest]: [f64; 2],
        expected: &'static str,
    ) -> Result<Option<f64>, Refused> {
        let Some(text) = self.text(cell, field) else { return Ok(None) };
        let number = text.parse::<f64>().ok().filter(|number| (least..=greatest).contains(number));
        number.map(Some).ok_or_else(|| refused(field, expected))
    }

    /// As `number`, in kilometres.
    fn length(
        &self,
        cell: Cell,
        field: Field,
        unit_km: f64,
        [least, greatest]: [f64; 2],
        expected: &'static str,
    ) -> Result<Option<f64>, Refused> {
        let length = self.number(cell, field, [least / unit_km, greatest / unit_km], expected)?;
        Ok(length.map(|length| length * unit_km))
    }

    /// As `number`, from degrees (or the map's unit) to radians; bounds in degrees.
    fn angle(
        &self,
        cell: Cell,
        field: Field,
        bounds_deg: [f64; 2],
        expected: &'static str,
    ) -> Result<Option<f64>, Refused> {
        let bounds = bounds_deg.map(|bound| bound.to_radians() / self.map.angle_rad);
        Ok(self.number(cell, field, bounds, expected)?.map(|angle| angle * self.map.angle_rad))
    }

    pub(super) fn time(&self, cell: Cell) -> Result<Option<Epoch>, Refused> {
        let (Some(_), Some(scale)) = (self.places[Field::Time as usize], self.map.time_scale) else { return Ok(None) };
        let wrong = || refused(Field::Time, "a moment of 1957 to 2100 as ISO 8601, MJD or JD");
        let date = self.text(cell, Field::Time).ok_or_else(wrong)?;
        let epoch = match self.places[Field::TimeOfDay as usize] {
            Some(_) => {
                let time = self.text(cell, Field::TimeOfDay).ok_or_else(wrong)?;
                of_clock(clocked(&format!("{date} {time}")), scale)
            }
            // Z says UTC: another scale contradicts it.
            None if date.ends_with('Z') && scale != TimeScale::UTC => None,
            None => match date.parse::<f64>() {
                Ok(days) => epoch_from_mjd(days, scale).or_else(|_| epoch_from_jd(days, scale)).ok(),
                Err(_) => of_clock(clocked(date), scale),
            },
        };
        // Sputnik to the end of the Sun's ephemeris.
        let (first, last) = (36_116.0, 88_069.0);
        epoch.filter(|epoch| (first..last).contains(&mjd_utc(*epoch))).map(Some).ok_or_else(wrong)
    }

    pub(super) fn sighting(&self, cell: Cell) -> Result<Sighting, Refused> {
        let altitude = self.angle(cell, Field::Altitude, [-90.0, 90.0], "an altitude of -90 to 90 deg")?;
        let height_unit = self.map.height_km;
        let height = self.length(cell, Field::Height, height_unit, [100.0, 50_000.0], "a height of 100 to 50000 km")?;
        if self.map.column(Field::SunAltitude).is_some() {
            let sun = self.angle(cell, Field::SunAltitude, [-90.0, 90.0], "an altitude of -90 to 90 deg")?;
            let azimuth = self.angle(cell, Field::AzimuthFromSun, [-360.0, 360.0], "an azimuth in deg")?;
            return Ok(Sighting::SunRelative {
                sun_altitude_rad: sun.ok_or_else(|| refused(Field::SunAltitude, "an altitude"))?,
                altitude_rad: altitude.ok_or_else(|| refused(Field::Altitude, "an altitude"))?,
                azimuth_from_sun_rad: azimuth.ok_or_else(|| refused(Field::AzimuthFromSun, "an azimuth"))?,
                height_km: height.ok_or_else(|| refused(Field::Height, "a height"))?,
            });
        }
        let azimuth = self.angle(cell, Field::Azimuth, [-360.0, 360.0], "an azimuth in deg")?;
        if let (Some(altitude_rad), Some(azimuth_rad), Some(height_km)) = (altitude, azimuth, height) {
            return Ok(Sighting::Horizontal { altitude_rad, azimuth_rad, height_km });
        }
        let distance_unit = self.map.distance_km;
        let range =
            self.length(cell, Field::Distance, distance_unit, [100.0, 100_000.0], "a distance of 100 to 100000 km")?;
        let ascension = self.angle(cell, Field::RightAscension, [0.0, 360.0], "a right ascension of 0 to 360 deg")?;
        let declination = self.angle(cell, Field::Declination, [-90.0, 90.0], "a declination of -90 to 90 deg")?;
        let phase_rad = self.angle(cell, Field::Phase, [0.0, 180.0], "an angle of 0 to 180 deg")?;
        Ok(match (range, ascension, declination) {
            (Some(range_km), Some(right_ascension_rad), Some(declination_rad)) => {
                Sighting::Equatorial { right_ascension_rad, declination_rad, range_km }
            }
            (Some(range_km), ..) => Sighting::Distance { range_km, phase_rad },
            _ => Sighting::Nothing,
        })
    }
}

/// A date that was read as UTC, on another clock.
fn of_clock(read: Option<Epoch>, scale: TimeScale) -> Option<Epoch> {
    read.map(|epoch| Epoch::from_duration(epoch.to_utc_duration(), scale))
}

/// A date with its time of day; an hour of one digit (`2024-01-01 5:03:02`), as tables of photometry write it, is one.
fn clocked(text: &str) -> Option<Epoch> {
    parse_iso(text).or_else(|| {
        let (date, time) = text.split_once(['T', ' '])?;
        let time = time.trim_start();
        (time.find(':') == Some(1)).then(|| parse_iso(&format!("{date}T0{time}"))).flatten()
    })
}

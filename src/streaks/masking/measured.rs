//! Measured streaks, from the table that `measure` writes.

use std::fmt;
use std::path::Path;

use hifitime::{Epoch, TimeScale};
use nalgebra::{Rotation3, Unit, Vector3};

use super::super::chip::Chip;
use super::super::frame::TargetFrame;
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{Direction, Gcrs, parse_instant, seconds_between};
use crate::input::TableRows;

/// Names of the columns, for errors.
const COLUMNS: &str = "a table of streakcast measure, with image, hdu, norad_id, detected, mid_utc, ra_deg, dec_deg, rate, \
                       offset_sigma_pix, tilt_deg, late_s, late_sigma_s, seeing_arcsec and flags";
/// Time between two positions that give the direction of a track, seconds.
const STEP_S: f64 = 0.01;
/// Time before and after the exposure at which a streak is still of the frame: rounding of the table, seconds.
const ROUNDING_S: f64 = 0.01;

/// Smallest error across the track, pixels.
const LEAST_SIGMA_PIX: f64 = 1e-4;

/// Streak that was measured on one chip.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredStreak {
    /// File of the frame, as in the table.
    pub image: String,
    /// HDU of the chip.
    pub hdu: usize,
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Name of the satellite; empty if it has none.
    pub name: String,
    /// Middle of the time in which the satellite is on the chip.
    pub epoch: Epoch,
    /// Its direction at that time.
    pub direction: Direction<Gcrs>,
    /// Light per second, in the unit of the frame.
    pub rate: f64,
    /// Error (one sigma) across the track at the middle of the streak, pixels.
    pub across_sigma_pix: f64,
    /// Difference in angle from the predicted track, radians, as [`StreakMeasurement`] has it.
    ///
    /// [`StreakMeasurement`]: crate::measure::StreakMeasurement
    pub tilt_rad: f64,
    /// Delay and its error (one sigma), seconds, if an end of the streak is on the chip.
    pub late_s: Option<(f64, f64)>,
    /// Seeing that the width of the streak implies, arcsec.
    pub seeing_arcsec: Option<f64>,
    /// True if pixels of the streak are saturated, or its sky is cut off: `rate` is a lower limit.
    pub is_saturated: bool,
}

/// Streaks that were found, from a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredTable {
    /// Streaks of satellites with a catalogue number.
    pub streaks: Vec<MeasuredStreak>,
    /// File of the frame and name of each other streak.
    pub without_satellite: Vec<[String; 2]>,
}

/// Reads the streaks that were found from a table (CSV or ECSV) of `streakcast measure`.
///
/// # Errors
/// The file cannot be read, a column is missing, or a value is invalid.
pub fn read_measured_streaks(path: &Path) -> Result<MeasuredTable, Error> {
    let failed = |error: std::io::Error| Error::system(error).in_file("", path);
    let rows = TableRows::open(path).map_err(failed)?;
    let column = |name| rows.column(name, COLUMNS).map_err(failed);
    let [image, hdu, id, detected] = [column("image")?, column("hdu")?, column("norad_id")?, column("detected")?];
    let [mid, ra, dec, rate] = [column("mid_utc")?, column("ra_deg")?, column("dec_deg")?, column("rate")?];
    let [across, tilt, seeing] = [column("offset_sigma_pix")?, column("tilt_deg")?, column("seeing_arcsec")?];
    let [late, late_sigma, flags] = [column("late_s")?, column("late_sigma_s")?, column("flags")?];
    let name = rows.find("name");
    // In tables of streaks that were given, the tilt is relative to the given streak, not to the predicted track.
    let given = rows.find("streak");
    let mut table = MeasuredTable::default();
    for row in rows {
        let row = row.map_err(failed)?;
        let number = |column| row.number_in(column, [f64::MIN, f64::MAX]).map_err(failed);
        let optional = |column| if row.is_missing(column) { Ok(None) } else { number(column).map(Some) };
        let positive = |column| match number(column)? {
            value if value > 0.0 => Ok(value),
            _ => Err(failed(row.wrong(column, "a number above 0"))),
        };
        // Streaks that were given may be unmeasured, or of unknown satellites.
        if given.is_some() && row.is_missing(detected) || !row.truth(detected).map_err(failed)? {
            continue;
        }
        if let Some(streak) = given.filter(|_| row.is_missing(id)) {
            table.without_satellite.push([image, streak].map(|column| row.text(column).to_owned()));
            continue;
        }
        let late_s = match (optional(late)?, optional(late_sigma)?) {
            (Some(late_s), Some(sigma_s)) => Some((late_s, sigma_s.abs())),
            _ => None,
        };
        let wrong_time = || failed(row.wrong(mid, "a time in UTC, such as 2026-08-14T23:36:25Z"));
        table.streaks.push(MeasuredStreak {
            image: row.text(image).to_owned(),
            hdu: row.parsed(hdu, "the number of an HDU, from 0").map_err(failed)?,
            norad_id: NoradId(row.parsed(id, "a catalogue number").map_err(failed)?),
            name: name.map(|name| row.text(name)).unwrap_or_default().to_owned(),
            epoch: parse_instant(row.text(mid), Some(TimeScale::UTC)).map_err(|_| wrong_time())?,
            direction: Direction::from_lon_lat_rad(number(ra)?.to_radians(), number(dec)?.to_radians()),
            rate: positive(rate)?,
            // Tables of earlier versions have errors of less than 0.0005 pixels as 0.
            across_sigma_pix: row.number_in(across, [0.0, f64::MAX]).map_err(failed)?.max(LEAST_SIGMA_PIX),
            tilt_rad: if given.is_some() { 0.0 } else { number(tilt)?.to_radians() },
            late_s,
            seeing_arcsec: optional(seeing)?.filter(|seeing| *seeing > 0.0),
            is_saturated: ["saturated", "clipped"].iter().any(|flag| row.text(flags).contains(flag)),
        });
    }
    Ok(table)
}

/// Reason why a measured streak is not used, although it is of a file with the name of the frame.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum UnusedReason {
    /// Its time is not in the exposure.
    OtherTime,
    /// Its HDU is not a chip of the frame.
    OtherHdu,
    /// Its track does not reach the chip.
    OffChip,
    /// There is another streak of the same satellite on the chip.
    Repeated,
}

impl fmt::Display for UnusedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OtherTime => "mid_utc is not in the exposure",
            Self::OtherHdu => "hdu is not one of the masked images",
            Self::OffChip => "the track does not reach the image",
            Self::Repeated => "there is another row of the satellite and the HDU",
        })
    }
}

/// Returns true if the file of a row of the table has the name of the file of a frame.
pub fn is_same_file_name(image: &str, frame: &Path) -> bool {
    Path::new(image).file_name() == frame.file_name()
}

impl MeasuredStreak {
    /// Returns the reason if the streak cannot be of a frame with its file name.
    pub(super) fn unused_in(&self, frame: &TargetFrame) -> Option<UnusedReason> {
        let at_s = seconds_between(frame.opened, self.epoch);
        if !(-ROUNDING_S..=frame.exposure_s + ROUNDING_S).contains(&at_s) {
            return Some(UnusedReason::OtherTime);
        }
        let is_chip = frame.chips.iter().any(|target| target.chip.hdu == self.hdu);
        (!is_chip).then_some(UnusedReason::OtherHdu)
    }

    /// Returns true if the streak is in a file of this name.
    pub fn is_of(&self, frame: &Path) -> bool {
        is_same_file_name(&self.image, frame)
    }

    /// Returns the measured track as a function of the predicted time, seconds after the shutter opened: the track that
    /// `sight` predicts for a satellite that is late by `late_s`, moved to the measured position and turned about it.
    /// `None` if the world coordinates of the chip do not contain the track.
    pub fn fitted<'a>(
        &self,
        chip: &Chip,
        opened: Epoch,
        late_s: f64,
        sight: &'a (dyn Fn(f64, f64) -> (Direction<Gcrs>, f64) + Sync),
    ) -> Option<impl Fn(f64) -> (Direction<Gcrs>, f64) + Sync + use<'a>> {
        let middle_s = seconds_between(opened, self.epoch) - late_s;
        let (from, to) = (*sight(middle_s, late_s).0.vector(), *self.direction.vector());
        let moved = Rotation3::rotation_between(&from, &to).unwrap_or_else(Rotation3::identity);
        let turned = |angle_rad: f64| Rotation3::from_axis_angle(&Unit::new_normalize(to), angle_rad);
        let pixel = |rotation: &Rotation3<f64>, time_s: f64| {
            let line: Vector3<f64> = rotation * sight(time_s, late_s).0.vector();
            chip.wcs.to_pixel(Direction::from_vector(line))
        };
        let next_s = middle_s + STEP_S;
        let (here, next) = (pixel(&moved, middle_s)?, pixel(&moved, next_s)?);
        let (ex, ey) = (next.x - here.x, next.y - here.y);
        // The tilt is positive if later positions are moved towards increasing y, or increasing x for a track nearer to
        // the columns. Whether this is clockwise on the sky depends on the world coordinates.
        let [nx, ny] = if ex.abs() >= ey.abs() { [-ey * ex.signum(), ex.abs()] } else { [ey.abs(), -ex * ey.signum()] };
        let sign = if self.tilt_rad == 0.0 {
            1.0
        } else {
            let there = pixel(&(turned(self.tilt_rad.abs()) * moved), next_s)?;
            ((there.x - next.x) * nx + (there.y - next.y) * ny).signum()
        };
        let rotation = turned(sign * self.tilt_rad) * moved;
        Some(move |time_s: f64| {
            let (direction, range_km) = sight(time_s, late_s);
            (Direction::from_vector(rotation * direction.vector()), range_km)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn found_streaks_of_no_satellite_are_named() {
        let table = tempfile::NamedTempFile::new().unwrap();
        let cells = "true,2026-04-25T21:00:00Z,10,20,5,0.1,0,,,2";
        let text = format!(
            "streak,image,hdu,norad_id,detected,mid_utc,ra_deg,dec_deg,rate,offset_sigma_pix,tilt_deg,late_s,\
             late_sigma_s,seeing_arcsec,flags\nA,a.fits,0,,{cells},\nB,a.fits,0,25544,{cells},clipped\n\
             C,a.fits,0,,{}\nD,a.fits,0,,,,,,,,,,,,outside\n",
            cells.replace("true", "false") + ","
        );
        std::fs::write(table.path(), text).unwrap();
        let found = read_measured_streaks(table.path()).unwrap();
        assert_eq!(found.without_satellite, [["a.fits", "A"]]);
        assert!(matches!(&found.streaks[..], [one] if one.norad_id.0 == 25544 && one.is_saturated), "{found:?}");
    }
}

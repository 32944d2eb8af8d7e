//! Streaks of which a table gives the place: ends, times, and width of the image.

use std::fmt::Display;
use std::io;
use std::path::Path;

use hifitime::Epoch;

use super::super::chip::Chip;
use super::super::tracking::Tracking;
use super::sky_track::{SkyPoint, SkyTrack};
use crate::error::Error;
use crate::frames::{Direction, Gcrs, parse_moment, seconds_between};
use crate::images::{Bounded, Header, PixelPosition, RowOrigin, StreakEnds, StreakRow};
use crate::input::{Column, TableRows};
use crate::output::format_utc;
use crate::units::{ARCSECONDS, KILOMETRES, METRES, PIXELS, SECONDS};

/// Number of points of a track. Between them a straight line in pixels is a smooth curve on the sky.
const POINTS: usize = 65;
/// Times outside of the exposure by less than this are rounded to its ends, seconds. Tables have times with
/// milliseconds.
const ROUNDED_S: f64 = 1.5e-3;

/// Width of the image of a given streak.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum GivenWidth {
    /// It is not given.
    Unknown,
    /// Seeing, defocus and size at this distance.
    Distance {
        /// Distance, km.
        range_km: f64,
        /// Diameter of the body, m; `None` if it is not given.
        size_m: Option<f64>,
    },
    /// Full width at half maximum of the image of the light, pixels.
    Pixels(f64),
    /// The same, arcsec.
    Arcsec(f64),
}

/// Time at which a light is at an end of its streak.
#[derive(Copy, Clone, Debug, PartialEq)]
enum EndTime {
    /// The shutter opens or closes.
    Shutter,
    /// Seconds after the shutter opened.
    Seconds(f64),
    At(Epoch),
}

/// Streak whose place a table gives.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenStreak {
    /// Name of the streak: the column `id`, or the number of the row from 1.
    pub id: String,
    /// Name of the file of the frame; `None` for all frames.
    pub image: Option<String>,
    /// HDU of the chip; `None` for all chips, or for the only one.
    pub hdu: Option<usize>,
    /// Ends of the streak.
    pub ends: StreakEnds,
    /// Width of the image.
    pub width: GivenWidth,
    /// True if ends in pixels are those of the frame before it was cut or binned.
    is_physical: bool,
    times: [EndTime; 2],
    origin: RowOrigin,
}

/// Columns besides those of the ends.
pub struct GivenColumns {
    range_km: Option<Bounded>,
    size_m: Option<Bounded>,
    fwhm_pix: Option<Bounded>,
    fwhm_arcsec: Option<Bounded>,
    enter_s: Option<Bounded>,
    exit_s: Option<Bounded>,
    enter_utc: Option<Column>,
    exit_utc: Option<Column>,
}

impl GivenColumns {
    /// Names of the columns.
    pub const NAMES: [&'static str; 12] = [
        "range_km",
        "size_m",
        "range",
        "size",
        "fwhm_pix",
        "fwhm_arcsec",
        "enter_utc",
        "exit_utc",
        "enter_s",
        "exit_s",
        "enter",
        "exit",
    ];

    /// Returns the columns of a table.
    ///
    /// # Errors
    /// The unit of a column is invalid.
    pub fn find(rows: &TableRows) -> io::Result<Self> {
        let find = |names: &[&'static str], unit, range| Bounded::find(rows, names, unit, range);
        Ok(Self {
            range_km: find(&["range_km", "range"], &KILOMETRES, [1.0, 1e9])?,
            size_m: find(&["size_m", "size"], &METRES, [0.0, 1000.0])?,
            fwhm_pix: find(&["fwhm_pix"], &PIXELS, [0.1, 100.0])?,
            fwhm_arcsec: find(&["fwhm_arcsec"], &ARCSECONDS, [1e-3, 36_000.0])?,
            enter_s: find(&["enter_s", "enter"], &SECONDS, [-1e6, 1e6])?,
            exit_s: find(&["exit_s", "exit"], &SECONDS, [-1e6, 1e6])?,
            enter_utc: rows.find("enter_utc"),
            exit_utc: rows.find("exit_utc"),
        })
    }
}

impl GivenStreak {
    /// Reads a row of a table.
    ///
    /// # Errors
    /// A cell is invalid, or the width is given twice.
    pub fn of_row(row: &StreakRow<'_>, columns: &GivenColumns) -> Result<Self, Error> {
        let (range_km, size_m) = (row.number(columns.range_km)?, row.number(columns.size_m)?);
        let fwhm_arcsec = row.number(columns.fwhm_arcsec)?;
        let width = match (row.number(columns.fwhm_pix)?, fwhm_arcsec, range_km) {
            (None, None, Some(range_km)) => GivenWidth::Distance { range_km, size_m },
            (Some(fwhm_pix), None, None) => GivenWidth::Pixels(fwhm_pix),
            (None, Some(fwhm_arcsec), None) => GivenWidth::Arcsec(fwhm_arcsec),
            (None, None, None) => GivenWidth::Unknown,
            _ => {
                let allowed = "one of fwhm_pix, fwhm_arcsec and range_km (a width contains defocus and size)";
                return Err(row.invalid("width of the streak", "given twice", allowed));
            }
        };
        if let Some(size_m) = size_m.filter(|_| range_km.is_none()) {
            return Err(row.invalid("size_m", &size_m.to_string(), "with range_km, which gives the angle"));
        }
        let time = |name: &str, utc: Option<Column>, seconds: Option<Bounded>| -> Result<EndTime, Error> {
            let text = row.text(utc);
            match (text, row.number(seconds)?) {
                ("", None) => Ok(EndTime::Shutter),
                ("", Some(seconds)) => Ok(EndTime::Seconds(seconds)),
                (text, None) => parse_moment(text, Some(hifitime::TimeScale::UTC))
                    .map(EndTime::At)
                    .map_err(|_| row.invalid(name, text, "a time in UTC, such as 2026-08-14T23:36:25Z")),
                (text, Some(_)) => Err(row.invalid(name, text, "either a time in UTC or seconds")),
            }
        };
        Ok(Self {
            id: row.id(),
            image: row.image().map(str::to_owned),
            hdu: row.hdu()?,
            ends: row.ends()?,
            is_physical: row.is_physical(),
            width,
            times: [
                time("enter_utc", columns.enter_utc, columns.enter_s)?,
                time("exit_utc", columns.exit_utc, columns.exit_s)?,
            ],
            origin: row.origin(),
        })
    }

    /// Returns the streak with its ends in the pixels of the frame with this header, if they are in physical pixels.
    pub(crate) fn in_frame(&self, header: &Header) -> Self {
        let ends = match self.ends {
            StreakEnds::Pixels(ends) if self.is_physical => StreakEnds::Pixels(ends.map(|end| end.of_physical(header))),
            ends => ends,
        };
        Self { ends, is_physical: false, ..self.clone() }
    }

    /// Returns true if the time at an end is given.
    pub(crate) fn has_times(&self) -> bool {
        self.times != [EndTime::Shutter; 2]
    }

    /// Sets the times at the two ends, seconds after the shutter opened.
    pub(crate) fn set_seconds(&mut self, ends_s: [f64; 2]) {
        self.times = ends_s.map(EndTime::Seconds);
    }

    /// Returns true if the row belongs to a frame with this file name.
    pub fn is_of(&self, file_name: &str) -> bool {
        self.image.as_deref().is_none_or(|image| image == file_name)
    }

    /// Returns the index of the chip of the streak among the chips with these HDUs; `None` for ends on the sky without
    /// an HDU, which may be on any of several chips.
    ///
    /// # Errors
    /// No chip has the HDU of the streak, or a streak in pixels has no HDU and there are several chips.
    pub(crate) fn chip_index(&self, hdus: &[usize], frame: &Path) -> Result<Option<usize>, Error> {
        let allowed = || {
            let listed: Vec<String> = hdus.iter().map(usize::to_string).collect();
            format!("HDU {} of {}", listed.join(", "), frame.display())
        };
        match (self.hdu, hdus) {
            (Some(hdu), _) => match hdus.iter().position(|of_chip| *of_chip == hdu) {
                None => Err(self.invalid("hdu", hdu, allowed())),
                index => Ok(index),
            },
            (None, [_]) => Ok(Some(0)),
            (None, _) if matches!(self.ends, StreakEnds::Sky(_)) => Ok(None),
            (None, _) => Err(self.invalid("hdu", "missing", allowed())),
        }
    }

    /// Returns the error of a value of this row.
    pub(crate) fn invalid(&self, what: &str, given: impl Display, allowed: impl Into<String>) -> Error {
        self.origin.of(Error::invalid(what, given, allowed))
    }

    /// Returns the times at which the light is at the ends, seconds after the shutter opened.
    fn seconds(&self, opened: Epoch, exposure_s: f64) -> Result<[f64; 2], Error> {
        let at = |time: EndTime, shutter_s: f64| match time {
            EndTime::Shutter => shutter_s,
            EndTime::Seconds(seconds) => seconds,
            EndTime::At(epoch) => seconds_between(opened, epoch),
        };
        let ends_s = [at(self.times[0], 0.0), at(self.times[1], exposure_s)];
        let [enter, exit] = self.times.map(|time| matches!(time, EndTime::Seconds(_)));
        let enter = if enter { "enter_s" } else { "enter_utc" };
        let exit = if exit { "exit_s" } else { "exit_utc" };
        for (name, time_s) in [enter, exit].into_iter().zip(ends_s) {
            if !(-ROUNDED_S..=exposure_s + ROUNDED_S).contains(&time_s) {
                let allowed = format!("0 to {exposure_s} s after it; the shutter opened at {}", format_utc(opened, 3));
                return Err(self.invalid(name, format!("{time_s:.3} s after the opening of the shutter"), allowed));
            }
        }
        let [from_s, to_s] = ends_s.map(|time_s| time_s.clamp(0.0, exposure_s));
        if to_s <= from_s {
            return Err(self.invalid(exit, format!("{to_s} s"), format!("later than {enter}, {from_s} s")));
        }
        Ok([from_s, to_s])
    }

    /// Returns the track of the light, which moves evenly from one end to the other: along a straight line of `chip`,
    /// or along a great circle.
    ///
    /// # Errors
    /// A time is outside of the exposure, or a position has no direction on the sky.
    pub(crate) fn track(
        &self,
        chip: &Chip,
        (opened, exposure_s): (Epoch, f64),
        (tracking, centre): (&Tracking, &Direction<Gcrs>),
        magnitude: f64,
    ) -> Result<SkyTrack, Error> {
        let [from_s, to_s] = self.seconds(opened, exposure_s)?;
        let range_km = if let GivenWidth::Distance { range_km, .. } = self.width { range_km } else { SkyPoint::FAR_KM };
        let point = |index: usize| -> Result<SkyPoint, Error> {
            let share = index as f64 / (POINTS - 1) as f64;
            let time_s = from_s + share * (to_s - from_s);
            let direction = match &self.ends {
                StreakEnds::Sky([first, last]) => between(first, last, share),
                StreakEnds::Pixels([first, last]) => {
                    let along = |a: f64, b: f64| a + share * (b - a);
                    let at = PixelPosition { x: along(first.x, last.x), y: along(first.y, last.y) };
                    let seen = chip.wcs.to_sky(at).ok_or_else(|| {
                        let [x, y] = at.fits();
                        self.invalid("position", format!("({x:.1}, {y:.1})"), "pixels with a direction on the sky")
                    })?;
                    tracking.on_sky(&seen, time_s, centre)
                }
            };
            Ok(SkyPoint { time_s, direction, range_km, magnitude: Some(magnitude) })
        };
        Ok(SkyTrack { points: (0..POINTS).map(point).collect::<Result<_, _>>()? })
    }
}

/// Returns the direction at a share (0 to 1) of the great circle from one direction to another.
fn between(first: &Direction<Gcrs>, last: &Direction<Gcrs>, share: f64) -> Direction<Gcrs> {
    let angle = first.separation_rad(last);
    // For a small angle the chord replaces the arc, which would be 0 / 0.
    let [a, b] = if angle < 1e-9 {
        [1.0 - share, share]
    } else {
        [((1.0 - share) * angle).sin() / angle.sin(), (share * angle).sin() / angle.sin()]
    };
    Direction::from_vector((first.vector() * a + last.vector() * b).normalize())
}

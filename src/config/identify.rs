//! Configuration of an identification request: position and time of a measured streak.

use std::path::{Path, PathBuf};

use hifitime::Epoch;
use serde::Deserialize;

use super::document::Config;
use super::error::request;
use super::identify_plan::IdentifyPlan;
use super::required::STREAK;
use super::values::{Quantity, in_range, parse_angle_deg, parse_duration_s, parse_exposure_s};
use crate::error::Error;
use crate::frames::{Direction, Gcrs, parse_direction, parse_moment, parse_start, seconds_between};
use crate::identify::{MeasuredStreak, Timing, fit_line};
use crate::images::{ExposureTime, OUTLINES, Outline, parse_regions};
use crate::input;

/// Default clock error (one sigma), seconds.
pub(super) const TIME_SIGMA_S: f64 = 0.5;
/// Default error of a position angle (one sigma), degrees.
const ANGLE_SIGMA_DEG: f64 = 1.0;
/// Default position error of an end (one sigma), arcsec.
const POSITION_SIGMA_ARCSEC: f64 = 5.0;
/// Default position error (one sigma) of an end measured by eye in a frame, pixels.
#[cfg(all(feature = "fits", unix))]
pub(super) const POSITION_SIGMA_PIX: f64 = 3.0;

/// Measured streak, in addition to [`Config`]: two ends, a position and an angle, two pixels of a frame, or regions.
///
/// ```
/// let streak: streakcast::config::IdentifyConfig =
///     serde_json::from_str(r#"{"end": ["325.4006,10.458", "325.4633,10.4838"], "exposure": "30s"}"#)?;
/// assert!(!streak.whole_streak);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args), command(next_help_heading = "Streak"))]
pub struct IdentifyConfig {
    /// End of the streak (ICRS), to be given twice: 232.01,8.93 or 15h28m04s,8d55m42s
    #[cfg_attr(feature = "cli", arg(long, value_name = "RA,DEC", allow_hyphen_values = true))]
    pub end: Vec<String>,
    /// Right ascension of the middle of the streak (ICRS): 188.5 (degrees) or 12h34m
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "position_angle")
    )]
    pub ra: Option<String>,
    /// Declination of the middle of the streak (ICRS): -30.5 or -30d30m
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "position_angle")
    )]
    pub dec: Option<String>,
    /// Position angle of the streak at --ra, --dec, in either direction, degrees from north through east
    #[cfg_attr(feature = "cli", arg(long, value_name = "DEG", allow_hyphen_values = true, requires = "ra"))]
    pub position_angle: Option<f64>,
    /// Length of the streak with its unit, for example 8arcmin
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", requires = "position_angle"))]
    pub length: Option<String>,
    /// Frame (FITS) of the streak: source of world coordinates, times and, if no site is given, the site
    #[cfg_attr(all(feature = "cli", feature = "fits", unix), arg(long, value_name = "FILE"))]
    #[cfg_attr(all(feature = "cli", not(all(feature = "fits", unix))), arg(skip))]
    pub image: Option<PathBuf>,
    /// First end in the frame, pixels counted from 1 as in FITS and DS9
    #[cfg_attr(
        all(feature = "cli", feature = "fits", unix),
        arg(long, value_name = "X,Y", allow_hyphen_values = true, requires_all = ["image", "to_pix"])
    )]
    #[cfg_attr(all(feature = "cli", not(all(feature = "fits", unix))), arg(skip))]
    pub from_pix: Option<String>,
    /// Second end in the frame
    #[cfg_attr(
        all(feature = "cli", feature = "fits", unix),
        arg(long, value_name = "X,Y", allow_hyphen_values = true, requires_all = ["image", "from_pix"])
    )]
    #[cfg_attr(all(feature = "cli", not(all(feature = "fits", unix))), arg(skip))]
    pub to_pix: Option<String>,
    /// HDU of the frame, counted from 0; the only image if omitted
    #[cfg_attr(all(feature = "cli", feature = "fits", unix), arg(long, value_name = "N"))]
    #[cfg_attr(all(feature = "cli", not(all(feature = "fits", unix))), arg(skip))]
    pub hdu: Option<usize>,
    /// DS9 region file drawn around the streak: polygons, boxes, lines or vectors in fk5, icrs, image or physical
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE"))]
    pub region: Option<PathBuf>,
    /// Position error (one sigma) of an end with its unit; if omitted 5arcsec, 3 pixels in a frame, a quarter of the
    /// width of regions
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE"))]
    pub place_sigma: Option<String>,
    /// Error (one sigma) of --position-angle with its unit; 1deg if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", requires = "position_angle"))]
    pub angle_sigma: Option<String>,
    /// Times of the satellite at the first and at the second --end
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "TIME",
            num_args = 2,
            value_delimiter = ',',
            requires = "end",
            conflicts_with_all = ["start", "exposure", "whole_streak"]
        )
    )]
    pub times: Vec<String>,
    /// Shutter opening, for example 2024-08-14T00:30:00.000Z; from the frame if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub start: Option<String>,
    /// Exposure time with its unit, for example 30s or 2min; from the frame if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true))]
    pub exposure: Option<String>,
    /// Both ends are positions of the satellite at shutter opening and closing, not at the edges of the frame
    #[cfg_attr(feature = "cli", arg(long))]
    pub whole_streak: bool,
    /// Clock error (one sigma) with its unit; 0.5s if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME"))]
    pub time_sigma: Option<String>,
}

/// Errors (one sigma) of a streak.
struct Sigmas {
    place_rad: f64,
    angle_rad: f64,
    time_s: f64,
}

/// Line on the sky along a streak: two ends, or a middle with an angle.
enum Line {
    Ends([Direction<Gcrs>; 2]),
    Middle { position: Direction<Gcrs>, angle_deg: f64, length_deg: Option<f64> },
}

impl IdentifyConfig {
    /// Checks the values, reads the files, and returns the measured streak.
    ///
    /// # Errors
    /// No streak or more than one is given, a time is missing, a file cannot be read, a position is outside the frame,
    /// or a number is out of range.
    pub fn resolve(&self, config: &Config) -> Result<IdentifyPlan, Error> {
        let has_middle = self.position_angle.is_some() || self.ra.is_some() || self.dec.is_some();
        let mut forms = vec![
            ("--end", !self.end.is_empty()),
            ("--position-angle", has_middle),
            ("--from-pix", self.from_pix.is_some() || self.to_pix.is_some()),
            ("--region", self.region.is_some()),
        ];
        forms.retain(|(_, is_given)| *is_given);
        let forms: Vec<&'static str> = forms.into_iter().map(|(form, _)| form).collect();
        let (source, (line, sigma_arcsec)) = match (forms.as_slice(), &self.region) {
            ([], _) => return Err(STREAK.missing()),
            (["--end"], _) => ("--end", (self.ends()?, POSITION_SIGMA_ARCSEC)),
            (["--position-angle"], _) => ("--position-angle", (self.middle()?, POSITION_SIGMA_ARCSEC)),
            (["--from-pix"], _) => ("--from-pix", self.in_frame()?),
            (["--region"], Some(path)) => ("--region", self.in_regions(path)?),
            (several, _) => {
                let several = several.join(" and ");
                return Err(request(format!("{several} exclude each other; specify {}", STREAK.words)));
            }
        };
        let (exposure, timing) = self.timing(config)?;
        let Sigmas { place_rad: place_sigma_rad, angle_rad: angle_sigma_rad, time_s: time_sigma_s } =
            self.sigmas(sigma_arcsec, exposure.start_sigma_s)?;
        let time = (exposure.start, exposure.duration_s);
        let streak = match line {
            Line::Ends(ends) => MeasuredStreak::from_ends(ends, time, timing, place_sigma_rad, time_sigma_s)?,
            Line::Middle { length_deg: None, .. } if timing == Timing::Whole => {
                return Err(Error::invalid(
                    "--whole-streak",
                    "given without the length of the streak",
                    "a streak of known length, with --length ANGLE",
                ));
            }
            Line::Middle { position, angle_deg, length_deg } => MeasuredStreak::from_middle(
                position,
                (angle_deg.to_radians(), angle_sigma_rad),
                length_deg.map(f64::to_radians),
                time,
                timing,
                place_sigma_rad,
                time_sigma_s,
            )?,
        };
        Ok(IdentifyPlan { streak, source, remarks: exposure.remarks })
    }

    /// Checks the times and errors that are the same for all streaks of a table.
    ///
    /// # Errors
    /// A value is invalid.
    #[cfg(all(feature = "fits", unix))]
    pub(super) fn check_common(&self, config: &Config) -> Result<(), Error> {
        self.given_exposure(config)?;
        self.sigmas(POSITION_SIGMA_ARCSEC, 0.0)?;
        config.photometry().map(drop)
    }

    /// Returns the errors of the streak. If none are given, `place_arcsec` is that of the position, and that of the time is
    /// at least `start_s`.
    fn sigmas(&self, place_arcsec: f64, start_s: f64) -> Result<Sigmas, Error> {
        let angle_deg = |what, given: &Option<String>, default_deg| {
            given.as_deref().map_or(Ok(default_deg), |given| parse_angle_deg(what, given))
        };
        let time_s = self.time_sigma.as_deref().map(|given| parse_duration_s("time-sigma", given)).transpose()?;
        Ok(Sigmas {
            place_rad: angle_deg("place-sigma", &self.place_sigma, place_arcsec / 3600.0)?.to_radians(),
            angle_rad: angle_deg("angle-sigma", &self.angle_sigma, ANGLE_SIGMA_DEG)?.to_radians(),
            time_s: in_range(
                "time-sigma",
                time_s.unwrap_or(TIME_SIGMA_S.max(start_s)),
                "s",
                "above 0 s, at most 86400 s",
                |seconds| seconds > 0.0,
            )?,
        })
    }

    /// Returns the configuration. If it has no site, sets the site of the frame's header, and also returns a message
    /// with that site.
    ///
    /// # Errors
    /// The frame cannot be read or has no site.
    pub fn with_site_of_frame(&self, config: Config) -> Result<(Config, Option<String>), Error> {
        #[cfg(all(feature = "fits", unix))]
        if let Some(path) = self.image.as_ref().filter(|_| config.takes_site_of_frame()) {
            let (site, unused) = super::identify_frame::site(path, self.hdu)?;
            return config.at_site_of_header(site.as_ref(), unused, &path.display().to_string());
        }
        Ok((config, None))
    }

    fn ends(&self) -> Result<Line, Error> {
        let [first, other] = self.end.as_slice() else {
            let times = match self.end.len() {
                1 => "once".to_owned(),
                count => format!("{count} times"),
            };
            return Err(Error::invalid("--end", format_args!("given {times}"), "twice, once for each end"));
        };
        let end = |text: &str| {
            let (ra, dec) = text.split_once(',').ok_or_else(|| {
                request(format!("invalid end '{text}'")).allowing("RA,DEC, for example 188.5,-30.5 or 12h34m,-30d30m")
            })?;
            parse_direction(ra.trim(), dec.trim())
        };
        Ok(Line::Ends([end(first)?, end(other)?]))
    }

    fn middle(&self) -> Result<Line, Error> {
        let (Some(ra), Some(dec), Some(angle_deg)) = (&self.ra, &self.dec, self.position_angle) else {
            return Err(request("incomplete middle of the streak; specify --ra, --dec and --position-angle"));
        };
        let length_deg = self.length.as_deref().map(|length| parse_angle_deg("length", length)).transpose()?;
        Ok(Line::Middle { position: parse_direction(ra, dec)?, angle_deg, length_deg })
    }

    #[cfg(not(all(feature = "fits", unix)))]
    fn in_frame(&self) -> Result<(Line, f64), Error> {
        Err(request("this build cannot read frames; it needs the cargo feature fits"))
    }

    #[cfg(all(feature = "fits", unix))]
    fn in_frame(&self) -> Result<(Line, f64), Error> {
        use super::identify_frame::{ends, pixel};
        let (Some(path), Some(from), Some(to)) = (&self.image, &self.from_pix, &self.to_pix) else {
            return Err(request("incomplete streak in a frame; specify --image, --from-pix and --to-pix"));
        };
        let (ends, pixel_arcsec) = ends(path, self.hdu, [pixel(from)?, pixel(to)?])?;
        Ok((Line::Ends(ends), POSITION_SIGMA_PIX * pixel_arcsec))
    }

    /// Returns the interval, and the relation between times and ends.
    fn timing(&self, config: &Config) -> Result<(ExposureTime, Timing), Error> {
        let scale = config.time_scale()?;
        match self.times.as_slice() {
            [] => {
                let timing = if self.whole_streak { Timing::Whole } else { Timing::Within };
                Ok((self.exposed(config)?, timing))
            }
            [first, second] => {
                let (first, second) = (parse_moment(first, scale)?, parse_moment(second, scale)?);
                let duration_s = seconds_between(first, second);
                if duration_s <= 0.0 {
                    return Err(Error::invalid(
                        "the second of --times",
                        format_args!("{duration_s} s after the first"),
                        "the time at the first --end, then a later one at the second",
                    ));
                }
                Ok((ExposureTime::given(first, duration_s), Timing::FirstToSecond))
            }
            other => Err(request(format!("--times has {} values", other.len())).allowing("2, one for each --end")),
        }
    }

    /// Returns shutter opening and exposure time (seconds) from `self`, or else from the configuration.
    fn given_exposure(&self, config: &Config) -> Result<(Option<Epoch>, Option<f64>), Error> {
        let given = |given: &Option<String>, configured: &Option<Quantity>| {
            given.clone().or(configured.as_ref().map(|value| value.as_str().to_owned()))
        };
        let scale = config.time_scale()?;
        let start = given(&self.start, &config.exposure.start).map(|start| parse_start(&start, scale)).transpose()?;
        let duration_s =
            given(&self.exposure, &config.exposure.duration).map(|length| parse_exposure_s(&length)).transpose()?;
        Ok((start, duration_s))
    }

    /// Returns the exposure: from `self`, or else from the configuration, or else from the frame's header, with remarks
    /// about it.
    fn exposed(&self, config: &Config) -> Result<ExposureTime, Error> {
        let (start, duration_s) = self.given_exposure(config)?;
        #[cfg(all(feature = "fits", unix))]
        if let Some(path) = &self.image {
            return super::identify_frame::exposure(path, self.hdu, start, duration_s);
        }
        match (start, duration_s) {
            (Some(start), Some(duration_s)) => Ok(ExposureTime::given(start, duration_s)),
            (None, _) => Err(Error::missing(
                "start of the exposure",
                "--start 2024-08-14T00:30:00.000Z, or --times with both --end",
            )),
            (_, None) => Err(Error::missing("exposure time", "--exposure 30s")),
        }
    }

    /// Returns the line through regions drawn around a streak, and the position error (one sigma) of its ends, arcsec.
    fn in_regions(&self, path: &Path) -> Result<(Line, f64), Error> {
        let text = input::read_to_string(path).map_err(Error::io(path))?;
        let mut outlines = Vec::new();
        for region in parse_regions(&path.display().to_string(), &text, OUTLINES)? {
            outlines.push(self.on_sky(region.outline).map_err(|error| error.in_line("", path, region.line))?);
        }
        if outlines.is_empty() {
            let allowed = format!("1 or more: {OUTLINES} in fk5, icrs, image or physical");
            return Err(Error::invalid("number of regions", 0, allowed).in_file("", path));
        }
        let line = fit_line(&outlines).map_err(|error| error.in_file("", path))?;
        // The middle line of a box is closer to the streak than the sides of the box. Lines have no width; several of
        // them scatter about the streak.
        let half_width_arcsec = line.half_width_rad.to_degrees() * 3600.0;
        let sigma_arcsec =
            if line.has_width { 0.5 * half_width_arcsec } else { POSITION_SIGMA_ARCSEC.max(half_width_arcsec) };
        Ok((Line::Ends(line.ends), sigma_arcsec))
    }

    #[cfg(not(all(feature = "fits", unix)))]
    fn on_sky(&self, outline: Outline) -> Result<Vec<Direction<Gcrs>>, Error> {
        match outline {
            Outline::Sky(corners) => Ok(corners),
            _ => Err(request("this build cannot read frames; regions in pixels need the cargo feature fits")),
        }
    }

    /// Returns the directions of the corners or ends of the part of a region in the frame.
    #[cfg(all(feature = "fits", unix))]
    fn on_sky(&self, outline: Outline) -> Result<Vec<Direction<Gcrs>>, Error> {
        use super::identify_frame::{header, region};
        let frame = || {
            let allowed = "--image FRAME, or a region in fk5 or icrs";
            self.image.as_ref().ok_or_else(|| Error::missing("frame of a region in pixels", allowed))
        };
        match outline {
            Outline::Sky(corners) => Ok(corners),
            Outline::Pixels(corners) => region(frame()?, self.hdu, &corners),
            Outline::Physical(mut corners) => {
                let header = header(frame()?, self.hdu)?;
                corners.iter_mut().for_each(|at| *at = at.of_physical(&header));
                region(frame()?, self.hdu, &corners)
            }
        }
    }
}

//! From what was typed, a frame, or regions to a measured streak.

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg, seconds_between};
use streakcast::identify::{MeasuredStreak, Timing, fit_line, parse_regions};
use streakcast::setup::{Quantity, Setup, parse_angle_deg, parse_duration_s, parse_moment};

use crate::identify_arguments::{IdentifyArguments, StreakPlaceArguments, StreakTimeArguments};

/// One sigma of an end where nobody says better, arcsec.
const PLACE_SIGMA_ARCSEC: f64 = 5.0;
/// The same in a frame, pixels: ends are found by eye.
#[cfg(feature = "fits")]
const PLACE_SIGMA_PIX: f64 = 3.0;
/// One sigma of the clock, s.
const TIME_SIGMA_S: f64 = 0.5;
/// One sigma of an angle that was typed, degrees.
const ANGLE_SIGMA_DEG: f64 = 1.0;

const WAYS: &str =
    "--end RA,DEC twice; --ra, --dec and --position-angle; --image with --from-pix and --to-pix; or --region FILE";

/// Two ends, or a middle with an angle.
enum Line {
    Ends([Direction<Gcrs>; 2]),
    Middle { place: Direction<Gcrs>, angle_deg: f64, length_deg: Option<f64> },
}

/// A line with the error of its ends, arcsec.
struct Place {
    line: Line,
    sigma_arcsec: f64,
}

/// What is to be identified, and where it came from in words.
pub struct Asked {
    pub streak: MeasuredStreak,
    pub from: &'static str,
}

pub fn asked(typed: &IdentifyArguments, setup: &Setup) -> anyhow::Result<Asked> {
    let ways = typed.streak.ways();
    let from = match ways.as_slice() {
        [one] => *one,
        [] => return Err(anyhow!("no streak; say {WAYS}")),
        several => return Err(anyhow!("{} exclude each other; say {WAYS}", several.join(" and "))),
    };
    let place = place(typed, from)?;
    let (start, duration_s, timing) = times(typed, setup)?;
    let sigma_arcsec = match &typed.streak.place_sigma {
        Some(said) => parse_angle_deg("place-sigma", said)? * 3600.0,
        None => place.sigma_arcsec,
    };
    let place_sigma_rad = (sigma_arcsec / 3600.0).to_radians();
    let said = typed.time.time_sigma.as_deref();
    let time_sigma_s = said.map_or(Ok(TIME_SIGMA_S), |said| parse_duration_s("time-sigma", said))?;
    let said = typed.streak.angle_sigma.as_deref();
    let angle_sigma_deg = said.map_or(Ok(ANGLE_SIGMA_DEG), |said| parse_angle_deg("angle-sigma", said))?;
    let time = (start, duration_s);
    let streak = match place.line {
        Line::Ends(ends) => MeasuredStreak::from_ends(ends, time, timing, place_sigma_rad, time_sigma_s)?,
        Line::Middle { place, angle_deg, length_deg } => MeasuredStreak::from_place(
            place,
            (angle_deg.to_radians(), angle_sigma_deg.to_radians()),
            length_deg.map(f64::to_radians),
            time,
            timing,
            place_sigma_rad,
            time_sigma_s,
        )?,
    };
    Ok(Asked { streak, from })
}

impl StreakPlaceArguments {
    /// The ways in which a streak was said.
    fn ways(&self) -> Vec<&'static str> {
        let mut ways = Vec::new();
        if !self.end.is_empty() {
            ways.push("--end");
        }
        if self.position_angle.is_some() || self.ra.is_some() || self.dec.is_some() {
            ways.push("--position-angle");
        }
        #[cfg(feature = "fits")]
        if self.from_pix.is_some() || self.to_pix.is_some() {
            ways.push("--from-pix");
        }
        if self.region.is_some() {
            ways.push("--region");
        }
        ways
    }
}

fn place(typed: &IdentifyArguments, from: &str) -> anyhow::Result<Place> {
    let streak = &typed.streak;
    match from {
        "--end" => {
            let [one, other] = streak.end.as_slice() else {
                return Err(anyhow!("--end was said {} times; allowed: twice, both ends", streak.end.len()));
            };
            Ok(Place { line: Line::Ends([direction(one)?, direction(other)?]), sigma_arcsec: PLACE_SIGMA_ARCSEC })
        }
        "--position-angle" => {
            let (Some(ra), Some(dec), Some(angle_deg)) = (&streak.ra, &streak.dec, streak.position_angle) else {
                return Err(anyhow!("no middle of the streak; say --ra, --dec and --position-angle"));
            };
            let length_deg = streak.length.as_deref().map(|length| parse_angle_deg("length", length)).transpose()?;
            let place = at(ra, dec)?;
            Ok(Place { line: Line::Middle { place, angle_deg, length_deg }, sigma_arcsec: PLACE_SIGMA_ARCSEC })
        }
        #[cfg(feature = "fits")]
        "--from-pix" => in_frame(streak),
        _ => {
            let path = streak.region.as_deref().unwrap_or(std::path::Path::new(""));
            let shown = path.display().to_string();
            let text = std::fs::read_to_string(path).map_err(|error| anyhow!("{shown}: {error}"))?;
            let line = fit_line(&parse_regions(&shown, &text)?).map_err(|error| anyhow!("{shown}: {error}"))?;
            // A box is drawn to hold a streak: its middle is known better than its sides.
            let half_width_arcsec = line.half_width_rad.to_degrees() * 3600.0;
            let sigma_arcsec = if half_width_arcsec > 0.0 { 0.5 * half_width_arcsec } else { PLACE_SIGMA_ARCSEC };
            Ok(Place { line: Line::Ends(line.ends), sigma_arcsec })
        }
    }
}

/// `188.5,-30.5`
fn direction(text: &str) -> anyhow::Result<Direction<Gcrs>> {
    let (ra, dec) = text
        .split_once(',')
        .ok_or_else(|| anyhow!("end '{text}' is no place; allowed: RA,DEC as 188.5,-30.5 or 12h34m,-30d30m"))?;
    at(ra.trim(), dec.trim())
}

fn at(ra: &str, dec: &str) -> anyhow::Result<Direction<Gcrs>> {
    Ok(Direction::from_lon_lat_rad(
        parse_right_ascension_deg(ra)?.to_radians(),
        parse_declination_deg(dec)?.to_radians(),
    ))
}

fn times(typed: &IdentifyArguments, setup: &Setup) -> anyhow::Result<(Epoch, f64, Timing)> {
    let scale = setup.time_scale()?;
    if let [first, second] = typed.time.times.as_slice() {
        let (first, second) = (parse_moment(first, scale)?, parse_moment(second, scale)?);
        let duration_s = seconds_between(first, second);
        if duration_s <= 0.0 {
            return Err(anyhow!(
                "times: the second is {duration_s} s after the first; allowed: that of the first --end first, then that of the second, later"
            ));
        }
        return Ok((first, duration_s, Timing::FirstToSecond));
    }
    let timing = if typed.time.whole_streak { Timing::Whole } else { Timing::Within };
    let (start, duration_s) = exposure(typed, setup, &typed.time)?;
    Ok((start, duration_s, timing))
}

/// When the shutter opened and for how long: as typed, else as the frame or the configuration says.
fn exposure(typed: &IdentifyArguments, setup: &Setup, time: &StreakTimeArguments) -> anyhow::Result<(Epoch, f64)> {
    let said = |typed: &Option<String>, configured: &Option<Quantity>| {
        typed.clone().or(configured.as_ref().map(Quantity::text))
    };
    let scale = setup.time_scale()?;
    let start = said(&time.start, &setup.start).map(|start| parse_moment(&start, scale)).transpose()?;
    let duration_s =
        said(&time.exposure, &setup.exposure).map(|length| parse_duration_s("exposure", &length)).transpose()?;
    #[cfg(feature = "fits")]
    if let Some(path) = &typed.streak.image {
        return frame::exposure(path, typed.streak.hdu, start, duration_s);
    }
    #[cfg(not(feature = "fits"))]
    let _ = typed;
    match (start, duration_s) {
        (Some(start), Some(duration_s)) => Ok((start, duration_s)),
        (None, _) => {
            Err(anyhow!("no start of the exposure; say --start 2024-08-14T00:30:00.000Z, or --times with both --end"))
        }
        (_, None) => Err(anyhow!("no length of the exposure; say --exposure 30s")),
    }
}

#[cfg(feature = "fits")]
fn in_frame(streak: &StreakPlaceArguments) -> anyhow::Result<Place> {
    let (Some(path), Some(from), Some(to)) = (&streak.image, &streak.from_pix, &streak.to_pix) else {
        return Err(anyhow!("no streak in the frame; say --image, --from-pix and --to-pix"));
    };
    let (ends, pixel_arcsec) = frame::ends(path, streak.hdu, [pixel(from)?, pixel(to)?])?;
    Ok(Place { line: Line::Ends(ends), sigma_arcsec: PLACE_SIGMA_PIX * pixel_arcsec })
}

#[cfg(feature = "fits")]
fn pixel(text: &str) -> anyhow::Result<streakcast::camera::PixelPosition> {
    let numbers = text.split_once(',').and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)));
    numbers
        .filter(|(x, y): &(f64, f64)| x.is_finite() && y.is_finite())
        .map(|(x, y)| streakcast::camera::PixelPosition::from_fits(x, y))
        .ok_or_else(|| anyhow!("pixel '{text}'; allowed: X,Y counted from 1, as 1024.5,2048"))
}

#[cfg(feature = "fits")]
mod frame {
    //! What a frame says.

    use std::path::Path;

    use anyhow::anyhow;
    use hifitime::Epoch;
    use streakcast::camera::{ExposureTime, FrameFile, Header, PixelPosition, Wcs};
    use streakcast::frames::{Direction, Gcrs};

    /// The image that is meant: the one said, else the only one.
    fn image(path: &Path, hdu: Option<usize>) -> anyhow::Result<(FrameFile, usize)> {
        let file = FrameFile::open(path)?;
        let images = file.images();
        let hdu = match (hdu, images.as_slice()) {
            (Some(hdu), _) => hdu,
            (None, [one]) => *one,
            (None, []) => return Err(anyhow!("{}: holds no image of two axes", path.display())),
            (None, several) => {
                let (first, last) = (several[0], several[several.len() - 1]);
                return Err(anyhow!(
                    "{}: holds {} images; say which: --hdu {first} to {last}",
                    path.display(),
                    several.len()
                ));
            }
        };
        file.image_size(hdu)?;
        Ok((file, hdu))
    }

    /// Both ends on the sky, and the side of a pixel, arcsec.
    pub fn ends(
        path: &Path,
        hdu: Option<usize>,
        pixels: [PixelPosition; 2],
    ) -> anyhow::Result<([Direction<Gcrs>; 2], f64)> {
        let (file, hdu) = image(path, hdu)?;
        let fail = |error: String| anyhow!("{}: HDU {hdu}: {error}", path.display());
        let wcs = Wcs::from_header(file.header(hdu)?).map_err(|error| fail(error.to_string()))?;
        let place = |pixel: PixelPosition| {
            let [x, y] = pixel.fits();
            wcs.to_sky(pixel).ok_or_else(|| fail(format!("pixel {x},{y} has no place on the sky")))
        };
        let [from, to] = pixels;
        let ends = [place(from)?, place(to)?];
        let length_pix = from.distance(to).max(1e-9);
        Ok((ends, ends[0].separation_rad(&ends[1]).to_degrees() * 3600.0 / length_pix))
    }

    /// Opening and length: what was said counts, the header where nothing was.
    pub fn exposure(
        path: &Path,
        hdu: Option<usize>,
        start: Option<Epoch>,
        duration_s: Option<f64>,
    ) -> anyhow::Result<(Epoch, f64)> {
        if let (Some(start), Some(duration_s)) = (start, duration_s) {
            return Ok((start, duration_s));
        }
        let (file, hdu) = image(path, hdu)?;
        let headers: [&Header; 2] = [file.header(hdu)?, file.header(0)?];
        let fail = |error| anyhow!("{}: {error}", path.display());
        let duration_s = duration_s.map_or_else(|| ExposureTime::duration_from_headers(&headers), Ok).map_err(fail)?;
        let start = start.map_or_else(|| ExposureTime::start_from_headers(&headers, duration_s), Ok).map_err(fail)?;
        Ok((start, duration_s))
    }
}

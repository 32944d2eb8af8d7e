//! Where a streak lies on the sky.

use super::error::QuestionError;
use super::streak::StreakSaid;
use crate::config::parse_angle_deg;
use crate::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};
use crate::identify::{fit_line, parse_regions};

/// One sigma of an end where nobody says better, arcsec.
const PLACE_SIGMA_ARCSEC: f64 = 5.0;

/// Two ends, or a middle with an angle.
pub(super) enum Line {
    Ends([Direction<Gcrs>; 2]),
    Middle { place: Direction<Gcrs>, angle_deg: f64, length_deg: Option<f64> },
}

/// A line with the error of its ends, arcsec.
pub(super) struct Place {
    pub line: Line,
    pub sigma_arcsec: f64,
}

/// By the way in which it was said.
pub(super) fn place(said: &StreakSaid, from: &str) -> Result<Place, QuestionError> {
    match from {
        "--end" => {
            let [one, other] = said.end.as_slice() else {
                let times = match said.end.len() {
                    1 => "once".to_owned(),
                    count => format!("{count} times"),
                };
                return Err(QuestionError::said(format!("--end was said {times}; allowed: twice, both ends")));
            };
            Ok(Place { line: Line::Ends([direction(one)?, direction(other)?]), sigma_arcsec: PLACE_SIGMA_ARCSEC })
        }
        "--position-angle" => {
            let (Some(ra), Some(dec), Some(angle_deg)) = (&said.ra, &said.dec, said.position_angle) else {
                return Err(QuestionError::said("no middle of the streak; say --ra, --dec and --position-angle"));
            };
            let length_deg = said.length.as_deref().map(|length| parse_angle_deg("length", length)).transpose()?;
            let place = at(ra, dec)?;
            Ok(Place { line: Line::Middle { place, angle_deg, length_deg }, sigma_arcsec: PLACE_SIGMA_ARCSEC })
        }
        "--from-pix" => in_frame(said),
        _ => in_regions(said),
    }
}

/// `188.5,-30.5`
fn direction(text: &str) -> Result<Direction<Gcrs>, QuestionError> {
    let (ra, dec) = text.split_once(',').ok_or_else(|| {
        QuestionError::said(format!("end '{text}' is no place; allowed: RA,DEC as 188.5,-30.5 or 12h34m,-30d30m"))
    })?;
    at(ra.trim(), dec.trim())
}

fn at(ra: &str, dec: &str) -> Result<Direction<Gcrs>, QuestionError> {
    Ok(Direction::from_lon_lat_rad(
        parse_right_ascension_deg(ra)?.to_radians(),
        parse_declination_deg(dec)?.to_radians(),
    ))
}

fn in_regions(said: &StreakSaid) -> Result<Place, QuestionError> {
    let path = said.region.as_deref().unwrap_or(std::path::Path::new(""));
    let shown = path.display().to_string();
    let fail = |error: &dyn std::fmt::Display| QuestionError::said(format!("{shown}: {error}"));
    let text = std::fs::read_to_string(path).map_err(|error| fail(&error))?;
    let line = fit_line(&parse_regions(&shown, &text)?).map_err(|error| fail(&error))?;
    // A box is drawn to hold a streak: its middle is known better than its sides.
    let half_width_arcsec = line.half_width_rad.to_degrees() * 3600.0;
    let sigma_arcsec = if half_width_arcsec > 0.0 { 0.5 * half_width_arcsec } else { PLACE_SIGMA_ARCSEC };
    Ok(Place { line: Line::Ends(line.ends), sigma_arcsec })
}

#[cfg(not(feature = "fits"))]
fn in_frame(_: &StreakSaid) -> Result<Place, QuestionError> {
    Err(QuestionError::said("this build reads no frames (cargo feature fits)"))
}

#[cfg(feature = "fits")]
fn in_frame(said: &StreakSaid) -> Result<Place, QuestionError> {
    use super::streak_frame::{ends, pixel};
    /// One sigma of an end that was found by eye, pixels.
    const PLACE_SIGMA_PIX: f64 = 3.0;

    let (Some(path), Some(from), Some(to)) = (&said.image, &said.from_pix, &said.to_pix) else {
        return Err(QuestionError::said("no streak in the frame; say --image, --from-pix and --to-pix"));
    };
    let (ends, pixel_arcsec) = ends(path, said.hdu, [pixel(from)?, pixel(to)?])?;
    Ok(Place { line: Line::Ends(ends), sigma_arcsec: PLACE_SIGMA_PIX * pixel_arcsec })
}

//! Synthetic frames with sky, stars and detector noise, simulated from a description.

use std::path::Path;

use hifitime::TimeScale;
use serde::Deserialize;

use super::super::chip::Chip;
use super::super::count_scale::CountScale;
use super::super::tracking::Tracking;
use super::star_trails::{SkyStar, add_trails, draw_stars};
use super::synthetic_shot::SyntheticShot;
use crate::error::Error;
use crate::frames::{Direction, mjd_utc};
use crate::images::{
    Card, CardValue, Detector, ImageValues, LightArea, NewImage, Pixels, Plane, Rice, Wcs, write_frame,
};
use crate::input::TableRows;
use crate::output::format_utc;
use crate::streaks::{Blur, RadialProfile, RandomStars, Star, background, flux_e};
use crate::units::{DEGREES, MAGNITUDES};

/// Description of a synthetic frame, read from a TOML file.
///
/// ```
/// let frame = streakcast::streaks::SyntheticFrame::from_toml(
///     "columns = 1024
///      rows = 1024
///      pixel_scale_arcsec = 0.5
///      zero_point_1s_mag = 26.5
///      sky_mag_arcsec2 = 21.0
///      stars = { per_megapixel = 300, slope = 0.3, brightest_mag = 14, faintest_mag = 22 }
///      detector = { gain_e_adu = 1.5, read_noise_e = 6, bias_adu = 200, quantisation = { greatest_adu = 65535 } }",
///     "sky.toml",
/// )?;
/// assert_eq!(frame.columns, 1024);
/// # Ok::<(), streakcast::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SyntheticFrame {
    /// Pixels along a row, 16 to 32768.
    pub columns: usize,
    /// Pixels along a column, 16 to 32768.
    pub rows: usize,
    /// Side of a pixel, arcsec, 0.001 to 600.
    pub pixel_scale_arcsec: f64,
    /// Position angle of the direction in which row numbers increase, degrees from north through east.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Magnitude of a star that gives one electron per second.
    pub zero_point_1s_mag: f64,
    /// Surface brightness of the sky, mag per square arcsecond.
    pub sky_mag_arcsec2: f64,
    /// Random stars; `None` for none.
    #[serde(default)]
    pub stars: Option<StarField>,
    /// CSV file of stars with the columns `ra_deg`, `dec_deg` and `magnitude`.
    #[serde(default)]
    pub star_list: Option<std::path::PathBuf>,
    /// Detector that converts electrons to counts.
    #[serde(default)]
    pub detector: Detector,
    /// If true, the frame is written in tiles compressed by RICE, which keeps whole counts exactly.
    #[serde(default)]
    pub compress: bool,
}

/// Density and magnitudes of random stars.
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StarField {
    /// Mean number of stars per million pixels.
    pub per_megapixel: f64,
    /// Logarithmic slope of the star counts with magnitude: N(< m) ∝ 10^(slope m).
    pub slope: f64,
    /// Brightest magnitude, mag.
    pub brightest_mag: f64,
    /// Faintest magnitude, mag.
    pub faintest_mag: f64,
}

impl SyntheticFrame {
    /// Reads the description from TOML; `origin` is the name of the file in errors.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown or missing, or a value is out of range.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, Error> {
        let frame: Self = toml::from_str(text)
            .map_err(|error| crate::input::toml_error(&error, text).in_file("synthetic frame", origin))?;
        frame.validate().map_err(|error| error.in_file("synthetic frame", origin))?;
        Ok(frame)
    }

    fn validate(&self) -> Result<(), Error> {
        let held = |key: &str, given: f64, [least, most]: [f64; 2]| Error::check_range(key, given, least, most);
        held("columns", self.columns as f64, [16.0, 32768.0])?;
        held("rows", self.rows as f64, [16.0, 32768.0])?;
        held("pixel_scale_arcsec", self.pixel_scale_arcsec, [0.001, 600.0])?;
        held("rotation_deg", self.rotation_deg, [-360.0, 360.0])?;
        held("zero_point_1s_mag", self.zero_point_1s_mag, [0.0, 50.0])?;
        held("sky_mag_arcsec2", self.sky_mag_arcsec2, [0.0, 40.0])?;
        self.detector.validate()
    }

    /// Computes the counts of sky and stars, with the effects of the detector, and the world coordinates of the frame.
    ///
    /// # Errors
    /// A value is out of range, or the list of stars is invalid.
    pub fn expose(&self, shot: &SyntheticShot<'_>) -> Result<(Plane, Wcs), Error> {
        let rotation_rad = self.rotation_deg.to_radians();
        let wcs = Wcs::tangent(shot.centre, self.pixel_scale_arcsec, rotation_rad, self.columns, self.rows)?;
        let profile = RadialProfile::new(&Blur::seeing(shot.optics.seeing(self.pixel_scale_arcsec)))?;
        // Magnitude of a star that gives one electron in the whole exposure.
        let zero_point_mag = self.zero_point_1s_mag + 2.5 * shot.exposure_s.log10();
        let field = self.stars.map(|field| RandomStars {
            per_megapixel: field.per_megapixel,
            slope: field.slope,
            brightest_mag: field.brightest_mag,
            faintest_mag: field.faintest_mag,
            zero_point_mag,
        });
        let listed = self
            .star_list
            .as_deref()
            .map_or(Ok(Vec::new()), |path| listed_stars(path, zero_point_mag, shot.exposure_s))?;
        let reach_pix = profile.pixel_reach_pix().min(200.0);
        // Electrons per pixel from the sky's surface brightness μ: 10^(-0.4 (μ - ZP)) times the area of the pixel.
        let area_arcsec2 = self.pixel_scale_arcsec * self.pixel_scale_arcsec;
        let sky_e = 10f64.powf(-0.4 * (self.sky_mag_arcsec2 - zero_point_mag)) * area_arcsec2;
        let light = match shot.tracking {
            Tracking::Sidereal => {
                let mut stars =
                    field.map_or(Ok(Vec::new()), |field| field.draw(self.rows, self.columns, reach_pix, shot.seed))?;
                let at = |star: &SkyStar| Some(Star { at: wcs.to_pixel(star.direction)?, flux_e: star.flux_e });
                stars.extend(listed.iter().filter_map(at));
                background(self.rows, self.columns, sky_e, &stars, &profile)?
            }
            Tracking::Rate { .. } => {
                let mut light = background(self.rows, self.columns, sky_e, &[], &profile)?;
                let chip = self.chip(wcs.clone(), shot.exposure_s)?;
                let mut stars = field.map_or(Ok(Vec::new()), |field| draw_stars(&field, &chip, shot, reach_pix))?;
                stars.extend(listed);
                add_trails(&mut light, &stars, &chip, shot, &profile)?;
                light
            }
        };
        // Stars and noise have different seeds.
        let (counts, _) = self.detector.expose(&light, shot.seed.wrapping_add(1))?;
        Ok((counts, wcs))
    }

    /// Returns the frame as a chip whose count scale gives one electron for a star of magnitude 0.
    fn chip(&self, wcs: Wcs, exposure_s: f64) -> Result<Chip, Error> {
        Ok(Chip {
            hdu: 0,
            name: String::new(),
            rows: self.rows,
            columns: self.columns,
            light_area: LightArea::whole(self.rows, self.columns),
            wcs,
            is_on_sky: true,
            scale: CountScale::of_frame(0.0, exposure_s)?,
        })
    }

    /// Writes the frame with header cards for world coordinates, exposure, zero point and gain.
    /// [`crate::streaks::TargetFrame`] reads these cards.
    ///
    /// # Errors
    /// A value is out of range, the list of stars is invalid, or the file cannot be written; no partial file remains.
    pub fn write(&self, shot: &SyntheticShot<'_>, path: &Path) -> Result<(), Error> {
        let (counts, wcs) = self.expose(shot)?;
        let whole = self.detector.quantisation.is_some();
        let largest = counts.values().iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let smallest = counts.values().iter().copied().fold(f32::INFINITY, f32::min);
        let pixels = if whole && smallest >= 0.0 && largest <= 65535.0 {
            Pixels::U16(counts.values().iter().map(|value| *value as u16).collect())
        } else {
            Pixels::F32(counts.into_values().into())
        };
        let Some(values) = ImageValues::new(self.columns, pixels) else { return Ok(()) };
        let cards = self.cards(shot, &wcs);
        let rice = self.compress.then(Rice::default);
        let image = NewImage { name: "", values: &values, cards: &cards, rice };
        write_frame(path, &[image])
    }

    fn cards(&self, shot: &SyntheticShot<'_>, wcs: &Wcs) -> Vec<Card> {
        let detector = &self.detector;
        // Magnitude of a star that gives one count in the whole exposure.
        let zero_point_mag = self.zero_point_1s_mag + 2.5 * (shot.exposure_s / detector.gain_e_adu).log10();
        let date = format_utc(shot.opened, 6);
        let texts = [
            ("DATE-OBS", date.trim_end_matches('Z').to_owned(), "shutter opened"),
            ("TIMESYS", "UTC".to_owned(), ""),
            ("FILTER", shot.filter.to_owned(), ""),
            ("BUNIT", "adu".to_owned(), ""),
        ];
        let saturation =
            detector.saturation.map(|saturation| saturation.full_well_e / detector.gain_e_adu + detector.bias_adu);
        let numbers = [
            ("MJD-OBS", Some(mjd_utc(shot.opened.to_time_scale(TimeScale::UTC))), "[d] shutter opened"),
            ("EXPTIME", Some(shot.exposure_s), "[s]"),
            ("MAGZP", Some(zero_point_mag), "[mag] of one count in the frame"),
            ("GAIN", Some(detector.gain_e_adu), "[e-/adu]"),
            ("RDNOISE", Some(detector.read_noise_e), "[e-]"),
            ("SATURATE", saturation, "[adu]"),
        ];
        let mut cards = wcs.cards();
        cards.extend(
            texts
                .iter()
                .flat_map(|(key, text, comment)| Card::with_value(key, &CardValue::Text(text.clone()), comment)),
        );
        cards.extend(
            numbers
                .iter()
                .filter_map(|(key, number, comment)| {
                    number.map(|number| Card::with_value(key, &CardValue::Real(number), comment))
                })
                .flatten(),
        );
        cards.extend(Card::remark(
            "HISTORY",
            &format!("synthetic frame of streakcast {}, seed {}", env!("CARGO_PKG_VERSION"), shot.seed),
        ));
        cards
    }
}

/// Columns and ranges of a list of stars, for errors.
const STAR_LIST_FORM: &str = "CSV with ra_deg, dec_deg (-90 to 90) and magnitude (-30 to 60)";

fn listed_stars(path: &Path, zero_point_mag: f64, exposure_s: f64) -> Result<Vec<SkyStar>, Error> {
    let failed = |error: std::io::Error| {
        Error::about_file("star list", path, format!("is invalid ({error})")).allowing(STAR_LIST_FORM)
    };
    let rows = TableRows::open(path).map_err(failed)?;
    let column = |names: &[&'static str], unit| rows.numbers(names, unit, STAR_LIST_FORM).map_err(failed);
    let ra = column(&["ra_deg", "ra"], &DEGREES)?;
    let dec = column(&["dec_deg", "dec"], &DEGREES)?;
    let magnitude = column(&["magnitude"], &MAGNITUDES)?;
    let mut stars = Vec::new();
    for row in rows {
        let row = row.map_err(failed)?;
        let number = |column, range| row.number_in(column, range).map_err(failed);
        let [ra_deg, dec_deg] = [number(ra, [f64::MIN, f64::MAX])?, number(dec, [-90.0, 90.0])?];
        let magnitude = number(magnitude, [-30.0, 60.0])?;
        let direction = Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians());
        let flux_e = flux_e(magnitude, zero_point_mag);
        stars.push(SkyStar { direction, flux_e, over_s: [0.0, exposure_s] });
    }
    Ok(stars)
}

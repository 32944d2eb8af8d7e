//! Measurement of the streaks of one frame of a run.

use super::document::Config;
use super::measured_tables::identify_listed;
use crate::error::Error;
use crate::measure::{
    CatalogueStar, Estimate, FrameMeasurements, FrameOptions, ListedMeasurement, ListedStreak, MeasureOptions,
    StarShape, StarTable, StarZeroPoint, ZeroPoints, measure_frame, measure_listed,
};
use crate::passes::Sky;
use crate::photometry::{Band, PhotometryOptions};
use crate::streaks::{Optics, TargetFrame};
use crate::watch::Watch;

/// Relative difference between the given seeing and that of the stars above which there is a warning.
const SEEING_TOLERANCE: f64 = 0.1;

/// Function that returns the optics of a frame, and whether their seeing is given.
type OpticsOf<'a> = &'a dyn Fn(&TargetFrame) -> Result<(Optics, bool), Error>;

/// Options of all frames of a run.
pub(super) struct FrameRun<'a> {
    pub config: &'a Config,
    /// Returns the optics of a frame, and whether their seeing is given.
    pub optics: OpticsOf<'a>,
    /// True if streaks are given instead of those of satellites.
    pub has_streaks: bool,
    pub fit_width: bool,
    /// False if the form of the point spread function is not given.
    pub is_form_known: bool,
    /// True if the pixels along each track are returned.
    pub cuts: bool,
    /// Table of stars for the zero point.
    pub stars: Option<&'a StarTable>,
    /// Position error (one sigma) of the ends of given streaks.
    pub place_sigma_deg: Option<f64>,
    pub satellite_size_m: Option<f64>,
    pub watch: &'a Watch,
}

/// Result of one frame.
pub(super) struct FrameResult {
    /// Streaks of predicted satellites, or those of the rows that are measured.
    pub measured: FrameMeasurements,
    /// Rows of given streaks.
    pub rows: Vec<ListedMeasurement>,
    /// Errors of rows, which are left out.
    pub invalid: Vec<Error>,
    pub remarks: Vec<String>,
    /// Those of the remarks that state a choice between values in headers.
    pub choices: Vec<String>,
    pub warnings: Vec<String>,
}

impl FrameRun<'_> {
    /// Measures the given streaks in a frame or, if the run has none, those of the satellites of the sky.
    ///
    /// # Errors
    /// Pixels cannot be read, passes cannot be computed, the table of stars has none in the band of the frame, or an
    /// option is invalid.
    pub fn measure(
        &self,
        frame: &TargetFrame,
        is_calibrated: bool,
        sky: Option<&Sky>,
        mut streaks: Vec<ListedStreak>,
    ) -> Result<FrameResult, Error> {
        let (mut rows, mut invalid, mut remarks, mut warnings) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let shown = frame.file.path().display();
        state_frame(frame, is_calibrated || self.stars.is_some(), &mut warnings);
        warnings.extend(sky.iter().flat_map(|sky| frame_warnings(sky, frame)));
        let photometry = photometry(self.config, frame)?;
        let (optics, is_seeing_known) = (self.optics)(frame)?;
        let filter = self.config.light.band.as_deref().or(frame.filter.as_deref());
        let stars: Option<Vec<CatalogueStar>> = self.stars.map(|table| table.in_band(filter)).transpose()?;
        let zero_points = match &stars {
            Some(stars) => ZeroPoints::Stars(stars),
            None if is_calibrated => ZeroPoints::Frame,
            None => ZeroPoints::Missing,
        };
        let measure = MeasureOptions {
            fit_width: self.fit_width,
            is_form_known: self.is_form_known,
            ..MeasureOptions::default()
        };
        let options = FrameOptions {
            zero_points,
            photometry,
            optics,
            is_seeing_known,
            satellite_size_m: self.satellite_size_m,
            measure,
            cuts: self.cuts,
        };
        let measured = match sky {
            Some(sky) if !self.has_streaks => measure_frame(sky, frame, &options)?,
            sky => {
                let mut unknown = Vec::new();
                if let Some(sky) = sky {
                    unknown = identify_listed(sky, frame, &mut streaks, self.place_sigma_deg, &photometry)?;
                }
                let sigma_arcsec = self.place_sigma_deg.map(|deg| deg * 3600.0);
                let (found, done) = measure_listed(frame, &streaks, sigma_arcsec, &options, &mut invalid, self.watch)?;
                rows = found;
                let passes = rows.iter().filter_map(|row| row.measured.as_deref().ok()).cloned().collect();
                FrameMeasurements { passes, left_out: unknown, ..done }
            }
        };
        for (hdu, from_stars) in &measured.star_zero_points {
            let chip = format!("{shown}: HDU {hdu}");
            state_stars(&chip, from_stars, &optics, is_seeing_known, &mut remarks, &mut warnings);
        }
        let choices = frame.choices();
        remarks.extend(choices.iter().cloned());
        remarks.extend(measured.remarks.iter().map(|remark| format!("{shown}: {remark}")));
        if let Some(summary) = frame.images.summary() {
            let used = match &measured.planes_used[..] {
                [] => "no plane is used".to_owned(),
                used => used.join("; "),
            };
            remarks.push(format!("{shown}: {summary}; {used}"));
        }
        let arbitrary = measured.passes.iter().filter(|pass| !pass.prediction.is_position_known).count();
        if arbitrary > 0 {
            warnings.push(format!(
                "{shown}: {arbitrary} of {} rows are of satellites with elements too old to predict positions (flag \
                 position): streaks may be of other satellites, and there are no limits; specify element sets of that time",
                measured.passes.len()
            ));
        }
        Ok(FrameResult { measured, rows, invalid, remarks, choices, warnings })
    }
}

/// Adds the HDUs of a frame that are ignored, and its missing calibration, to the warnings.
fn state_frame(frame: &TargetFrame, has_zero_point: bool, warnings: &mut Vec<String>) {
    let shown = frame.file.path().display();
    warnings.extend(frame.left_out.iter().map(|(hdu, error)| format!("{shown}: HDU {hdu} is ignored: {error}")));
    if !has_zero_point {
        warnings.push(format!(
            "{shown}: no zero point: magnitudes are instrumental, -2.5 log10 of the counts; specify --zero-point or --stars"
        ));
    }
    if frame.chips.iter().any(|target| target.electrons_per_unit.is_none()) {
        let doubt = frame.doubtful_gain.as_ref().map(|doubt| format!(" ({doubt})")).unwrap_or_default();
        warnings.push(format!(
            "{shown}: the gain is unknown{doubt}: errors do not contain the photon noise of the streaks; specify --gain"
        ));
    }
}

/// Adds the zero point from stars, or the reason why there is none, to the remarks and warnings.
fn state_stars(
    chip: &str,
    found: &StarZeroPoint,
    optics: &Optics,
    is_seeing_known: bool,
    remarks: &mut Vec<String>,
    warnings: &mut Vec<String>,
) {
    let counts = found.counts();
    match (found.zero_point_mag, found.shape) {
        (Some(Estimate { value, sigma }), shape) => {
            let seeing = match shape {
                Some(StarShape { seeing_arcsec, form, is_form_measured: true }) => {
                    format!("; {form} of FWHM {seeing_arcsec:.2} arcsec")
                }
                Some(StarShape { seeing_arcsec, .. }) => format!("; FWHM {seeing_arcsec:.2} arcsec"),
                None => "; FWHM not measured, too few bright stars".to_owned(),
            };
            remarks.push(format!("{chip}: zero point {value:.3} +- {sigma:.3} mag; {counts}{seeing}"));
        }
        (None, _) => {
            let allowed = if found.doubt.is_none() { "; allowed: 3 usable stars or more" } else { "" };
            warnings.push(format!("{chip}: no zero point, magnitudes are instrumental; {counts}{allowed}"));
        }
    }
    if let Some(seeing_arcsec) = found.shape.map(|shape| shape.seeing_arcsec).filter(|_| is_seeing_known)
        && (seeing_arcsec / optics.seeing_arcsec).ln().abs() > (1.0 + SEEING_TOLERANCE).ln()
    {
        warnings.push(format!(
            "{chip}: the FWHM of the stars is {seeing_arcsec:.2} arcsec, the given seeing {:.2} arcsec: magnitudes are \
             biased; omit the seeing to use that of the stars",
            optics.seeing_arcsec
        ));
    }
}

/// Returns warnings about the position of the telescope, the time and the site of a frame.
pub(super) fn frame_warnings(sky: &Sky, frame: &TargetFrame) -> Vec<String> {
    frame.exposure().map(|(exposure, radius_rad)| sky.frame_warnings(&exposure, radius_rad)).unwrap_or_default()
}

/// Returns the photometric options of a frame: the band is the one given, or else that of the filter in the header.
pub(super) fn photometry(config: &Config, frame: &TargetFrame) -> Result<PhotometryOptions, Error> {
    let given = config.photometry()?;
    let filter = frame.filter.as_deref().unwrap_or_default().trim();
    let word = filter.split_whitespace().next().unwrap_or_default();
    // `H alpha 656nm` is no infrared band.
    let band = word.trim_end_matches('\'').parse::<Band>().ok().filter(|band| !band.is_infrared() || word == filter);
    Ok(match band.filter(|_| config.light.band.is_none()) {
        Some(band) => {
            let system = if config.light.mag_system.is_some() { given.system } else { band.usual_system() };
            PhotometryOptions { band, system, ..given }
        }
        None => given,
    })
}

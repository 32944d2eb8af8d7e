//! What can be said of an injection besides the setup.

use std::path::PathBuf;

use serde::Deserialize;

/// Frames, exposure, streaks, counts and truth, as they were said: texts with their units, nothing resolved.
///
/// ```
/// let said: streakcast::injection::InjectionSaid =
///     serde_json::from_str(r#"{"image": ["frame.fits"], "random_streaks": 2, "magnitude": [5, 7], "seeing": "1.2arcsec"}"#)?;
/// assert_eq!(said.truth_points, 11);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InjectionSaid {
    /// Frames to inject into; none where one is synthetic.
    pub image: Vec<PathBuf>,
    /// Description of a synthetic frame (TOML), instead.
    pub synthetic: Option<PathBuf>,
    /// How many synthetic frames.
    pub frames: Option<usize>,
    /// Shutter opening; the header's where unsaid.
    pub start: Option<String>,
    /// Length of the exposure with its unit; the header's where unsaid.
    pub exposure: Option<String>,
    /// Opening and length from a row of this schedule.
    pub schedule: Option<PathBuf>,
    /// `exposure_id` of that row.
    pub row: Option<String>,
    /// Right ascension of a synthetic frame's centre.
    pub ra: Option<String>,
    /// Declination of a synthetic frame's centre.
    pub dec: Option<String>,
    /// Side of a pixel with its unit, for random streaks in a frame that says nothing of the sky.
    pub pixel_scale: Option<String>,
    /// These HDUs alone, from 0.
    pub hdu: Vec<usize>,
    /// What the telescope follows: arcsec/s towards east and north; none where it follows the stars.
    pub track_rate: Vec<f64>,
    /// As many random streaks in each frame.
    pub random_streaks: Option<usize>,
    /// As many random streaks a square degree, on the average.
    pub streak_density: Option<f64>,
    /// Their magnitude, or the brightest and the faintest.
    pub magnitude: Vec<f64>,
    /// Their rate, or the slowest and the fastest, deg/s.
    pub streak_rate_deg_s: Vec<f64>,
    /// Period (s), amplitude (mag) and, where it is said, phase (turns) of a tumbling body.
    pub tumbling: Vec<f64>,
    /// Flashes: magnitude, seconds after the middle of the frame, full width (s).
    pub glint: Vec<Vec<f64>>,
    /// A light curve (CSV of `time_s` and `delta_mag`).
    pub light_curve: Option<PathBuf>,
    /// Chassis and solar array as two lights.
    pub resolve_panels: bool,
    /// FWHM of a star's image with its unit; the telescope's where unsaid.
    pub seeing: Option<String>,
    /// Its form: `gaussian`, `moffat`, `moffat:BETA`, `double`.
    pub psf: String,
    /// Magnitude of a star whose image sums to 1 in the frame's unit; the header's where unsaid.
    pub zero_point: Option<f64>,
    /// The same of a star that makes 1 count a second.
    pub zero_point_1s: Option<f64>,
    /// Electrons a count; the header's where unsaid.
    pub gain: Option<f64>,
    /// A detector (TOML).
    pub detector: Option<PathBuf>,
    /// Light alone.
    pub no_noise: bool,
    /// The same seed gives the same frame.
    pub seed: u64,
    /// Points along each streak in the table of them.
    pub truth_points: usize,
    /// Whose bits the masks have.
    pub mask_bits: String,
    /// No extensions of mask and truth.
    pub pixels_only: bool,
}

impl Default for InjectionSaid {
    fn default() -> Self {
        Self {
            image: Vec::new(),
            synthetic: None,
            frames: None,
            start: None,
            exposure: None,
            schedule: None,
            row: None,
            ra: None,
            dec: None,
            pixel_scale: None,
            hdu: Vec::new(),
            track_rate: Vec::new(),
            random_streaks: None,
            streak_density: None,
            magnitude: Vec::new(),
            streak_rate_deg_s: Vec::new(),
            tumbling: Vec::new(),
            glint: Vec::new(),
            light_curve: None,
            resolve_panels: false,
            seeing: None,
            psf: "moffat".to_owned(),
            zero_point: None,
            zero_point_1s: None,
            gain: None,
            detector: None,
            no_noise: false,
            seed: 0,
            truth_points: 11,
            mask_bits: "lsst".to_owned(),
            pixels_only: false,
        }
    }
}

impl InjectionSaid {
    /// Files that are read: no output may take their place.
    pub fn files(&self) -> Vec<PathBuf> {
        let one = [&self.synthetic, &self.schedule, &self.light_curve, &self.detector];
        self.image.iter().chain(one.into_iter().flatten()).cloned().collect()
    }
}

//! Options of an injection: frames, exposure, streaks, counts and truth.

use std::path::PathBuf;

use serde::Deserialize;

use super::values::Numbers;

/// Frames, exposure, streaks, counts and truth of an injection, beside a [`Config`].
///
/// ```
/// let injection: streakcast::config::InjectionConfig =
///     serde_json::from_str(r#"{"image": ["frame.fits"], "random_streaks": 2, "magnitude": [5, 7], "seeing": "1.2arcsec"}"#)?;
/// assert_eq!(injection.truth_points, 11);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct InjectionConfig {
    /// Frames to inject into: FITS, also mosaics and tile-compressed .fz
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "synthetic"))]
    pub image: Vec<PathBuf>,
    /// A synthetic frame instead: a TOML file of size, scale, sky, stars and detector
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", conflicts_with = "image"))]
    pub synthetic: Option<PathBuf>,
    /// Number of synthetic frames, each from a seed of its own
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", requires = "synthetic"))]
    pub frames: Option<usize>,
    /// Shutter opening, as 2020-03-06T00:04:15.410Z; the header's if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true, help_heading = "Exposure"))]
    pub start: Option<String>,
    /// Length of the exposure with its unit, as 30s or 2min; the header's if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true, help_heading = "Exposure"))]
    pub exposure: Option<String>,
    /// Opening and length from a row of a schedule; a synthetic frame takes its pointing too
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "FILE",
            requires = "row",
            conflicts_with_all = ["start", "exposure"],
            help_heading = "Exposure"
        )
    )]
    pub schedule: Option<PathBuf>,
    /// exposure_id of that row
    #[cfg_attr(feature = "cli", arg(long, value_name = "ID", requires = "schedule", help_heading = "Exposure"))]
    pub row: Option<String>,
    /// Right ascension of a synthetic frame's centre (ICRS): 188.5 or 12h34m
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "synthetic", help_heading = "Exposure")
    )]
    pub ra: Option<String>,
    /// Declination of a synthetic frame's centre (ICRS)
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "synthetic", help_heading = "Exposure")
    )]
    pub dec: Option<String>,
    /// Side of a pixel with its unit, for random streaks in a frame without world coordinates
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", help_heading = "Exposure"))]
    pub pixel_scale: Option<String>,
    /// Only these HDUs, counted from 0; all images with world coordinates if omitted
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "N", num_args = 1.., value_delimiter = ',', help_heading = "Exposure")
    )]
    pub hdu: Vec<usize>,
    /// Rate of a moving target that the telescope follows: arcsec/s towards east and north on the sky; the frame's coordinates hold half way
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "EAST,NORTH",
            value_parser = Numbers::parse::<2, 2>,
            allow_hyphen_values = true,
            help_heading = "Exposure"
        )
    )]
    pub track_rate: Option<Numbers>,
    /// Random streaks instead of satellites: number in each frame
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "N",
            requires = "magnitude",
            conflicts_with_all = ["elements", "shells", "streak_density"],
            help_heading = "Streaks"
        )
    )]
    pub random_streaks: Option<usize>,
    /// Random streaks: mean number per square degree of the frame
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "N",
            requires = "magnitude",
            conflicts_with_all = ["elements", "shells"],
            help_heading = "Streaks"
        )
    )]
    pub streak_density: Option<f64>,
    /// Magnitude of random streaks, as if they stood still: one, or from the brightest to the faintest, as 4,8
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "MAG[,MAG]",
            value_parser = Numbers::parse::<1, 2>,
            allow_hyphen_values = true,
            help_heading = "Streaks"
        )
    )]
    pub magnitude: Option<Numbers>,
    /// Speed of random streaks over the frame, deg/s, the slower first; it sets their distance too. 0.2,0.8 if omitted: low satellites
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "RATE[,RATE]",
            value_parser = Numbers::parse::<1, 2>,
            allow_hyphen_values = true,
            help_heading = "Streaks"
        )
    )]
    pub streak_rate_deg_s: Option<Numbers>,
    /// A tumbling body: period s, amplitude mag from faintest to brightest, and phase (turns) at shutter opening
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "S,MAG[,TURNS]",
            value_parser = Numbers::parse::<2, 3>,
            allow_hyphen_values = true,
            help_heading = "Streaks"
        )
    )]
    pub tumbling: Option<Numbers>,
    /// A flash: its magnitude, seconds after the light passes nearest to the frame's middle, full width s; may be given several times
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "MAG,S,S",
            value_parser = Numbers::parse::<3, 3>,
            allow_hyphen_values = true,
            help_heading = "Streaks"
        )
    )]
    pub glint: Vec<Numbers>,
    /// A light curve of your own: CSV of time_s after shutter opening and delta_mag
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Streaks"))]
    pub light_curve: Option<PathBuf>,
    /// Chassis and solar array as two lights side by side, if a model has them
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Streaks"))]
    pub resolve_panels: bool,
    /// Width of a star's image (FWHM) with its unit, as 1.2arcsec; the telescope's if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", help_heading = "Streaks"))]
    pub seeing: Option<String>,
    /// Form of a star's image: gaussian, moffat (β 3.5), moffat:BETA, double
    #[cfg_attr(feature = "cli", arg(long, value_name = "FORM", default_value = "moffat", help_heading = "Streaks"))]
    pub psf: String,
    /// Magnitude of a star whose image sums to 1 in the frame's unit; the header's if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Counts"))]
    pub zero_point: Option<f64>,
    /// Magnitude of a star of 1 count per second, instead of --zero-point
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "MAG",
            allow_hyphen_values = true,
            conflicts_with = "zero_point",
            help_heading = "Counts"
        )
    )]
    pub zero_point_1s: Option<f64>,
    /// Electrons per count; the header's if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "E", help_heading = "Counts"))]
    pub gain: Option<f64>,
    /// Detector (TOML): saturation with bleeding, crosstalk, vignetting, non-linearity and more
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Counts"))]
    pub detector: Option<PathBuf>,
    /// Only light, without the noise of its own electrons
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Counts"))]
    pub no_noise: bool,
    /// Seed; the same seed gives the same frame
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "N",
            default_value_t = 0,
            value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64),
            help_heading = "Counts"
        )
    )]
    pub seed: u64,
    /// Points along each streak in the extension STREAK_POINTS
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 11, help_heading = "Truth"))]
    pub truth_points: usize,
    /// Bits of the mask: lsst, desdm, last, ztf, hst
    #[cfg_attr(feature = "cli", arg(long, value_name = "SURVEY", default_value = "lsst", help_heading = "Truth"))]
    pub mask_bits: String,
    /// No extensions of mask and truth in the frame
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Truth"))]
    pub pixels_only: bool,
}

impl Default for InjectionConfig {
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
            track_rate: None,
            random_streaks: None,
            streak_density: None,
            magnitude: None,
            streak_rate_deg_s: None,
            tumbling: None,
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

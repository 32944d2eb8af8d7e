//! Options of an injection request: frames, exposure, streaks, counts and truth.

use std::path::PathBuf;

use serde::Deserialize;

use super::values::Numbers;

/// Frames, exposure, streaks, counts and truth of an injection, in addition to [`Config`](super::Config).
///
/// ```
/// let injection: streakcast::config::InjectionConfig =
///     serde_json::from_str(r#"{"image": ["a.fits"], "random_streaks": 2, "magnitude": [5, 7]}"#)?;
/// assert_eq!((injection.image.len(), injection.seed), (1, 0));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct InjectionConfig {
    /// Input frames: FITS, including mosaics and tile-compressed .fz
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", num_args = 1..))]
    pub image: Vec<PathBuf>,
    /// Synthetic frame instead of --image: TOML file of size, scale, sky, stars and detector
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", conflicts_with = "image"))]
    pub synthetic: Option<PathBuf>,
    /// Number of synthetic frames, each with its own seed
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", requires = "synthetic"))]
    pub frames: Option<usize>,
    /// Shutter opening, for example 2020-03-06T00:04:15.410Z; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true, help_heading = "Exposure"))]
    pub start: Option<String>,
    /// Exposure time with its unit, for example 30s or 2min; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "TIME", allow_hyphen_values = true, help_heading = "Exposure"))]
    pub exposure: Option<String>,
    /// Schedule with the exposure of --row: start, exposure time, and the pointing of a synthetic frame
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
    /// exposure_id of the row of --schedule
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
    /// Pixel scale with its unit, for random streaks and streaks in pixels in a frame without world coordinates
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", help_heading = "Exposure"))]
    pub pixel_scale: Option<String>,
    /// HDUs to use, counted from 0; all images with world coordinates if omitted
    #[cfg_attr(
        feature = "cli",
        arg(long, value_name = "N", num_args = 1.., value_delimiter = ',', help_heading = "Exposure")
    )]
    pub hdu: Vec<usize>,
    /// Non-sidereal tracking rate, arcsec/s towards east and north; the world coordinates are those of mid-exposure
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
    /// Number of random streaks in each frame, instead of satellites
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
    /// Mean number of random streaks per square degree, instead of satellites
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
    /// Magnitude of random streaks: one value, or the brightest and the faintest, for example 4,8
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
    /// Angular rate of random streaks, deg/s: one value, or the lowest and the highest; the rate also sets the
    /// distance; 0.2,0.8 if omitted
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
    /// Table of streaks, instead of satellites: CSV, ECSV or FITS, one row a streak, with its ends (x1_pix, y1_pix,
    /// x2_pix, y2_pix; or ra1_deg, dec1_deg, ...) and its magnitude or peak
    #[cfg_attr(
        feature = "cli",
        arg(
            long,
            value_name = "TABLE",
            conflicts_with_all = ["elements", "shells", "random_streaks", "streak_density"],
            help_heading = "Streaks"
        )
    )]
    pub streaks: Option<PathBuf>,
    /// Diameter of the satellites in m, 0 for points; that of the model if omitted, 2 m for random streaks, and 0 for
    /// --streaks
    #[cfg_attr(feature = "cli", arg(long, value_name = "M", help_heading = "Streaks"))]
    pub satellite_size: Option<f64>,
    /// Tumbling: period in s, amplitude from faintest to brightest in mag, and phase in turns at shutter opening
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
    /// Flash: magnitude, time after the closest approach to the frame's centre in s, full width in s; may be repeated
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
    /// Light curve: CSV file with columns time_s (after shutter opening) and delta_mag
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Streaks"))]
    pub light_curve: Option<PathBuf>,
    /// Draw chassis and solar array as separate sources, if the model has them
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Streaks"))]
    pub resolve_panels: bool,
    /// Seeing: FWHM of the point spread function with its unit, for example 1.2arcsec; that of --telescope if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "ANGLE", help_heading = "Streaks"))]
    pub seeing: Option<String>,
    /// Point spread function: gaussian, moffat (β 3.5), moffat:BETA, double; or a file: an image (.fits), or the set of
    /// PSFEx (.psf), instead of seeing, defocus and size; moffat if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "FORM", value_hint = clap::ValueHint::FilePath, help_heading = "Streaks"))]
    pub psf: Option<String>,
    /// Oversampling of the image of --psf: number of its pixels along a pixel of the frame; that in its header
    /// (OVERSAMP), or else 1, if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Streaks"))]
    pub psf_oversampling: Option<usize>,
    /// Zero point: magnitude of a star with a total of 1 in the frame's unit; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "MAG", allow_hyphen_values = true, help_heading = "Counts"))]
    pub zero_point: Option<f64>,
    /// Zero point for 1 count per second, instead of --zero-point
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
    /// Gain, electrons per count; from the header if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "E", help_heading = "Counts"))]
    pub gain: Option<f64>,
    /// Detector file (TOML): saturation with bleeding, crosstalk, vignetting, non-linearity and more
    #[cfg_attr(feature = "cli", arg(long, value_name = "FILE", help_heading = "Counts"))]
    pub detector: Option<PathBuf>,
    /// Add the streaks without shot noise
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Counts"))]
    pub no_noise: bool,
    /// Seed of the random numbers; the same seed gives the same frame
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
    /// Number of points along each streak in the extension STREAK_POINTS; 11 if omitted
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", help_heading = "Truth"))]
    pub truth_points: Option<usize>,
    /// Labels for the training of detectors, beside the frames: coco (FRAME.coco.json, or coco.json of several frames),
    /// yolo (FRAME.txt, oriented boxes) and ds9 (FRAME.reg); several are separated by commas
    #[cfg_attr(feature = "cli", arg(long, value_name = "FORMAT", value_delimiter = ',', help_heading = "Truth"))]
    pub labels: Vec<String>,
    /// Mask bits: lsst (if omitted), desdm, last, ztf, hst
    #[cfg_attr(feature = "cli", arg(long, value_name = "SURVEY", help_heading = "Truth"))]
    pub mask_bits: Option<String>,
    /// Write only the pixels, without mask and truth extensions
    #[cfg_attr(feature = "cli", arg(long, help_heading = "Truth"))]
    pub pixels_only: bool,
}

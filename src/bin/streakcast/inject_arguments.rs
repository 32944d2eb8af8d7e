//! What can be typed after `inject`.

use std::path::PathBuf;

use clap::Args;

use crate::shared_arguments::SharedArguments;

#[derive(Args)]
pub struct InjectArguments {
    /// Frames to inject into: FITS, also mosaics and tile-compressed .fz
    #[arg(long, value_name = "FILE", num_args = 1.., required_unless_present = "synthetic")]
    pub image: Vec<PathBuf>,
    /// A synthetic frame instead: a TOML file of size, scale, sky, stars and detector
    #[arg(long, value_name = "FILE", conflicts_with = "image")]
    pub synthetic: Option<PathBuf>,
    /// How many synthetic frames, each from a seed of its own
    #[arg(long, value_name = "N", requires = "synthetic")]
    pub frames: Option<usize>,
    /// File to write, whole or not at all; a folder where there are several frames
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub exposure: ExposureArguments,
    #[command(flatten)]
    pub streaks: StreakArguments,
    #[command(flatten)]
    pub counts: CountArguments,
    #[command(flatten)]
    pub truth: TruthArguments,
    #[command(flatten)]
    pub shared: SharedArguments,
}

/// When and where the frame was taken, as far as its header does not say or says it wrongly.
#[derive(Args)]
#[command(next_help_heading = "Exposure")]
pub struct ExposureArguments {
    /// Shutter opening, as 2020-03-06T00:04:15.410Z; the header's where unsaid
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub start: Option<String>,
    /// Length of the exposure with its unit, as 30s or 2min; the header's where unsaid
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub exposure: Option<String>,
    /// Opening and length from a row of a schedule; a synthetic frame takes its pointing too
    #[arg(long, value_name = "FILE", requires = "row", conflicts_with_all = ["start", "exposure"])]
    pub schedule: Option<PathBuf>,
    /// exposure_id of that row
    #[arg(long, value_name = "ID", requires = "schedule")]
    pub row: Option<String>,
    /// Right ascension of a synthetic frame's centre (ICRS): 188.5 or 12h34m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "synthetic")]
    pub ra: Option<String>,
    /// Declination of a synthetic frame's centre (ICRS)
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "synthetic")]
    pub dec: Option<String>,
    /// Side of a pixel with its unit, for random streaks in a frame that says nothing of the sky
    #[arg(long, value_name = "ANGLE")]
    pub pixel_scale: Option<String>,
    /// Only these HDUs, counted from 0; all images with world coordinates where unsaid
    #[arg(long, value_name = "N", num_args = 1.., value_delimiter = ',')]
    pub hdu: Vec<usize>,
    /// The telescope follows something that moves: arcsec/s towards east and north on the sky; the frame's coordinates hold half way
    #[arg(long, value_name = "EAST,NORTH", value_parser = numbers::<2, 2>, allow_hyphen_values = true)]
    pub track_rate: Option<Numbers>,
}

/// Which streaks, and how their light changes.
#[derive(Args)]
#[command(next_help_heading = "Streaks")]
pub struct StreakArguments {
    /// Random streaks instead of satellites: as many in each frame
    #[arg(long, value_name = "N", requires = "magnitude", conflicts_with_all = ["elements", "shells", "streak_density"])]
    pub random_streaks: Option<usize>,
    /// Random streaks: as many a square degree of the frame on the average
    #[arg(long, value_name = "N", requires = "magnitude", conflicts_with_all = ["elements", "shells"])]
    pub streak_density: Option<f64>,
    /// Magnitude of random streaks, as if they stood still: one, or from the brightest to the faintest, as 4,8
    #[arg(long, value_name = "MAG[,MAG]", value_parser = numbers::<1, 2>, allow_hyphen_values = true)]
    pub magnitude: Option<Numbers>,
    /// Speed of random streaks over the frame, deg/s, the slower first; it sets their distance too. 0.2,0.8 where unsaid: low satellites
    #[arg(long, value_name = "RATE[,RATE]", value_parser = numbers::<1, 2>, allow_hyphen_values = true)]
    pub streak_rate_deg_s: Option<Numbers>,
    /// A tumbling body: period s, amplitude mag from faintest to brightest, and where in the period (turns) the shutter opens
    #[arg(long, value_name = "S,MAG[,TURNS]", value_parser = numbers::<2, 3>, allow_hyphen_values = true)]
    pub tumbling: Option<Numbers>,
    /// A flash: its magnitude, seconds after the light passes nearest to the frame's middle, full width s; may be said several times
    #[arg(long, value_name = "MAG,S,S", value_parser = numbers::<3, 3>, allow_hyphen_values = true)]
    pub glint: Vec<Numbers>,
    /// A light curve of one's own: CSV of time_s after the shutter opened and delta_mag
    #[arg(long, value_name = "FILE")]
    pub light_curve: Option<PathBuf>,
    /// Chassis and solar array as two lights side by side, where a model has them
    #[arg(long)]
    pub resolve_panels: bool,
    /// Width of a star's image (FWHM) with its unit, as 1.2arcsec; the telescope's where unsaid
    #[arg(long, value_name = "ANGLE")]
    pub seeing: Option<String>,
    /// Form of a star's image: gaussian, moffat (β 3.5), moffat:BETA, double
    #[arg(long, value_name = "FORM", default_value = "moffat")]
    pub psf: String,
}

/// From magnitudes to counts and noise.
#[derive(Args)]
#[command(next_help_heading = "Counts")]
pub struct CountArguments {
    /// Magnitude of a star whose image sums to 1 in the frame's unit; the header's where unsaid
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub zero_point: Option<f64>,
    /// The same of a star that makes 1 count per second
    #[arg(long, value_name = "MAG", allow_hyphen_values = true, conflicts_with = "zero_point")]
    pub zero_point_1s: Option<f64>,
    /// Electrons a count; the header's where unsaid
    #[arg(long, value_name = "E")]
    pub gain: Option<f64>,
    /// Detector (TOML): saturation with bleeding, crosstalk, vignetting, non-linearity and more
    #[arg(long, value_name = "FILE")]
    pub detector: Option<PathBuf>,
    /// Light alone, without the noise of its own electrons
    #[arg(long)]
    pub no_noise: bool,
    /// The same seed gives the same frame
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: u64,
}

/// What is told about the streaks.
#[derive(Args)]
#[command(next_help_heading = "Truth")]
pub struct TruthArguments {
    /// The truth table beside the frame: a file that ends in .csv, .ecsv, .json or .jsonl
    #[arg(long, value_name = "FILE")]
    pub truth: Option<PathBuf>,
    /// Points along each streak in the extension STREAK_POINTS
    #[arg(long, value_name = "N", default_value_t = 11)]
    pub truth_points: usize,
    /// Rows for Rubin's source_injection: a CSV or ECSV file of trails
    #[arg(long, value_name = "FILE")]
    pub trails: Option<PathBuf>,
    /// Bits of the mask: lsst, desdm, last, ztf, hst
    #[arg(long, value_name = "SURVEY", default_value = "lsst")]
    pub mask_bits: String,
    /// No extensions of mask and truth in the frame
    #[arg(long)]
    pub pixels_only: bool,
    /// Picture of the frame (the chip with the longest streak): a .png file
    #[cfg(feature = "plot")]
    #[arg(long, value_name = "FILE")]
    pub preview: Option<PathBuf>,
    /// The same with the streaks marked
    #[cfg(feature = "plot")]
    #[arg(long, value_name = "FILE")]
    pub preview_marked: Option<PathBuf>,
}

/// Numbers with commas between.
#[derive(Clone, Debug)]
pub struct Numbers(pub Vec<f64>);

/// From `LEAST` to `MOST` numbers.
fn numbers<const LEAST: usize, const MOST: usize>(text: &str) -> Result<Numbers, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|number| number.trim().parse().ok().filter(|number: &f64| number.is_finite())).collect();
    let count = if LEAST == MOST { LEAST.to_string() } else { format!("{LEAST} to {MOST}") };
    match numbers {
        Some(numbers) if (LEAST..=MOST).contains(&numbers.len()) => Ok(Numbers(numbers)),
        _ => Err(format!("allowed: {count} numbers with commas between and no blanks")),
    }
}

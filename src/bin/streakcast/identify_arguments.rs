//! What can be typed after `identify`.

use std::path::PathBuf;

use clap::Args;

use crate::shared_arguments::{OutputArguments, SharedArguments};

#[derive(Args)]
pub struct IdentifyArguments {
    #[command(flatten)]
    pub streak: StreakPlaceArguments,
    #[command(flatten)]
    pub time: StreakTimeArguments,
    /// Satellites in the Earth's shadow too
    #[arg(long)]
    pub include_dark: bool,
    /// The most candidates that are listed
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub top: usize,
    #[command(flatten)]
    pub shared: SharedArguments,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Where the streak lies: by two ends, by a place and an angle, in a frame, or by regions.
#[derive(Args, Clone)]
#[command(next_help_heading = "Streak")]
pub struct StreakPlaceArguments {
    /// One end of the streak (ICRS), said twice: 232.01,8.93 or 15h28m04s,8d55m42s
    #[arg(long, value_name = "RA,DEC", allow_hyphen_values = true)]
    pub end: Vec<String>,
    /// Right ascension of the middle of the streak (ICRS): 188.5 (degrees) or 12h34m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "position_angle")]
    pub ra: Option<String>,
    /// Declination of the middle of the streak (ICRS): -30.5 or -30d30m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, requires = "position_angle")]
    pub dec: Option<String>,
    /// Position angle of the streak there, either direction, degrees from north through east
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, requires = "ra")]
    pub position_angle: Option<f64>,
    /// Length of the streak with its unit, as 8arcmin
    #[arg(long, value_name = "ANGLE", requires = "position_angle")]
    pub length: Option<String>,
    /// A frame (FITS) with the streak: its coordinates and times
    #[cfg(feature = "fits")]
    #[arg(long, value_name = "FILE")]
    pub image: Option<PathBuf>,
    /// One end in the frame, pixels counted from 1 as FITS and DS9 count
    #[cfg(feature = "fits")]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires_all = ["image", "to_pix"])]
    pub from_pix: Option<String>,
    /// The other end
    #[cfg(feature = "fits")]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires_all = ["image", "from_pix"])]
    pub to_pix: Option<String>,
    /// HDU of the frame, counted from 0; the only image where unsaid
    #[cfg(feature = "fits")]
    #[arg(long, value_name = "N", requires = "image")]
    pub hdu: Option<usize>,
    /// Regions of DS9 drawn around the streak: polygons, boxes, lines or vectors in fk5 or icrs
    #[arg(long, value_name = "FILE")]
    pub region: Option<PathBuf>,
    /// One sigma of an end with its unit; 5arcsec where unsaid, 3 pixels in a frame, half the half width of regions
    #[arg(long, value_name = "ANGLE")]
    pub place_sigma: Option<String>,
    /// One sigma of --position-angle with its unit; 1deg where unsaid
    #[arg(long, value_name = "ANGLE", requires = "position_angle")]
    pub angle_sigma: Option<String>,
}

/// When it was made.
#[derive(Args, Clone)]
#[command(next_help_heading = "Streak")]
pub struct StreakTimeArguments {
    /// When the satellite was at the first and at the second --end
    #[arg(long, value_name = "TIME", num_args = 2, value_delimiter = ',', requires = "end", conflicts_with_all = ["start", "exposure", "whole_streak"])]
    pub times: Vec<String>,
    /// Shutter opening, as 2024-08-14T00:30:00.000Z; the frame's where unsaid
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub start: Option<String>,
    /// Length of the exposure with its unit, as 30s or 2min; the frame's where unsaid
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub exposure: Option<String>,
    /// Both ends are those of the streak, not of the frame: where the satellite was as the shutter opened and closed
    #[arg(long)]
    pub whole_streak: bool,
    /// One sigma of the clock with its unit; 0.5s where unsaid
    #[arg(long, value_name = "TIME")]
    pub time_sigma: Option<String>,
}

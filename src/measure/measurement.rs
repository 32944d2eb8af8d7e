//! Inputs and results of the measurement of a streak.

use super::background::Background;
use crate::images::{LightArea, PixelPosition, Plane};
use crate::streaks::{SkyPoint, StreakPath};

/// Image with a streak.
#[derive(Copy, Clone, Debug)]
pub struct StreakImage<'a> {
    /// Pixels.
    pub plane: &'a Plane,
    /// Sky background of the pixels.
    pub background: &'a Background,
    /// Illuminated part.
    pub light_area: &'a LightArea,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Electrons per unit of the pixels; `None` if unknown: the photon noise of the streak is then omitted.
    pub electrons_per_unit: Option<f64>,
    /// Value at which a pixel is saturated; `None` if unknown.
    pub saturation: Option<f64>,
    /// Angular size of a pixel, arcsec.
    pub pixel_scale_arcsec: f64,
    /// Ratio of width to height of a pixel on the sky.
    pub pixel_aspect: f64,
}

/// Predicted track of a satellite in an image, with its errors.
#[derive(Clone, Debug)]
pub struct PredictedStreak {
    /// Predicted positions. Times are seconds after the shutter opened; the path extends beyond the exposure by the
    /// delays that are searched and beyond the image by the corridor. The rate is 1 where the satellite is lit and 0
    /// elsewhere.
    pub path: StreakPath,
    /// Displacement of the track in the image per second of delay, pixels per second, because the observer moves during
    /// the delay. The displacement by the motion of the satellite is not included.
    pub drift_pix_s: [f64; 2],
    /// Error (one sigma) along the track, seconds.
    pub lateness_sigma_s: f64,
    /// Upper limit of the delays that are searched, seconds.
    pub largest_delay_s: f64,
    /// Times at the two ends of a streak whose ends are given, seconds after the shutter opened. The streak then has no
    /// delay; `cross_sigma_pix` is the error (one sigma) of each end across and along the streak, and the path extends
    /// beyond the ends by several sigmas. `None` for a predicted track.
    pub ends_s: Option<[f64; 2]>,
    /// Error (one sigma) across the track, pixels.
    pub cross_sigma_pix: f64,
    /// Range of the satellite, km.
    pub range_km: f64,
    /// Radius of a disk with the area of the satellite, m.
    pub radius_m: f64,
    /// Error (one sigma) of the radius, m; 0 if the size is given.
    pub radius_sigma_m: f64,
}

impl PredictedStreak {
    /// Distance of a satellite whose distance is unknown, km: it is a point in focus.
    pub const FAR_KM: f64 = SkyPoint::FAR_KM;
}

/// Options of a measurement.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct MeasureOptions {
    /// Half width of the corridor in sigmas of the prediction.
    pub corridor_sigmas: f64,
    /// Largest half width of the corridor, pixels.
    pub most_corridor_pix: f64,
    /// Probability of a false detection in one corridor.
    pub false_alarm: f64,
    /// Upper limits are this number of sigmas above the signal at the most probable position in the corridor.
    pub limit_sigmas: f64,
    /// If true, the width is a parameter of the flux fit; otherwise it is the given seeing.
    pub fit_width: bool,
    /// With `fit_width`: if false, the given seeing is only a guess, and the width of a streak too faint for the fit is
    /// unknown within a factor of two; if true, only its distance and size are unknown.
    pub is_seeing_known: bool,
    /// False if the form of the point spread function is only a guess: the streak may be Gaussian, or a Moffat profile of
    /// β = 3.5 or 2.5. The flux is then the mean over these forms, weighted by the probabilities of their fits, and
    /// their scatter is part of its error.
    pub is_form_known: bool,
    /// Mean distance to the nearest other streak beside this one in a table, pixels. The corridor reaches half-way to
    /// it.
    pub neighbour_pix: Option<f64>,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self {
            corridor_sigmas: 3.0,
            most_corridor_pix: 2000.0,
            false_alarm: 0.01,
            limit_sigmas: 3.0,
            fit_width: false,
            is_seeing_known: false,
            is_form_known: false,
            neighbour_pix: None,
        }
    }
}

/// Remark about a measurement.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Flag {
    /// Pixels of the streak are saturated: the flux is a lower limit.
    Saturated,
    /// The sky is cut off at the smallest value of the image: the flux is a lower limit, and there is no limit.
    Clipped,
    /// Another streak of a table is so near that the light of both is mixed.
    Blended,
    /// The streak runs along the edge of the image.
    Edge,
    /// Stars or defects cover more than half of the streak, or of a position at which a streak that was not found may
    /// be: there is no limit. A streak of a table without any usable pixel is not measured.
    Masked,
    /// A dark streak is in the corridor, as in a difference of images: a brighter streak would not be found, and there
    /// is no limit.
    Dark,
    /// The width of the streak differs from the given seeing by more than 20 %: the flux is biased.
    Width,
    /// The gain is unknown: the error does not contain the photon noise of the streak.
    NoGain,
    /// There is no free area for fits next to the streak, so that the error is that of the pixels, without faint stars.
    PixelNoise,
    /// The elements are too old to predict the position: a streak may be of another satellite, and there is no limit.
    Position,
    /// An end of a streak of a table is at the edge of the image or outside of it: the streak may continue there.
    Open,
    /// A streak of a table is outside of the image, and not measured.
    Outside,
    /// Fewer than 12 pixels of a streak of a table are in the image, and it is not measured.
    Short,
    /// The table has no ends of the streak, and it is not measured.
    NoEnds,
}

impl Flag {
    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Saturated => "saturated",
            Self::Clipped => "clipped",
            Self::Blended => "blended",
            Self::Edge => "edge",
            Self::Masked => "masked",
            Self::Dark => "dark",
            Self::Width => "width",
            Self::NoGain => "no_gain",
            Self::PixelNoise => "pixel_noise",
            Self::Position => "position",
            Self::Open => "open",
            Self::Outside => "outside",
            Self::Short => "short",
            Self::NoEnds => "no_ends",
        }
    }
}

/// A number and its error (one sigma).
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// One sigma.
    pub sigma: f64,
}

/// Measured streak, or upper limit of a streak that was not found.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StreakMeasurement {
    /// True if the streak was found.
    pub is_detected: bool,
    /// Light per second, in the unit of the pixels, averaged over the track in the image.
    pub rate: Estimate,
    /// Part of the error of `rate` that the error of the satellite's size causes.
    pub size_sigma: f64,
    /// Part of the error of `rate` that the form of the point spread function causes, if it is unknown or others fit
    /// better, and the accuracy of the fit.
    pub form_sigma: f64,
    /// Part of the error of the rate by a width that is neither known nor fitted.
    pub width_sigma: f64,
    /// Rate that is excluded at the given number of sigmas everywhere in the corridor. It is not a limit with the flags
    /// `Masked`, `Dark`, `Position` and `Clipped`.
    pub rate_limit: f64,
    /// Fitted rate divided by its error without `size_sigma` and `form_sigma`. Unlike `rate`, the fitted rate is not
    /// corrected for the bias by the fitted position.
    pub signal_to_noise: f64,
    /// Significance in the search, in sigmas of the noise.
    pub significance: f64,
    /// Significance from which a streak is detected: noise exceeds it with the probability `false_alarm`.
    pub threshold: f64,
    /// Distance from the predicted track, pixels, positive towards increasing y (increasing x for a track nearer to the
    /// columns).
    pub offset_pix: Estimate,
    /// Difference in angle from the predicted track, radians.
    pub tilt_rad: f64,
    /// Delay, seconds, if an end of the streak is in the image.
    pub late_s: Option<Estimate>,
    /// Number of ends in the image.
    pub ends: usize,
    /// Measured seeing: FWHM of a star's image, arcsec, that gives the width of the streak; `None` at low signal.
    pub seeing_arcsec: Option<f64>,
    /// Full width at half maximum of the drawn streak, pixels.
    pub width_pix: f64,
    /// Length in the image, pixels.
    pub length_pix: f64,
    /// First and last time at which the satellite is in the image, seconds after the shutter opened.
    pub inside_s: [f64; 2],
    /// Path of the measured streak.
    pub path: StreakPath,
    /// Remarks, in order.
    pub flags: Vec<Flag>,
    /// Largest distance from the predicted track at which the streak was searched for, pixels.
    pub corridor_pix: f64,
}

impl StreakMeasurement {
    /// Returns the error (one sigma) of the rate by the noise: without the parts that are proportional to the light,
    /// which do not matter at the threshold of detection.
    pub fn noise_sigma(&self) -> f64 {
        let of_light = [self.size_sigma, self.form_sigma, self.width_sigma].map(|sigma| sigma * sigma);
        (self.rate.sigma * self.rate.sigma - of_light.iter().sum::<f64>()).max(0.0).sqrt()
    }

    /// Returns both ends of the measured streak in the image, in the order of time.
    pub fn ends_in_frame(&self) -> [PixelPosition; 2] {
        self.inside_s.map(|time_s| self.path.point_at(time_s))
    }
}

//! Validated plan of an injection.

use std::path::PathBuf;

use hifitime::Epoch;

use super::super::frame::{FrameOverrides, SyntheticFrame, TargetFrame};
use super::super::light::{Modulation, RandomStreaks};
use super::super::optics::Optics;
use super::super::tracking::Tracking;
use super::super::truth::MaskPreset;
use crate::frames::{Direction, Gcrs};
use crate::images::Detector;
use crate::photometry::{Band, MagSystem, PhotometryOptions};

/// Frames, light, optics, detector and truth of an injection.
#[derive(Clone, Debug)]
pub struct InjectionPlan {
    /// Frames in files; empty for synthetic frames.
    pub images: Vec<PathBuf>,
    /// Synthetic frames.
    pub synthetic: Option<SyntheticPlan>,
    /// Values that override the headers.
    pub overrides: FrameOverrides,
    /// Rate of the telescope, arcsec/s towards east and north; `None` for sidereal tracking.
    pub tracking_arcsec_s: Option<[f64; 2]>,
    /// Random streaks; `None` for satellites.
    pub random: Option<RandomPlan>,
    /// Changes of brightness.
    pub modulation: Modulation,
    /// If true, chassis and solar array are drawn as two lights.
    pub resolve_panels: bool,
    /// Image of a star.
    pub optics: Optics,
    /// Name of the shape of a star's image, for the history of the frame.
    pub psf_name: String,
    /// Name of the telescope.
    pub telescope: Option<String>,
    /// Detector.
    pub detector: Option<Detector>,
    /// Photometry, in V if no band is given.
    pub photometry: PhotometryOptions,
    /// True if no band is given, so that the frame's filter determines it.
    pub band_of_filter: bool,
    /// Zero point of the magnitudes; that of the band if omitted.
    pub mag_system: Option<MagSystem>,
    /// If true, photon noise of the added electrons is drawn.
    pub noise: bool,
    /// Seed.
    pub seed: u64,
    /// Number of points along each streak in the table of points.
    pub truth_points: usize,
    /// Bits of the mask.
    pub mask_preset: MaskPreset,
    /// If true, no extensions of mask and truth are written.
    pub pixels_only: bool,
}

/// Synthetic frames.
#[derive(Clone, Debug)]
pub struct SyntheticPlan {
    /// Description.
    pub frame: SyntheticFrame,
    /// File of the description.
    pub path: PathBuf,
    /// Shutter opening.
    pub opened: Epoch,
    /// Length of the exposure, seconds.
    pub exposure_s: f64,
    /// Centre of the frame.
    pub centre: Direction<Gcrs>,
}

/// Random streaks: their number, or the number per square degree.
#[derive(Copy, Clone, Debug)]
pub struct RandomPlan {
    /// Number, magnitudes and rates.
    pub streaks: RandomStreaks,
    /// True if the number is per square degree.
    pub is_per_square_degree: bool,
}

impl InjectionPlan {
    /// Returns the motion of the telescope in an exposure of this length.
    pub fn tracking(&self, exposure_s: f64) -> Tracking {
        self.tracking_arcsec_s.map_or(Tracking::Sidereal, |[east, north]| Tracking::Rate {
            east_rad_s: (east / 3600.0).to_radians(),
            north_rad_s: (north / 3600.0).to_radians(),
            reference_s: 0.5 * exposure_s,
        })
    }

    /// Returns the photometry of a frame, and a warning if the band is unknown. The band is the given one, else the first
    /// word of the filter in the header.
    pub(super) fn photometry_of(&self, frame: &TargetFrame) -> (PhotometryOptions, Option<String>) {
        let word = frame.filter.as_deref().and_then(|filter| filter.split_whitespace().next());
        let band = word.map(|word| word.trim_end_matches('\'').parse::<Band>());
        match band.filter(|_| self.band_of_filter) {
            Some(Ok(band)) => {
                let system = self.mag_system.unwrap_or(band.usual_system());
                (PhotometryOptions { band, system, ..self.photometry }, None)
            }
            // Random streaks have a magnitude without a band.
            Some(Err(_)) if self.random.is_none() => {
                let filter = frame.filter.as_deref().unwrap_or_default();
                let warning =
                    format!("filter {filter:?} is not a band with known magnitudes: V is used; specify --band");
                (self.photometry, Some(warning))
            }
            _ => (self.photometry, None),
        }
    }
}

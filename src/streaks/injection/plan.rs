//! Validated plan of an injection.

use std::path::PathBuf;

use hifitime::Epoch;

use super::super::frame::{FrameOverrides, SyntheticFrame, TargetFrame};
use super::super::light::{ChosenStreaks, Modulation, RandomStreaks};
use super::super::optics::Optics;
use super::super::tracking::Tracking;
use super::super::truth::MaskPreset;
use super::labels::LabelFormat;
use crate::frames::{Direction, Gcrs};
use crate::images::{Detector, PsfFile};
use crate::photometry::{Band, MagSystem, PhotometryOptions};

/// Frames, lights, optics, detector and output options of an injection.
#[derive(Clone, Debug)]
pub struct InjectionPlan {
    /// Paths of existing frames; empty if synthetic frames are made.
    pub images: Vec<PathBuf>,
    /// Description of synthetic frames; `None` for existing frames.
    pub synthetic: Option<SyntheticPlan>,
    /// Values that replace those of the headers.
    pub overrides: FrameOverrides,
    /// Rate of the telescope, arcsec/s towards east and north; `None` for sidereal tracking.
    pub tracking_arcsec_s: Option<[f64; 2]>,
    /// Random streaks.
    pub random: Option<RandomPlan>,
    /// Streaks of a table. Without these and random streaks, the streaks are those of satellites.
    pub chosen: Option<ChosenStreaks>,
    /// Diameter of the lights, m; `None` for that of the model, and 2 m for random streaks.
    pub satellite_size_m: Option<f64>,
    /// Changes of the brightness of satellites along their tracks.
    pub modulation: Modulation,
    /// If true, chassis and solar array of a satellite are drawn as two lights.
    pub resolve_panels: bool,
    /// Seeing and telescope.
    pub optics: Optics,
    /// Point spread function from a file, in place of seeing, defocus and size.
    pub psf_file: Option<PsfFile>,
    /// Name of the shape of a star's image, for the history of the frame.
    pub psf_name: String,
    /// Name of the telescope; `None` if it is not given.
    pub telescope: Option<String>,
    /// Detector that replaces the detector implied by the header; `None` to use the implied one.
    pub detector: Option<Detector>,
    /// Photometric options; the band is V if none is given.
    pub photometry: PhotometryOptions,
    /// True if no band is given, so that the filter of each frame determines the band.
    pub band_of_filter: bool,
    /// Zero point system of the magnitudes; the system of the band if `None`.
    pub mag_system: Option<MagSystem>,
    /// If true, photon noise of the added electrons is simulated.
    pub noise: bool,
    /// Seed of noise and random streaks.
    pub seed: u64,
    /// Number of points along each streak in the table of points.
    pub truth_points: usize,
    /// Formats of labels that are written beside the frames.
    pub labels: Vec<LabelFormat>,
    /// Files that are read, which no labels may replace.
    pub inputs: Vec<PathBuf>,
    /// Survey or pipeline whose mask bits are used.
    pub mask_preset: MaskPreset,
    /// If true, neither masks nor truth tables are appended to the file.
    pub pixels_only: bool,
}

/// Description and exposure of synthetic frames.
#[derive(Clone, Debug)]
pub struct SyntheticPlan {
    /// Description of the sky, the stars and the detector.
    pub frame: SyntheticFrame,
    /// Path of the file with the description.
    pub path: PathBuf,
    /// Time at which the shutter opened.
    pub opened: Epoch,
    /// Exposure time, seconds.
    pub exposure_s: f64,
    /// Direction of the centre of the frame.
    pub centre: Direction<Gcrs>,
}

/// Distribution of random streaks, and the meaning of their number.
#[derive(Copy, Clone, Debug)]
pub struct RandomPlan {
    /// Number, magnitudes and angular rates.
    pub streaks: RandomStreaks,
    /// True if the number is per square degree, false if it is per frame.
    pub is_per_square_degree: bool,
}

impl InjectionPlan {
    /// Returns true if the streaks are those of satellites.
    pub fn is_of_satellites(&self) -> bool {
        self.random.is_none() && self.chosen.is_none()
    }

    /// Returns the tracking of the telescope in an exposure of `exposure_s` seconds.
    pub fn tracking(&self, exposure_s: f64) -> Tracking {
        self.tracking_arcsec_s.map_or(Tracking::Sidereal, |[east, north]| Tracking::Rate {
            east_rad_s: (east / 3600.0).to_radians(),
            north_rad_s: (north / 3600.0).to_radians(),
            reference_s: 0.5 * exposure_s,
        })
    }

    /// Returns the photometric options of a frame, and a warning if its filter is not a known band. The band is the one
    /// given in the plan, or else the first word of the filter in the header.
    pub(super) fn photometry_of(&self, frame: &TargetFrame) -> (PhotometryOptions, Option<String>) {
        let word = frame.filter.as_deref().and_then(|filter| filter.split_whitespace().next());
        let band = word.map(|word| word.trim_end_matches('\'').parse::<Band>());
        match band.filter(|_| self.band_of_filter) {
            Some(Ok(band)) => {
                let system = self.mag_system.unwrap_or(band.usual_system());
                (PhotometryOptions { band, system, ..self.photometry }, None)
            }
            // Magnitudes of random and chosen streaks are used as given, without a band.
            Some(Err(_)) if self.is_of_satellites() => {
                let filter = frame.filter.as_deref().unwrap_or_default();
                let warning =
                    format!("filter {filter:?} is not a band with known magnitudes: V is used; specify --band");
                (self.photometry, Some(warning))
            }
            _ => (self.photometry, None),
        }
    }
}

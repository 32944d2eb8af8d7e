//! Source of a streak: a satellite or a random light.

use std::fmt;
use std::sync::Arc;

use super::modulation::Modulation;
use super::resolved::ResolvedPanels;
use super::sky_track::SkyTrack;
use crate::elements::NoradId;

/// Name of a source.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SourceName {
    /// A satellite.
    Satellite {
        /// NORAD catalogue number.
        norad_id: NoradId,
        /// Name in the element set; empty if it has none.
        name: Arc<str>,
    },
    /// A random light, with its number in the frame, from 1.
    Random(usize),
    /// A light of a table of streaks, with its name there.
    Chosen(Arc<str>),
}

impl fmt::Display for SourceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Satellite { norad_id, name } => f.write_str(&norad_id.or_name(name)),
            Self::Random(number) => write!(f, "random {number}"),
            Self::Chosen(id) => f.write_str(id),
        }
    }
}

/// A satellite or random light, with the data that are written about its streak.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Name of the source.
    pub name: SourceName,
    /// Origin of the magnitude, as written in tables.
    pub mag_source: String,
    /// Time from the epoch of the elements to the exposure, days; `None` for a random streak.
    pub element_age_days: Option<f64>,
    /// HDU of the only chip on which the source is drawn; `None` for all chips.
    pub hdu: Option<usize>,
    /// Full width at half maximum of the image of each light, arcsec; `None` if seeing, defocus and size determine it.
    pub image_fwhm_arcsec: Option<f64>,
    /// The one or two lights that form the source.
    pub parts: Vec<SourcePart>,
}

/// One light of a source.
#[derive(Clone, Debug, PartialEq)]
pub struct SourcePart {
    /// `whole`, `chassis` or `array`.
    pub label: &'static str,
    /// Directions and magnitudes.
    pub track: SkyTrack,
    /// Radius of a disk with the area of this part, m.
    pub radius_m: f64,
}

impl Source {
    /// Returns the lights of a source, with modulated brightness: one disk of the size of the satellite, or its two
    /// panels.
    ///
    /// The times of glints are relative to `middle_s`, seconds after the shutter opened.
    #[doc(hidden)]
    pub fn parts(
        track: &SkyTrack,
        modulation: &Modulation,
        middle_s: f64,
        radius_m: f64,
        panels: Option<&ResolvedPanels>,
    ) -> Vec<SourcePart> {
        let track = modulation.applied(track, middle_s);
        match panels {
            None => vec![SourcePart { label: "whole", track, radius_m }],
            Some(panels) => {
                let [chassis, array] = panels.split(&track);
                vec![
                    SourcePart { label: "chassis", track: chassis, radius_m: panels.base_radius_m },
                    SourcePart { label: "array", track: array, radius_m: panels.sail_radius_m },
                ]
            }
        }
    }
}

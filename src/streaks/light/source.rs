//! What draws a streak: a satellite, or a light from a seed.

use std::fmt;
use std::sync::Arc;

use super::modulation::Modulation;
use super::resolved::ResolvedPanels;
use super::sky_track::SkyTrack;
use crate::elements::NoradId;

/// Who it is.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceName {
    /// A satellite.
    Satellite {
        /// Number in the catalogue.
        norad_id: NoradId,
        /// Name in the element set; empty where it has none.
        name: Arc<str>,
    },
    /// Drawn from a seed: its number among those of its frame, from 1.
    Random(usize),
}

impl fmt::Display for SourceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Satellite { norad_id, name } if name.is_empty() => write!(f, "{}", norad_id.0),
            Self::Satellite { name, .. } => f.write_str(name),
            Self::Random(number) => write!(f, "random {number}"),
        }
    }
}

/// A moving light with all that its streak depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Who it is.
    pub name: SourceName,
    /// What the magnitude rests on, as tables spell it.
    pub mag_source: String,
    /// Exposure less epoch of the elements, days; `None` for a random streak.
    pub element_age_days: Option<f64>,
    /// One or two lights that together are the source.
    pub parts: Vec<SourcePart>,
}

/// One light of a source.
#[derive(Clone, Debug, PartialEq)]
pub struct SourcePart {
    /// `whole`, `chassis` or `array`.
    pub label: &'static str,
    /// Where it is and how bright.
    pub track: SkyTrack,
    /// Radius of the disk that it is as large as, m.
    pub radius_m: f64,
}

impl Source {
    /// The parts of a track in changing light: one disk as large as the satellite, or its two panels.
    ///
    /// Glints count from `middle_s` after the shutter opened.
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

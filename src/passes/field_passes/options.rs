//! Options of a field query.

use crate::photometry::PhotometryOptions;

/// Options of a field query.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassOptions {
    /// If true, crossings that are dark all the time are included. In W1 and W2 none is dark.
    pub include_dark: bool,
    /// Smallest probability with which near misses are included; `None` for nominal crossings only.
    pub min_probability: Option<f64>,
    /// Number of points along the track, evenly spaced in time from entry to exit; 0 for none.
    pub samples: usize,
    /// Band, magnitude system and extinction.
    pub photometry: PhotometryOptions,
    /// If true, the brightness of all points and the peak are omitted, which is several times faster.
    pub without_light: bool,
    /// If true, the probability of a crossing is not computed and is 1, which is faster from an orbit. Near misses are
    /// not affected.
    #[doc(hidden)]
    pub without_probability: bool,
}

impl PassOptions {
    /// Returns true if satellites in the Earth's shadow are to be searched.
    pub(in crate::passes) fn with_shadow(&self) -> bool {
        self.include_dark || self.photometry.band.is_thermal()
    }
}

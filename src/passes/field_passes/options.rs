//! Options of a field query.

use crate::photometry::PhotometryOptions;

/// Options of a field query.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassOptions {
    /// Include crossings that are dark all the time.
    pub include_dark: bool,
    /// Include near misses that cross with at least this probability; `None` for nominal crossings only.
    pub min_probability: Option<f64>,
    /// Number of points along the track, evenly spaced in time from entry to exit; 0 for none.
    pub samples: usize,
    /// Band, system, extinction.
    pub photometry: PhotometryOptions,
    /// Omit the brightness of all points and the peak, which is several times faster.
    pub without_light: bool,
}

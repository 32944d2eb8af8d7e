//! Measured magnitudes: reading, viewing geometry, selection and reduction.
//!
//! ```text
//! file ── RecordReader ── Record ── Placement ── Selection ── Measurement ── Reducer ── Pixel
//! ```
//!
//! - `format`, `column_map`: layouts of published tables, and of custom tables
//! - `blocks`, `rows`, `record`, `reader`: blocks of whole rows of a file, parsed into records in parallel and in
//!   bounded memory
//! - `untimed`: passes of measurements without times
//! - `placement`, `ephemeris`, `offset`, `triangle`: viewing geometry from element sets (with a fitted delay), from
//!   recorded angles, or from distance and phase angle
//! - `identify`: identification of the satellites of tracks
//! - `selection`, `dropped`, `measure`: selection of records, numbers of dropped records by reason, and conversion to
//!   measurements
//! - `reduce`, `density_mode`: pixels of viewing geometry with the mode of their magnitudes
//!
//! ```
//! use streakcast::fit::measurements::{
//!     PhotometryOptions, Placement, RecordReader, ReduceOptions, Reducer, Selection, measure_each,
//! };
//!
//! let text = "Date,StdMag,Mag,Filter,Penumbra,Distance,Phase,Channel,Track\n\
//!             2021-01-01 15:18:04.795000,8.167,7.18581,Clear,0,697.324,78.267,7,18903315\n\
//!             2021-01-01 15:18:04.895000,8.527,99,Clear,0,697.143,78.21,7,18903315\n";
//! let mut reader = RecordReader::from_reader("a table", Box::new(text.as_bytes()), &PhotometryOptions::default())?;
//! let mut reducer = Reducer::new(ReduceOptions { least_count: 1, ..ReduceOptions::default() })?;
//! // VisorSats are at a height of 550 km: distance and phase determine the geometry.
//! let placement = Placement::recorded(Some(550.0));
//! let dropped = measure_each(&mut reader, &placement, &Selection::default(), |points| reducer.add(points))?;
//! assert_eq!(reducer.finish().kept().count(), 1);
//! assert_eq!(dropped.total(), 1);
//! # Ok::<(), streakcast::Error>(())
//! ```
//!
//! ```
//! use streakcast::fit::measurements::{Measurement, Measurements};
//! use streakcast::fit::{RawWeights, points_of_measurements};
//! use streakcast::geometry::ViewingGeometry;
//! use streakcast::photometry::StandardMagnitude;
//!
//! let geometry = ViewingGeometry::from_angles(-0.2, 1.0, -0.9, 900.0, 550.0).expect("a valid geometry");
//! let point = Measurement {
//!     magnitude: StandardMagnitude(6.3),
//!     sigma_mag: Some(0.1),
//!     geometry,
//!     group: 0,
//!     norad_id: None,
//!     epoch: None,
//!     grazing_height_km: None,
//!     lit_fraction: 1.0,
//! };
//! let mut measured = Measurements::default();
//! measured.groups.push("track 1".to_owned());
//! measured.points.push(point);
//! assert_eq!(points_of_measurements(&measured, &RawWeights::default()).len(), 1);
//! ```

mod blocks;
mod column_map;
mod density_mode;
mod dropped;
mod ephemeris;
mod format;
mod identify;
mod measure;
mod offset;
mod placement;
mod reader;
mod record;
mod reduce;
mod rows;
mod selection;
mod triangle;
mod untimed;

pub use measure::{Measurement, Measurements};
pub(crate) use record::{Record, Sighting};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    column_map::ColumnMap,
    density_mode::{DensityMode, half_sample_mode, kernel_mode, kernel_sigma},
    dropped::{DropCounts, DropReason},
    format::{FilterCounts, Format},
    identify::{
        AcceptanceLimits, AssociationOptions, TrackCandidate, associate, identification_table, identify_tracks,
    },
    measure::{measure, measure_each},
    placement::{OrbitRadius, Placed, Placement, Placer, PositionSource},
    reader::{PhotometryOptions, RecordReader},
    record::{RecordSource, Records},
    reduce::{Pixel, ReduceOptions, Reducer, Reduction, reduce},
    selection::{Selection, StationInterval, Stations},
};

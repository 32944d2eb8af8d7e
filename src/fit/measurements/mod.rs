//! Measured magnitudes: read, placed in geometry, selected, reduced.
//!
//! ```text
//! file ── RecordReader ── Record ── Placement ── Selection ── Measurement ── Reducer ── Pixel
//!         blocks, rows              elements, or what the rows say           layers, HEALPix, mode
//! ```
//!
//! `format` knows the published tables, `column_map` any other; `blocks` cuts files into whole rows, `rows` makes `record`s of their
//! `cells`, `filters` counts through what they were seen, `reader` does so on all threads in bounded memory. `placement` finds the geometry
//! (`nearest_orbit` by element sets, `triangle` from distance and phase, `offset` how late a satellite passes, `ephemeris` Sun and Earth
//! over years), `associate` which satellites a track may be of, `identify` which it
//! is. `station` tells when a satellite was on station, `selection` what is used,
//! `dropped` counts what is not; `measure` does all of it. `reduce` makes pixels, `density_mode` their magnitudes, `tables` both.
//! `simulate` makes photometry of which the truth is known, one `night` after the other; `mmt_csv` writes it.
//!
//! ```
//! use streakcast::fit::measurements::{Placement, ReadOptions, RecordReader, ReduceOptions, Reducer, Selection, measure_each};
//!
//! let text = "Date,StdMag,Mag,Filter,Penumbra,Distance,Phase,Channel,Track\n\
//!             2021-01-01 15:18:04.795000,8.167,7.18581,Clear,0,697.324,78.267,7,18903315\n\
//!             2021-01-01 15:18:04.895000,8.527,99,Clear,0,697.143,78.21,7,18903315\n";
//! let mut reader = RecordReader::from_reader("a table", Box::new(text.as_bytes()), &ReadOptions::default())?;
//! let mut reducer = Reducer::new(ReduceOptions { least_count: 1, ..ReduceOptions::default() })?;
//! // VisorSats fly 550 km high: distance and phase make the geometry.
//! let placement = Placement::recorded(Some(550.0));
//! let dropped = measure_each(&mut reader, &placement, &Selection::default(), |points| reducer.add(points))?;
//! assert_eq!(reducer.finish().kept().count(), 1);
//! assert_eq!(dropped.total(), 1);
//! # Ok::<(), streakcast::fit::measurements::MeasuredError>(())
//! ```

mod associate;
mod blocks;
mod cells;
mod column_map;
mod density_mode;
mod dropped;
mod ephemeris;
mod error;
mod filters;
mod format;
mod identify;
mod measure;
mod measurement;
mod mmt_csv;
mod nearest_orbit;
mod night;
mod offset;
mod placement;
mod reader;
mod record;
mod reduce;
mod rows;
mod selection;
mod simulate;
mod station;
mod tables;
mod triangle;

pub use crate::math::quantile::quantile;
pub use associate::{AssociationOptions, Candidate, associate};
pub use column_map::ColumnMap;
pub use density_mode::{DensityMode, half_sample_mode, interquartile_range, kernel_mode, kernel_sigma};
pub use dropped::{DropCounts, DropExample, DropReason};
pub use error::MeasuredError;
pub use filters::{BandDoubt, FilterCounts};
pub use format::Format;
pub use identify::{Credible, Identification, identification_table, identify};
pub use measure::{measure, measure_each};
pub use measurement::{Measurement, Measurements};
pub use mmt_csv::write_mmt_csv;
pub use placement::{OrbitRadius, Place, Placed, Placement, Placer};
pub use reader::{ReadOptions, RecordReader};
pub use record::{Record, RecordSource, Records, RecordsSource, Sighting};
pub use reduce::{Pixel, ReduceOptions, Reducer, Reduction, reduce};
pub use selection::Selection;
pub use simulate::{Simulation, SimulationOptions, TrackTruth, simulate};
pub use station::{StationInterval, Stations};

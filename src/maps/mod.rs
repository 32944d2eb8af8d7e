//! Magnitude maps: over a satellite's own sky, and over the sky of a site.
//!
//! `grid` says which directions are asked, `body` and `sky` answer for any direction and for all of a grid, `tables` makes tables of the
//! answers, `healpix_file` FITS files (`card_text` the words in their headers), `shadow_edge` draws where the Earth's shadow ends, `light` turns directions into magnitudes, `facts` says what all rests on, and `paper` knows the panels of figures 6 to 9 of Lu (2024).

mod body;
#[cfg(feature = "fits")]
mod card_text;
mod error;
mod facts;
mod grid;
#[cfg(feature = "fits")]
mod healpix_file;
mod light;
mod paper;
mod shadow_edge;
mod sky;
mod tables;

pub use body::{BodyMap, BodyPoint, BodyView};
pub use error::MapError;
pub use facts::{Fact, FactValue};
pub use grid::{DEFAULT_NSIDE, DEFAULT_STEP_DEG, Grid};
pub use paper::{FigurePanel, PAPER_FIGURES, PaperFigure};
pub use shadow_edge::ShadowEdgePoint;
pub use sky::{Earth, SkyMap, SkyPoint, SkyView};

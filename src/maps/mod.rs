//! Magnitude maps: all directions below a satellite, and all directions of the sky above a site.
//!
//! `grid` holds the directions of a map; `body` and `sky` compute one direction or a whole grid, with magnitudes from
//! `light`; `tables` and `healpix_file` write maps; `shadow_edge` computes the edge of the Earth's shadow; and
//! `lu2024_figures` lists the panels of figures 6 to 9 of Lu (2024).

mod body;
mod error;
mod grid;
#[cfg(all(feature = "fits", unix))]
mod healpix_file;
mod light;
mod lu2024_figures;
mod shadow_edge;
mod sky;
mod tables;

pub use body::{BodyMap, BodyPoint, BodyView};
pub use error::MapError;
pub use grid::Grid;
pub use sky::{Earth, SkyMap, SkyPoint, SkyView};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    grid::{DEFAULT_NSIDE, DEFAULT_STEP_DEG},
    light::{Fact, FactValue},
    lu2024_figures::{FigurePanel, PAPER_FIGURES, PaperFigure},
};

//! Magnitude maps: all directions below a satellite, and all directions of the sky above a site.
//!
//! `grid` holds the directions of a map; `body` and `sky` compute one direction or a whole grid, with magnitudes from
//! `light`; `tables` and `healpix_file` write maps; `shadow_edge` computes the edge of the Earth's shadow; and
//! `lu2024_figures` lists the panels of figures 6 to 9 of Lu (2024).
//!
//! ```
//! use streakcast::Site;
//! use streakcast::maps::{Earth, Grid, SkyView};
//! use streakcast::photometry::{ModelLibrary, PhotometryOptions};
//!
//! let model = ModelLibrary::embedded().find("starlink-v1.5")?;
//! let earth = Earth::Ellipsoid(Site::from_mpc("X05")?);
//! // Satellites at 550 km; the Sun is in the west, 18 deg below the horizon.
//! let sun = [270.0_f64, -18.0].map(f64::to_radians);
//! let view = SkyView::new(&model, earth, 550.0, sun[0], sun[1], PhotometryOptions::default())?;
//! let map = view.map(Grid::healpix(8)?)?;
//! let lit = map.points.iter().filter(|point| point.lit_fraction > 0.0).count();
//! assert!(lit > 0 && lit <= map.points.len());
//! # Ok::<(), streakcast::Error>(())
//! ```

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

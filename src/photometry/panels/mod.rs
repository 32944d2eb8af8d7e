//! Satellites of any number of flat panels and of spheres for parts without orientation: attitudes, obstruction, light,
//! and the force of sunlight.

mod assembly;
mod attitude;
mod build;
mod panel_file;
mod shapes;
mod sunlight_force;

pub use assembly::LitFace;
pub use assembly::{Face, PanelAssembly};
pub use panel_file::PanelsSpec;
pub use panel_file::{AttitudeSpec, Coefficient, LawSpec};
pub use shapes::{PanelPolygon, PlacedRectangle};
pub use sunlight_force::SunlightForce;

//! Satellites of any number of flat panels and of spheres for parts without orientation: attitudes, obstruction, light,
//! and the force of sunlight.

mod assembly;
mod attitude;
mod build;
mod panel_file;
mod shapes;
mod sunlight_force;

pub use assembly::{Face, LitFace, PanelAssembly, Part};
pub use attitude::{Attitude, PanelOffset};
pub use panel_file::{
    AttitudeSpec, BlockingSpec, Coefficient, LawSpec, OffsetSpec, PanelParameter, PanelSpec, PanelsSpec, SphereSpec,
};
pub use shapes::{PanelPolygon, PlacedRectangle, Sphere, SpherePhase};
pub use sunlight_force::SunlightForce;

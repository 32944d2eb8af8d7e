//! Satellites of any number of flat panels, and parts of no orientation: how each stands, what hides it, and the light of all.

mod assembly;
mod attitude;
mod build;
mod obstruction;
mod panel_file;
mod rectangle;
mod sphere;

pub use assembly::{Face, LitFace, PanelAssembly, Part};
pub use attitude::{Attitude, PanelOffset};
pub use panel_file::{
    AttitudeSpec, BlockingSpec, Coefficient, LawSpec, OffsetSpec, PanelParameter, PanelSpec, PanelsSpec, SphereSpec,
};
pub use rectangle::PlacedRectangle;
pub use sphere::{Sphere, SpherePhase};

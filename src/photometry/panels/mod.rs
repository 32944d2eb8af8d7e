//! Satellites of any number of flat panels and of parts without orientation: attitudes, obstruction, and light.

mod assembly;
mod attitude;
mod build;
mod panel_file;
mod polygon;
mod rectangle;
mod sphere;

pub use assembly::{Face, LitFace, PanelAssembly, Part};
pub use attitude::{Attitude, PanelOffset};
pub use panel_file::{
    AttitudeSpec, BlockingSpec, Coefficient, LawSpec, OffsetSpec, PanelParameter, PanelSpec, PanelsSpec, SphereSpec,
};
pub use polygon::PanelPolygon;
pub use rectangle::PlacedRectangle;
pub use sphere::{Sphere, SpherePhase};

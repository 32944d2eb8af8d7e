//! Satellites of any number of flat panels: how each stands, what hides it, and the light of all of them.

mod assembly;
mod attitude;
mod build;
mod obstruction;
mod panel_file;
mod rectangle;

pub use assembly::{Face, LitFace, PanelAssembly, Part};
pub use attitude::{Attitude, PanelOffset};
pub use panel_file::{
    AttitudeSpec, BlockingSpec, Coefficient, LawSpec, OffsetSpec, PanelParameter, PanelSpec, PanelsSpec,
};
pub use rectangle::PlacedRectangle;

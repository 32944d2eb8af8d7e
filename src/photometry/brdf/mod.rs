//! Reflection laws (BRDFs), each in its own file, with a common trait.

mod abg;
mod any;
mod binomial;
mod energy;
mod facets;
mod gaussian;
mod lambert;
mod law;
mod phong;
mod retro;
mod straight;

pub(crate) use abg::Abg;
pub use any::Law;
pub(crate) use binomial::Binomial;
pub(super) use energy::each_outgoing;
pub(crate) use energy::{reflected_share, transmitted_share};
pub use facets::Facets;
pub(crate) use gaussian::Gaussian;
pub use lambert::Lambert;
pub use law::{Brdf, Incidence};
pub use phong::Phong;
pub use retro::Retro;
pub(crate) use straight::Straight;

//! Laws of reflection, one a file, behind one trait.

mod abg;
mod any;
mod binomial;
mod energy;
mod gaussian;
mod lambert;
mod law;
mod phong;

pub use abg::Abg;
pub use any::Law;
pub use binomial::Binomial;
pub use energy::reflected_share;
pub use gaussian::Gaussian;
pub use lambert::Lambert;
pub use law::Brdf;
pub use phong::Phong;

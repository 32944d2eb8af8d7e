//! Laws of reflection, one a file, behind one trait.

mod lambert;
mod law;
mod phong;

pub use lambert::Lambert;
pub use law::Brdf;
pub use phong::Phong;

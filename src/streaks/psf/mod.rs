//! Point spread functions. `seeing` is the atmosphere's profile, `blur` adds defocus and size, `convolve` computes their convolution as a
//! `curve` of the radius, `profile` averages it over pixels and splits it into `layers`, `points` draws points of light with these.

mod blur;
mod convolve;
mod curve;
mod layers;
mod points;
mod profile;
mod seeing;

pub use blur::{Blur, BlurError};
pub use points::{PointLight, draw_point, draw_points};
pub use profile::RadialProfile;
pub use seeing::Seeing;

//! Point spread functions. `seeing` is the profile of a star, `blur` adds defocus and the size of the body, and
//! `convolve` tabulates their convolution as a `curve` of the radius. `profile` averages this curve over pixels and
//! splits it into `layers`, which `points` uses to draw points of light.

mod blur;
mod convolve;
mod curve;
mod layers;
mod points;
mod profile;
mod seeing;

pub use blur::Blur;
pub use points::draw_point;
pub(crate) use points::{PointLight, draw_points};
pub use profile::RadialProfile;
pub use seeing::Seeing;

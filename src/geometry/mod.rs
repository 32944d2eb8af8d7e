//! How Sun, Earth, satellite and observer stand to one another.

mod error;
mod observer;
mod shadow;
mod site;
mod sun;
mod topocentric;
mod viewing;

pub use error::GeometryError;
pub use observer::{Observer, ObserverState};
pub use shadow::{Illumination, illumination};
pub use site::Site;
pub use sun::{SunState, SunTable};
pub use topocentric::{Aspect, aspect};
pub use viewing::ViewingGeometry;

//! Geometry of Sun, Earth, satellite and observer.
//!
//! ```
//! use hifitime::Epoch;
//! use streakcast::frames::{EopTable, Gcrs, Orientation, Position, Velocity};
//! use streakcast::geometry::{Observer, Site, SunState, aspect, illumination};
//!
//! let epoch = Epoch::from_gregorian_utc_hms(2026, 4, 25, 23, 30, 0);
//! let (orientation, sun) = (Orientation::at(epoch, &EopTable::embedded()), SunState::at(epoch));
//! let observer = Observer::new(Site::by_name("Rubin")?).state(&orientation);
//! let (satellite, velocity) = (Position::<Gcrs>::new(-5900.0, 150.0, -3500.0), Velocity::<Gcrs>::new(1.0, 7.4, 0.5));
//!
//! let seen = aspect(&satellite, &velocity, &observer.position, &sun.earth_velocity);
//! let direction = seen.direction;
//! println!("RA {:.4} deg", direction.longitude_rad().to_degrees());
//! println!("Dec {:.4} deg", direction.latitude_rad().to_degrees());
//! println!("altitude and azimuth {:?} rad", observer.altitude_azimuth_rad(&seen.geometric));
//! println!("{}", illumination(&satellite, &sun.sun).name());
//! # Ok::<(), streakcast::Error>(())
//! ```

mod limb;
mod pointing_limits;
mod shadow;
mod site;
mod sun;
mod topocentric;
mod viewing;

pub use limb::EarthLimb;
pub(crate) use shadow::KARMAN_LINE_KM;
pub use shadow::{Illumination, ShadowModel, illumination};
pub(crate) use site::SAME_SITE_KM;
pub use site::{Observer, ObserverState, Site};
pub use sun::SunState;
pub use topocentric::{Aspect, aspect};
pub use viewing::ViewingGeometry;
pub(crate) use viewing::body_to_gcrs;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    pointing_limits::{PointingAngles, PointingLimits},
    shadow::{grazing_height_km, sunlit_by_100_km_rule},
    site::ellipsoidal_height_km,
    sun::SunTable,
    topocentric::icrs_of_apparent,
};

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
//! # Ok::<(), streakcast::geometry::GeometryError>(())
//! ```

mod error;
mod limb;
mod shadow;
mod site;
mod sun;
mod topocentric;
mod viewing;

pub use error::GeometryError;
pub use limb::EarthLimb;
pub use shadow::{Illumination, KARMAN_LINE_KM, ShadowModel, grazing_height_km, illumination, sunlit_by_100_km_rule};
pub(crate) use site::SAME_SITE_KM;
pub use site::{Observer, ObserverState, Site, ellipsoidal_height_km};
pub use sun::{SunState, SunTable};
pub use topocentric::{Aspect, aspect, icrs_of_apparent};
pub use viewing::{ViewingGeometry, body_to_gcrs};

//! Acceleration of satellites by the pressure of sunlight, from the panels of their brightness models.
//!
//! The force is that of all light that the panels intercept, less the momentum of the light that they reflect. It
//! depends on the areas of the panels, because most light is absorbed. Magnitudes determine only the products of areas
//! and reflectances: the sizes in the built-in models are assumed, and the force has their relative error. Further
//! assumptions:
//!
//! * The reflectances in the band of the model apply to the whole spectrum of the Sun.
//! * Absorbed power is emitted as heat without a net force. A panel that emits it by Lambert's law from its lit face
//!   only would receive up to 2/3 of the absorbed momentum along its normal in addition.
//! * Attitudes are those of the brightness model, which was fitted with the Sun below the plane of the chassis. A solar
//!   array in another attitude on the day side has another force.
//! * Light reflected by the Earth, and its infrared radiation, are not included.
//!
//! ```
//! use streakcast::frames::{Gcrs, Position};
//! use streakcast::geometry::ShadowModel;
//! use streakcast::photometry::ModelLibrary;
//!
//! let model = ModelLibrary::embedded().find("starlink-v1.5")?;
//! let satellite = Position::<Gcrs>::new(-1800.0, 6690.0, 0.0);
//! let sun = Position::<Gcrs>::new(149_597_870.7, 0.0, 0.0);
//! let lit_fraction = ShadowModel::default().illumination(&satellite, &sun).lit_fraction();
//! if let Some(acceleration) = model.sunlight_acceleration(&satellite, &sun, lit_fraction, 295.0) {
//!     // m/s², GCRS
//!     let [x, y, z] = [acceleration.vector().x, acceleration.vector().y, acceleration.vector().z];
//!     println!("{x:.3e} {y:.3e} {z:.3e}");
//! #   assert!(x < -1e-8 && x > -1e-6, "{x}");
//! }
//! # Ok::<(), streakcast::Error>(())
//! ```

use super::model::BrightnessModel;
use super::panels::{PanelAssembly, SunlightForce};
use crate::constants::AU_KM;
use crate::frames::{Acceleration, Body, Direction, Gcrs, Position};
use crate::geometry::body_to_gcrs;

impl BrightnessModel {
    /// Returns the force of sunlight on the satellite, as areas, for a direction of the Sun in the body frame (with
    /// y = 0); `None` for a model without panels.
    ///
    /// The force depends only on the Sun's latitude above the plane of the chassis. Programs that need it at many times
    /// should compute it at some latitudes and interpolate, because one computation takes 0.1 to 0.2 s for two panels.
    #[doc(hidden)]
    pub fn sunlight_force(&self, to_sun: &Direction<Body>) -> Option<SunlightForce> {
        if let Some(assembly) = self.assembly() {
            return Some(assembly.sunlight_force(to_sun.vector()));
        }
        let file = self.file()?;
        let panels = PanelAssembly::chassis_and_sail(file.shape.as_ref()?, file.coefficients.as_ref()?);
        Some(panels.sunlight_force(to_sun.vector()))
    }

    /// Returns the acceleration by the pressure of sunlight in GCRS.
    ///
    /// `satellite` and `sun` are geocentric positions, `lit_fraction` is the fraction of the Sun's light that reaches
    /// the satellite, [0, 1], and `mass_kg` its mass. `None` for a model without panels, and for positions, fractions
    /// or masses that are not valid.
    #[doc(hidden)]
    pub fn sunlight_acceleration(
        &self,
        satellite: &Position<Gcrs>,
        sun: &Position<Gcrs>,
        lit_fraction: f64,
        mass_kg: f64,
    ) -> Option<Acceleration<Gcrs>> {
        let to_gcrs = body_to_gcrs(satellite, sun)?;
        let to_sun = *sun - *satellite;
        let force = self.sunlight_force(&(to_gcrs.inverse() * to_sun.direction()?))?;
        Some(to_gcrs * force.acceleration(mass_kg, lit_fraction, to_sun.norm_km() / AU_KM)?)
    }
}

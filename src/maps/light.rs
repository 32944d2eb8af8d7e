//! From directions to magnitudes: the model's light in the band that was asked for.

use crate::frames::{Body, Direction};
use crate::geometry::ViewingGeometry;
use crate::photometry::{
    BodyAngles, BrightnessModel, Earthshine, Magnitude, PhotometryOptions, Places, StandardMagnitude, airmass,
};

use super::facts::{Fact, FactValue};

/// The distance of standard magnitudes, km.
pub(super) const STANDARD_RANGE_KM: f64 = 1000.0;

/// A model with what is the same in every direction.
///
/// A map has no use for the sigma and source that come with each single magnitude; without them a direction costs a third. That both ways
/// give the same magnitude is a test.
#[derive(Clone, Debug)]
pub(super) struct Light<'a> {
    model: &'a BrightnessModel,
    options: PhotometryOptions,
    /// From the model's band to the one asked for, mag.
    colour_mag: f64,
}

impl<'a> Light<'a> {
    pub fn new(model: &'a BrightnessModel, options: PhotometryOptions) -> Self {
        Self { model, options, colour_mag: model.colour_to_mag(options.band, options.system) }
    }

    /// At 1000 km by sunlight of which `lit_fraction` (above 0) is left and, where it is not off, earthshine; the Sun at 1 au. `None` where nothing
    /// lit is seen.
    pub fn standard_magnitude(
        &self,
        to_sun: &Direction<Body>,
        to_observer: &Direction<Body>,
        height_km: f64,
        lit_fraction: f64,
    ) -> Option<StandardMagnitude> {
        if self.options.earthshine != Earthshine::Off && self.model.is_of_panels() {
            let geometry = ViewingGeometry::from_angles(
                to_sun.latitude_rad(),
                to_observer.longitude_rad(),
                to_observer.latitude_rad(),
                STANDARD_RANGE_KM,
                height_km,
            )?;
            let options = PhotometryOptions { sun_distance: false, extinction_mag_per_airmass: None, ..self.options };
            let bright = self.model.brightness(&geometry, lit_fraction, &options)?;
            return Some(StandardMagnitude(bright.magnitude.0));
        }
        let standard = self.model.standard_magnitude_towards(to_sun, to_observer)?;
        self.shaded(StandardMagnitude(standard.0 + self.colour_mag), lit_fraction)
    }

    /// True where magnitudes are those of panels under the Sun alone: many at once cost a fraction of each by itself.
    pub fn is_sunlight_on_panels(&self) -> bool {
        self.options.earthshine == Earthshine::Off && self.model.satellite().is_some()
    }

    /// At 1000 km by full sunlight, many at once; not a number where nothing lit is seen.
    pub fn sunlight_at(&self, places: &Places, out: &mut [f64]) {
        self.model.standard_magnitudes_at(places, out);
        out.iter_mut().for_each(|magnitude| *magnitude += self.colour_mag);
    }

    /// The same from directions in the body frame.
    pub fn sunlight_towards(&self, angles: &BodyAngles, out: &mut [f64]) {
        self.model.standard_magnitudes(angles, out);
        out.iter_mut().for_each(|magnitude| *magnitude += self.colour_mag);
    }

    /// What the Earth's shadow leaves of a magnitude by full sunlight; `None` where that is nothing, or there was none.
    pub fn shaded(&self, standard: StandardMagnitude, lit_fraction: f64) -> Option<StandardMagnitude> {
        let shade = if lit_fraction < 1.0 { -2.5 * lit_fraction.log10() } else { 0.0 };
        let magnitude = standard.0 + shade;
        magnitude.is_finite().then_some(StandardMagnitude(magnitude))
    }

    /// What distance and air add to a standard magnitude; `None` with air at the horizon and below, where it has no airmass.
    pub fn dimming(&self, range_km: f64, altitude_rad: f64) -> Option<Magnitude> {
        let air = match self.options.extinction_mag_per_airmass {
            Some(k) => k * airmass(altitude_rad)?,
            None => 0.0,
        };
        Some(StandardMagnitude(0.0).at_range(range_km).dimmed_by(air))
    }

    /// Model, band and zero point.
    pub fn facts(&self) -> Vec<Fact> {
        let text = |shown: &dyn std::fmt::Display| FactValue::Text(shown.to_string());
        let mut facts = vec![
            Fact::new("model", "MODEL", text(&self.model.source()), "what magnitudes rest on"),
            Fact::new("band", "BAND", text(&self.options.band), "passband"),
            Fact::new("mag_system", "MAGSYS", text(&self.options.system), "zero point"),
        ];
        if self.model.is_of_panels() {
            facts.push(Fact::new(
                "earthshine",
                "ERTHSHIN",
                text(&self.options.earthshine.name()),
                "light of the Earth",
            ));
        }
        if self.model.file().is_some_and(|file| file.provenance.provisional) {
            facts.push(Fact::new("model_status", "MODSTAT", text(&"provisional"), "as the model file says"));
        }
        facts
    }

    /// Extinction, mag per airmass, where there is any.
    pub fn extinction(&self) -> Option<f64> {
        self.options.extinction_mag_per_airmass
    }
}

//! Magnitudes of a map in the band and magnitude system of its options, and the metadata of a map.

use crate::geometry::ViewingGeometry;
use crate::output::Provenance;
use crate::photometry::{
    BodyAngles, BrightnessModel, Earthshine, Magnitude, PhotometryOptions, SatellitePositions, StandardMagnitude,
    airmass,
};

/// Range to which standard magnitudes refer, km.
pub(super) const STANDARD_RANGE_KM: f64 = 1000.0;

/// A brightness model with photometric options, as used by maps.
///
/// Maps use neither the uncertainty nor the source of a magnitude. Omitting both makes a direction three times faster;
/// a test compares the magnitudes.
#[derive(Clone, Debug)]
pub(super) struct MapPhotometry<'a> {
    model: &'a BrightnessModel,
    options: PhotometryOptions,
    /// Colour term from the band of the model to the band of the options, mag.
    colour_mag: f64,
}

impl<'a> MapPhotometry<'a> {
    pub fn new(model: &'a BrightnessModel, options: PhotometryOptions) -> Self {
        Self { model, options, colour_mag: model.colour_to_mag(options.band, options.system) }
    }

    /// Returns the magnitude at a range of 1000 km, with sunlight reduced to the fraction `lit_fraction` and with
    /// earthshine unless it is switched off. The Sun is at 1 au. `None` if no lit surface is visible.
    pub fn standard_magnitude(&self, geometry: &ViewingGeometry, lit_fraction: f64) -> Option<StandardMagnitude> {
        if self.is_single() {
            let geometry = ViewingGeometry { range_km: STANDARD_RANGE_KM, ..*geometry };
            let options = PhotometryOptions { sun_distance: false, extinction_mag_per_airmass: None, ..self.options };
            let bright = self.model.brightness(&geometry, lit_fraction, &options)?;
            return Some(StandardMagnitude(bright.magnitude.0));
        }
        let standard = self.model.standard_magnitude(geometry)?;
        self.shaded(StandardMagnitude(standard.0 + self.colour_mag), lit_fraction)
    }

    /// Returns true if each direction is computed alone: with its own integral over the Earth, or with thermal
    /// emission. Otherwise all directions of a row are computed together.
    pub fn is_single(&self) -> bool {
        let has_earthshine = self.options.earthshine != Earthshine::Off && self.model.is_of_panels();
        has_earthshine || self.shines_in_shadow()
    }

    /// Returns true if magnitudes include thermal emission, also that of satellites in the Earth's shadow.
    pub fn shines_in_shadow(&self) -> bool {
        self.options.band.has_emission()
    }

    /// Computes the magnitudes at a range of 1000 km in full sunlight; NaN where no lit surface is visible.
    pub fn sunlight_at(&self, positions: &SatellitePositions, out: &mut [f64]) {
        self.model.standard_magnitudes_at(positions, out);
        out.iter_mut().for_each(|magnitude| *magnitude += self.colour_mag);
    }

    /// Computes the same as [`Self::sunlight_at`] for directions in the body frame.
    pub fn sunlight_towards(&self, angles: &BodyAngles, out: &mut [f64]) {
        self.model.standard_magnitudes(angles, out);
        out.iter_mut().for_each(|magnitude| *magnitude += self.colour_mag);
    }

    /// Converts a magnitude in full sunlight to one with sunlight reduced to `lit_fraction`; `None` if no light
    /// remains.
    pub fn shaded(&self, standard: StandardMagnitude, lit_fraction: f64) -> Option<StandardMagnitude> {
        let shade = if lit_fraction < 1.0 { -2.5 * lit_fraction.log10() } else { 0.0 };
        let magnitude = standard.0 + shade;
        magnitude.is_finite().then_some(StandardMagnitude(magnitude))
    }

    /// Returns the apparent magnitude that corresponds to a standard magnitude of 0, at this range (km) and altitude
    /// (radians). `None` if extinction is applied at or below the horizon, where the airmass is undefined.
    pub fn dimming(&self, range_km: f64, altitude_rad: f64) -> Option<Magnitude> {
        let air = match self.options.extinction_mag_per_airmass {
            Some(k) => k * airmass(altitude_rad)?,
            None => 0.0,
        };
        Some(StandardMagnitude(0.0).at_range(range_km).dimmed_by(air))
    }

    /// Returns the metadata of the photometry: model, band and zero point.
    pub fn facts(&self) -> Vec<Fact> {
        let text = |shown: &dyn std::fmt::Display| FactValue::Text(shown.to_string());
        let mut facts = vec![
            Fact::new("model", "MODEL", text(&self.model.source()), "source of the magnitudes"),
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
            facts.push(Fact::new("model_status", "MODSTAT", text(&"provisional"), "status in the model file"));
        }
        facts
    }

    /// Returns the extinction, mag per airmass; `None` if no extinction is applied.
    pub fn extinction(&self) -> Option<f64> {
        self.options.extinction_mag_per_airmass
    }
}

/// One entry of the metadata of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// Name in the provenance of a table, in snake_case with the unit at the end.
    pub name: &'static str,
    /// Keyword in a FITS header.
    pub keyword: &'static str,
    /// Value of the entry.
    pub value: FactValue,
    /// Comment on the FITS header card.
    pub comment: &'static str,
}

/// Value of a metadata entry.
#[derive(Clone, Debug, PartialEq)]
pub enum FactValue {
    /// Text.
    Text(String),
    /// A number, in the unit in which the name of the entry ends.
    Real(f64),
}

impl FactValue {
    pub(super) fn text(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl Fact {
    pub(super) fn new(name: &'static str, keyword: &'static str, value: FactValue, comment: &'static str) -> Self {
        Self { name, keyword, value, comment }
    }

    /// Adds the entry to the provenance of an output.
    pub fn state(&self, provenance: &mut Provenance) {
        match &self.value {
            FactValue::Text(text) => provenance.state(self.name, text.as_str()),
            FactValue::Real(number) => provenance.state(self.name, *number),
        }
    }
}

/// Rounds away the error of a conversion from degrees to radians and back.
pub(super) fn rounded(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}

//! Magnitudes of a map in the band and system of its options, and the metadata of a map.

use crate::geometry::ViewingGeometry;
use crate::output::Provenance;
use crate::photometry::{
    BodyAngles, BrightnessModel, Earthshine, Magnitude, PhotometryOptions, SatellitePositions, StandardMagnitude,
    airmass,
};

/// Distance of standard magnitudes, km.
pub(super) const STANDARD_RANGE_KM: f64 = 1000.0;

/// A brightness model with its options.
///
/// Maps need no sigma and no source; without these a direction takes a third of the time. A test compares both.
#[derive(Clone, Debug)]
pub(super) struct MapPhotometry<'a> {
    model: &'a BrightnessModel,
    options: PhotometryOptions,
    /// Offset from the band of the model to that of the options, mag.
    colour_mag: f64,
}

impl<'a> MapPhotometry<'a> {
    pub fn new(model: &'a BrightnessModel, options: PhotometryOptions) -> Self {
        Self { model, options, colour_mag: model.colour_to_mag(options.band, options.system) }
    }

    /// Returns the magnitude at 1000 km in sunlight reduced to `lit_fraction` (above 0) and, unless it is off,
    /// earthshine; the Sun is at 1 au. `None` where no lit surface is visible.
    pub fn standard_magnitude(&self, geometry: &ViewingGeometry, lit_fraction: f64) -> Option<StandardMagnitude> {
        if self.has_earthshine() {
            let geometry = ViewingGeometry { range_km: STANDARD_RANGE_KM, ..*geometry };
            let options = PhotometryOptions { sun_distance: false, extinction_mag_per_airmass: None, ..self.options };
            let bright = self.model.brightness(&geometry, lit_fraction, &options)?;
            return Some(StandardMagnitude(bright.magnitude.0));
        }
        let standard = self.model.standard_magnitude(geometry)?;
        self.shaded(StandardMagnitude(standard.0 + self.colour_mag), lit_fraction)
    }

    /// Returns true where each direction needs its own sum over the Earth; without earthshine rows are computed at
    /// once.
    pub fn has_earthshine(&self) -> bool {
        self.options.earthshine != Earthshine::Off && self.model.is_of_panels()
    }

    /// Computes magnitudes at 1000 km in full sunlight; NaN where no lit surface is visible.
    pub fn sunlight_at(&self, positions: &SatellitePositions, out: &mut [f64]) {
        self.model.standard_magnitudes_at(positions, out);
        out.iter_mut().for_each(|magnitude| *magnitude += self.colour_mag);
    }

    /// Same as [`Self::sunlight_at`], from directions in the body frame.
    pub fn sunlight_towards(&self, angles: &BodyAngles, out: &mut [f64]) {
        self.model.standard_magnitudes(angles, out);
        out.iter_mut().for_each(|magnitude| *magnitude += self.colour_mag);
    }

    /// Returns the magnitude in the Earth's shadow from that in full sunlight; `None` where no light remains.
    pub fn shaded(&self, standard: StandardMagnitude, lit_fraction: f64) -> Option<StandardMagnitude> {
        let shade = if lit_fraction < 1.0 { -2.5 * lit_fraction.log10() } else { 0.0 };
        let magnitude = standard.0 + shade;
        magnitude.is_finite().then_some(StandardMagnitude(magnitude))
    }

    /// Returns the apparent magnitude of a standard magnitude of 0 at this range and altitude; `None` with extinction
    /// at and below the horizon, where the airmass is undefined.
    pub fn dimming(&self, range_km: f64, altitude_rad: f64) -> Option<Magnitude> {
        let air = match self.options.extinction_mag_per_airmass {
            Some(k) => k * airmass(altitude_rad)?,
            None => 0.0,
        };
        Some(StandardMagnitude(0.0).at_range(range_km).dimmed_by(air))
    }

    /// Returns the metadata: model, band and zero point.
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

    /// Returns the extinction, mag per airmass.
    pub fn extinction(&self) -> Option<f64> {
        self.options.extinction_mag_per_airmass
    }
}

/// One metadata entry of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// Name in the provenance of a table, snake_case with the unit last.
    pub name: &'static str,
    /// Keyword in a FITS header.
    pub keyword: &'static str,
    /// Value.
    pub value: FactValue,
    /// Comment in a FITS header.
    pub comment: &'static str,
}

/// Text or a number.
#[derive(Clone, Debug, PartialEq)]
pub enum FactValue {
    /// Text.
    Text(String),
    /// A number in the unit of the name.
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

/// Removes the rounding of a conversion from degrees to radians and back.
pub(super) fn rounded(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}

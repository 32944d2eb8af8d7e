//! Published measurements, read from a data folder, with their viewing geometries.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use super::super::measurements::{
    DropReason, Format, Measurement, Measurements, PhotometryOptions, Placement, RecordReader, Selection, measure,
};
use crate::error::{Error, ErrorKind};
use crate::geometry::{KARMAN_LINE_KM, ViewingGeometry};
use crate::input;
use crate::photometry::{
    Band, BrightnessModel, Earthshine, MagSystem, PhotometryOptions as LightOptions, StandardMagnitude,
    StandardMagnitudes,
};

/// A published set of measurements.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DataSet {
    /// Starlink V1.5, Pomenis.
    Pomenis,
    /// Starlink V2 mini, Slingshot.
    SlingshotV2,
    /// Starlink VisorSat, MMT-9.
    Mmt9VisorSat,
    /// OneWeb, MMT-9.
    Mmt9OneWeb,
    /// Iridium NEXT, MMT-9.
    Mmt9IridiumNext,
    /// Payloads in the list qs.mag of visual observers.
    AmateursPayloads,
    /// Rocket bodies in the list qs.mag of visual observers.
    AmateursRocketBodies,
}

impl DataSet {
    /// All sets of measurements.
    pub const ALL: [Self; 7] = [
        Self::Pomenis,
        Self::SlingshotV2,
        Self::Mmt9VisorSat,
        Self::Mmt9OneWeb,
        Self::Mmt9IridiumNext,
        Self::AmateursPayloads,
        Self::AmateursRocketBodies,
    ];

    /// Returns the survey and its publication.
    pub fn source(self) -> &'static str {
        match self {
            Self::Pomenis => "Pomenis (Fankhauser, Tyson and Askari 2023)",
            Self::SlingshotV2 => "Slingshot (Kandula et al. 2025)",
            Self::Mmt9VisorSat | Self::Mmt9OneWeb | Self::Mmt9IridiumNext => {
                "MMT-9 (Karpov et al. 2016, Beskin et al. 2017)"
            }
            Self::AmateursPayloads | Self::AmateursRocketBodies => "qs.mag (McCants)",
        }
    }

    /// Returns a word by which the provenance of a model names the survey.
    pub(super) fn survey(self) -> &'static str {
        match self {
            Self::Pomenis => "pomenis",
            Self::SlingshotV2 => "slingshot",
            Self::Mmt9VisorSat | Self::Mmt9OneWeb | Self::Mmt9IridiumNext => "mmt",
            Self::AmateursPayloads | Self::AmateursRocketBodies => "qs.mag",
        }
    }

    /// Returns the path of the set's file in a data folder.
    pub fn path(self) -> &'static str {
        match self {
            Self::Pomenis => "photometry/pomenis/pomenis_observations.csv",
            Self::SlingshotV2 => "photometry/slingshot_v2/Observations_in_field.csv",
            Self::Mmt9VisorSat => "derived/mmt9_starlink_visorsat.csv.gz",
            Self::Mmt9OneWeb => "derived/mmt9_oneweb.csv.gz",
            Self::Mmt9IridiumNext => "derived/mmt9_iridium2.csv.gz",
            Self::AmateursPayloads | Self::AmateursRocketBodies => "metadata/qs.mag",
        }
    }

    fn read(self, path: &Path) -> Result<SetMeasurements, Error> {
        match self {
            Self::Pomenis => read_survey(path, Format::Pomenis, None),
            Self::SlingshotV2 => read_survey(path, Format::Slingshot, None),
            // Without element sets, circular orbits at the height that was used in the fit are assumed.
            Self::Mmt9VisorSat => read_survey(path, Format::Mmt, Some(540.0)),
            Self::Mmt9OneWeb => read_survey(path, Format::Mmt, Some(1200.0)),
            Self::Mmt9IridiumNext => read_survey(path, Format::Mmt, Some(780.0)),
            Self::AmateursPayloads => Ok(SetMeasurements { sunlit: read_qs_mag(path, false)?, grazing: Vec::new() }),
            Self::AmateursRocketBodies => Ok(SetMeasurements { sunlit: read_qs_mag(path, true)?, grazing: Vec::new() }),
        }
    }
}

/// One published magnitude with which a model is compared.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ReferenceMeasurement {
    /// Magnitude at 1000 km, taken as V (Vega), although some surveys are unfiltered.
    pub magnitude: StandardMagnitude,
    /// Phase angle Sun-satellite-observer, [0, π], radians.
    pub phase_rad: f64,
    /// Complete viewing geometry; `None` if only the phase angle is known.
    pub geometry: Option<ViewingGeometry>,
    /// Number of the track, night or object: measurements of one group are not independent of one another.
    pub group: u32,
    /// Fraction of the Sun's light that reached the satellite, (0, 1]; the model's magnitude is dimmed accordingly.
    pub lit_fraction: f64,
}

impl ReferenceMeasurement {
    /// Returns the uncertainty (one sigma) of the model's magnitude in this geometry and light, V (Vega), mag; that of
    /// the model if only the phase angle is known.
    pub fn sigma_of_model_mag(&self, model: &BrightnessModel) -> Option<f64> {
        let Some(geometry) = self.geometry else { return Some(model.sigma_mag()) };
        let sunlight = LightOptions { earthshine: Earthshine::Off, ..LightOptions::default() };
        Some(model.brightness(&geometry, self.lit_fraction, &sunlight)?.sigma_mag)
    }

    /// Returns the magnitude of the model in this geometry and light, V (Vega) at a range of 1000 km. `None` if no lit
    /// surface is visible, or if the model requires angles that are unknown.
    pub fn of_model(&self, model: &BrightnessModel) -> Option<StandardMagnitude> {
        let is_of_phase_alone = model.satellite().is_none() && model.assembly().is_none();
        let geometry = if is_of_phase_alone { at_phase(self.phase_rad) } else { self.geometry };
        let lit = geometry.and_then(|geometry| in_v(model, &geometry))?;
        Some(StandardMagnitude(lit.0 - 2.5 * self.lit_fraction.log10()))
    }
}

/// Returns the magnitude of a model in full sunlight at a range of 1000 km, converted from the model's band to V
/// (Vega).
pub(super) fn in_v(model: &BrightnessModel, geometry: &ViewingGeometry) -> Option<StandardMagnitude> {
    let colour_mag = model.colour_to_mag(Band::V, MagSystem::Vega);
    model.standard_magnitude(geometry).map(|magnitude| StandardMagnitude(magnitude.0 + colour_mag))
}

/// Returns a geometry with this phase angle. The Sun is in the plane of the chassis. The observer is in the Sun's half
/// plane for phase angles up to 90°, and in the opposite half plane beyond.
fn at_phase(phase_rad: f64) -> Option<ViewingGeometry> {
    let (longitude, latitude) = if phase_rad <= FRAC_PI_2 { (0.0, -phase_rad) } else { (PI, phase_rad - PI) };
    ViewingGeometry::from_angles(0.0, longitude, latitude, 1000.0, 550.0)
}

/// Measurements of one set.
#[derive(Clone, Debug, Default, PartialEq)]
struct SetMeasurements {
    /// Measurements in full sunlight: the line to the Sun passes at least 100 km above the ground (Lu 2024), and the
    /// survey does not flag them as in the penumbra.
    sunlit: Vec<ReferenceMeasurement>,
    /// Measurements in sunlight that passes less than 100 km above the ground.
    grazing: Vec<ReferenceMeasurement>,
}

/// Reads all rows in the survey's usual filter whose satellite is lit.
fn read_survey(path: &Path, format: Format, height_km: Option<f64>) -> Result<SetMeasurements, Error> {
    let options = PhotometryOptions { format: Some(format), keep_duplicates: true, ..PhotometryOptions::default() };
    let placement = Placement::recorded(height_km);
    let read = |selection: &Selection| -> Result<Measurements, Error> {
        let measured = measure(&mut RecordReader::open(&[path], &options)?, &placement, selection)?;
        let broken = [DropReason::Unparsable, DropReason::NoMagnitude];
        if let Some(example) = broken.iter().find_map(|reason| measured.dropped.example(*reason)) {
            return Err(Error::new(ErrorKind::Invalid, format!("photometry {}", example.clone())));
        }
        Ok(measured)
    };
    let reference = |point: &Measurement, lit_fraction: f64| ReferenceMeasurement {
        magnitude: point.magnitude,
        phase_rad: point.geometry.phase_angle_rad(),
        geometry: Some(point.geometry),
        group: point.group,
        lit_fraction,
    };
    let sunlit = read(&Selection::default())?;
    // A survey may flag grazing rows as in the penumbra.
    let any_light = Selection { drop_penumbra_flag: false, least_grazing_height_km: None, ..Selection::default() };
    let all = read(&any_light)?;
    let is_grazing = |point: &&Measurement| {
        point.grazing_height_km.is_some_and(|height_km| height_km < KARMAN_LINE_KM) && point.lit_fraction > 0.0
    };
    Ok(SetMeasurements {
        // The 100 km rule leaves 0.01 mag of dimming at most, which is neglected.
        sunlit: sunlit.points.iter().map(|point| reference(point, 1.0)).collect(),
        grazing: all.points.iter().filter(is_grazing).map(|point| reference(point, point.lit_fraction)).collect(),
    })
}

/// Reads standard magnitudes (McCants' qs.mag) of payloads or of rocket bodies, on which the priors are based.
///
/// The name selects the kind of object: "Rk" marks a rocket body; "Deb" and "Db" mark debris, which is omitted.
fn read_qs_mag(path: &Path, rocket_bodies: bool) -> Result<Vec<ReferenceMeasurement>, Error> {
    let unreadable = |problem: String| Error::new(ErrorKind::File, problem).in_file("photometry", path);
    let bytes = input::read(path).map_err(|error| unreadable(error.to_string()))?;
    // Names are Latin-1; the numbers are ASCII.
    let text = String::from_utf8_lossy(&bytes);
    let table = StandardMagnitudes::from_qs_mag(&text).map_err(|error| unreadable(error.to_string()))?;
    let listed = text.lines().filter_map(|line| {
        let (id, name) = (line.get(0..5)?.trim().parse().ok()?, line.get(18..33)?);
        let selected = !name.contains("Deb") && !name.contains(" Db") && name.contains("Rk") == rocket_bodies;
        let magnitude = table.get(id).filter(|_| selected)?;
        Some(ReferenceMeasurement { magnitude, phase_rad: FRAC_PI_2, geometry: None, group: id, lit_fraction: 1.0 })
    });
    Ok(listed.collect())
}

/// All measurements found in a data folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Photometry {
    sets: BTreeMap<DataSet, SetMeasurements>,
}

impl Photometry {
    /// Reads every known file that is in the folder.
    ///
    /// # Errors
    /// None of the files exists, or one is invalid.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let mut sets = BTreeMap::new();
        for set in DataSet::ALL {
            let path = folder.join(set.path());
            if path.is_file() {
                sets.insert(set, set.read(&path)?);
            }
        }
        if sets.is_empty() {
            let mut looked_for = DataSet::ALL.map(DataSet::path).to_vec();
            looked_for.dedup();
            return Err(Error::new(ErrorKind::Missing, format!("no photometry in {}", folder.display()))
                .allowing(looked_for.join(", ")));
        }
        Ok(Self { sets })
    }

    /// Returns the measurements of one set in full sunlight by the 100 km rule of Lu (2024); `None` if its file is
    /// missing.
    pub fn get(&self, set: DataSet) -> Option<&[ReferenceMeasurement]> {
        self.sets.get(&set).map(|all| all.sunlit.as_slice())
    }

    /// Returns the measurements of one set with grazing sunlight: the satellite is lit, and the line to the Sun passes
    /// lower than 100 km above the ground. Empty if its file is missing.
    pub fn grazing(&self, set: DataSet) -> &[ReferenceMeasurement] {
        self.sets.get(&set).map_or(&[], |all| all.grazing.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_a_phase_has_a_geometry_of_that_phase() {
        for degrees in [0.0_f64, 1.0, 89.0, 90.0, 91.0, 179.0, 180.0] {
            let geometry = at_phase(degrees.to_radians()).expect("a geometry");
            assert!((geometry.phase_angle_rad().to_degrees() - degrees).abs() < 1e-9, "{degrees}");
        }
    }
}

//! Measured magnitudes with the geometry they were measured in, out of a folder of published files.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use super::super::measurements::{DropReason, Format, Placement, ReadOptions, RecordReader, Selection, measure};
use crate::geometry::ViewingGeometry;
use crate::photometry::{Band, BrightnessModel, MagSystem, StandardMagnitude};

use super::amateurs;
use super::error::CheckError;

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
    /// Payloads of qs.mag.
    AmateursPayloads,
    /// Rocket bodies of qs.mag.
    AmateursRocketBodies,
}

impl DataSet {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Pomenis,
        Self::SlingshotV2,
        Self::Mmt9VisorSat,
        Self::Mmt9OneWeb,
        Self::Mmt9IridiumNext,
        Self::AmateursPayloads,
        Self::AmateursRocketBodies,
    ];

    /// Whose it is.
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

    /// Where it lies in a data folder.
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

    fn read(self, path: &Path) -> Result<Vec<Measurement>, CheckError> {
        match self {
            Self::Pomenis => surveyed(path, Format::Pomenis, None),
            Self::SlingshotV2 => surveyed(path, Format::Slingshot, None),
            // No element sets: circular orbits at the height where the points were fitted.
            Self::Mmt9VisorSat => surveyed(path, Format::Mmt, Some(540.0)),
            Self::Mmt9OneWeb => surveyed(path, Format::Mmt, Some(1200.0)),
            Self::Mmt9IridiumNext => surveyed(path, Format::Mmt, Some(780.0)),
            Self::AmateursPayloads => amateurs::read(path, false),
            Self::AmateursRocketBodies => amateurs::read(path, true),
        }
    }
}

/// One measured magnitude.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Brought to 1000 km, as V (Vega), though some were measured through no filter.
    pub magnitude: StandardMagnitude,
    /// Angle Sun-satellite-observer, [0, π], radians.
    pub phase_rad: f64,
    /// All angles; `None` where only the phase is known.
    pub geometry: Option<ViewingGeometry>,
}

impl Measurement {
    fn in_geometry(magnitude: StandardMagnitude, geometry: ViewingGeometry) -> Self {
        Self::with_phase(magnitude, geometry.phase_angle_rad(), Some(geometry))
    }

    pub(super) fn with_phase(magnitude: StandardMagnitude, phase_rad: f64, geometry: Option<ViewingGeometry>) -> Self {
        Self { magnitude, phase_rad, geometry }
    }

    /// What the model says, V (Vega) at 1000 km; `None` where it says nothing: nothing lit is seen, or it needs angles that are not known.
    pub fn of_model(&self, model: &BrightnessModel) -> Option<StandardMagnitude> {
        let of_phase_alone = model.satellite().is_none() && model.assembly().is_none();
        let geometry = if of_phase_alone { at_phase(self.phase_rad) } else { self.geometry };
        geometry.and_then(|geometry| in_v(model, &geometry))
    }
}

/// What a model says by full sunlight at 1000 km, whatever its own band, in that of everything it is compared with: V (Vega).
pub(super) fn in_v(model: &BrightnessModel, geometry: &ViewingGeometry) -> Option<StandardMagnitude> {
    let colour_mag = model.colour_to_mag(Band::V, MagSystem::Vega);
    model.standard_magnitude(geometry).map(|magnitude| StandardMagnitude(magnitude.0 + colour_mag))
}

/// A geometry of this phase: the Sun on the plane of the chassis, the observer in its half plane, turned over the zenith past 90°.
fn at_phase(phase_rad: f64) -> Option<ViewingGeometry> {
    let (longitude, latitude) = if phase_rad <= FRAC_PI_2 { (0.0, -phase_rad) } else { (PI, phase_rad - PI) };
    ViewingGeometry::from_angles(0.0, longitude, latitude, 1000.0, 550.0)
}

/// Every row through the usual filter in full sunlight, by the paper's 100 km rule: all of them count, so a broken one is an error.
fn surveyed(path: &Path, format: Format, height_km: Option<f64>) -> Result<Vec<Measurement>, CheckError> {
    let options = ReadOptions { format: Some(format), keep_duplicates: true, ..ReadOptions::default() };
    let mut reader = RecordReader::open(&[path], &options)?;
    let measured = measure(&mut reader, &Placement::recorded(height_km), &Selection::default())?;
    let broken = [DropReason::Unparsable, DropReason::NoMagnitude];
    if let Some(example) = broken.iter().find_map(|reason| measured.dropped.example(*reason)) {
        return Err(CheckError::Row(example.clone()));
    }
    let points = measured.points.iter();
    Ok(points.map(|point| Measurement::in_geometry(point.magnitude, point.geometry)).collect())
}

/// All measurements that a folder holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Photometry {
    sets: BTreeMap<DataSet, Vec<Measurement>>,
}

impl Photometry {
    /// Reads every known file that is there.
    ///
    /// # Errors
    /// [`CheckError::Nothing`] where none is; the others for a file that is there and cannot be understood.
    pub fn read(folder: &Path) -> Result<Self, CheckError> {
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
            return Err(CheckError::Nothing { folder: folder.to_owned(), looked_for: looked_for.join(", ") });
        }
        Ok(Self { sets })
    }

    /// The measurements of one set; `None` where the folder lacks it.
    pub fn get(&self, set: DataSet) -> Option<&[Measurement]> {
        self.sets.get(&set).map(Vec::as_slice)
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

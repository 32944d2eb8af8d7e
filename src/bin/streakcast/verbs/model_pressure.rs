//! `model pressure`: acceleration of a satellite by the pressure of sunlight.

use anyhow::anyhow;
use serde_json::json;
use streakcast::constants::SOLAR_IRRADIANCE_W_M2;
use streakcast::frames::Direction;
use streakcast::output::{Column, Kind, Provenance, Table, Value};
use streakcast::photometry::BrightnessModel;

use super::map::{model_of, provisional};
use super::model::{ModelPressureArguments, library_of};
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};

const ON_SCREEN: &[Shown] = &[
    rounded("sun_latitude_deg", "Sun latitude deg", 1),
    rounded("cross_section_m2", "section m2", 2),
    rounded("pressure_coefficient", "C_R", 3),
    rounded("acceleration_away_from_sun_nm_s2", "away from Sun nm/s2", 2),
    rounded("acceleration_x_nm_s2", "x", 2),
    rounded("acceleration_y_nm_s2", "y", 2),
    rounded("acceleration_z_nm_s2", "z", 2),
    shown("in_fitted_range", "fitted"),
];

/// Smallest and largest accepted mass, kg.
const MASSES_KG: [f64; 2] = [0.01, 1e6];

pub fn pressure(typed: ModelPressureArguments) -> anyhow::Result<Outcome> {
    let notices = Notices::new(typed.quiet);
    let [least_kg, most_kg] = MASSES_KG;
    if !(least_kg..=most_kg).contains(&typed.mass_kg) {
        return Err(anyhow!("mass is {} kg; allowed: {least_kg} to {most_kg}", typed.mass_kg));
    }
    if let Some(invalid) = typed.sun_latitude_deg.iter().find(|latitude| !(-90.0..=90.0).contains(*latitude)) {
        return Err(anyhow!("latitude of the Sun is {invalid} deg; allowed: -90 to 90"));
    }
    let output = Output::new(typed.output.format.as_deref(), typed.output.output)?;
    let model = model_of(&library_of(typed.config.as_deref())?, &typed.model)?;
    let latitudes_deg: Vec<f64> = match typed.sun_latitude_deg.as_slice() {
        [] => (-3..=9).map(|step| 10.0 * f64::from(step)).collect(),
        given => given.to_vec(),
    };
    let table = table_of(&model, &latitudes_deg, typed.mass_kg)
        .ok_or_else(|| anyhow!("model {} has no panels; allowed: a model of panels", model.source()))?;
    notices.warn(&provisional(&model));
    let mut provenance = Provenance::new();
    provenance.state("model", model.source().to_string());
    provenance.state("mass_kg", json!(typed.mass_kg));
    provenance.state("solar_irradiance_w_m2", json!(SOLAR_IRRADIANCE_W_M2));
    provenance.state("frame", "body: z to the zenith, x in the half plane of z and the Sun, y = z x x");
    provenance.state("light", "full sunlight at 1 au; no thermal emission, no light of the Earth");
    output.write(&VerbResult::new("accelerations", &table, ON_SCREEN, &provenance), &notices)?;
    Ok(Outcome::Done)
}

/// Returns one row for each latitude of the Sun; `None` for a model without panels.
fn table_of(model: &BrightnessModel, latitudes_deg: &[f64], mass_kg: f64) -> Option<Table> {
    const NM: f64 = 1e9;
    let range = model.file().and_then(|file| file.geometry_range?.sun_latitude_deg);
    let row = |&latitude_deg: &f64| {
        let to_sun = Direction::from_lon_lat_rad(0.0, latitude_deg.to_radians());
        let force = model.sunlight_force(&to_sun)?;
        let acceleration = force.acceleration(mass_kg, 1.0, 1.0)?;
        let away_m2 = -force.per_pressure_m2.dot(to_sun.vector());
        let away_m_s2 = -acceleration.vector().dot(to_sun.vector());
        let [x, y, z] = [0, 1, 2].map(|axis| Value::Real(acceleration.vector()[axis] * NM));
        let in_range = range.map(|[from, to]| Value::Boolean((from..=to).contains(&latitude_deg)));
        Some(vec![
            latitude_deg.into(),
            force.cross_section_m2.into(),
            (away_m2 / force.cross_section_m2).into(),
            (away_m_s2 * NM).into(),
            x,
            y,
            z,
            in_range.unwrap_or(Value::Null),
        ])
    };
    Some(Table { columns: COLUMNS.to_vec(), rows: latitudes_deg.iter().map(row).collect::<Option<_>>()? })
}

const COLUMNS: [Column; 8] = [
    Column::real("sun_latitude_deg", "deg", 3, "Latitude of the Sun above the plane of the chassis."),
    Column::real("cross_section_m2", "m2", 4, "Area that intercepts sunlight, projected towards the Sun."),
    Column::real(
        "pressure_coefficient",
        "",
        4,
        "Force away from the Sun, divided by pressure and cross-section: 1 for a black satellite.",
    ),
    Column::real(
        "acceleration_away_from_sun_nm_s2",
        "nm / s2",
        4,
        "Acceleration away from the Sun, in full sunlight at 1 au.",
    ),
    Column::real(
        "acceleration_x_nm_s2",
        "nm / s2",
        4,
        "Acceleration along x of the body frame, towards the Sun's azimuth.",
    ),
    Column::real("acceleration_y_nm_s2", "nm / s2", 4, "Acceleration along y = z x x."),
    Column::real("acceleration_z_nm_s2", "nm / s2", 4, "Acceleration along z, towards the zenith."),
    Column::new(
        "in_fitted_range",
        Kind::Boolean,
        "True if the model was fitted at this latitude of the Sun; empty if the model states no range.",
    ),
];

//! Amateurs' standard magnitudes (McCants' qs.mag), payloads and rocket bodies apart: what the priors rest on.

use std::path::Path;

use crate::photometry::StandardMagnitudes;

use super::error::CheckError;
use super::photometry::Measurement;
use super::rows::text_of;

/// Payloads, or rocket bodies; by the name: "Rk" marks a rocket body, "Deb" and "Db" debris, which is left out.
pub(super) fn read(path: &Path, rocket_bodies: bool) -> Result<Vec<Measurement>, CheckError> {
    let text = text_of(path)?;
    let table = StandardMagnitudes::from_qs_mag(&text)
        .map_err(|error| CheckError::Unreadable { path: path.to_owned(), problem: error.to_string() })?;
    let listed = text.lines().filter_map(|line| {
        let (id, name) = (line.get(0..5)?.trim().parse().ok()?, line.get(18..33)?);
        let wanted = !name.contains("Deb") && !name.contains(" Db") && name.contains("Rk") == rocket_bodies;
        let half_lit = table.get(id).filter(|_| wanted)?;
        Some(Measurement::with_phase(half_lit, std::f64::consts::FRAC_PI_2, None))
    });
    Ok(listed.collect())
}

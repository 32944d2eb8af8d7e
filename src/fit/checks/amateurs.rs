//! Amateurs' standard magnitudes (McCants' qs.mag), payloads and rocket bodies apart: what the priors rest on.

use std::path::Path;

use crate::photometry::StandardMagnitudes;

use super::error::CheckError;
use super::photometry::Measurement;

/// Payloads, or rocket bodies; by the name: "Rk" marks a rocket body, "Deb" and "Db" debris, which is left out.
pub(super) fn read(path: &Path, rocket_bodies: bool) -> Result<Vec<Measurement>, CheckError> {
    let unreadable = |problem: String| CheckError::Unreadable { path: path.to_owned(), problem };
    let bytes = std::fs::read(path).map_err(|error| unreadable(error.to_string()))?;
    // Names are Latin-1; the numbers are ASCII.
    let text = String::from_utf8_lossy(&bytes);
    let table = StandardMagnitudes::from_qs_mag(&text).map_err(|error| unreadable(error.to_string()))?;
    let listed = text.lines().filter_map(|line| {
        let (id, name) = (line.get(0..5)?.trim().parse().ok()?, line.get(18..33)?);
        let wanted = !name.contains("Deb") && !name.contains(" Db") && name.contains("Rk") == rocket_bodies;
        let half_lit = table.get(id).filter(|_| wanted)?;
        Some(Measurement::with_phase(half_lit, std::f64::consts::FRAC_PI_2, None))
    });
    Ok(listed.collect())
}

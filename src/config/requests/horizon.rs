//! What nobody can have seen.

use super::error::QuestionError;
use crate::config::Prepared;
use crate::output::format_utc;
use crate::passes::Exposure;
use crate::schedule::lowest_altitudes_rad;

/// Refuses what lies below the horizon, or the Earth's limb, at any time of the exposure; `what` is what errors call it.
///
/// # Errors
/// An altitude below 0°.
pub fn above_the_horizon(what: &str, exposure: &Exposure, prepared: &Prepared) -> Result<(), QuestionError> {
    let viewpoint = prepared.sky.viewpoint();
    let altitudes_rad = lowest_altitudes_rad(&[exposure], viewpoint, &prepared.eop);
    match altitudes_rad.first() {
        Some(altitude_rad) if *altitude_rad < 0.0 => Err(QuestionError::said(format!(
            "the {what} is below {} of {} at {} (altitude {:.1} deg); allowed: 0 deg or more",
            viewpoint.border_name(),
            viewpoint.name(),
            format_utc(exposure.start, 0),
            altitude_rad.to_degrees()
        ))),
        _ => Ok(()),
    }
}

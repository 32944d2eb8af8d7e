//! Predicted magnitudes of measured streaks, corrected by earlier streaks of the same pass.

use hifitime::Epoch;

use super::frame::MeasuredPass;
use super::measurement::{Estimate, Flag};
use crate::elements::NoradId;
use crate::frames::seconds_between;
use crate::passes::LONGEST_PASS_GAP_S;
use crate::photometry::{PassResidual, PassUpdate};

/// Flags of streaks that correct no others: limits, fluxes of less than half of a streak, and streaks that may be of
/// another satellite.
const UNUSED_FLAGS: [Flag; 4] = [Flag::Saturated, Flag::Clipped, Flag::Masked, Flag::Position];
/// Largest number of earlier streaks that are used, the last ones.
const MOST_OF_A_PASS: usize = 40;

/// Sets the corrected predictions of streaks that follow other streaks of the same satellite by at most 20 minutes, in
/// any order of the frames. The predictions of the streaks must be without other measurements.
///
/// The frames may have different bands: the error of the colour is part of that of each residual.
pub(crate) fn predict_within_passes<'a>(streaks: impl IntoIterator<Item = &'a mut MeasuredPass>) {
    let mut streaks: Vec<&mut MeasuredPass> = streaks.into_iter().collect();
    let mut known: Vec<(NoradId, Epoch, PassResidual)> = streaks.iter().filter_map(|pass| residual(pass)).collect();
    known.sort_by_key(|(_, epoch, _)| *epoch);
    for pass in &mut streaks {
        let satellite = &pass.prediction.satellite;
        let (Some(id), Some(light), Some(geometry)) = (satellite.norad_id, &satellite.brightness, &satellite.geometry)
        else {
            continue;
        };
        let is_earlier = |(of, epoch, _): &&(NoradId, Epoch, PassResidual)| *of == id && is_of_pass(*epoch, pass.epoch);
        let earlier = known.iter().rev().filter(is_earlier).take(MOST_OF_A_PASS).map(|(_, _, residual)| *residual);
        let update = PassUpdate::new(earlier.collect());
        pass.of_pass = update.map(|update| {
            let light = update.apply(geometry, light.clone());
            Estimate { value: light.magnitude.0, sigma: light.sigma_mag }
        });
    }
}

/// Returns true if a streak of the same satellite can be of the same pass as a later one.
fn is_of_pass(epoch: Epoch, later: Epoch) -> bool {
    epoch < later && seconds_between(epoch, later) <= LONGEST_PASS_GAP_S
}

/// Returns the residual of a streak that may correct others.
fn residual(pass: &MeasuredPass) -> Option<(NoradId, Epoch, PassResidual)> {
    let satellite = &pass.prediction.satellite;
    let (id, light, geometry) = (satellite.norad_id?, satellite.brightness.as_ref()?, satellite.geometry?);
    let is_doubtful = UNUSED_FLAGS.iter().any(|flag| pass.measured.flags.contains(flag));
    let magnitude = pass.magnitude.filter(|_| pass.is_calibrated && !is_doubtful)?;
    // Errors of the prediction apart from the scatter: colour and position.
    let more_mag = (light.sigma_mag.powi(2) - light.scatter_mag.powi(2)).max(0.0).sqrt();
    let residual = PassResidual {
        geometry,
        residual_mag: magnitude.value - light.magnitude.0,
        scatter_mag: light.scatter_mag,
        error_mag: more_mag.hypot(magnitude.sigma),
    };
    Some((id, pass.epoch, residual))
}

#[cfg(test)]
mod tests {
    use hifitime::Unit;

    use super::*;

    #[test]
    fn only_earlier_streaks_within_twenty_minutes_are_of_the_same_pass() {
        let epoch = Epoch::from_gregorian_utc_at_midnight(2026, 8, 14);
        for (minutes, is_same) in
            [(-1.0, false), (0.0, false), (0.1, true), (19.9, true), (21.0, false), (1440.0, false)]
        {
            assert_eq!(is_of_pass(epoch, epoch + minutes * Unit::Minute), is_same, "{minutes} min");
        }
    }
}

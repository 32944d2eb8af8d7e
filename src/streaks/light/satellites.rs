//! Satellites that cross the field during an exposure, as lights to be drawn.

use super::modulation::Modulation;
use super::resolved::ResolvedPanels;
use super::sky_track::{SkyPoint, SkyTrack};
use super::source::{Source, SourceName};
use crate::elements::NoradId;
use crate::error::Error;
use crate::frames::{EopTable, Gcrs, Orientation, OrientationTable, Position, seconds_after};
use crate::orbit::PositionSource;
use crate::passes::{Exposure, Field, Pass, PassOptions, Sky, Viewpoint};
use crate::photometry::PhotometryOptions;
use crate::streaks::tracking::Tracking;

/// Number of samples of a pass. The brightness changes by less than a thousandth from one sample to the next, except in
/// the penumbra, which contains dozens of samples.
const SAMPLES: usize = 257;

/// Margin around the chips, radians (0.1°). It makes each track begin and end where its image does not reach a chip.
const MARGIN_RAD: f64 = 1.7e-3;

/// Options for the light of satellites.
#[derive(Copy, Clone, Debug)]
pub struct SatelliteLight<'a> {
    /// Band, magnitude system and extinction.
    pub photometry: &'a PhotometryOptions,
    /// Changes of brightness along the track.
    pub modulation: &'a Modulation,
    /// If true, chassis and solar array are separate lights, for models that have both.
    pub resolve_panels: bool,
    /// Tracking of the telescope.
    pub tracking: &'a Tracking,
    /// Size of all satellites, m; `None` for those of the models.
    pub size_m: Option<f64>,
}

/// Lights of the satellites in one exposure.
#[derive(Clone, Debug, Default)]
pub struct SatelliteExposure {
    /// Satellites that are lit somewhere on their track through the field.
    pub sources: Vec<Source>,
    /// NORAD catalogue numbers of the satellites that may be anywhere on their orbits, because their elements are too
    /// old.
    pub unknown: Vec<NoradId>,
}

/// Returns the satellites that are sunlit while they are within `radius_rad` (plus a small margin) of the pointing and
/// the shutter is open. If the telescope tracks a moving target, the search covers the whole strip of the sky over
/// which the frame moves.
///
/// # Errors
/// Passes cannot be computed, or if the field covers more than half of the sky.
pub fn satellites(
    sky: &Sky,
    eop: &EopTable,
    exposure: &Exposure,
    radius_rad: f64,
    light: &SatelliteLight<'_>,
) -> Result<SatelliteExposure, Error> {
    let of_known_age = sky;
    // Satellites of unknown position are counted where they are predicted.
    let sky = &sky.clone().with_elements_of_any_age();
    let reach_rad = light.tracking.reach_rad(exposure.duration_s);
    let field = Field::circle(2.0 * (radius_rad + reach_rad + MARGIN_RAD))?;
    let options = PassOptions { samples: SAMPLES, photometry: *light.photometry, ..PassOptions::default() };
    let mut crossings = sky.field_passes(std::slice::from_ref(exposure), &field, &options)?;
    let passes = crossings.by_exposure.pop().unwrap_or_default();
    let (known, unknown): (Vec<&Pass>, Vec<&Pass>) = passes.iter().partition(|pass| {
        pass.position_source != PositionSource::ElementSet
            || of_known_age.is_known(pass.element_index, pass.element_age_days)
    });
    let sources = known.into_iter().map(|pass| source(sky, eop, exposure, pass, light)).collect();
    let mut unknown: Vec<NoradId> = unknown.into_iter().map(|pass| pass.norad_id).collect();
    unknown.sort_unstable();
    unknown.dedup();
    Ok(SatelliteExposure { sources, unknown })
}

fn source(sky: &Sky, eop: &EopTable, exposure: &Exposure, pass: &Pass, light: &SatelliteLight<'_>) -> Source {
    let model = sky.model(pass.element_index);
    let track = SkyTrack::of_pass(pass, exposure);
    let seen = |point: &SkyPoint| light.tracking.seen(&point.direction, point.time_s, &exposure.pointing);
    let middle_s = track.closest_s(&exposure.pointing, seen).unwrap_or(0.0);
    let panels = light.resolve_panels.then(|| panels(sky, eop, exposure, pass, light)).flatten();
    Source {
        name: SourceName::Satellite { norad_id: pass.norad_id, name: sky.elements()[pass.element_index].name.clone() },
        mag_source: model.source().to_string(),
        element_age_days: Some(pass.element_age_days),
        hdu: None,
        image_fwhm_arcsec: None,
        parts: Source::parts(
            &track,
            light.modulation,
            middle_s,
            0.5 * light.size_m.unwrap_or(model.size_m()),
            panels.as_ref(),
        ),
    }
}

/// Returns chassis and solar array; `None` for models without panels and for telescopes in orbit.
fn panels(
    sky: &Sky,
    eop: &EopTable,
    exposure: &Exposure,
    pass: &Pass,
    light: &SatelliteLight<'_>,
) -> Option<ResolvedPanels> {
    let Viewpoint::Site(observer) = sky.viewpoint() else { return None };
    let end = seconds_after(exposure.start, exposure.duration_s);
    let turning = OrientationTable::new(exposure.start, end, eop);
    let position = |time_s: f64| -> Position<Gcrs> {
        let orientation: Orientation = turning.at_s(time_s);
        observer.position(&orientation)
    };
    ResolvedPanels::of_pass(pass, exposure, sky.model(pass.element_index), light.photometry.earthshine, position)
}

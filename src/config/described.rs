//! Descriptions of inputs in the provenance of results: site, observer, element files, constellations, ephemerides.

use std::sync::Arc;

use hifitime::Epoch;
use serde_json::json;

use super::document::Config;
use crate::constants::DAY_S;
use crate::elements::{Constellation, ElementSet, Ephemeris, EphemerisObject, Rejected, Satellites, SourceFile};
use crate::frames::seconds_between;
use crate::geometry::Site;
use crate::math::quantile::median;
use crate::orbit::{EphemerisCoverage, MeanMotion};
use crate::output::format_utc;
use crate::passes::{OrbitingObserver, Sky};

/// Largest number of records and satellites listed; counts include all of them.
pub(super) const LISTED: usize = 1000;

/// Returns names with catalogue numbers, for warnings; `satellites` are indices of `elements`.
pub(super) fn names(satellites: impl Iterator<Item = usize>, elements: &[ElementSet]) -> Vec<String> {
    let name = |index: usize| match &elements[index] {
        set if set.name.is_empty() => set.norad_id.to_string(),
        set => format!("{} ({})", set.name, set.norad_id),
    };
    satellites.map(name).collect()
}

pub(super) fn site_json(site: &Site) -> serde_json::Value {
    let round = |value: f64, digits: i32| (value * 10_f64.powi(digits)).round() / 10_f64.powi(digits);
    json!({
        "name": site.name,
        "mpc_code": site.mpc_code,
        "latitude_deg": round(site.latitude_rad.to_degrees(), 7),
        "longitude_deg": round(site.longitude_rad.to_degrees(), 7),
        "height_m": round(site.height_m, 3),
    })
}

pub(super) fn observer_json(config: &Config, observer: &OrbitingObserver) -> serde_json::Value {
    let (norad_id, designator) = match observer.object() {
        EphemerisObject::Norad(norad_id) => (Some(norad_id.0), None),
        EphemerisObject::Designator(designator) => (None, Some(designator.as_ref())),
    };
    let span = |ephemeris: &Arc<Ephemeris>| {
        let (first, last) = ephemeris.interval();
        json!({
            "file": ephemeris.file.as_ref(),
            "first_utc": format_utc(first, 3),
            "last_utc": format_utc(last, 3),
        })
    };
    json!({
        "norad_id": norad_id,
        "international_designator": designator,
        "name": observer.name(),
        "elements_epoch_utc": observer.elements_epoch().map(|epoch| format_utc(epoch, 3)),
        "ephemerides": observer.ephemerides().iter().map(span).collect::<Vec<_>>(),
        "file": config.observer_elements.as_ref().map(|path| path.display().to_string()),
        "limb_height_km": observer.limb().height_km,
        "max_zenith_angle_deg": config.max_zenith_angle,
        "min_sun_angle_deg": config.min_sun_angle,
        "min_limb_angle_deg": config.min_limb_angle,
    })
}

/// Returns the files of a catalogue; an empty list if there is none.
pub(super) fn elements_json(catalogue: Option<&Satellites>) -> serde_json::Value {
    catalogue.iter().flat_map(|catalogue| &catalogue.sources).map(source_json).collect()
}

fn source_json(source: &SourceFile) -> serde_json::Value {
    json!({
        "file": source.name.as_ref(),
        "sha256": source.sha256,
        "format": source.format.to_string(),
        "records": source.records,
        "rejected": source.rejected,
        "bad_checksums_accepted": source.bad_checksums_accepted,
        "first_epoch_utc": format_utc(source.first_epoch, 3),
        "last_epoch_utc": format_utc(source.last_epoch, 3),
    })
}

pub(super) fn rejected_json(rejected: &Rejected) -> serde_json::Value {
    json!({
        "file": rejected.file.as_ref(),
        "line": rejected.line,
        "reason": rejected.reason.to_string(),
    })
}

pub(super) fn constellations_json(constellations: &[Constellation]) -> serde_json::Value {
    let stated = constellations.iter().map(|constellation| {
        json!({
            "name": constellation.name,
            "satellites": constellation.satellites(),
            "deployed_fraction": constellation.deployed_fraction,
            "synthetic": true,
            "source": constellation.source,
        })
    });
    stated.collect()
}

pub(super) fn period_json(
    first_start: Epoch,
    satellites: usize,
    shells: serde_json::Value,
    elements: Option<serde_json::Value>,
) -> serde_json::Value {
    let mut stated =
        json!({ "first_start_utc": format_utc(first_start, 3), "satellites": satellites, "shells": shells });
    if let Some(elements) = elements {
        stated["elements"] = elements;
    }
    stated
}

/// Returns the use of ephemerides between two times, with the satellites for which element sets are used instead.
pub(super) fn ephemerides_json(sky: &Sky, without_elements: &[String], first: Epoch, last: Epoch) -> serde_json::Value {
    let of = |wanted: EphemerisCoverage| {
        let found = sky.ephemeris_coverage(first, last).filter(move |(_, part)| *part == wanted);
        names(found.map(|(index, _)| index), sky.elements())
    };
    let (whole, part, none) = (of(EphemerisCoverage::Whole), of(EphemerisCoverage::Part), of(EphemerisCoverage::None));
    json!({
        "satellites_covered": whole.len(),
        "satellites_partly_covered": part.len(),
        "satellites_not_covered": none.len(),
        "partly_covered": part.iter().take(LISTED).collect::<Vec<_>>(),
        "not_covered": none.iter().take(LISTED).collect::<Vec<_>>(),
        "without_element_set": without_elements.iter().take(LISTED).collect::<Vec<_>>(),
        "interpolation": "Lagrange, degree 7",
    })
}

/// Returns the number of satellites by the source of their mean motion, and the median lateness of those from files at
/// a time.
pub(super) fn mean_motion_json(sky: &Sky, from_files: usize, at: Epoch) -> serde_json::Value {
    let counts = sky.mean_motions();
    let median_s = |sigma_s: &dyn Fn(usize, f64) -> f64| {
        let ages = sky.elements()[..from_files].iter().map(|set| seconds_between(set.epoch, at) / DAY_S).enumerate();
        let median_s = median(ages.map(|(index, age_days)| sigma_s(index, age_days)).collect());
        (100.0 * median_s).round() / 100.0
    };
    let of = |wanted: &[MeanMotion]| wanted.iter().filter_map(|motion| counts.get(motion)).sum::<usize>();
    json!({
        "two_or_three_epochs": of(&[MeanMotion::TwoSets, MeanMotion::Disagreeing, MeanMotion::Enclosed]),
        "four_epochs": of(&[MeanMotion::FourSets]),
        "shell": of(&[MeanMotion::Shell]),
        "arrived_at_shell": of(&[MeanMotion::Arrived]),
        "published_drag_confirmed": of(&[MeanMotion::Coasting]),
        "rate_of_change": of(&[MeanMotion::Rate]),
        "far_from_shells": of(&[MeanMotion::OffShell]),
        "changed_between_epochs": of(&[MeanMotion::Changed, MeanMotion::NoRate]),
        "one_epoch": of(&[MeanMotion::OneSet]),
        "median_late_s": median_s(&|index, age_days| sky.uncertainty(index, age_days).along_track_s),
        "median_late_with_one_epoch_s": median_s(&|index, age_days| sky.uncertainty_of_one_set(index, age_days).along_track_s),
    })
}

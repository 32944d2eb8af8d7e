//! Trails in the exposures of space telescopes, compared with the numbers of SPARKLES (Borlaff, Marcum & Howell 2025,
//! Nature, s41586-025-09759-5; Borlaff et al. 2026 on SPHEREx).

use hifitime::Epoch;

use super::reproduce::Reproduced;
use super::trail_statistics::{Mean, TrailRequest, TrailStatistics, trail_statistics};
use crate::constants::{DAY_S, EARTH_EQUATORIAL_RADIUS_KM, WGS72_MU_KM3_S2};
use crate::elements::{ElementSet, NoradId};
use crate::error::{Error, ErrorKind};
use crate::frames::seconds_after;
use crate::geometry::{EarthLimb, PointingLimits};
use crate::output::format_utc;
use crate::passes::{Field, OrbitingObserver, Sky};
use crate::photometry::PhotometryOptions;

/// NORAD catalogue number of SPHEREx.
const SPHEREX: u32 = 63_182;
/// Catalogue number of the telescope at 800 km, which no catalogue has.
const INVENTED: u32 = 999_999_998;
/// Mean inclination of the satellites of the trails in the published figure, degrees, as dashed lines in the histogram
/// of directions.
const INCLINATION_DEG: f64 = 53.16;

/// Space telescope with its limits and published numbers.
struct Mission {
    name: &'static str,
    /// Object whose orbit the telescope has, with its catalogue number.
    orbit: (&'static str, u32),
    /// Height of a sun-synchronous orbit in the plane of that object, km; `None` for its own orbit.
    height_km: Option<f64>,
    /// Largest zenith angle, smallest Sun angle and smallest limb angle, degrees.
    limits_deg: [Option<f64>; 3],
    field_deg: [f64; 2],
    exposure_s: f64,
    /// Published mean number of trails, with its kind.
    trails: &'static [(&'static str, f64)],
    /// Published share of exposures with a trail, percent.
    streaked_percent: Option<f64>,
    source: &'static str,
    reason: &'static str,
}

const CATALOGUE: &str =
    "the catalogue: other objects at another time than in the paper (16,656 of mid-2025, with rocket bodies)";

/// Numbers of 2025: SPHEREx from the text of the second paper, the others read from figure 1 of the first at 15,000 to
/// 16,656 satellites, with an error of about 20 %.
const MISSIONS: [Mission; 4] = [
    Mission {
        name: "SPHEREx",
        orbit: ("SPHEREx", SPHEREX),
        height_km: None,
        limits_deg: [Some(35.0), Some(91.0), None],
        field_deg: [3.5, 11.3],
        exposure_s: 112.5,
        trails: &[("observed", 2.18), ("predicted", 2.19)],
        streaked_percent: Some(73.3),
        source: "Borlaff et al. 2026 (SPHEREx, May to September 2025): observed 2.18 +0.11 -0.09, predicted 2.19 +0.18 -0.17 trails, \
                 73.3 % of exposures",
        reason: CATALOGUE,
    },
    Mission {
        name: "Hubble",
        orbit: ("the Hubble Space Telescope", 20_580),
        height_km: None,
        limits_deg: [None, Some(50.0), Some(7.6)],
        field_deg: [202.0 / 3600.0, 202.0 / 3600.0],
        exposure_s: 540.0,
        trails: &[("figure", 0.1)],
        streaked_percent: None,
        source: "Borlaff, Marcum & Howell 2025 (Nature, s41586-025-09759-5), figure 1",
        reason: "random pointings here and archival ones in the paper, and the catalogue",
    },
    Mission {
        name: "Xuntian",
        orbit: ("Tiangong", 48_274),
        height_km: None,
        limits_deg: [None, Some(55.0), Some(7.6)],
        field_deg: [1.05, 1.05],
        exposure_s: 540.0,
        trails: &[("figure", 3.5)],
        streaked_percent: None,
        source: "Borlaff, Marcum & Howell 2025 (Nature, s41586-025-09759-5), figure 1",
        reason: "the paper also counts satellites that the Moon or the Earth lights, and the catalogue",
    },
    Mission {
        name: "800 km, sun-synchronous",
        orbit: ("SPHEREx", SPHEREX),
        height_km: Some(800.0),
        limits_deg: [None, None, Some(55.7)],
        field_deg: [1.183, 1.183],
        exposure_s: 600.0,
        trails: &[("figure", 0.8)],
        streaked_percent: None,
        source: "Borlaff, Marcum & Howell 2025, author correction of 2026 (s41586-026-10553-0), figure 1",
        reason: CATALOGUE,
    },
];

/// Compares the trails in random exposures of the space telescopes of SPARKLES with the published numbers.
///
/// The satellites are those of `sky`, of any observer; it must have the element sets of SPHEREx, Hubble and Tiangong,
/// whose orbits the telescopes have. The exposures begin in the day from `start`. Also returns the statistics of
/// SPHEREx.
///
/// # Errors
/// An element set is missing; otherwise the errors of [`trail_statistics`].
pub fn borlaff2026(
    sky: &Sky,
    start: Epoch,
    pointings: usize,
    seed: u64,
) -> Result<(Vec<Reproduced>, TrailStatistics), Error> {
    let mut rows = Vec::new();
    let mut of_spherex = TrailStatistics::default();
    for mission in &MISSIONS {
        let observer = mission.observer(sky.elements())?;
        let [width_deg, height_deg] = mission.field_deg;
        let field = Field::rectangle_deg(width_deg, height_deg)?;
        let request = TrailRequest {
            start,
            end: seconds_after(start, DAY_S),
            pointings,
            seed,
            exposure_s: mission.exposure_s,
            field: &field,
            limit_mag: None,
            include_dark: true,
            photometry: PhotometryOptions::default(),
        };
        let found = trail_statistics(&sky.seen_from(observer), &request)?;
        rows.extend(mission.rows(&found, &request, sky.elements().len()));
        if mission.orbit.1 == SPHEREX && mission.height_km.is_none() {
            of_spherex = found;
        }
    }
    Ok((rows, of_spherex))
}

impl Mission {
    fn observer(&self, elements: &[ElementSet]) -> Result<OrbitingObserver, Error> {
        let (object, norad_id) = self.orbit;
        let set = elements.iter().find(|set| set.norad_id == NoradId(norad_id));
        let set = set.ok_or_else(|| {
            Error::new(
                ErrorKind::Missing,
                format!("the elements have no element set of {object} ({norad_id}), whose orbit is used"),
            )
            .allowing("a catalogue with it, or a file with its element set in addition")
        })?;
        let set = self.height_km.map_or_else(|| set.clone(), |height_km| sun_synchronous(set, height_km));
        let [zenith, sun, limb] = self.limits_deg.map(|limit_deg| limit_deg.map(f64::to_radians));
        let limits = PointingLimits { max_zenith_angle_rad: zenith, min_sun_angle_rad: sun, min_limb_angle_rad: limb };
        let failed = |reason| crate::passes::no_observer(self.name, &reason);
        Ok(OrbitingObserver::new(&set, EarthLimb::default()).map_err(failed)?.with_limits(limits))
    }

    fn rows(&self, found: &TrailStatistics, request: &TrailRequest<'_>, satellites: usize) -> Vec<Reproduced> {
        let limit = |name: &str, limit_deg: Option<f64>| limit_deg.map(|deg| format!("{name} angle {deg} deg"));
        let [zenith, sun, limb] = self.limits_deg;
        let limits: Vec<String> =
            [limit("largest zenith", zenith), limit("smallest Sun", sun), limit("smallest limb", limb)]
                .into_iter()
                .flatten()
                .collect();
        let assumed = format!(
            "computed for {}: {satellites} satellites, {} random pointings from {} over a day, exposures of {} s, field {:.3} by \
             {:.3} deg, {}",
            self.name,
            request.pointings,
            format_utc(request.start, 0),
            self.exposure_s,
            self.field_deg[0],
            self.field_deg[1],
            limits.join(", ")
        );
        let row = |quantity: String, unit, published, ours: Mean, scale: f64| Reproduced {
            quantity: format!("{}: {quantity}", self.name),
            unit,
            published,
            by_method: None,
            ours: scale * ours.mean,
            ours_sigma: Some(scale * ours.sigma),
            source: self.source,
            assumed: assumed.clone(),
            reason: self.reason,
        };
        let [lit, streaked] = found.trails_and_share(request.seed, None, false);
        let [with_dark, _] = found.trails_and_share(request.seed, None, true);
        let trails = self.trails.iter();
        let mut rows: Vec<Reproduced> = trails
            .map(|(kind, trails)| row(format!("trails an exposure ({kind})"), "", Some(*trails), lit, 1.0))
            .collect();
        rows.push(row("the same with satellites in shadow".to_owned(), "", None, with_dark, 1.0));
        if self.streaked_percent.is_some() {
            rows.push(row("exposures with a trail".to_owned(), "%", self.streaked_percent, streaked, 100.0));
            // The most frequent directions on both sides of the north; those with the same number of trails have one
            // mean.
            let angles = found.position_angles(false);
            for (side, from, sign) in [("west", 0, -1.0), ("east", 9, 1.0)] {
                let most = angles[from..from + 9].iter().copied().max().filter(|most| *most > 0);
                let peaks: Vec<usize> = (from..from + 9).filter(|bin| Some(angles[*bin]) == most).collect();
                if peaks.is_empty() {
                    continue;
                }
                let bin = peaks.iter().sum::<usize>() as f64 / peaks.len() as f64;
                let peak = Mean { mean: 10.0 * bin - 85.0, sigma: 5.0 };
                let quantity = format!("most frequent position angle {side} of north");
                rows.push(row(quantity, "deg", Some(sign * (90.0 - INCLINATION_DEG)), peak, 1.0));
            }
        }
        rows
    }
}

/// Returns elements of a circular sun-synchronous orbit at another height in the plane of a sun-synchronous orbit.
fn sun_synchronous(set: &ElementSet, height_km: f64) -> ElementSet {
    // n² a³ = μ
    let radius_of = |rev_day: f64| (WGS72_MU_KM3_S2 / (rev_day * std::f64::consts::TAU / DAY_S).powi(2)).cbrt();
    let radius_km = EARTH_EQUATORIAL_RADIUS_KM + height_km;
    // The node precesses at the same rate: cos i is proportional to a^3.5.
    let cosine = set.inclination_deg.to_radians().cos() * (radius_km / radius_of(set.mean_motion_rev_day)).powf(3.5);
    ElementSet {
        norad_id: NoradId(INVENTED),
        name: format!("telescope at {height_km} km").into(),
        international_designator: "".into(),
        mean_motion_rev_day: (WGS72_MU_KM3_S2 / radius_km.powi(3)).sqrt() * DAY_S / std::f64::consts::TAU,
        inclination_deg: cosine.acos().to_degrees(),
        eccentricity: 0.001,
        bstar_per_earth_radius: 0.0,
        mean_motion_dot_rev_day2: 0.0,
        ..set.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without trails on a side there is no most frequent direction, and those with the same number have one mean.
    #[test]
    fn directions_without_trails_are_omitted() {
        let field = Field::rectangle_deg(1.0, 1.0).expect("a field");
        let request = TrailRequest {
            start: Epoch::from_gregorian_utc_at_midnight(2026, 4, 25),
            end: Epoch::from_gregorian_utc_at_midnight(2026, 4, 26),
            pointings: 2,
            seed: 1,
            exposure_s: 60.0,
            field: &field,
            limit_mag: None,
            include_dark: true,
            photometry: PhotometryOptions::default(),
        };
        let mission = MISSIONS.iter().find(|mission| mission.streaked_percent.is_some()).expect("SPHEREx");
        let rows_of = |angles_deg: &[f64]| {
            let trail = |angle_deg: &f64| crate::forecast::Trail {
                orbit: crate::forecast::OrbitHeight::Low,
                lit: true,
                position_angle_rad: angle_deg.to_radians(),
                p_brighter: 0.0,
            };
            let trails = vec![angles_deg.iter().map(trail).collect(), Vec::new()];
            mission.rows(&TrailStatistics { trails, ..TrailStatistics::default() }, &request, 1)
        };
        let angles = |angles_deg: &[f64]| -> Vec<(bool, f64)> {
            let rows = rows_of(angles_deg).into_iter().filter(|row| row.quantity.contains("position angle"));
            rows.map(|row| (row.quantity.contains("west"), row.ours)).collect()
        };
        assert_eq!(angles(&[]), []);
        assert_eq!(angles(&[35.0]), [(false, 35.0)]);
        assert_eq!(angles(&[-35.0, -55.0, 15.0, 17.0, 85.0]), [(true, -45.0), (false, 15.0)]);
        let dark = rows_of(&[35.0]).into_iter().find(|row| row.quantity.contains("in shadow")).expect("a row");
        assert!(dark.published.is_none());
    }

    /// A sun-synchronous orbit at 800 km has an inclination of 98.6° (Vallado, Fundamentals of Astrodynamics, 11.4.1).
    #[test]
    fn sun_synchronous_at_another_height() {
        let epoch = Epoch::from_gregorian_utc_at_midnight(2026, 4, 25);
        let made = crate::elements::Constellation::by_name("oneweb").expect("built in").element_sets(epoch).remove(0);
        // 650 km: 14.74 revolutions a day at 97.96° (SPHEREx).
        let low = ElementSet { mean_motion_rev_day: 14.7396, inclination_deg: 97.9584, ..made };
        let high = sun_synchronous(&low, 800.0);
        assert!((high.inclination_deg - 98.6).abs() < 0.05, "{}", high.inclination_deg);
        assert!((high.mean_motion_rev_day - 14.27).abs() < 0.01, "{}", high.mean_motion_rev_day);
    }
}

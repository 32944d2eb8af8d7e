//! How likely any satellite is in an exposure, and how much streak is to be expected, however old the elements are.
//!
//! A satellite may be so early or late that its prediction stands far from the field, or on the other side of the Earth. What
//! counts is that its path leads through the field, and by which delays it does. For each satellite whose orbit plane passes the
//! field:
//!
//! 1. From the middle of the exposure along the orbit (two-body arithmetic, refined with SGP4) to the place where it passes
//!    the line of sight, and the same place some revolutions before and after, as far as 3.5 sigma reach.
//! 2. There, the exact chords of [`crossing_odds`](super::probability), or, where it may be late by more than seconds, those of a circle on the
//!    sky (`late_path`).
//!
//! Errors across the track of tens of kilometres and more (manoeuvring satellites, months after their elements) tilt the plane instead of shifting the
//! path on the sky: a satellite that is that far off its plane is still at its distance from the Earth.
//!
//! An exposure longer than half a minute is asked for in pieces, each with the site where it then is, for the site moves past many planes (by
//! up to 280 km in ten minutes). The delays that bring a satellite into the field during different pieces exclude one another: its chance is that of being in the
//! field during the first piece, and of entering it during each of the others. So a longer exposure never has less. Where an error of seconds moves
//! nothing (less than [`LONG_DELAY_S`]), the exact path is cut over all of the exposure.
//!
//! What is left out: delays beyond 3.5 sigma (0.05 % of each satellite's chance). What is simplified: the planes do not turn during the
//! delay (5° a day at most), and the site stands still before and after the exposure or its piece (up to 6 % in the number of those that enter, as it
//! moves with or against the satellites; from the second piece on that is in the chance). In exposures longer than a revolution a satellite that comes back is counted again, up to 1. For a telescope in orbit only the passes and
//! near misses of [`Sky::field_passes`] are summed.

use rayon::prelude::*;

use super::expose::ABERRATION_MARGIN_RAD;
use super::exposure::Exposure;
use super::field::Field;
use super::look::LOWEST_ALTITUDE_RAD;
use super::places::{LONG_DELAY_S, Question};
use super::probability::REACH_SIGMAS;
use super::scene::{Scene, end_s, groups};
use super::sightline::ObserverMotion;
use super::sky::{PassOptions, Sky, SkyError, check};
use super::track::FieldPass;
use super::windows::Wanted;
use crate::constants::DAY_S;
use crate::frames::{seconds_after, seconds_between};
use crate::geometry::Observer;
use crate::orbit::{Candidate, Cone, Cones, OrbitUncertainty, Reach};

/// Satellites that may be late are asked for in pieces of an exposure no longer than this, seconds: in it the site moves by 14 km at most.
const PIECE_S: f64 = 30.0;
/// From an orbit, passes less probable than this are not looked for.
const LEAST_IN_FLIGHT: f64 = 0.01;

/// One satellite that may be in one exposure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Chance {
    /// Which of the sky's element sets.
    pub element_index: usize,
    /// Probability that it is in the field at any time of the exposure, (0, 1].
    pub probability: f64,
    /// Expected length of its streak within the field, radians: the average over all its errors, 0 for those that lead past.
    pub streak_length_rad: f64,
    /// How far away it is where its path is nearest to the centre of the field, km.
    pub range_km: f64,
}

impl Sky {
    /// Every satellite that may be in each exposure while the Sun shines on it, with its probability; by exposure, in catalogue order.
    ///
    /// With fresh elements these are little more than the nominal crossings. With elements months old they are all satellites whose
    /// orbits lead through the field, each with a small chance.
    ///
    /// # Errors
    /// [`SkyError`] where an exposure has no finite length, pointing or rotation, or lies outside the years of the Sun's ephemeris.
    pub fn chances(&self, exposures: &[Exposure], field: &Field) -> Result<Vec<Vec<Chance>>, SkyError> {
        self.chances_with(exposures, field, LONG_DELAY_S)
    }

    /// The same, with circles for the paths of satellites whose error along the track is no less than `long_delay_s`.
    fn chances_with(
        &self,
        exposures: &[Exposure],
        field: &Field,
        long_delay_s: f64,
    ) -> Result<Vec<Vec<Chance>>, SkyError> {
        for exposure in exposures {
            check(exposure)?;
        }
        let Some(observer) = self.viewpoint().site() else { return self.chances_in_flight(exposures, field) };
        let mut by_exposure = vec![Vec::new(); exposures.len()];
        for group in groups(exposures) {
            let start = exposures[group[0]].start;
            let span_s = group.iter().map(|&one| end_s(start, &exposures[one])).fold(0.0, f64::max);
            let mut scene = self.scene_without_windows(start, span_s);
            let reach = |sigma: OrbitUncertainty| Reach {
                along_track_s: REACH_SIGMAS * sigma.along_track_s,
                cross_track_km: REACH_SIGMAS * sigma.cross_track_km,
            };
            scene.windows = self.windows_over(start, seconds_after(start, span_s), Wanted::Anyone, reach);
            let found: Vec<(usize, Vec<Chance>)> = group
                .par_iter()
                .map_init(Vec::new, |seen, &one| {
                    (one, self.chances_of(&scene, observer, (&exposures[one], field), long_delay_s, seen))
                })
                .collect();
            for (one, chances) in found {
                by_exposure[one] = chances;
            }
        }
        Ok(by_exposure)
    }

    /// From an orbit, where a late satellite takes another way through the field: the passes and near misses that are found there, a few
    /// minutes early or late at most.
    fn chances_in_flight(&self, exposures: &[Exposure], field: &Field) -> Result<Vec<Vec<Chance>>, SkyError> {
        let options =
            PassOptions { min_probability: Some(LEAST_IN_FLIGHT), without_light: true, ..PassOptions::default() };
        let passes = self.field_passes(exposures, field, &options)?.by_exposure;
        // The mean chord of a circle is π/2 of its radius.
        let mean_chord_rad = std::f64::consts::FRAC_PI_2 * field.bounding_radius_rad();
        let length_rad = |pass: &FieldPass, exposure: &Exposure| {
            if pass.is_crossing() {
                pass.streak_length_rad
            } else {
                mean_chord_rad.min(pass.angular_rate_rad_s * exposure.duration_s)
            }
        };
        let of = |(passes, exposure): (Vec<FieldPass>, &Exposure)| {
            let mut chances: Vec<Chance> = passes
                .iter()
                .filter(|pass| pass.lit && pass.probability > 0.0)
                .map(|pass| Chance {
                    element_index: pass.element_index,
                    probability: pass.probability,
                    streak_length_rad: pass.probability * length_rad(pass, exposure),
                    range_km: pass.mid.range_km,
                })
                .collect();
            chances.sort_by_key(|chance| chance.element_index);
            chances
        };
        Ok(passes.into_iter().zip(exposures).map(of).collect())
    }

    fn uncertainty_at(&self, element_index: usize, age_s: f64) -> OrbitUncertainty {
        self.uncertainty(element_index, age_s / DAY_S)
    }

    fn chances_of(
        &self,
        scene: &Scene,
        observer: &Observer,
        (exposure, field): (&Exposure, &Field),
        long_delay_s: f64,
        seen: &mut Vec<Candidate>,
    ) -> Vec<Chance> {
        let on_sky = field.on_sky(&exposure.pointing, exposure.rotation_rad);
        let opened_s = seconds_between(scene.start, exposure.start);
        let closed_s = opened_s + exposure.duration_s;
        let question = |opened_s: f64, closed_s: f64, only_entering: bool| {
            let mid_s = 0.5 * (opened_s + closed_s);
            let orientation = scene.orientation.at_s(mid_s);
            let earth_velocity = scene.sun.at_s(mid_s).earth_velocity;
            let site = ObserverMotion::of_site(observer, &orientation, earth_velocity, mid_s);
            Question {
                scene,
                shadow: self.shadow(),
                field: &on_sky,
                site: site.still_outside(opened_s, closed_s),
                orientation,
                opened_s,
                closed_s,
                long_delay_s,
                only_entering,
            }
        };
        // From the opening on, so that a longer exposure begins with the same pieces.
        let pieces: Vec<Question<'_>> = (0..(exposure.duration_s / PIECE_S).ceil().max(1.0) as u32)
            .map(|number| {
                let from_s = opened_s + PIECE_S * f64::from(number);
                question(from_s, closed_s.min(from_s + PIECE_S), number > 0)
            })
            .collect();
        seen.clear();
        for (number, piece) in (0..).zip(&pieces) {
            let (mid_s, half_s) = (0.5 * (piece.opened_s + piece.closed_s), 0.5 * (piece.closed_s - piece.opened_s));
            let Some((window, window_start_s)) = scene.window_at(mid_s) else { continue };
            let cone = Cone {
                mid_s: mid_s - window_start_s,
                half_duration_s: half_s,
                observer: piece.site.position(mid_s),
                observer_speed_km_s: piece.site.fastest_km_s(mid_s, half_s),
                axis: exposure.pointing,
                radius_rad: on_sky.bounding_radius_rad() + ABERRATION_MARGIN_RAD,
            };
            let cones = Cones { whole: &cone, parts: &[], first: number, shade: None };
            window.candidates(&cones, &piece.orientation.teme_to_gcrs, seen);
        }
        seen.sort_unstable_by_key(|candidate| (candidate.element_index, candidate.cone));
        let whole = question(opened_s, closed_s, false);
        let sine_of_lowest = LOWEST_ALTITUDE_RAD.sin();
        let of_one = |one: &[Candidate]| {
            let element_index = one[0].element_index as usize;
            let propagator = self.index().propagator(element_index)?;
            let age_s = seconds_between(propagator.epoch(), seconds_after(scene.start, 0.5 * (opened_s + closed_s)));
            let sigma = self.uncertainty_at(element_index, age_s);
            let asked = |question: &Question<'_>| {
                let place = question.odds(propagator, sigma)?;
                let horizon = observer.state(&question.orientation);
                let is_up = horizon.sine_of_altitude(&place.geometric) >= sine_of_lowest;
                is_up.then_some(Chance {
                    element_index,
                    probability: place.odds.probability.min(1.0),
                    streak_length_rad: place.odds.streak_length_rad,
                    range_km: place.range_km,
                })
            };
            if sigma.along_track_s < long_delay_s {
                return asked(&whole);
            }
            // Who enters in one piece does not enter in another.
            one.iter().filter_map(|seen| asked(&pieces[seen.cone as usize])).reduce(|one, other| Chance {
                probability: (one.probability + other.probability).min(1.0),
                streak_length_rad: one.streak_length_rad + other.streak_length_rad,
                ..one
            })
        };
        seen.chunk_by(|one, other| one.element_index == other.element_index).filter_map(of_one).collect()
    }
}

#[cfg(test)]
mod tests {
    use hifitime::{Epoch, Unit};

    use super::*;
    use crate::elements::{Constellation, ElementSet, Origin};
    use crate::frames::{Direction, EopTable};
    use crate::geometry::Site;
    use crate::passes::ModelChoice;
    use crate::photometry::ModelLibrary;

    /// A satellite of a shell as if it were published, some days before.
    fn aged(mut set: ElementSet, number: usize, epoch: Epoch) -> ElementSet {
        set.origin = Origin::Published;
        // Every third belongs to nobody: debris ages more slowly.
        set.name = if number.is_multiple_of(3) { "DEBRIS".into() } else { "STARLINK-1".into() };
        set.epoch = epoch;
        set
    }

    /// Exposures over half of the sky.
    fn exposures(start: Epoch) -> Vec<Exposure> {
        (0..36u32)
            .map(|number| {
                let (zenith_deg, turn) = (f64::from(number % 6) * 10.0, f64::from(number) * 2.4);
                Exposure {
                    id: number.to_string(),
                    start: seconds_after(start, 40.0 * f64::from(number)),
                    duration_s: 30.0,
                    pointing: Direction::from_lon_lat_rad(
                        (240.0 + 0.17 * f64::from(number) + zenith_deg * turn.cos() / 0.86).to_radians(),
                        (-30.0 + zenith_deg * turn.sin()).to_radians().clamp(-1.5, 1.5),
                    ),
                    rotation_rad: 0.4,
                }
            })
            .collect()
    }

    /// The slow way is the reference: exact chords of every revolution's path.
    #[test]
    fn verif_circles_in_place_of_paths_change_little() {
        /// How likely one satellite is: the bend of its path and the change of its rate within the field.
        const OF_ONE: f64 = 1e-3;
        /// Expected length of one streak, radians: 0.006° of the 3° that most are.
        const LENGTH_RAD: f64 = 1e-4;
        /// How many streaks are expected in an exposure, of their number: the errors of many cancel.
        const OF_AN_EXPOSURE: f64 = 3e-3;
        let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
        let shapes = r#"{"shapes": [{"rectangle_deg": [1.2, 2.5], "center_deg": [-0.7, 0]},
            {"rectangle_deg": [1.2, 2.5], "center_deg": [0.7, 0]}], "unit": "deg"}"#;
        let fields = [Field::circle(3.5f64.to_radians()).unwrap(), Field::from_json(shapes).unwrap()];
        let site = Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).unwrap();
        let choice = ModelChoice::new(&ModelLibrary::embedded()).unwrap();
        let mut compared = 0;
        for age_days in [10.0, 40.0, 174.0, 400.0] {
            let epoch = start - age_days * Unit::Day;
            let shells = Constellation::by_name("starlink-gen1").unwrap().element_sets(epoch);
            let elements: Vec<ElementSet> =
                shells.into_iter().step_by(5).enumerate().map(|(number, set)| aged(set, number, epoch)).collect();
            let sky = Sky::new(elements, Observer::new(site.clone()), EopTable::embedded(), &choice);
            let exposures = exposures(start);
            for field in &fields {
                let exact = sky.chances_with(&exposures, field, f64::INFINITY).unwrap();
                let fast = sky.chances(&exposures, field).unwrap();
                for (number, (exact, fast)) in exact.iter().zip(&fast).enumerate() {
                    let mut sums = [0.0, 0.0];
                    for index in 0..sky.elements().len() {
                        let of = |chances: &[Chance]| {
                            let chance = chances.iter().find(|chance| chance.element_index == index);
                            chance.map_or((0.0, 0.0), |chance| (chance.probability, chance.streak_length_rad))
                        };
                        let (one, other) = (of(exact), of(fast));
                        compared += usize::from(one.0 > 0.0 && one != other);
                        assert!((one.0 - other.0).abs() < OF_ONE, "{age_days} d, {number}: {one:?} {other:?}");
                        assert!((one.1 - other.1).abs() < LENGTH_RAD, "{age_days} d, {number}: {one:?} {other:?}");
                        sums = [sums[0] + one.0, sums[1] + other.0];
                    }
                    assert!((sums[0] - sums[1]).abs() < OF_AN_EXPOSURE * sums[0].max(0.1), "{age_days} d: {sums:?}");
                }
            }
        }
        assert!(compared > 2000, "{compared}");
    }
}

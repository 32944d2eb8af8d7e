//! Orbit planes and phases of a whole catalogue over a few hours, from which satellites inside a cone are found.
//!
//! A satellite in the field of view lies on a line of sight, at some distance from the Earth's centre. Its orbit plane
//! must pass through that point, and the satellite must be there at that time. All tests use quantities that change
//! slowly (normal of the plane, mean longitude, eccentricity vector). SGP4 gives them at both ends of the window, and
//! they are interpolated in between:
//!
//! 1. **Plane.** A point of the cone's axis at distance ρ is `|n·O + ρ n·d|` away from the orbit plane, where n is the
//!    normal of the plane, O the observer and d the axis. Other points of the cone differ from this by at most the
//!    cone's width. The satellite's shell (perigee to apogee) limits ρ to [ρ₁, ρ₂]. The expression inside the bars is
//!    linear in ρ, so it need only be computed at both ends. Satellites are sorted by shell and by plane, and processed
//!    in chunks that share ρ₁ and ρ₂. The same test with the mean plane of a chunk and the largest distance from it
//!    rejects most chunks as a whole. One or two in a hundred satellites pass this test.
//! 2. **Side.** By their mean longitudes, nine in ten of the remaining satellites are on another side of the Earth.
//! 3. **Phase.** For the rest, the interpolated elements give the velocity, and the position to some 20 km, and hence
//!    the closest approach to the line of sight during the exposure. One or two in ten thousand satellites pass this
//!    test. It is skipped for satellites with strong drag and for extreme eccentricities. Of the few satellites
//!    that cannot be interpolated, only those that are too far away by SGP4 are rejected.
//!
//! SGP4 is evaluated only for the satellites that pass. Every margin is conservative: `tests/library/crossings.rs`
//! compares the result with a search without these tests, and `verif_model_error_is_within_its_margin` compares the
//! margins with SGP4.

use hifitime::Epoch;
use nalgebra::Vector3;
use rayon::prelude::*;

use super::super::propagator::DECAYED_RADIUS_KM;
use super::super::state::State;
use super::cone::{ConePassage, ConeTest};
use super::kepler::Phase;
use super::kepler::SlowElements;
use super::side::SWING_PER_ECCENTRICITY;
use crate::error::Error;
use crate::frames::{Teme, seconds_between};
use crate::orbit::propagator::{LeftOut, Propagator, SatelliteIndex, SearchedPropagator};
use crate::watch::Watch;

/// Longest interval of one window, seconds. During six hours an orbit's node moves by at most 2.5°, and above 250 km
/// drag changes the mean longitude by less than the margin.
pub const MAX_WINDOW_S: f64 = 6.0 * 3600.0;

/// Largest angle between the orbit plane by SGP4 and the interpolated plane, radians. It is due to the short-period
/// terms at both ends of the window, 2 · 3/2 · J₂/2p² · sin I cos I, and to the curvature of the precession.
const PLANE_SLOP_RAD: f64 = 1.2e-3;

/// Largest distance, km, by which SGP4's radius is below the perigee or above the apogee of the osculating orbits at
/// the ends of the window: four times the short-period amplitude of a low orbit.
const RADIUS_SLOP_KM: f64 = 35.0;

/// Largest distance between SGP4's position and the interpolated one, as a fraction of the semi-major axis, for an
/// orbit of one Earth radius. It is due to J₂ terms, which fall with the square of the semi-major axis.
const POSITION_SLOP: f64 = 8.0e-3;

/// Largest distance due to effects that do not fall with height (lunar and solar terms, resonances), km.
const POSITION_SLOP_FLOOR_KM: f64 = 6.0;

/// Perigee distance below which drag changes the orbit within a window, km; only the plane test is used for these
/// satellites.
const DRAGGED_PERIGEE_KM: f64 = DECAYED_RADIUS_KM + 230.0;

/// Eccentricity above which the interpolated position is too inaccurate near perigee; only the plane test is used then.
const TOO_ECCENTRIC: f64 = 0.9;

/// Short-period terms in the difference of two osculating mean longitudes (radians), and in a mean motion computed from
/// two osculating semi-major axes (relative).
const LONGITUDE_NOISE_RAD: f64 = 0.02;
const RATE_NOISE: f64 = 0.01;

/// Range of perigees that count as one shell when satellites are sorted, km; small against [`RADIUS_SLOP_KM`].
const SHELL_KM: f64 = 10.0;

/// Range of the polar component of the normals in which planes are sorted by their nodes.
const BAND: f32 = 0.05;

/// Number of satellites that share one shell in the plane test; a multiple of the number of f32 in the widest vector.
pub(super) const CHUNK: usize = 64;

/// Distance from the predicted position within which a satellite is searched for with delays.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Reach {
    /// Distance along the track as a time, seconds.
    pub along_track_s: f64,
    /// Distance across the track, km.
    pub cross_track_km: f64,
}

/// One satellite before it is sorted into a chunk.
struct Entry {
    phase: Phase,
    normal: [f32; 3],
    normal_change: [f32; 3],
    lowest_km: f64,
    highest_km: f64,
    cross_track_km: f64,
}

/// Up to [`CHUNK`] satellites of similar shells, with the components of their normals as columns.
#[derive(Clone, Debug)]
pub(super) struct Chunk {
    pub lowest_km: f64,
    pub highest_km: f64,
    pub slop_km: f64,
    /// Mean of the normals at the start of the window, and its change until the end.
    pub mean_normal: [Vector3<f64>; 2],
    /// Largest distance of a normal from the mean normal of the same time.
    pub spread: f64,
    /// Columns, apart from the numbers of the whole chunk, which are read for every search.
    pub normal: Box<[[f32; CHUNK]; 3]>,
    pub normal_change: Box<[[f32; CHUNK]; 3]>,
    pub phases: Vec<Phase>,
}

/// Orbit planes and phases of a catalogue from `start` on, over at most [`MAX_WINDOW_S`].
#[derive(Clone, Debug)]
pub struct Window {
    start: Epoch,
    pub(super) span_s: f64,
    pub(super) chunks: Vec<Chunk>,
    /// Satellites that are not interpolated and always need SGP4.
    pub(super) always: Vec<Uninterpolated>,
    left_out: Vec<LeftOut>,
}

/// Satellite whose elements cannot be interpolated over a window.
#[derive(Clone, Debug)]
pub(super) struct Uninterpolated {
    pub element_index: u32,
    reach: Reach,
    /// Its propagator and the start of the window in minutes after the epoch; `None` with an ephemeris for a part of
    /// the window.
    orbit: Option<Box<(Propagator, f64)>>,
}

impl Uninterpolated {
    /// Returns the whole time interval unless the satellite is too far away; a satellite that has no position in the
    /// middle of the interval may be anywhere.
    pub fn inside(&self, test: &ConeTest<'_>) -> Option<ConePassage> {
        let along_track_s = self.reach.along_track_s as f32;
        let is_far = self.orbit.as_deref().is_some_and(|(propagator, start_minutes)| {
            let state = propagator.teme_state(start_minutes + test.mid_s() / 60.0);
            state.is_ok_and(|state| {
                !test.may_be_reached(state.position.vector(), along_track_s, self.reach.cross_track_km)
            })
        });
        (!is_far).then(|| test.anywhere(along_track_s))
    }
}

/// How one satellite is treated in the search.
enum Kind {
    Regular(Entry),
    Always(Option<Box<(Propagator, f64)>>),
    LeftOut(Box<Error>),
    Absent,
}

impl Window {
    /// Propagates every satellite to both ends of the window, on all threads (about 1 µs per satellite and core).
    ///
    /// A satellite that has an ephemeris for some of the exposures in the window is not interpolated, because ephemeris
    /// and SGP4 differ by more than the margins. Exposures longer than [`MAX_WINDOW_S`] use SGP4 only.
    ///
    /// `unknown` returns, for an element index, the reason why a satellite has no known position without an ephemeris;
    /// such a satellite is left out. `reach` returns, for an element index, the distance from the prediction within
    /// which that satellite is searched for. The margins are valid for windows of at most [`MAX_WINDOW_S`]; callers
    /// must split longer intervals.
    ///
    /// # Errors
    /// [`Cancelled`](crate::ErrorKind::Cancelled) if `watch` is stopped.
    pub fn new(
        index: &SatelliteIndex,
        start: Epoch,
        end: Epoch,
        unknown: &(dyn Fn(usize) -> Option<Error> + Sync),
        reach: &(dyn Fn(usize) -> Reach + Sync),
        watch: &Watch,
    ) -> Result<Self, Error> {
        let span_s = seconds_between(start, end).max(1.0);
        let made: Vec<Kind> = (0..index.len())
            .into_par_iter()
            .with_min_len(64)
            .map(|element_index| {
                if watch.check().is_err() {
                    return Kind::Absent;
                }
                let propagator = match index.source_over(element_index, [start, end], MAX_WINDOW_S) {
                    SearchedPropagator::Absent => return Kind::Absent,
                    SearchedPropagator::Several => return Kind::Always(None),
                    SearchedPropagator::One(propagator) => propagator,
                };
                let minutes = propagator.minutes_since_epoch(start);
                if let Some(reason) = unknown(element_index).filter(|_| !propagator.has_ephemeris()) {
                    return Kind::LeftOut(Box::new(reason));
                }
                let end_minutes = minutes + span_s / 60.0;
                let always = || Kind::Always(Some(Box::new((propagator.clone(), minutes))));
                match (propagator.teme_state(minutes), propagator.teme_state(end_minutes)) {
                    (Ok(first), Ok(last)) => entry(element_index, &first, &last, span_s, reach(element_index))
                        .map_or_else(always, Kind::Regular),
                    // A satellite without a position at either end of the window is left out. If only one end has no
                    // position, SGP4 is evaluated at each time.
                    (Err(error), Err(_)) => Kind::LeftOut(Box::new(error)),
                    _ => always(),
                }
            })
            .collect();
        watch.check()?;

        let mut window = Self { start, span_s, chunks: Vec::new(), always: Vec::new(), left_out: Vec::new() };
        let mut entries = Vec::with_capacity(made.len());
        for (element_index, kind) in made.iter().enumerate() {
            match kind {
                Kind::Regular(entry) => entries.push(entry),
                Kind::Always(orbit) => window.always.push(Uninterpolated {
                    element_index: element_index as u32,
                    reach: reach(element_index),
                    orbit: orbit.clone(),
                }),
                Kind::LeftOut(reason) => {
                    if let Some(propagator) = index.propagator(element_index) {
                        window.left_out.push(LeftOut {
                            norad_id: propagator.norad_id(),
                            element_index,
                            reason: (**reason).clone(),
                        });
                    }
                }
                Kind::Absent => {}
            }
        }
        // Thin shells are sorted by height. Thick shells (eccentric orbits) follow, sorted by perigee, so that few
        // chunks contain both kinds. Within a shell, satellites of similar inclinations are sorted by the node.
        entries.par_sort_by_cached_key(|entry| {
            let is_thick = entry.highest_km - entry.lowest_km > 200.0;
            let [x, y, z] = entry.normal;
            let (shell, band) = ((entry.lowest_km / SHELL_KM) as i32, (z / BAND).floor() as i32);
            (is_thick, shell, band, (x.atan2(-y) * 1e6) as i32)
        });
        window.chunks = entries.chunks(CHUNK).map(|entries| chunk(entries.iter().copied())).collect();
        Ok(window)
    }

    /// Returns the start of the window.
    pub fn start(&self) -> Epoch {
        self.start
    }

    /// Returns the satellites that have no position at any time of the window.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }
}

/// Computes the slowly varying elements of one satellite from its states at both ends of the window. `None` if they do
/// not describe the motion; SGP4 is then always used.
fn entry(element_index: usize, first: &State<Teme>, last: &State<Teme>, span_s: f64, reach: Reach) -> Option<Entry> {
    let reference = first.position.vector().normalize();
    let (begin, end) = (SlowElements::from_state(first, &reference)?, SlowElements::from_state(last, &reference)?);
    let eccentricity = |elements: &SlowElements| elements.eccentricity[0].hypot(elements.eccentricity[1]);
    let perigee = |elements: &SlowElements| elements.semi_major_axis_km * (1.0 - eccentricity(elements));
    let apogee = |elements: &SlowElements| elements.semi_major_axis_km * (1.0 + eccentricity(elements));
    let mut lowest_km = perigee(&begin).min(perigee(&end)) - RADIUS_SLOP_KM;
    let highest_km = apogee(&begin).max(apogee(&end)) + RADIUS_SLOP_KM;
    let dragged = lowest_km + RADIUS_SLOP_KM < DRAGGED_PERIGEE_KM;
    if dragged {
        lowest_km = DECAYED_RADIUS_KM;
    }
    // The mean of both mean motions determines the number of whole revolutions: its error from osculating terms is
    // 2e-3, which sums to a twentieth of a revolution.
    let expected = begin.mean_longitude_rad + 0.5 * (begin.mean_motion_rad_s() + end.mean_motion_rad_s()) * span_s;
    let turns = ((expected - end.mean_longitude_rad) / std::f64::consts::TAU).round();
    let change = end.mean_longitude_rad + turns * std::f64::consts::TAU - begin.mean_longitude_rad;
    // If drag terms diverge, the velocity is not the derivative of the position, and the phase test is invalid.
    let drift = (change - (expected - begin.mean_longitude_rad)).abs();
    if drift > LONGITUDE_NOISE_RAD + RATE_NOISE * (expected - begin.mean_longitude_rad).abs() {
        return None;
    }
    let semi_major_axis_km = begin.semi_major_axis_km;
    let eccentric = eccentricity(&begin).max(eccentricity(&end));
    // J₂ terms at perigee scale as a (R/a)² / (1 - e)³.
    let slop_km = POSITION_SLOP_FLOOR_KM
        + POSITION_SLOP * DECAYED_RADIUS_KM.powi(2) / semi_major_axis_km / (1.0 - eccentric).powi(3);
    let [k, h] = begin.eccentricity;
    Some(Entry {
        phase: Phase {
            element_index: element_index as u32,
            reference: [reference.x as f32, reference.y as f32, reference.z as f32],
            mean_longitude_rad: begin.mean_longitude_rad,
            mean_longitude_rate_rad_s: change / span_s,
            eccentricity: [k as f32, h as f32],
            eccentricity_change: [(end.eccentricity[0] - k) as f32, (end.eccentricity[1] - h) as f32],
            semi_major_axis_km: semi_major_axis_km as f32,
            semi_major_axis_change_km: (end.semi_major_axis_km - semi_major_axis_km) as f32,
            slop_km: (slop_km + reach.cross_track_km) as f32,
            along_track_s: reach.along_track_s as f32,
            swing_rad: (SWING_PER_ECCENTRICITY * eccentric) as f32,
            only_plane: dragged || eccentric > TOO_ECCENTRIC,
        },
        normal: begin.normal.map(|component| component as f32).into(),
        normal_change: (end.normal - begin.normal).map(|component| component as f32).into(),
        // An error across the track may be radial, upwards or downwards.
        lowest_km: lowest_km - reach.cross_track_km,
        highest_km: highest_km + reach.cross_track_km,
        cross_track_km: reach.cross_track_km,
    })
}

fn chunk<'a>(entries: impl ExactSizeIterator<Item = &'a Entry> + Clone) -> Chunk {
    let mut chunk = Chunk {
        lowest_km: f64::INFINITY,
        highest_km: 0.0,
        slop_km: 0.0,
        mean_normal: [Vector3::zeros(); 2],
        spread: 0.0,
        normal: Box::new([[0.0; CHUNK]; 3]),
        normal_change: Box::new([[0.0; CHUNK]; 3]),
        phases: Vec::with_capacity(entries.len()),
    };
    for (lane, entry) in entries.enumerate() {
        chunk.lowest_km = chunk.lowest_km.min(entry.lowest_km);
        chunk.highest_km = chunk.highest_km.max(entry.highest_km);
        chunk.slop_km = chunk.slop_km.max(PLANE_SLOP_RAD * entry.highest_km + entry.cross_track_km);
        for axis in 0..3 {
            chunk.normal[axis][lane] = entry.normal[axis];
            chunk.normal_change[axis][lane] = entry.normal_change[axis];
        }
        chunk.phases.push(entry.phase);
    }
    let count = chunk.phases.len();
    let normals_at = |fraction: f64| (0..count).map(move |lane| (lane, fraction));
    let normal = |(lane, fraction)| chunk.normal_at(lane, fraction);
    let [start, end] = [0.0, 1.0].map(|fraction| normals_at(fraction).map(normal).sum::<Vector3<f64>>() / count as f64);
    // Normals and their mean are linear in time, so their distance is largest at one end.
    let from = |mean: Vector3<f64>, fraction| normals_at(fraction).map(move |at| (normal(at) - mean).norm());
    chunk.spread = from(start, 0.0).chain(from(end, 1.0)).fold(0.0, f64::max);
    chunk.mean_normal = [start, end - start];
    chunk
}

impl Chunk {
    /// Returns the interpolated normal. It is the chord of an arc and therefore too short, by at most 1e-4; this
    /// amounts to 0.7 km, which the margin includes.
    pub fn normal_at(&self, lane: usize, fraction: f64) -> Vector3<f64> {
        let component =
            |axis: usize| f64::from(self.normal[axis][lane]) + fraction * f64::from(self.normal_change[axis][lane]);
        Vector3::new(component(0), component(1), component(2))
    }
}

#[cfg(test)]
mod tests {
    use super::super::cone::{Cone, Cones, SearchScope};
    use super::super::side::Cap;
    use super::*;
    use crate::constants::WGS72_MU_KM3_S2;
    use crate::elements::{ElementSet, NoradId, Origin};
    use crate::frames::{Direction, Gcrs, Position, Rotation, seconds_after};
    use crate::orbit::DragModel;

    fn element_set(norad_id: u32, altitude_km: f64, eccentricity: f64, inclination_deg: f64) -> ElementSet {
        let a = 6378.137 + altitude_km;
        let turn = f64::from(norad_id) * 137.508;
        ElementSet {
            norad_id: NoradId(norad_id),
            name: "".into(),
            international_designator: "".into(),
            epoch: Epoch::from_gregorian_utc_at_noon(2026, 4, 20),
            mean_motion_rev_day: (WGS72_MU_KM3_S2 / a.powi(3)).sqrt() * 86_400.0 / std::f64::consts::TAU,
            eccentricity,
            inclination_deg,
            right_ascension_of_node_deg: turn.rem_euclid(360.0),
            argument_of_perigee_deg: (turn * 1.7).rem_euclid(360.0),
            mean_anomaly_deg: (turn * 2.3).rem_euclid(360.0),
            bstar_per_earth_radius: 1e-4,
            mean_motion_dot_rev_day2: 0.0,
            mean_motion_ddot_rev_day3: 0.0,
            revolution_at_epoch: 0,
            decayed: None,
            origin: Origin::Synthetic,
        }
    }

    /// Orbits of every kind: low to geosynchronous and beyond, circular to Molniya, equatorial to retrograde.
    fn orbits() -> Vec<ElementSet> {
        let mut orbits = Vec::new();
        for altitude_km in [300.0, 420.0, 550.0, 780.0, 1200.0, 2500.0, 8000.0, 20_200.0, 35_786.0, 60_000.0] {
            for eccentricity in [0.0001_f64, 0.002, 0.02, 0.1, 0.3, 0.7, 0.85] {
                for inclination_deg in [0.01, 28.5, 53.0, 63.4, 86.4, 97.6, 140.0] {
                    if (6378.137 + altitude_km) * (1.0 - eccentricity) > 6650.0 {
                        orbits.push(element_set(
                            900_000_000 + orbits.len() as u32,
                            altitude_km,
                            eccentricity,
                            inclination_deg,
                        ));
                    }
                }
            }
        }
        orbits
    }

    /// The three margins of the search hold against SGP4 over a whole window, with a third of each to spare.
    #[test]
    fn verif_model_error_is_within_its_margin() {
        let elements = orbits();
        let index = SatelliteIndex::new(&elements, DragModel::Published);
        let start = Epoch::from_gregorian_utc_at_midnight(2026, 4, 26);
        let end = seconds_after(start, MAX_WINDOW_S);
        let window = Window::new(&index, start, end, &|_| None, &|_| Reach::default(), &Watch::default()).unwrap();
        let mut checked = 0;
        let mut worst = [0.0_f64; 3];
        for chunk in &window.chunks {
            for (lane, phase) in chunk.phases.iter().enumerate().filter(|(_, phase)| !phase.only_plane) {
                let element_index = phase.element_index as usize;
                let propagator = index.propagator(element_index).expect("made");
                for step in 0..=90 {
                    let time_s = MAX_WINDOW_S * f64::from(step) / 90.0;
                    let fraction = time_s / MAX_WINDOW_S;
                    let truth =
                        propagator.teme_state(propagator.minutes_since_epoch(start) + time_s / 60.0).expect("in orbit");
                    let normal = chunk.normal_at(lane, fraction);
                    let (interpolated, _) = phase.state(&normal, time_s, fraction);
                    let position = truth.position.vector();
                    let radius_km = position.norm();
                    let ratios = [
                        normal.dot(position).abs() / (PLANE_SLOP_RAD * radius_km),
                        (interpolated - position).norm() / f64::from(phase.slop_km),
                        (radius_km - highest(phase)).max(lowest(phase) - radius_km) / RADIUS_SLOP_KM,
                    ];
                    // A narrow cone straight up to the satellite: the cap of the cone must contain it without
                    // additional margins.
                    let up = position.normalize();
                    let height_km = radius_km - DECAYED_RADIUS_KM;
                    let cap = Cap::from_cone(
                        &(up * DECAYED_RADIUS_KM),
                        &up,
                        1e-6,
                        [height_km - 0.1, height_km + 0.1],
                        radius_km,
                    );
                    let slop_km = f64::from(phase.slop_km);
                    assert!(cap.expect("a cap").may_hold(phase, &normal, time_s, 0.0, slop_km));
                    for (worst, ratio) in worst.iter_mut().zip(ratios) {
                        *worst = worst.max(ratio);
                    }
                    assert!(
                        ratios.iter().all(|ratio| *ratio < 0.67),
                        "{:?} at {time_s} s: fraction of the margins for plane, position, radius {ratios:?}",
                        elements[element_index]
                    );
                    checked += 1;
                }
            }
        }
        assert!(checked > 20_000, "only {checked} positions were checked; worst {worst:?}");
    }

    /// A satellite that decays within the window is found where it passes before, and not on the other side of the
    /// Earth.
    #[test]
    fn a_satellite_that_decays_in_the_window_is_found_where_it_is() {
        let start = Epoch::from_gregorian_utc_at_midnight(2026, 4, 26);
        let decayed = Some(seconds_after(start, 3.0 * 3600.0));
        let elements = [ElementSet { decayed, ..element_set(900_000_001, 400.0, 0.001, 53.0) }];
        let index = SatelliteIndex::new(&elements, DragModel::Published);
        let end = seconds_after(start, MAX_WINDOW_S);
        let reach = Reach { along_track_s: 200.0, cross_track_km: 5.0 };
        let window = Window::new(&index, start, end, &|_| None, &|_| reach, &Watch::default()).unwrap();
        let propagator = index.propagator(0).expect("made");
        let to_gcrs = Rotation::<Teme, Gcrs>::from_matrix(nalgebra::Matrix3::identity());
        // Exposure of 30 s of the position where the satellite passes at `passes_s`, `early_s` before that.
        let found = |passes_s: f64, early_s: f64| {
            let minutes = propagator.minutes_since_epoch(start) + passes_s / 60.0;
            let up = propagator.teme_state(minutes).expect("in orbit").position.vector().normalize();
            let cone = Cone {
                mid_s: passes_s - early_s,
                half_duration_s: 15.0,
                observer: Position::from_vector(up * DECAYED_RADIUS_KM),
                observer_speed_km_s: 0.46,
                axis: Direction::from_vector(up),
                radius_rad: 0.03,
            };
            let mut found = Vec::new();
            let cones = Cones { whole: &cone, parts: &[], first: 0, shadow: None, scope: SearchScope::Delayed };
            window.candidates(&cones, &to_gcrs, &mut found);
            found
        };
        for early_s in [0.0, 190.0, -190.0] {
            let [candidate] = found(3600.0, early_s)[..] else { panic!("{early_s} s early: not found") };
            let [from_s, to_s] = candidate.near_s.map(f64::from);
            assert_eq!([from_s, to_s], [-215.0, 215.0], "{early_s} s early");
        }
        // Half a revolution before it is on the other side of the Earth.
        assert_eq!(found(3600.0, 2700.0), []);
    }

    fn lowest(phase: &Phase) -> f64 {
        extreme(phase, -1.0).into_iter().fold(f64::INFINITY, f64::min)
    }

    fn highest(phase: &Phase) -> f64 {
        extreme(phase, 1.0).into_iter().fold(0.0, f64::max)
    }

    fn extreme(phase: &Phase, sign: f64) -> [f64; 2] {
        [0.0, 1.0].map(|fraction: f64| {
            let [k, h] = [0, 1].map(|axis| {
                f64::from(phase.eccentricity[axis]) + fraction * f64::from(phase.eccentricity_change[axis])
            });
            (f64::from(phase.semi_major_axis_km) + fraction * f64::from(phase.semi_major_axis_change_km))
                * (1.0 + sign * k.hypot(h))
        })
    }
}

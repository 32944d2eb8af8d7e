//! Interpolated ephemeris of one satellite: states in TEME, and errors from the covariance.
//!
//! Position and velocity at a time are those of the Lagrange polynomial of degree 7 through the positions of the eight
//! states around it. Its error between states of step h on a circular orbit of radius r and rate ω is
//!
//! ```text
//! r (ωh)⁸ / 8! · Π |t - tᵢ| / h⁸ ≤ 1.1·10⁻³ r (ωh)⁸
//! ```
//!
//! and twelve times as much in the first and last interval: 1 mm at 550 km and steps of 120 s, 1 m (9 m at the ends) at
//! the longest step, a twentieth of a revolution. Longer steps are gaps, across which nothing is interpolated.
//! Velocities of the file are not used: in the public Starlink ephemerides they differ from the derivative of the
//! positions by 4.5 m/s after the second day, 0.3 km at the ends of a Hermite polynomial.

use std::f64::consts::TAU;
use std::sync::Arc;

use hifitime::{Epoch, TimeScale, Unit};
use nalgebra::{Matrix3, Vector3};

use super::lateness::Lateness;
use super::state::State;
use super::uncertainty::OrbitUncertainty;
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::elements::{CovarianceAxes, Ephemeris, EphemerisFrame, EphemerisState, PositionCovariance};
use crate::frames::{EopTable, OrientationTable, Position, Teme, Velocity, eme2000_to_gcrs, seconds_between};

/// Number of states of the polynomial.
const NODES: usize = 8;
/// Longest step between two states across which positions are interpolated, as an angle about the Earth's centre.
const LONGEST_STEP_RAD: f64 = TAU / 20.0;
/// Error of interpolation and frames, km, added to the covariance.
const INTERPOLATION_KM: f64 = 0.01;
/// Errors of an ephemeris without a covariance, km: those of an element set at its epoch.
const ALONG_UNSTATED_KM: f64 = 1.0;
const CROSS_UNSTATED_KM: f64 = 0.3;

/// States of one ephemeris in TEME, ready for interpolation.
#[derive(Clone, Debug)]
pub(super) struct EphemerisTable {
    start: Epoch,
    /// Times of the states, UTC seconds after the start without leap seconds, as SGP4 counts.
    times_s: Vec<f64>,
    /// Positions, km.
    positions: Vec<Vector3<f64>>,
    /// Index of the first state after each gap, and the number of states.
    ends: Vec<usize>,
    /// Times and variances: radial, along the track, out of the plane, km².
    variances: Vec<(f64, [f64; 3])>,
}

impl EphemerisTable {
    /// Transforms an ephemeris to TEME.
    pub fn new(ephemeris: &Ephemeris, eop: &EopTable) -> Self {
        let (start, end) = ephemeris.interval();
        let axes = Axes { frame: ephemeris.frame, orientation: OrientationTable::new(start, end, eop) };
        let states: Vec<_> = ephemeris.states.iter().map(|state| axes.to_teme(state)).collect();
        let times_s: Vec<f64> = ephemeris.states.iter().map(|state| utc_seconds(start, state.epoch)).collect();
        let is_gap = |index: usize| {
            let (r, v) = &states[index - 1];
            (times_s[index] - times_s[index - 1]) * r.cross(v).norm() > LONGEST_STEP_RAD * r.norm_squared()
        };
        let mut ends: Vec<usize> = (1..states.len()).filter(|&index| is_gap(index)).collect();
        ends.push(states.len());
        let positions = states.into_iter().map(|(position, _)| position).collect();
        let mut table = Self { start, times_s, positions, ends, variances: Vec::new() };
        table.variances = ephemeris.covariances.iter().map(|one| table.variances_of(one, &axes)).collect();
        table
    }

    /// Returns the time of the first state.
    pub fn start(&self) -> Epoch {
        self.start
    }

    /// Returns true if the states cover an interval without a gap, seconds after the start.
    pub fn covers(&self, from_s: f64, to_s: f64) -> bool {
        let covering = |part: std::ops::Range<usize>| {
            part.len() >= NODES && self.times_s[part.start] <= from_s && to_s <= self.times_s[part.end - 1]
        };
        self.parts().any(covering)
    }

    /// Returns true if a part of an interval is covered.
    pub fn overlaps(&self, from_s: f64, to_s: f64) -> bool {
        from_s <= self.times_s[self.times_s.len() - 1] && to_s >= self.times_s[0]
    }

    /// Index ranges of the states between gaps.
    fn parts(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| start..end)
    }

    /// Returns the state at a time, seconds after the start; `None` outside the covered intervals.
    pub fn state_at(&self, time_s: f64) -> Option<State<Teme>> {
        // A time at the end of an interval rounds beyond it by less than a microsecond.
        let after = self.times_s.partition_point(|time| *time < time_s - 1e-6);
        let part = self.parts().find(|part| part.contains(&after))?;
        if part.len() < NODES || time_s < self.times_s[part.start] - 1e-6 {
            return None;
        }
        let first = after.saturating_sub(NODES / 2).clamp(part.start, part.end - NODES);
        let nodes = first..first + NODES;
        let (position, velocity) = lagrange(&self.times_s[nodes.clone()], &self.positions[nodes], time_s);
        Some(State { position: Position::from_vector(position), velocity: Velocity::from_vector(velocity) })
    }

    /// Returns the errors of one sigma at a covered time, seconds after the start.
    pub fn uncertainty_at(&self, time_s: f64) -> OrbitUncertainty {
        let speed_km_s = self.state_at(time_s).map_or(f64::INFINITY, |state| state.velocity.norm_km_s());
        let [along_km, cross_km] = match self.variance_at(time_s) {
            // One sigma for both directions across the track: the larger one.
            Some([radial, along, normal]) => {
                [along, radial.max(normal)].map(|variance_km2| variance_km2.sqrt().hypot(INTERPOLATION_KM))
            }
            None => [ALONG_UNSTATED_KM, CROSS_UNSTATED_KM],
        };
        let along_track_s = along_km / speed_km_s;
        OrbitUncertainty { along_track_s, cross_track_km: cross_km, lateness: Lateness::gaussian(along_track_s) }
    }

    /// Returns the largest errors of one sigma at any time: seconds along the track, kilometres across it.
    pub fn largest_errors(&self) -> (f64, f64) {
        let errors = self.times_s.iter().map(|time_s| self.uncertainty_at(*time_s));
        errors.fold((0.0, 0.0), |(along_s, cross_km): (f64, f64), one| {
            (along_s.max(one.along_track_s), cross_km.max(one.cross_track_km))
        })
    }

    /// Interpolates the variances linearly; beyond their ends they are constant.
    fn variance_at(&self, time_s: f64) -> Option<[f64; 3]> {
        let after = self.variances.partition_point(|(time, _)| *time <= time_s);
        let (before, next) = (self.variances.get(after.wrapping_sub(1)), self.variances.get(after));
        match (before, next) {
            (Some((from_s, from)), Some((to_s, to))) => {
                let share = (time_s - from_s) / (to_s - from_s);
                Some(std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])))
            }
            (one, other) => one.or(other).map(|(_, variances)| *variances),
        }
    }

    /// Returns the time of a covariance and its variances: radial, along the track, out of the plane, km².
    fn variances_of(&self, covariance: &PositionCovariance, axes: &Axes) -> (f64, [f64; 3]) {
        let [xx, yx, yy, zx, zy, zz] = covariance.terms_km2;
        let time_s = utc_seconds(self.start, covariance.epoch);
        let variances = match covariance.axes {
            CovarianceAxes::Radial => [xx, yy, zz],
            CovarianceAxes::Tangential => [yy, xx, zz],
            CovarianceAxes::States => {
                let terms = Matrix3::new(xx, yx, zx, yx, yy, zy, zx, zy, zz);
                let to_teme = axes.rotation(covariance.epoch);
                // A covariance outside the states, or in a gap, has the axes at the nearest node.
                let nearest = self.times_s.partition_point(|time| *time < time_s).clamp(1, self.positions.len() - 1);
                let at_nearest = || {
                    let (before, after) = (self.positions[nearest - 1], self.positions[nearest]);
                    (after, after - before)
                };
                let state = self
                    .state_at(time_s)
                    .map_or_else(at_nearest, |state| (*state.position.vector(), *state.velocity.vector()));
                let (radial, normal) = (state.0.normalize(), state.0.cross(&state.1).normalize());
                [radial, normal.cross(&radial), normal].map(|axis| {
                    let axis = to_teme.transpose() * axis;
                    axis.dot(&(terms * axis))
                })
            }
        };
        // The least eigenvalue may be negative by rounding.
        (time_s, variances.map(|variance| variance.max(0.0)))
    }
}

/// Returns the UTC seconds between two epochs, leap seconds not counted, as SGP4 counts its minutes.
fn utc_seconds(start: Epoch, epoch: Epoch) -> f64 {
    (epoch.to_duration_in_time_scale(TimeScale::UTC) - start.to_duration_in_time_scale(TimeScale::UTC))
        .to_unit(Unit::Second)
}

/// Axes of an ephemeris.
struct Axes {
    frame: EphemerisFrame,
    orientation: OrientationTable,
}

impl Axes {
    /// Returns the matrix to TEME at a time.
    fn rotation(&self, epoch: Epoch) -> Matrix3<f64> {
        let orientation = self.orientation.at_s(seconds_between(self.orientation.reference(), epoch));
        let from_gcrs = orientation.teme_to_gcrs.inverse();
        match self.frame {
            EphemerisFrame::Eme2000 => *(from_gcrs * eme2000_to_gcrs()).matrix(),
            EphemerisFrame::Gcrf => *from_gcrs.matrix(),
            EphemerisFrame::Teme => Matrix3::identity(),
            EphemerisFrame::Itrf => *orientation.itrs_to_teme.matrix(),
        }
    }

    /// Returns position and velocity in TEME.
    fn to_teme(&self, state: &EphemerisState) -> (Vector3<f64>, Vector3<f64>) {
        let to_teme = self.rotation(state.epoch);
        let position = to_teme * Vector3::from(state.position_km);
        let mut velocity = to_teme * Vector3::from(state.velocity_km_s);
        if self.frame == EphemerisFrame::Itrf {
            // v = R v' + ω × r
            velocity += Vector3::z().cross(&position) * EARTH_ROTATION_RAD_S;
        }
        (position, velocity)
    }
}

/// Returns value and derivative of the polynomial through some positions, by Newton's divided differences.
fn lagrange(times_s: &[f64], positions: &[Vector3<f64>], time_s: f64) -> (Vector3<f64>, Vector3<f64>) {
    let mut differences: [Vector3<f64>; NODES] = std::array::from_fn(|node| positions[node]);
    for order in 1..NODES {
        for node in (order..NODES).rev() {
            differences[node] = (differences[node] - differences[node - 1]) / (times_s[node] - times_s[node - order]);
        }
    }
    let (mut value, mut slope) = (differences[NODES - 1], Vector3::zeros());
    for node in (0..NODES - 1).rev() {
        let since_s = time_s - times_s[node];
        slope = slope * since_s + value;
        value = value * since_s + differences[node];
    }
    (value, slope)
}

/// An ephemeris attached to a satellite with an element set.
#[derive(Clone, Debug)]
pub(super) struct Attached {
    pub table: Arc<EphemerisTable>,
    /// Minutes from the epoch of the element set to the start of the table.
    pub start_minutes: f64,
}

impl Attached {
    /// Returns the seconds after the start of the table.
    pub fn seconds(&self, minutes: f64) -> f64 {
        (minutes - self.start_minutes) * 60.0
    }
}

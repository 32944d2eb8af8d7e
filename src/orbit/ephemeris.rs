//! Interpolated ephemeris of one satellite: states in TEME, and errors from the covariance.
//!
//! The velocities of the file are not used: in the public Starlink ephemerides they differ from the derivative of the
//! positions by 4.5 m/s after the second day, which would be an error of 0.3 km at the ends of a Hermite polynomial.
//! The states of the polynomial are chosen in [`nodes`](super::nodes).

use std::fmt;
use std::sync::Arc;

use hifitime::{Duration, Epoch, TimeScale, Unit};
use nalgebra::{Matrix3, Vector3};

use super::lateness::Lateness;
use super::nodes::{NODES, chosen_nodes, gap_reason, lagrange};
use super::state::State;
use super::uncertainty::{OrbitClass, OrbitUncertainty, uncertainty};
use crate::constants::DAY_S;
use crate::elements::{CovarianceAxes, Ephemeris, EphemerisFrame, EphemerisState, PositionCovariance};
use crate::frames::{EopTable, OrientationTable, Position, Teme, Velocity, eme2000_to_gcrs, seconds_between};

/// Error of interpolation and frames, km, added in quadrature to the errors from the covariance.
const INTERPOLATION_KM: f64 = 0.01;
/// Positions are computed for this time before and after an exposure, seconds: the longest delay that is searched, and
/// a minute for tracks.
pub(super) const EPHEMERIS_MARGIN_S: f64 = Lateness::LONGEST_S + 60.0;
/// Largest difference of two ephemerides of one message at the same time, km. Beyond it they contradict each other.
const LARGEST_CONTRADICTION_KM: f64 = 1.0;

/// States of one ephemeris in TEME, ready for interpolation.
#[derive(Clone, Debug)]
pub(super) struct EphemerisTable {
    /// Name of the file.
    file: Arc<str>,
    /// Time at which the file was created; `None` if omitted.
    created: Option<Epoch>,
    start: Epoch,
    /// Interval that the ephemeris is for, seconds after the start.
    usable_s: [f64; 2],
    /// Interval of the states, seconds after the start. States outside `usable_s` are used for late and early
    /// satellites, which are on the same track.
    reach_s: [f64; 2],
    /// Times of the states, UTC seconds after the start without leap seconds, as SGP4 counts.
    times_s: Vec<f64>,
    /// Positions, km.
    positions: Vec<Vector3<f64>>,
    /// States of the polynomial between each state and the next one.
    nodes: Vec<[u32; NODES]>,
    /// First gap between two states at or after each state, as the index of the state before the gap; the number of
    /// states if there is no gap.
    next_gap: Vec<usize>,
    /// Times and variances: radial, along the track, out of the plane, km².
    variances: Vec<(f64, [f64; 3])>,
}

impl EphemerisTable {
    /// Transforms an ephemeris to TEME.
    pub fn new(ephemeris: &Ephemeris, eop: &EopTable) -> Self {
        let (start, end) = (ephemeris.states[0].epoch, ephemeris.states[ephemeris.states.len() - 1].epoch);
        let (from, to) = ephemeris.interval();
        let usable_s = [utc_seconds(start, from), utc_seconds(start, to)];
        let axes = Axes { frame: ephemeris.frame, orientation: OrientationTable::new(start, end, eop) };
        let positions: Vec<_> = ephemeris.states.iter().map(|state| axes.to_teme(state)).collect();
        let times_s: Vec<f64> = ephemeris.states.iter().map(|state| utc_seconds(start, state.epoch)).collect();
        let chosen = chosen_nodes(&times_s, &positions);
        let mut next_gap = vec![times_s.len(); chosen.len()];
        for at in (0..chosen.len()).rev() {
            let later = next_gap.get(at + 1).copied().unwrap_or(times_s.len());
            next_gap[at] = if chosen[at].is_none() { at } else { later };
        }
        let nodes = chosen.into_iter().map(|nodes| nodes.unwrap_or([0; NODES])).collect();
        let (file, created, variances) = (ephemeris.file.clone(), ephemeris.created, Vec::new());
        let reach_s = [times_s[0].min(usable_s[0]), times_s[times_s.len() - 1].max(usable_s[1])];
        let mut table =
            Self { file, created, start, usable_s, reach_s, times_s, positions, nodes, next_gap, variances };
        table.variances =
            ephemeris.covariances.iter().map(|covariance| table.variances_of(covariance, &axes)).collect();
        table
    }

    /// Returns the name of the file.
    pub fn file(&self) -> &Arc<str> {
        &self.file
    }

    /// Returns the sort key of this ephemeris among several of a satellite; the one with the largest key is preferred.
    /// The key is the creation time (the time of the first state if it is omitted), then the time of the first state.
    /// The name of the file decides between equal times, so that the order of reading does not matter.
    pub fn rank(&self) -> (Duration, Duration, Arc<str>) {
        let utc = |epoch: Epoch| epoch.to_utc_duration();
        (utc(self.created.unwrap_or(self.start)), utc(self.start), self.file.clone())
    }

    /// Returns the time of the first state.
    pub fn start(&self) -> Epoch {
        self.start
    }

    /// Returns true if the ephemeris is for an interval and its states cover it without a gap, seconds after the start.
    pub fn covers(&self, from_s: f64, to_s: f64) -> bool {
        self.covers_within(self.usable_s, from_s, to_s)
    }

    /// Returns true if positions can be computed in a whole interval, seconds after the start.
    fn reaches(&self, from_s: f64, to_s: f64) -> bool {
        self.covers_within(self.reach_s, from_s, to_s)
    }

    fn covers_within(&self, limits_s: [f64; 2], from_s: f64, to_s: f64) -> bool {
        let last = self.nodes.len() - 1;
        if from_s < limits_s[0] || to_s > limits_s[1] {
            return false;
        }
        let first = self.times_s.partition_point(|time| *time <= from_s).saturating_sub(1).min(last);
        let until = self.times_s.partition_point(|time| *time < to_s).saturating_sub(1).min(last);
        self.next_gap[first] > until.max(first)
    }

    /// Returns the longest covered interval around another one, seconds after the start; `None` if that one is not
    /// covered.
    pub fn covered_around(&self, inner_s: [f64; 2]) -> Option<[f64; 2]> {
        self.covered_within(self.usable_s, inner_s)
    }

    fn covered_within(&self, limits_s: [f64; 2], [from_s, to_s]: [f64; 2]) -> Option<[f64; 2]> {
        if !self.covers_within(limits_s, from_s, to_s) {
            return None;
        }
        let last = self.nodes.len() - 1;
        let step = self.times_s.partition_point(|time| *time <= from_s).saturating_sub(1).min(last);
        let is_gap = |step: &usize| self.next_gap[*step] == *step;
        let first_s = (0..step).rev().find(is_gap).map_or(f64::NEG_INFINITY, |gap| self.times_s[gap + 1]);
        let end_s = self.times_s.get(self.next_gap[step]).copied().unwrap_or(f64::INFINITY);
        Some([first_s.max(limits_s[0]), end_s.min(limits_s[1])])
    }

    /// Returns the description of the first gap between states in an interval, with its reason; `None` without a gap.
    pub fn gap_in(&self, [from_s, to_s]: [f64; 2]) -> Option<String> {
        let (times_s, positions) = (&self.times_s, &self.positions);
        let is_in = |&step: &usize| self.next_gap[step] == step && times_s[step] <= to_s && times_s[step + 1] >= from_s;
        let step = (0..self.nodes.len()).find(is_in)?;
        let epoch = |index: usize| (self.start + times_s[index] * Unit::Second).to_time_scale(TimeScale::UTC);
        let reason = gap_reason(times_s, positions, step, epoch);
        Some(format!("gap from {} to {}: {reason}", epoch(step), epoch(step + 1)))
    }

    /// Returns the ends of the intervals that the ephemeris is for, of its states and of its gaps, seconds after the
    /// start.
    fn ends_s(&self) -> impl Iterator<Item = f64> + '_ {
        let gaps = (0..self.nodes.len()).filter(|step| self.next_gap[*step] == *step);
        let of_gaps = gaps.flat_map(|step| [self.times_s[step], self.times_s[step + 1]]);
        self.usable_s.into_iter().chain(self.reach_s).chain(of_gaps)
    }

    /// Returns the seconds from the start to a time, as SGP4 counts them.
    pub fn seconds_at(&self, epoch: Epoch) -> f64 {
        utc_seconds(self.start, epoch)
    }

    /// Returns true if a part of an interval is covered.
    pub fn overlaps(&self, from_s: f64, to_s: f64) -> bool {
        from_s <= self.usable_s[1] && to_s >= self.usable_s[0]
    }

    /// Returns the state at a time, seconds after the start; `None` outside the covered intervals.
    pub fn state_at(&self, time_s: f64) -> Option<State<Teme>> {
        // Rounding moves a time at the end of an interval beyond it by less than a microsecond.
        const ROUNDING_S: f64 = 1e-6;
        if time_s < self.reach_s[0] - ROUNDING_S || time_s > self.reach_s[1] + ROUNDING_S {
            return None;
        }
        let after = self.times_s.partition_point(|time| *time < time_s - ROUNDING_S);
        let is_at_state = self.times_s.get(after).is_some_and(|time| *time <= time_s + ROUNDING_S);
        let is_covered = |&step: &usize| self.next_gap.get(step).is_some_and(|gap| *gap > step);
        // At the time of a state, the step after it is used if the step before it is a gap or missing.
        let before = after.checked_sub(1).filter(|_| after < self.times_s.len());
        let step = before.filter(is_covered).or(is_at_state.then_some(after).filter(is_covered))?;
        let nodes = self.nodes[step].map(|node| node as usize);
        let (position, velocity) =
            lagrange(nodes.map(|node| self.times_s[node]), nodes.map(|node| self.positions[node]), time_s);
        Some(State { position: Position::from_vector(position), velocity: Velocity::from_vector(velocity) })
    }

    /// Returns true if another ephemeris of the same message is for the same time, but for another orbit.
    pub fn contradicts(&self, other: &Self) -> bool {
        let [own, others] = [(0.0, self), (utc_seconds(self.start, other.start), other)];
        let from_s = (own.0 + self.usable_s[0]).max(others.0 + other.usable_s[0]);
        let to_s = (own.0 + self.usable_s[1]).min(others.0 + other.usable_s[1]);
        let is_same_message = self.file == other.file && self.created == other.created;
        // Adjoining ephemerides have one time in common.
        is_same_message
            && to_s > from_s
            && [0.25, 0.5, 0.75].iter().any(|share| {
                let time_s = from_s + share * (to_s - from_s);
                let [Some(first), Some(second)] =
                    [own, others].map(|(start_s, table)| table.state_at(time_s - start_s))
                else {
                    return false;
                };
                (first.position.vector() - second.position.vector()).norm() > LARGEST_CONTRADICTION_KM
            })
    }

    /// Returns the errors of one sigma at a covered time, seconds after the start, for a satellite of this class.
    ///
    /// Without covariances, they are those of an element set of the satellite with its epoch at the first state, and
    /// the distribution of the delay is a Gaussian about 0. Before the first covariance and after the last one, each
    /// error is the larger of this value and the one from the nearest covariance.
    pub fn uncertainty_at(&self, time_s: f64, class: OrbitClass) -> OrbitUncertainty {
        let speed_km_s = self.state_at(time_s).map_or(f64::INFINITY, |state| state.velocity.norm_km_s());
        // One sigma for both directions across the track: the larger one.
        let of = |[radial, along, normal]: [f64; 3]| {
            let [along_km, cross_km] =
                [along, radial.max(normal)].map(|variance_km2| variance_km2.sqrt().hypot(INTERPOLATION_KM));
            (along_km / speed_km_s, cross_km)
        };
        let unstated = || {
            let errors = uncertainty(class, time_s / DAY_S);
            (errors.along_track_s, errors.cross_track_km)
        };
        let (along_track_s, cross_track_km) = match self.variance_at(time_s) {
            Variance::Stated(variances) => of(variances),
            Variance::Outside(variances) => {
                let (stated, unstated) = (of(variances), unstated());
                (stated.0.max(unstated.0), stated.1.max(unstated.1))
            }
            Variance::Unstated => unstated(),
        };
        OrbitUncertainty { along_track_s, cross_track_km, lateness: Lateness::gaussian(along_track_s) }
    }

    /// Returns the largest errors of one sigma at any time: seconds along the track, kilometres across it.
    pub fn largest_errors(&self, class: OrbitClass) -> (f64, f64) {
        // Between these times the errors are at most those at one of the two ends.
        let ends = [self.variances.first(), self.variances.last()].into_iter().flatten();
        let beyond = ends.flat_map(|(time_s, _)| [time_s - 1e-3, time_s + 1e-3]);
        let times = beyond.chain(self.variances.iter().map(|(time_s, _)| *time_s)).chain(self.times_s.iter().copied());
        let covered = times.filter(|time_s| self.covers(*time_s, *time_s));
        let errors = covered.map(|time_s| self.uncertainty_at(time_s, class));
        errors.fold((0.0, 0.0), |(along_s, cross_km): (f64, f64), error| {
            (along_s.max(error.along_track_s), cross_km.max(error.cross_track_km))
        })
    }

    /// Interpolates the variances linearly between two covariances.
    fn variance_at(&self, time_s: f64) -> Variance {
        let after = self.variances.partition_point(|(time, _)| *time <= time_s);
        let (before, next) = (self.variances.get(after.wrapping_sub(1)), self.variances.get(after));
        match (before, next) {
            (Some((from_s, from)), Some((to_s, to))) => {
                let share = (time_s - from_s) / (to_s - from_s);
                Variance::Stated(std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])))
            }
            // Times of states and covariances differ by rounding.
            (Some((last_s, last)), None) if time_s - last_s < 1e-5 => Variance::Stated(*last),
            (None, Some((first_s, first))) if first_s - time_s < 1e-5 => Variance::Stated(*first),
            (Some((_, end)), None) | (None, Some((_, end))) => Variance::Outside(*end),
            (None, None) => Variance::Unstated,
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
                // For a covariance outside the states, or in a gap, the axes are those at the nearest state.
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

/// Variances at a time: radial, along the track, out of the plane, km².
enum Variance {
    /// At or between covariances.
    Stated([f64; 3]),
    /// Those of the last covariance before, or of the first one after the time.
    Outside([f64; 3]),
    Unstated,
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

    /// Returns the position in TEME.
    fn to_teme(&self, state: &EphemerisState) -> Vector3<f64> {
        self.rotation(state.epoch) * Vector3::from(state.position_km)
    }
}

/// Source of the positions of a satellite. Displayed as `element set`, or as `ephemeris` and the name of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum PositionSource {
    /// SGP4 with its element set.
    #[default]
    ElementSet,
    /// Ephemeris of an operator in the file of this name, as given.
    Ephemeris(Arc<str>),
}

impl fmt::Display for PositionSource {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PositionSource::ElementSet => formatter.write_str("element set"),
            PositionSource::Ephemeris(file) => {
                // The provenance contains the full path.
                write!(formatter, "ephemeris {}", file.rsplit(['/', '\\']).next().unwrap_or(file))
            }
        }
    }
}

/// One ephemeris of a satellite with an element set, or several that together cover a time without a hole.
#[derive(Clone, Debug)]
pub(super) struct Attached {
    /// The ephemerides, the preferred one first; at least one.
    pub segments: Vec<Segment>,
    /// Class of the satellite, for errors that the ephemeris does not state.
    pub class: OrbitClass,
    /// Largest errors of one sigma: seconds along the track, kilometres across it.
    pub largest_errors: (f64, f64),
    /// Times at which positions change to those of another ephemeris that does not agree, minutes after the epoch of
    /// the element set.
    pub jumps_minutes: Vec<f64>,
}

/// Table of an ephemeris and its start.
#[derive(Clone, Debug)]
pub(super) struct Segment {
    pub table: Arc<EphemerisTable>,
    /// Minutes from the epoch of the element set to the start of the table.
    pub start_minutes: f64,
}

impl Segment {
    /// Returns the seconds after the start of the table.
    fn seconds(&self, minutes: f64) -> f64 {
        (minutes - self.start_minutes) * 60.0
    }
}

impl Attached {
    /// Joins ephemerides of one satellite, the preferred one first.
    pub fn joined(of_one: &[&Self]) -> Option<Self> {
        let largest = of_one.iter().map(|attached| attached.largest_errors);
        let mut joined = Self {
            segments: of_one.iter().flat_map(|attached| attached.segments.iter().cloned()).collect(),
            class: of_one.first()?.class,
            largest_errors: largest.fold((0.0, 0.0), |sum: (f64, f64), error| (sum.0.max(error.0), sum.1.max(error.1))),
            jumps_minutes: Vec::new(),
        };
        joined.jumps_minutes = joined.jumps();
        Some(joined)
    }

    fn jumps(&self) -> Vec<f64> {
        /// A hundredth of a millisecond, in which a satellite moves by a decimetre.
        const BESIDE_MINUTES: f64 = 1e-5 / 60.0;
        let ends = self
            .segments
            .iter()
            .flat_map(|segment| segment.table.ends_s().map(|end_s| segment.start_minutes + end_s / 60.0));
        let is_jump = |minutes: &f64| {
            let beside = [minutes - BESIDE_MINUTES, minutes + BESIDE_MINUTES].map(|minutes| {
                let (table, time_s) = self.at(minutes);
                table.state_at(time_s).map(|state| *state.position.vector())
            });
            matches!(beside, [Some(before), Some(after)] if (after - before).norm() > LARGEST_CONTRADICTION_KM)
        };
        ends.filter(is_jump).collect()
    }

    /// Returns the name of the file; the first one, with the number of the others, of several.
    pub fn file(&self) -> Arc<str> {
        let first = self.segments[0].table.file();
        let mut others: Vec<&Arc<str>> = self.segments.iter().map(|segment| segment.table.file()).collect();
        others.sort_unstable();
        others.dedup();
        match others.len() {
            1 => first.clone(),
            several => format!("{first} and {} more", several - 1).into(),
        }
    }

    /// Returns the ephemeris of a time and the seconds after its start: the preferred one of those that are for this
    /// time, or else one that reaches it.
    fn at(&self, minutes: f64) -> (&EphemerisTable, f64) {
        let preferred = &self.segments[0];
        if self.segments.len() == 1 {
            return (&preferred.table, preferred.seconds(minutes));
        }
        let first = |is_for: &dyn Fn(&EphemerisTable, f64) -> bool| {
            let mut all = self.segments.iter().map(|segment| (&*segment.table, segment.seconds(minutes)));
            all.find(|(table, time_s)| is_for(table, *time_s))
        };
        let found = first(&|table, time_s| table.covers(time_s, time_s));
        let found = found.or_else(|| first(&|table, time_s| table.reaches(time_s, time_s)));
        found.unwrap_or((&preferred.table, preferred.seconds(minutes)))
    }

    /// Returns the state at a time after the epoch of the element set; `None` if no ephemeris covers it.
    pub fn state_at(&self, minutes: f64) -> Option<State<Teme>> {
        let (table, time_s) = self.at(minutes);
        // Between adjoining ephemerides, rounding leaves times that neither has exactly.
        let of_any = || self.segments.iter().find_map(|segment| segment.table.state_at(segment.seconds(minutes)));
        table.state_at(time_s).or_else(of_any)
    }

    /// Returns the errors of one sigma at a time after the epoch of the element set.
    pub fn uncertainty_at(&self, minutes: f64) -> OrbitUncertainty {
        let (table, time_s) = self.at(minutes);
        table.uncertainty_at(time_s, self.class)
    }

    /// Returns true if one ephemeris is for the middle of an interval, minutes after the epoch of the element set, and
    /// positions can be computed in it and for the delays that are searched.
    pub fn is_for_middle(&self, [from, to]: [f64; 2]) -> bool {
        let [segment] = &self.segments[..] else { return false };
        let middle_s = segment.seconds(0.5 * (from + to));
        segment.table.covers(middle_s, middle_s)
            && segment
                .table
                .reaches(segment.seconds(from) - EPHEMERIS_MARGIN_S, segment.seconds(to) + EPHEMERIS_MARGIN_S)
    }

    /// Returns true if the ephemerides are for an interval, minutes after the epoch of the element set, and for
    /// `beyond_s` before and after it, and positions can be computed for the delays that are searched. Several
    /// ephemerides must agree where positions change from one to another.
    pub fn covers(&self, [from, to]: [f64; 2], beyond_s: f64) -> bool {
        if let [segment] = &self.segments[..] {
            let (from_s, to_s) = (segment.seconds(from) - beyond_s, segment.seconds(to) + beyond_s);
            return segment.table.covers(from_s, to_s)
                && segment.table.reaches(from_s - EPHEMERIS_MARGIN_S, to_s + EPHEMERIS_MARGIN_S);
        }
        let reach_minutes = (beyond_s + EPHEMERIS_MARGIN_S) / 60.0;
        if self.jumps_minutes.iter().any(|jump| (from - reach_minutes..=to + reach_minutes).contains(jump)) {
            return false;
        }
        self.has_no_hole([from, to], beyond_s)
    }

    /// Returns true if ephemerides are used for all short exposures in an interval, minutes after the epoch of the
    /// element set: those of both sides of a time at which positions jump must have states beyond it.
    pub fn covers_exposures(&self, ends: [f64; 2]) -> bool {
        /// Longest part of an exposure after a jump or before it.
        const LONGEST_PART_S: f64 = 300.0;
        if self.jumps_minutes.is_empty() {
            return self.covers(ends, 0.0);
        }
        let is_across = |jump: f64, segment: &Segment| {
            let (at_s, beyond_s) = (segment.seconds(jump), EPHEMERIS_MARGIN_S + LONGEST_PART_S);
            segment.table.reaches(at_s - beyond_s, at_s + beyond_s)
        };
        let mut jumps = self.jumps_minutes.iter().filter(|jump| (ends[0]..=ends[1]).contains(jump));
        jumps.all(|jump| self.segments.iter().filter(|segment| is_across(*jump, segment)).count() > 1)
            && self.has_no_hole(ends, 0.0)
    }

    fn has_no_hole(&self, [from, to]: [f64; 2], beyond_s: f64) -> bool {
        let reaches_all = |beyond_s: f64, limits: &dyn Fn(&EphemerisTable) -> [f64; 2]| {
            let (mut known, to) = (from - beyond_s / 60.0, to + beyond_s / 60.0);
            loop {
                let ends = self.segments.iter().filter_map(|segment| {
                    let at_s = segment.seconds(known);
                    let [_, end_s] = segment.table.covered_within(limits(&segment.table), [at_s, at_s])?;
                    Some(segment.start_minutes + end_s / 60.0)
                });
                let Some(end) = ends.max_by(f64::total_cmp) else { return false };
                if end >= to {
                    return true;
                }
                // Rounding of the ends of adjoining ephemerides: a microsecond.
                const ROUNDING_MINUTES: f64 = 1e-6 / 60.0;
                if end <= known + ROUNDING_MINUTES {
                    return false;
                }
                known = end + ROUNDING_MINUTES;
            }
        };
        reaches_all(beyond_s, &|table| table.usable_s)
            && reaches_all(beyond_s + EPHEMERIS_MARGIN_S, &|table| table.reach_s)
    }

    /// Returns true if a part of an interval, minutes after the epoch of the element set, is covered.
    pub fn overlaps(&self, [from, to]: [f64; 2]) -> bool {
        self.segments.iter().any(|segment| segment.table.overlaps(segment.seconds(from), segment.seconds(to)))
    }

    /// Returns true if two ephemerides of one message are for the same time and differ.
    pub fn contradicts(&self, other: &Self) -> bool {
        self.segments.iter().any(|own| other.segments.iter().any(|segment| own.table.contradicts(&segment.table)))
    }
}

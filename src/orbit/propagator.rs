//! Propagators of one satellite, by SGP4 or from an ephemeris, and of a whole catalogue.

use std::cmp::Reverse;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::{PI, TAU};
use std::fmt;
use std::sync::Arc;

use hifitime::{Epoch, Unit};
use rayon::prelude::*;
use sgp4::{Constants, MinutesSinceEpoch, Orbit, WGS72, afspc_epoch_to_sidereal_time};

use super::ephemeris::{Attached, EphemerisTable, PositionSource, Segment};
use super::resonance::Resonance;
use super::state::State;
use super::station_keeping::DragModel;
use super::uncertainty::{OrbitClass, OrbitUncertainty};
use crate::constants::{DAY_S, WGS72_MU_KM3_S2};
use crate::elements::{ElementSet, Ephemeris, EphemerisObject, NoradId};
use crate::error::{Error, ErrorKind};
use crate::frames::{EopTable, Gcrs, Position, Rotation, Teme, Velocity};

/// Distance from the Earth's centre below which a satellite counts as decayed: one Earth radius of WGS72, as in the
/// code of the US Air Force Space Command (AFSPC; error 6).
pub const DECAYED_RADIUS_KM: f64 = 6378.135;

/// Largest disagreement between positions and velocities at two times, km. For correct velocities, the error of the
/// comparison, h³/12 · |r‴|, is 2 m for the fastest orbit and a step h of 10 s. SGP4's velocity omits the change of the
/// mean motion by drag, which becomes visible where the drag terms of elements that are years old diverge.
const LARGEST_GAP_KM: f64 = 1.0;
/// The same limit as a velocity for longer steps, km/s. In a minute, h³/12 · |r‴| is 0.4 km; where the forces of Moon
/// and Sun are strongest, the disagreement is some m/s.
const LARGEST_MISMATCH_KM_S: f64 = 0.1;

/// Age of elements that do not determine a position: the source of an error of the kind
/// [`UnknownPosition`](ErrorKind::UnknownPosition).
#[derive(Debug)]
pub struct TooOld {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Days from the element epoch to the requested time; negative if the epoch is later.
    pub age_days: f64,
}

impl fmt::Display for TooOld {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "satellite {}: position unknown, {}", self.norad_id, elements_of_age(self.age_days))
    }
}

impl std::error::Error for TooOld {}

/// Returns the error of a satellite whose position cannot be computed.
pub fn no_position(norad_id: NoradId, reason: fmt::Arguments<'_>) -> Error {
    Error::new(ErrorKind::NoPosition, format!("satellite {norad_id}{reason}"))
}

/// SGP4 cannot be initialised from the elements of a satellite.
pub fn not_initialised(norad_id: NoradId, reason: &str) -> Error {
    no_position(norad_id, format_args!(": SGP4 cannot be initialised from its elements: {reason}"))
}

/// Returns the age of element sets as text: `elements 216 days old`, or `elements 30 days newer than the exposure`.
pub fn elements_of_age(age_days: f64) -> String {
    match age_days {
        days if days < 0.0 => format!("elements {:.0} days newer than the exposure", -days),
        days => format!("elements {days:.0} days old"),
    }
}

/// SGP4 (or SDP4) constants of one satellite, in the AFSPC mode with WGS72: the model with which element sets are
/// fitted. With an ephemeris attached, positions are interpolated in it.
#[derive(Clone)]
pub struct Propagator {
    constants: Constants,
    epoch: Epoch,
    norad_id: NoradId,
    /// Time of decay, and the same in minutes after the epoch of the elements.
    decayed: Option<Box<(Epoch, f64)>>,
    period_s: f64,
    eccentricity: f64,
    /// Largest plausible distance from the Earth's centre.
    farthest_km: f64,
    /// Present for half-day and one-day orbits only. Few satellites have this or an ephemeris, so that they take little
    /// memory.
    resonance: Option<Box<Resonance>>,
    ephemeris: Option<Box<Attached>>,
}

impl fmt::Debug for Propagator {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Propagator").field("norad_id", &self.norad_id).field("epoch", &self.epoch).finish()
    }
}

impl Propagator {
    /// Initialises SGP4.
    ///
    /// # Errors
    /// The eccentricity is outside [0, 1) or the mean motion is not positive.
    pub fn new(elements: &ElementSet) -> Result<Self, Error> {
        let fail = |reason: String| not_initialised(elements.norad_id, &reason);
        let orbit = Orbit::from_kozai_elements(
            &WGS72,
            elements.inclination_deg * (PI / 180.0),
            elements.right_ascension_of_node_deg * (PI / 180.0),
            elements.eccentricity,
            elements.argument_of_perigee_deg * (PI / 180.0),
            elements.mean_anomaly_deg * (PI / 180.0),
            elements.mean_motion_rev_day * (PI / 720.0),
        )
        .map_err(|error| fail(error.to_string()))?;
        // Julian years from J2000 (UTC); SGP4 uses them for the Moon, the Sun and the sidereal time at epoch. They are
        // computed from a Julian date in one f64, which rounds to 40 µs, as in the AFSPC code. This rounding moves
        // deep-space orbits of the verification set by 4 mm.
        let years = ((elements.epoch.to_mjd_utc_days() + 2_400_000.5) - 2_451_545.0) / 365.25;
        let constants =
            Constants::new(WGS72, afspc_epoch_to_sidereal_time, years, elements.bstar_per_earth_radius, orbit)
                .map_err(|error| fail(error.to_string()))?;
        let period_s = DAY_S / elements.mean_motion_rev_day;
        // Two semi-major axes, a = (μ P² / 4π²)^⅓, and a tenth for perturbations by Moon and Sun.
        let farthest_km = 2.2 * (WGS72_MU_KM3_S2 * (period_s / TAU).powi(2)).cbrt();
        let resonance = Resonance::new(&constants).map(Box::new);
        Ok(Self {
            constants,
            epoch: elements.epoch,
            norad_id: elements.norad_id,
            decayed: elements
                .decayed
                .map(|decayed| Box::new((decayed, (decayed - elements.epoch).to_unit(hifitime::Unit::Minute)))),
            period_s,
            eccentricity: elements.eccentricity,
            farthest_km,
            resonance,
            ephemeris: None,
        })
    }

    /// Returns the propagator of the same satellite with positions of an ephemeris.
    fn with_ephemeris(&self, table: &Arc<EphemerisTable>, class: OrbitClass) -> Self {
        let start_minutes = self.minutes_since_epoch(table.start());
        let segments = vec![Segment { table: table.clone(), start_minutes }];
        let largest_errors = table.largest_errors(class);
        let attached = Attached { segments, class, largest_errors, jumps_minutes: Vec::new() };
        Self { ephemeris: Some(Box::new(attached)), ..self.clone() }
    }

    /// Returns the propagator of a satellite with several ephemerides, the preferred one first, for times that only
    /// several of them cover; `None` unless there are several.
    fn joined(of_one: &[Self]) -> Option<Self> {
        let attached: Vec<&Attached> = of_one.iter().filter_map(|propagator| propagator.ephemeris.as_deref()).collect();
        let joined = Attached::joined(&attached).filter(|joined| joined.segments.len() > 1)?;
        Some(Self { ephemeris: Some(Box::new(joined)), ..of_one.first()?.clone() })
    }

    /// Returns the source of the positions.
    pub fn position_source(&self) -> PositionSource {
        let of_file = |attached: &Attached| PositionSource::Ephemeris(attached.file());
        self.ephemeris.as_deref().map_or(PositionSource::ElementSet, of_file)
    }

    /// Returns true if positions are interpolated in an ephemeris.
    pub fn has_ephemeris(&self) -> bool {
        self.ephemeris.is_some()
    }

    /// Returns the errors of one sigma of the attached ephemeris at a time; `None` for SGP4.
    ///
    /// They are those of its covariance; where it has none, those of an element set with its epoch at the first state.
    #[doc(hidden)]
    pub fn stated_uncertainty(&self, epoch: Epoch) -> Option<OrbitUncertainty> {
        Some(self.ephemeris.as_ref()?.uncertainty_at(self.minutes_since_epoch(epoch)))
    }

    /// Returns true if the attached ephemeris is for an interval, and for `beyond_s` before and after it.
    fn covers(&self, ends: [Epoch; 2], beyond_s: f64) -> bool {
        let ends = ends.map(|epoch| self.minutes_since_epoch(epoch));
        self.ephemeris.as_ref().is_some_and(|attached| attached.covers(ends, beyond_s))
    }

    /// Returns true if the attached ephemerides are used for all short exposures in an interval.
    fn covers_exposures(&self, ends: [Epoch; 2]) -> bool {
        let ends = ends.map(|epoch| self.minutes_since_epoch(epoch));
        self.ephemeris.as_ref().is_some_and(|attached| attached.covers_exposures(ends))
    }

    /// Returns true if the attached ephemeris is for the middle of an interval and has states in all of it.
    fn is_for_middle(&self, ends: [Epoch; 2]) -> bool {
        let ends = ends.map(|epoch| self.minutes_since_epoch(epoch));
        self.ephemeris.as_ref().is_some_and(|attached| attached.is_for_middle(ends))
    }

    /// Returns true if the attached ephemeris covers a part of an interval.
    fn overlaps(&self, ends: [Epoch; 2]) -> bool {
        let ends = ends.map(|epoch| self.minutes_since_epoch(epoch));
        self.ephemeris.as_ref().is_some_and(|attached| attached.overlaps(ends))
    }

    /// As [`Propagator::new`], without the published drag where the satellite holds its orbit by thrust.
    ///
    /// # Errors
    /// As [`Propagator::new`].
    #[doc(hidden)]
    pub fn with_drag(elements: &ElementSet, drag: DragModel) -> Result<Self, Error> {
        Self::new(&drag.propagated(elements))
    }

    /// Returns the position integrated from the element epoch; `None` for orbits without resonances.
    #[cfg(test)]
    pub(super) fn position_from_the_epoch(&self, minutes: f64) -> Option<[f64; 3]> {
        let mut initial = self.resonance.as_ref().and_then(|_| self.constants.initial_state())?;
        let integrated = self.constants.propagate_from_state(MinutesSinceEpoch(minutes), Some(&mut initial), true);
        integrated.ok().map(|prediction| prediction.position)
    }

    /// NORAD catalogue number.
    pub fn norad_id(&self) -> NoradId {
        self.norad_id
    }

    /// Returns the epoch of the elements.
    pub fn epoch(&self) -> Epoch {
        self.epoch
    }

    /// Checks that velocities agree with the positions of two states, `step_s` apart, the first at `minutes` after the
    /// element epoch.
    ///
    /// # Errors
    /// They do not agree, because the drag terms have diverged.
    pub fn check_step(
        &self,
        first: &State<Gcrs>,
        second: &State<Gcrs>,
        step_s: f64,
        minutes: f64,
    ) -> Result<(), Error> {
        let moved_km = second.position.vector() - first.position.vector();
        let by_velocity_km = (first.velocity.vector() + second.velocity.vector()) * (0.5 * step_s);
        if (moved_km - by_velocity_km).norm() <= LARGEST_GAP_KM.max(LARGEST_MISMATCH_KM_S * step_s) {
            return Ok(());
        }
        Err(self.diverged(
            minutes,
            format_args!(
                "positions change by {:.1} km/s but the velocity is {:.1} km/s: the drag terms have diverged",
                moved_km.norm() / step_s,
                by_velocity_km.norm() / step_s
            ),
        ))
    }

    /// Returns the angular rate about the Earth's centre at perigee, rad/s, with a tenth added for changes since the
    /// element epoch.
    pub fn fastest_turn_rad_s(&self) -> f64 {
        // dν/dt = n (1 + e)² / (1 - e²)^{3/2} at ν = 0
        let e = self.eccentricity;
        1.1 * TAU / self.period_s * (1.0 + e).powi(2) / (1.0 - e * e).powf(1.5)
    }

    /// Returns the minutes from the element epoch to `epoch` in UTC, for any scale of `epoch`: leap seconds in between
    /// are not counted, as in the AFSPC code and in python-sgp4. The last leap second was inserted at the end of 2016.
    pub fn minutes_since_epoch(&self, epoch: Epoch) -> f64 {
        (epoch.to_utc_duration() - self.epoch.to_utc_duration()).to_unit(Unit::Minute)
    }

    /// Returns the geocentric state at `epoch`.
    ///
    /// # Errors
    /// The satellite has decayed, the drag terms have diverged, or the ephemeris in use has no state at that time.
    pub fn state(&self, epoch: Epoch, teme_to_gcrs: &Rotation<Teme, Gcrs>) -> Result<State<Gcrs>, Error> {
        self.state_at_minutes(self.minutes_since_epoch(epoch), teme_to_gcrs)
    }

    /// Returns the geocentric state `minutes` after the element epoch.
    ///
    /// # Errors
    /// The satellite has decayed, the drag terms have diverged, or the ephemeris in use has no state at that time.
    pub fn state_at_minutes(&self, minutes: f64, teme_to_gcrs: &Rotation<Teme, Gcrs>) -> Result<State<Gcrs>, Error> {
        let state = self.teme_state(minutes)?;
        Ok(State { position: *teme_to_gcrs * state.position, velocity: *teme_to_gcrs * state.velocity })
    }

    /// Returns the orbital period at the element epoch, seconds.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Returns the distances of perigee and apogee from the Earth's centre at the element epoch, km.
    pub fn perigee_apogee_km(&self) -> (f64, f64) {
        // a = (μ P² / 4π²)^⅓
        let semi_major_axis_km = (WGS72_MU_KM3_S2 * (self.period_s / TAU).powi(2)).cbrt();
        (semi_major_axis_km * (1.0 - self.eccentricity), semi_major_axis_km * (1.0 + self.eccentricity))
    }

    /// Returns the time from which the satellite is known to have decayed.
    pub(crate) fn decayed(&self) -> Option<Epoch> {
        self.decayed.as_deref().map(|(decayed, _)| *decayed)
    }

    /// Returns the result of SGP4 in TEME, km and km/s, `minutes` after the element epoch, for verification against
    /// other implementations. An attached ephemeris is not used, and distances that are too large are not rejected.
    ///
    /// # Errors
    /// The satellite has decayed, the drag terms have diverged, or the ephemeris in use has no state at that time.
    pub fn teme_state_at_minutes(&self, minutes: f64) -> Result<([f64; 3], [f64; 3]), Error> {
        if let Some((decayed, after)) = self.decayed.as_deref().copied()
            && minutes > after
        {
            // Without a date the time is that of the elements.
            return Err(if after == 0.0 {
                no_position(self.norad_id, format_args!(" has decayed (DECAYED of its element set) at an unknown time"))
            } else {
                let reason = format_args!(" has decayed before {decayed} (DECAY_DATE of its element set)");
                no_position(self.norad_id, reason)
            });
        }
        let mut resonance = self.resonance.as_ref().map(|kept| kept.state_before(&self.constants, minutes));
        let prediction = self
            .constants
            .propagate_from_state(MinutesSinceEpoch(minutes), resonance.as_mut(), true)
            .map_err(|error| self.diverged(minutes, format_args!("{error}")))?;
        let [x, y, z] = prediction.position;
        let radius_km = (x * x + y * y + z * z).sqrt();
        // NaN counts as decayed too.
        if radius_km.is_nan() || radius_km < DECAYED_RADIUS_KM {
            let days = minutes / 1440.0;
            let reason = format_args!(
                " has decayed: {radius_km:.0} km from the Earth's centre {days:.2} days after the element epoch; expected at \
                 least {DECAYED_RADIUS_KM} km"
            );
            return Err(no_position(self.norad_id, reason));
        }
        Ok((prediction.position, prediction.velocity))
    }

    /// Returns the error of elements that leave SGP4's valid range during the propagation.
    fn diverged(&self, minutes: f64, reason: fmt::Arguments<'_>) -> Error {
        let days = minutes / 1440.0;
        no_position(self.norad_id, format_args!(": SGP4 fails {days:.2} days after the element epoch: {reason}"))
    }

    /// Returns the state in TEME, `minutes` after the element epoch.
    pub(super) fn teme_state(&self, minutes: f64) -> Result<State<Teme>, Error> {
        if let Some(attached) = &self.ephemeris {
            return attached.state_at(minutes).ok_or_else(|| {
                let days = minutes / 1440.0;
                let reason = format_args!(": its ephemeris does not cover {days:.4} days after the element epoch");
                no_position(self.norad_id, reason)
            });
        }
        let ([x, y, z], [u, v, w]) = self.teme_state_at_minutes(minutes)?;
        let radius_km = (x * x + y * y + z * z).sqrt();
        // The distance cannot exceed twice the semi-major axis; where it does, the drag terms have diverged.
        if radius_km > self.farthest_km {
            let limit_km = self.farthest_km;
            return Err(self.diverged(
                minutes,
                format_args!(
                    "the predicted distance from the Earth's centre is {radius_km:.0} km, above the orbit's limit of \
                     {limit_km:.0} km"
                ),
            ));
        }
        Ok(State { position: Position::new(x, y, z), velocity: Velocity::new(u, v, w) })
    }
}

/// A satellite without a position, and the reason. Such satellites never stop a computation.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LeftOut {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Position of its element set in the catalogue.
    pub element_index: usize,
    /// Reason for the missing position.
    pub reason: Error,
}

/// Propagators of a catalogue. Construction takes about 1 µs per satellite and core.
#[derive(Clone, Debug)]
pub struct SatelliteIndex {
    /// Propagators in catalogue order; `None` where SGP4 cannot be initialised.
    propagators: Vec<Option<Propagator>>,
    left_out: Vec<LeftOut>,
    drag: DragModel,
    /// Propagators with ephemerides by position in the catalogue, the one created last first. If there are several, the
    /// last propagator has all of them.
    ephemerides: BTreeMap<usize, Vec<Propagator>>,
    /// Satellites with ephemerides of one message that contradict each other, by their positions in the catalogue.
    contradictory: Vec<usize>,
}

/// Part of an interval for which ephemerides are used.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum EphemerisCoverage {
    /// Ephemerides cover the whole interval and the delays that are searched before and after it.
    Whole,
    /// Ephemerides cover parts of it.
    Part,
    /// Element sets are used.
    None,
}

/// Propagator of one satellite over an interval of the search.
pub(super) enum SearchedPropagator<'a> {
    /// SGP4 cannot be initialised.
    Absent,
    /// One propagator for all exposures.
    One(&'a Propagator),
    /// An ephemeris for some exposures and SGP4, or another ephemeris, for others.
    Several,
}

impl SatelliteIndex {
    /// Initialises SGP4 for every element set, on all threads.
    pub fn new(elements: &[ElementSet], drag: DragModel) -> Self {
        let made = elements.par_iter().map(|set| Propagator::new(&drag.propagated(set))).collect();
        Self::of_propagators(elements, made, drag)
    }

    /// Creates an index of the propagators of satellites, `Err` where SGP4 could not be initialised. They were made
    /// from the elements of an [`OrbitModel`](super::OrbitModel) with this treatment of drag.
    pub fn of_propagators(elements: &[ElementSet], made: Vec<Result<Propagator, Error>>, drag: DragModel) -> Self {
        let mut left_out = Vec::new();
        let propagators = made
            .into_iter()
            .enumerate()
            .map(|(element_index, result)| {
                let norad_id = elements[element_index].norad_id;
                result.map_err(|reason| left_out.push(LeftOut { norad_id, element_index, reason })).ok()
            })
            .collect();
        Self { propagators, left_out, drag, ephemerides: BTreeMap::new(), contradictory: Vec::new() }
    }

    /// Adds ephemerides to the satellites of the same `elements`; those of other satellites are ignored.
    pub fn with_ephemerides(mut self, elements: &[ElementSet], ephemerides: &[Arc<Ephemeris>], eop: &EopTable) -> Self {
        if ephemerides.is_empty() {
            return self;
        }
        let mut positions: HashMap<EphemerisObject, Vec<usize>> = HashMap::new();
        for (position, set) in elements.iter().enumerate() {
            let designator = EphemerisObject::Designator(set.international_designator.clone());
            for object in [EphemerisObject::Norad(set.norad_id), designator] {
                positions.entry(object).or_default().push(position);
            }
        }
        let attached: Vec<(usize, Propagator)> = ephemerides
            .par_iter()
            .filter_map(|ephemeris| Some((positions.get(&ephemeris.object)?, ephemeris)))
            .flat_map_iter(|(positions, ephemeris)| {
                let table = Arc::new(EphemerisTable::new(ephemeris, eop));
                let of = |&position: &usize| {
                    let propagator = self.propagators[position].as_ref()?;
                    Some((
                        position,
                        propagator.with_ephemeris(&table, OrbitClass::from_elements(&elements[position], self.drag)),
                    ))
                };
                positions.iter().filter_map(of).collect::<Vec<_>>()
            })
            .collect();
        for (position, propagator) in attached {
            self.ephemerides.entry(position).or_default().push(propagator);
        }
        for (position, of_one) in &mut self.ephemerides {
            of_one.sort_by_cached_key(|propagator| {
                Reverse(propagator.ephemeris.as_ref().map(|attached| attached.segments[0].table.rank()))
            });
            let attached: Vec<_> = of_one.iter().filter_map(|propagator| propagator.ephemeris.as_deref()).collect();
            let contradicts = |(at, ephemeris): (usize, &&Attached)| {
                attached[at + 1..].iter().any(|other| ephemeris.contradicts(other))
            };
            if attached.iter().enumerate().any(contradicts) {
                self.contradictory.push(*position);
            }
            of_one.extend(Propagator::joined(of_one));
        }
        self
    }

    /// Returns the satellites with ephemerides of one message that are for the same time and differ by more than a
    /// kilometre, by their positions in the catalogue. The ephemeris that begins later is used.
    pub fn contradictory_ephemerides(&self) -> &[usize] {
        &self.contradictory
    }

    /// Returns the propagator of a satellite for an interval such as an exposure: with the last created ephemeris that
    /// covers it and the delays searched, or with several that together cover it without a hole, otherwise SGP4.
    pub fn propagator_over(&self, element_index: usize, ends: [Epoch; 2]) -> Option<&Propagator> {
        let of_one = self.ephemerides.get(&element_index).map_or(&[][..], Vec::as_slice);
        let covering = of_one.iter().find(|propagator| propagator.covers(ends, 0.0));
        // Where ephemerides do not join, that of the middle is used beyond its interval, if it has states there.
        let of_middle = || of_one.iter().find(|propagator| propagator.is_for_middle(ends));
        covering.or_else(of_middle).or_else(|| self.propagator(element_index))
    }

    /// Returns true if satellites have ephemerides.
    pub fn has_ephemerides(&self) -> bool {
        !self.ephemerides.is_empty()
    }

    /// Returns the satellites with ephemerides by their positions in the catalogue, and the part of an interval for
    /// which these are used.
    pub fn ephemeris_coverage(&self, ends: [Epoch; 2]) -> impl Iterator<Item = (usize, EphemerisCoverage)> + '_ {
        self.ephemerides.iter().map(move |(&position, of_one)| {
            let coverage = if of_one.iter().any(|propagator| propagator.covers_exposures(ends)) {
                EphemerisCoverage::Whole
            } else if of_one.iter().any(|propagator| propagator.overlaps(ends)) {
                EphemerisCoverage::Part
            } else {
                EphemerisCoverage::None
            };
            (position, coverage)
        })
    }

    /// Returns the largest errors of one sigma in the ephemerides of a satellite: seconds along the track, kilometres
    /// across it; 0 without any.
    pub fn largest_stated_errors(&self, element_index: usize) -> (f64, f64) {
        let of_one = self.ephemerides.get(&element_index).map_or(&[][..], Vec::as_slice);
        let attached = of_one.iter().filter_map(|propagator| propagator.ephemeris.as_ref());
        let errors = attached.map(|attached| attached.largest_errors);
        errors.fold((0.0, 0.0), |(along_s, cross_km): (f64, f64), error| (along_s.max(error.0), cross_km.max(error.1)))
    }

    /// Returns the source of positions for exposures with a part in an interval, none of them longer than `longest_s`.
    pub(super) fn source_over(&self, element_index: usize, ends: [Epoch; 2], longest_s: f64) -> SearchedPropagator<'_> {
        let Some(sgp4) = self.propagator(element_index) else { return SearchedPropagator::Absent };
        match self.ephemerides.get(&element_index).map(Vec::as_slice) {
            Some([latest, ..]) if latest.covers(ends, longest_s) => SearchedPropagator::One(latest),
            Some(of_one) if of_one.iter().any(|propagator| propagator.overlaps(ends)) => SearchedPropagator::Several,
            _ => SearchedPropagator::One(sgp4),
        }
    }

    /// Returns the number of element sets, including those that cannot be propagated.
    pub fn len(&self) -> usize {
        self.propagators.len()
    }

    /// Returns true for an empty catalogue.
    pub fn is_empty(&self) -> bool {
        self.propagators.is_empty()
    }

    /// Returns the propagator of the element set at this position; `None` where SGP4 cannot be initialised or the
    /// position does not exist.
    pub fn propagator(&self, element_index: usize) -> Option<&Propagator> {
        self.propagators.get(element_index)?.as_ref()
    }

    /// Returns the satellites for which SGP4 cannot be initialised at any time.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }
}

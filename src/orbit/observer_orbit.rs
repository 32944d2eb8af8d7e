//! Orbit of an observing telescope: SGP4 with an element set, or interpolation in the ephemerides of its operator.

use std::cmp::Reverse;
use std::sync::Arc;

use hifitime::Epoch;

use super::arc::OrbitArc;
use super::ephemeris::EphemerisTable;
use super::propagator::Propagator;
use super::state::State;
use crate::elements::{ElementSet, Ephemeris};
use crate::error::{Error, ErrorKind};
use crate::frames::{EopTable, Gcrs, Rotation, Teme, seconds_after, seconds_between};

/// Orbit of an observing telescope.
#[derive(Clone, Debug)]
pub struct ObserverOrbit(Source);

#[derive(Clone, Debug)]
enum Source {
    Elements(Box<Propagator>),
    /// Tables of the ephemerides, the one created last first.
    Ephemerides(Arc<[EphemerisTable]>),
}

impl ObserverOrbit {
    /// Creates the orbit of an element set.
    ///
    /// # Errors
    /// SGP4 cannot be initialised.
    pub fn of_elements(elements: &ElementSet) -> Result<Self, Error> {
        Ok(Self(Source::Elements(Box::new(Propagator::new(elements)?))))
    }

    /// Creates the orbit of one or more ephemerides of one object.
    pub fn of_ephemerides(ephemerides: &[Arc<Ephemeris>], eop: &EopTable) -> Self {
        let mut tables: Vec<EphemerisTable> =
            ephemerides.iter().map(|ephemeris| EphemerisTable::new(ephemeris, eop)).collect();
        tables.sort_by_cached_key(|table| Reverse(table.rank()));
        Self(Source::Ephemerides(tables.into()))
    }

    /// Returns the epoch of the element set; `None` for ephemerides.
    pub fn elements_epoch(&self) -> Option<Epoch> {
        match &self.0 {
            Source::Elements(propagator) => Some(propagator.epoch()),
            Source::Ephemerides(_) => None,
        }
    }

    /// Returns true if two ephemerides of one message are for the same time and differ by more than a kilometre.
    pub fn is_contradictory(&self) -> bool {
        let Source::Ephemerides(tables) = &self.0 else { return false };
        tables.iter().enumerate().any(|(at, table)| tables[at + 1..].iter().any(|other| table.contradicts(other)))
    }

    /// Returns the longest part of an interval around another one, `inner`, for which one ephemeris gives positions;
    /// the whole interval for an element set. `None` if no ephemeris covers `inner`: positions in it are unknown.
    pub fn known_part(&self, outer: [Epoch; 2], inner: [Epoch; 2]) -> Option<[Epoch; 2]> {
        let Source::Ephemerides(tables) = &self.0 else { return Some(outer) };
        let of_table = |table: &EphemerisTable| {
            let [from_s, to_s] = table.covered_around(inner.map(|epoch| table.seconds_at(epoch)))?;
            let [from, to] = [from_s, to_s].map(|time_s| seconds_after(table.start(), time_s));
            Some([outer[0].max(from), outer[1].min(to)])
        };
        tables.iter().filter_map(of_table).max_by_key(|[from, to]| *to - *from)
    }

    /// Returns the geocentric state at `epoch`, from the ephemeris created last of those that cover it.
    ///
    /// # Errors
    /// The errors of [`Propagator::state`] for an element set; no ephemeris covers the time.
    pub fn state(&self, epoch: Epoch, teme_to_gcrs: &Rotation<Teme, Gcrs>) -> Result<State<Gcrs>, Error> {
        match &self.0 {
            Source::Elements(propagator) => propagator.state(epoch, teme_to_gcrs),
            Source::Ephemerides(tables) => {
                let state = tables.iter().find_map(|table| table.state_at(table.seconds_at(epoch)));
                let state = state.ok_or_else(|| self.outside([epoch, epoch]))?;
                Ok(State { position: *teme_to_gcrs * state.position, velocity: *teme_to_gcrs * state.velocity })
            }
        }
    }

    /// Returns the arc of the orbit over an interval, extended on both sides by `margin_s` as far as positions are
    /// known. Its times are seconds after `reference`.
    ///
    /// The rotation is taken as constant, as in [`OrbitArc::new`].
    ///
    /// # Errors
    /// The errors of [`OrbitArc::new`]; no ephemeris covers the whole interval.
    pub fn arc(
        &self,
        reference: Epoch,
        inner: [Epoch; 2],
        margin_s: f64,
        teme_to_gcrs: &Rotation<Teme, Gcrs>,
    ) -> Result<OrbitArc, Error> {
        let outer = [seconds_after(inner[0], -margin_s), seconds_after(inner[1], margin_s)];
        match &self.0 {
            Source::Elements(propagator) => {
                let minutes = propagator.minutes_since_epoch(reference);
                let (start_s, length_s) = (seconds_between(reference, outer[0]), seconds_between(outer[0], outer[1]));
                OrbitArc::new(propagator, minutes, start_s, length_s, teme_to_gcrs)
            }
            Source::Ephemerides(tables) => {
                let covered = tables
                    .iter()
                    .find_map(|table| Some((table, table.covered_around(inner.map(|epoch| table.seconds_at(epoch)))?)));
                let (table, [first_s, last_s]) = covered.ok_or_else(|| self.outside(inner))?;
                let [from_s, to_s] = outer.map(|epoch| table.seconds_at(epoch).clamp(first_s, last_s));
                let reference_s = table.seconds_at(reference);
                OrbitArc::of_positions(from_s - reference_s, to_s - from_s, |time_s| {
                    let state = table.state_at((reference_s + time_s).clamp(first_s, last_s));
                    let state = state.ok_or_else(|| self.outside(inner))?;
                    Ok(*(*teme_to_gcrs * state.position).vector())
                })
            }
        }
    }

    /// Returns the description of the first gap between states in an interval, with its reason; `None` if an ephemeris
    /// covers the interval without a gap.
    pub fn gap_in(&self, interval: [Epoch; 2]) -> Option<String> {
        let Source::Ephemerides(tables) = &self.0 else { return None };
        let covers =
            |table: &EphemerisTable| table.covered_around(interval.map(|epoch| table.seconds_at(epoch))).is_some();
        if tables.iter().any(covers) {
            return None;
        }
        tables.iter().find_map(|table| table.gap_in(interval.map(|epoch| table.seconds_at(epoch))))
    }

    fn outside(&self, [first, last]: [Epoch; 2]) -> Error {
        let gap = self.gap_in([first, last]).map_or_else(String::new, |reason| format!(": {reason}"));
        let sentence = format!("no ephemeris covers the time from {first} to {last} as a whole{gap}");
        Error::new(ErrorKind::NoPosition, sentence)
    }
}

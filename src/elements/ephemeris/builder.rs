//! Checks of states and covariances, common to all formats.

use std::sync::Arc;

use hifitime::{Duration, Epoch, Unit};
use nalgebra::Matrix6;

use super::data::{CovarianceAxes, Ephemeris, EphemerisFrame, EphemerisObject, EphemerisState, PositionCovariance};

/// Smallest number of states required by the interpolation.
const FEWEST_STATES: usize = 8;
/// Accepted distances from the Earth's centre, km. Positions in metres are outside this range.
const RADII_KM: std::ops::RangeInclusive<f64> = 6_378.0..=1_000_000.0;
/// Largest time from the first to the last state, days. It limits the size of the table of the Earth's orientation for
/// these states.
const LONGEST_SPAN_DAYS: f64 = 366.0;
/// Largest rounding of the stated start and end of an ephemeris, s.
const STATED_ROUNDING_S: f64 = 1.0;
/// Smallest accepted eigenvalue of the correlation matrix of a covariance. It is below 0 because numbers in files are
/// rounded to ten digits or fewer.
const LEAST_EIGENVALUE: f64 = -1e-6;
/// Number of elements of the lower triangle of a 6 × 6 matrix.
pub(super) const TERMS: usize = 21;

/// Invalid value in an ephemeris file.
#[derive(Debug)]
pub(in super::super) struct Problem {
    /// Line number, from 1.
    pub line: usize,
    pub what: String,
    pub given: String,
    pub allowed: String,
}

impl Problem {
    pub fn new(line: usize, what: impl Into<String>, given: impl ToString, allowed: impl Into<String>) -> Self {
        Self { line, what: what.into(), given: given.to_string(), allowed: allowed.into() }
    }
}

/// Ephemeris whose states and covariances are being read.
pub(super) struct Builder {
    ephemeris: Ephemeris,
    /// Start and end that the file states.
    stated: [Option<Epoch>; 2],
}

impl Builder {
    /// Creates an ephemeris without states. `created` is the creation time of the file, if it is stated.
    pub fn new(object: EphemerisObject, name: &str, frame: EphemerisFrame, created: Option<Epoch>) -> Self {
        let (name, file) = (Arc::from(name), Arc::from(""));
        let (states, covariances) = (Vec::new(), Vec::new());
        let usable = [None; 2];
        let ephemeris = Ephemeris { object, name, file, created, frame, usable, states, covariances };
        Self { ephemeris, stated: [None; 2] }
    }

    /// Limits the times at which positions can be computed.
    pub fn usable(mut self, usable: [Option<Epoch>; 2]) -> Self {
        self.ephemeris.usable = usable;
        self
    }

    /// Sets the start and the end that the file states. Positions outside are not computed.
    pub fn stated(self, stated: [Option<Epoch>; 2]) -> Self {
        Self { stated, ..self }
    }

    /// Adds a state: position in km and velocity in km/s.
    pub fn state(&mut self, line: usize, epoch: Epoch, numbers: [f64; 6]) -> Result<(), Problem> {
        if let Some(last) = self.ephemeris.states.last()
            && epoch <= last.epoch
        {
            let allowed = format!("times after that of the state before it, {}", last.epoch);
            return Err(Problem::new(line, "time of the state", epoch, allowed));
        }
        if let Some(first) = self.ephemeris.states.first()
            && epoch - first.epoch > LONGEST_SPAN_DAYS * Unit::Day
        {
            let days = (epoch - first.epoch).to_unit(Unit::Day);
            let allowed = format!("at most {LONGEST_SPAN_DAYS} days; split the file");
            return Err(Problem::new(line, "time after the first state", format!("{days:.3} days"), allowed));
        }
        let [x, y, z, u, v, w] = numbers;
        let radius_km = (x * x + y * y + z * z).sqrt();
        if !RADII_KM.contains(&radius_km) {
            let allowed = format!("{} to {} km", RADII_KM.start(), RADII_KM.end());
            return Err(Problem::new(line, "distance from the Earth's centre", format!("{radius_km} km"), allowed));
        }
        self.ephemeris.states.push(EphemerisState { epoch, position_km: [x, y, z], velocity_km_s: [u, v, w] });
        Ok(())
    }

    /// Adds a covariance: the lower triangle for position and velocity by rows, km², km²/s and km²/s².
    pub fn covariance(
        &mut self,
        line: usize,
        epoch: Epoch,
        axes: CovarianceAxes,
        terms: [f64; TERMS],
    ) -> Result<(), Problem> {
        if let Some(last) = self.ephemeris.covariances.last()
            && epoch <= last.epoch
        {
            let allowed = format!("times after that of the covariance before it, {}", last.epoch);
            return Err(Problem::new(line, "time of the covariance", epoch, allowed));
        }
        let mut terms_km2 = [0.0; 6];
        terms_km2.copy_from_slice(&terms[..6]);
        let least = least_eigenvalue(&terms);
        if least.is_nan() || least < LEAST_EIGENVALUE {
            return Err(Problem::new(
                line,
                "least eigenvalue of the correlation matrix",
                least,
                "a covariance without negative eigenvalues",
            ));
        }
        self.ephemeris.covariances.push(PositionCovariance { epoch, axes, terms_km2 });
        Ok(())
    }

    /// Returns the ephemeris. `line` is the last line of its data, and `is_line_cut` is true if the file ends there
    /// without a line break.
    pub fn finish(mut self, line: usize, is_line_cut: bool) -> Result<Ephemeris, Problem> {
        let [start, stop] = self.stated;
        let last = self.ephemeris.states.last().map(|state| state.epoch);
        if is_line_cut && (stop.is_none() || last < stop) {
            // A truncated number may still be a valid number.
            let allowed =
                "a line end after the last line, or a last state at the stated end (the file may be truncated)";
            return Err(Problem::new(line, "end of the file", "inside a line", allowed));
        }
        let states = &self.ephemeris.states;
        if states.len() < FEWEST_STATES {
            return Err(Problem::new(line, "number of states", states.len(), format!("{FEWEST_STATES} or more")));
        }
        let (first, last, before) = (states[0].epoch, states[states.len() - 1].epoch, states[states.len() - 2].epoch);
        let step: Duration = last - before;
        if let Some(stop) = stop
            && stop > last + step
        {
            let allowed = format!("the stated end {stop}, or at most one step before it (the file may be truncated)");
            return Err(Problem::new(line, "time of the last state", last, allowed));
        }
        let [from, to] = &mut self.ephemeris.usable;
        let rounding = STATED_ROUNDING_S * Unit::Second;
        if let Some(start) = start.filter(|start| *start > first + rounding) {
            *from = (*from).max(Some(start));
        }
        if let Some(stop) = stop.filter(|stop| *stop < last - rounding) {
            *to = Some(to.map_or(stop, |to| to.min(stop)));
        }
        let (from, to) = self.ephemeris.interval();
        if from > to {
            let states = format!("within the states, {first} to {last}");
            return Err(Problem::new(line, "usable interval", format!("{from} to {to}"), states));
        }
        Ok(self.ephemeris)
    }
}

/// Returns the smallest eigenvalue of the correlation matrix; NaN if an element is not finite. A variance may be 0 if
/// all covariances with it are 0.
fn least_eigenvalue(terms: &[f64; TERMS]) -> f64 {
    let term = |row: usize, column: usize| terms[row.max(column) * (row.max(column) + 1) / 2 + row.min(column)];
    let scale = |axis: usize| if term(axis, axis) == 0.0 { 1.0 } else { term(axis, axis).sqrt() };
    let correlation = Matrix6::from_fn(|row, column| term(row, column) / (scale(row) * scale(column)));
    // The square root of a negative variance is NaN.
    if correlation.iter().any(|value| !value.is_finite()) {
        return f64::NAN;
    }
    correlation.symmetric_eigenvalues().min()
}

/// Parses a number, which must be finite.
pub(super) fn number(line: usize, what: &str, text: &str) -> Result<f64, Problem> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| Problem::new(line, what, format!("{:?}", text.trim()), "a finite number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a lower triangle with equal variances and a covariance of the first two components.
    fn terms(variance: f64, covariance: f64) -> [f64; TERMS] {
        let mut terms = [0.0; TERMS];
        for axis in 0..6 {
            terms[axis * (axis + 1) / 2 + axis] = variance;
        }
        terms[1] = covariance;
        terms
    }

    #[test]
    fn verif_least_eigenvalue_of_two_correlated_axes() {
        // The eigenvalues for a correlation c are 1 - c and 1 + c.
        assert!((least_eigenvalue(&terms(4.0, 3.0)) - 0.25).abs() < 1e-12);
        assert!((least_eigenvalue(&terms(4.0, 5.0)) + 0.25).abs() < 1e-12);
        assert_eq!(least_eigenvalue(&terms(0.0, 0.0)), 0.0);
        assert!((least_eigenvalue(&terms(0.0, 1.0)) + 1.0).abs() < 1e-12);
        assert!(least_eigenvalue(&terms(-1.0, 0.0)).is_nan());
        assert!(least_eigenvalue(&terms(f64::NAN, 0.0)).is_nan());
    }
}

//! What is wrong with a fit, by name: bounds that were hit, parameters that cannot be told apart, geometry that was never seen.

use std::fmt;

use super::coverage::{PoorAxis, poor_axes};
use super::form::BLOCK;
use super::inference::Stop;
use super::solve::{Fit, Problem};

/// Parameters more alike than this cannot be told apart by the points.
const ALIKE: f64 = 0.95;
/// A parameter whose magnitude changes by less than this when it is changed by its own size does not matter at a point.
const MATTERS_MAG: f64 = 0.1;
/// Fewer points than this (and this share of all) at which a parameter matters do not carry it.
const LEAST_POINTS: usize = 20;
const LEAST_SHARE: f64 = 0.005;

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// The descent did not end by itself.
    NotConverged,
    /// A parameter stands at a bound: the points want it beyond.
    AtBound {
        /// Its name.
        name: String,
        /// The bound.
        value: f64,
    },
    /// Two parameters move together.
    Degenerate {
        /// One.
        one: String,
        /// The other.
        other: String,
        /// Their correlation.
        correlation: f64,
    },
    /// A parameter that is not known better than its own size.
    Unknown {
        /// Its name.
        name: String,
        /// As fitted.
        value: f64,
        /// One sigma.
        sigma: f64,
    },
    /// The curvature is singular: nothing is said of these.
    Singular {
        /// Names of the parameters that move freely.
        names: Vec<String>,
    },
    /// A parameter matters at few points only.
    FewPoints {
        /// Its name.
        name: String,
        /// How many.
        points: usize,
    },
    /// An axis of the geometry that the points leave open, or see too little of.
    Coverage(PoorAxis),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotConverged => write!(f, "the descent did not converge"),
            Self::AtBound { name, value } => write!(f, "{name} stands at its bound {value}"),
            Self::Degenerate { one, other, correlation } => {
                write!(f, "{one} and {other} cannot be told apart (correlation {correlation:.2})")
            }
            Self::Unknown { name, value, sigma } => {
                write!(f, "{name} is {value:.3e} +- {sigma:.3e}: not known better than its size")
            }
            Self::Singular { names } => write!(f, "the points say nothing of {}", names.join(", ")),
            Self::FewPoints { name, points } => write!(f, "{name} matters at {points} points only"),
            Self::Coverage(PoorAxis { name, thin, narrow }) => {
                let narrow = narrow.map(|[from, to]| format!("only {from:.1} to {to:.1} deg"));
                let thin = thin.iter().map(|([from, to], n)| format!("{n} points at {from} to {to} deg"));
                let words: Vec<String> = narrow.into_iter().chain(thin).collect();
                write!(f, "poor coverage of the {name}: {}", words.join(", "))
            }
        }
    }
}

/// Everything that is wrong; a sound fit has none.
pub fn faults(problem: &Problem, fit: &Fit) -> Vec<Fault> {
    let name = |i: usize| fit.parameters[i].name.clone();
    let mut faults = Vec::new();
    if matches!(fit.stop, Stop::Evaluations | Stop::Failed) {
        faults.push(Fault::NotConverged);
    }
    let at_bound = fit.certainty.at_bound.iter();
    faults.extend(at_bound.map(|&i| Fault::AtBound { name: name(i), value: fit.parameters[i].value }));
    if !fit.certainty.undetermined.is_empty() {
        faults.push(Fault::Singular { names: fit.certainty.undetermined.iter().map(|&(i, _)| name(i)).collect() });
    }
    for (k, &i) in fit.free.iter().enumerate() {
        // An angle of 0 is known well whatever its size.
        let has_size = fit.parameters[i].least >= 0.0;
        if let Some(sigma) = fit.certainty.sigma(i).filter(|sigma| has_size && *sigma > fit.parameters[i].value) {
            faults.push(Fault::Unknown { name: name(i), value: fit.parameters[i].value, sigma });
        }
        for &j in &fit.free[..k] {
            if let Some(correlation) = fit.certainty.correlation(i, j).filter(|c| c.abs() > ALIKE) {
                faults.push(Fault::Degenerate { one: name(j), other: name(i), correlation });
            }
        }
    }
    let carried = points_behind(problem, fit);
    let least = LEAST_POINTS.max((LEAST_SHARE * problem.points().len() as f64) as usize);
    for (&i, points) in fit.free.iter().zip(carried) {
        if points < least && fit.parameters[i].least >= 0.0 && !fit.certainty.at_bound.contains(&i) {
            faults.push(Fault::FewPoints { name: name(i), points });
        }
    }
    faults.extend(poor_axes(problem.points()).into_iter().map(Fault::Coverage));
    faults
}

/// For each free parameter the number of points at which it matters: where |p dm/dp| > 0.1 mag.
pub fn points_behind(problem: &Problem, fit: &Fit) -> Vec<usize> {
    let n = problem.points().len();
    let values = fit.values();
    let sloped = problem.prepared().with_slopes(&values, &fit.free, &fit.parameters);
    let mut counts = vec![0; fit.free.len()];
    let (mut out, mut slopes) = ([0.0; BLOCK], vec![[0.0; BLOCK]; fit.free.len()]);
    for block in 0..n.div_ceil(BLOCK) {
        sloped.magnitudes_and_slopes(block, &mut out, &mut slopes);
        let lanes = BLOCK.min(n - block * BLOCK);
        for ((count, slope), &i) in counts.iter_mut().zip(&slopes).zip(&fit.free) {
            *count += slope[..lanes].iter().filter(|slope| (*slope * values[i]).abs() > MATTERS_MAG).count();
        }
    }
    counts
}

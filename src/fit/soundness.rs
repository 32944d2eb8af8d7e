//! Faults of a fit: parameters at bounds, degenerate or undetermined parameters, and poor coverage of the viewing
//! geometry.
//!
//! For the coverage, each axis of the geometry is divided into bins: 5° in the Sun's latitude, 30° in the observer's
//! longitude from the Sun (folded) and 15° in the observer's latitude. The model extrapolates into bins with fewer than
//! ten points. Longitudes must be covered from 0° to 180°. The possible latitudes depend on height and site. Therefore
//! only the whole bins within the observed range are required (without one point in a thousand at each end), and this
//! range must be at least two bins wide.

use std::fmt;

use crate::geometry::ViewingGeometry;
use crate::math::quantile::quantile;
use crate::output::counted;

use super::form::BLOCK;
use super::inference::Stop;
use super::point::FitPoint;
use super::solve::{Fit, Problem};

/// Correlation above which two parameters are degenerate.
const DEGENERATE: f64 = 0.95;
/// A point depends on a parameter if changing it by its own value changes the magnitude by more than this, mag.
const DEPENDENT_MAG: f64 = 0.1;
/// Smallest number, and smallest fraction, of points that must depend on a parameter.
const LEAST_POINTS: usize = 20;
const LEAST_SHARE: f64 = 0.005;
/// Smallest number of points in a bin of the geometry.
const LEAST_IN_CELL: usize = 10;
/// Fraction of the points that is ignored at each end of the observed range.
const STRAY_SHARE: f64 = 0.001;
/// Smallest width of the observed range of a latitude, in bins.
const LEAST_CELLS: f64 = 2.0;

/// One fault of a fit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// A descent stopped at its limit of evaluations or failed.
    NotConverged,
    /// A parameter is at a bound, and the points favour values beyond it.
    AtBound {
        /// Name of the parameter.
        name: String,
        /// The bound.
        value: f64,
    },
    /// Two parameters are strongly correlated.
    Degenerate {
        /// First parameter.
        first: String,
        /// Second parameter.
        other: String,
        /// Correlation of both parameters.
        correlation: f64,
    },
    /// The sigma of a parameter exceeds its value.
    Unconstrained {
        /// Name of the parameter.
        name: String,
        /// Fitted value.
        value: f64,
        /// Uncertainty (one sigma).
        sigma: f64,
    },
    /// The curvature is singular: the points do not determine these parameters.
    Singular {
        /// Names of the parameters.
        names: Vec<String>,
    },
    /// Few points depend on a parameter.
    FewPoints {
        /// Name of the parameter.
        name: String,
        /// Number of the points that depend on the parameter.
        points: usize,
    },
    /// An axis of the viewing geometry is poorly covered.
    Coverage(PoorAxis),
}

/// Gaps in the coverage of one axis of the geometry.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PoorAxis {
    /// Name of the axis, for example `Sun's latitudes`.
    pub name: &'static str,
    /// Bins with fewer than ten points: lower and upper end, degrees, and number of points.
    pub thin: Vec<([f64; 2], usize)>,
    /// Observed range, degrees, if it is too narrow; otherwise `None`.
    pub narrow: Option<[f64; 2]>,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotConverged => write!(f, "the descent did not converge"),
            Self::AtBound { name, value } => write!(f, "{name} is at its bound {value}"),
            Self::Degenerate { first, other, correlation } => {
                write!(f, "{first} and {other} are degenerate (correlation {correlation:.2})")
            }
            Self::Unconstrained { name, value, sigma } => {
                write!(f, "{name} is not constrained by the data ({value:.3e} +- {sigma:.3e})")
            }
            Self::Singular { names } => write!(f, "the points do not constrain {}", names.join(", ")),
            Self::FewPoints { name, points } => {
                let points = counted(*points, "point", "points");
                write!(f, "{name} changes the magnitude of only {points} by more than {DEPENDENT_MAG} mag")
            }
            Self::Coverage(PoorAxis { name, thin, narrow }) => {
                let narrow = narrow.map(|[from, to]| format!("only {from:.1} to {to:.1} deg"));
                let thin = thin.iter().map(|([from, to], n)| format!("{n} points at {from} to {to} deg"));
                let gaps: Vec<String> = narrow.into_iter().chain(thin).collect();
                write!(f, "poor coverage of the {name}: {}", gaps.join(", "))
            }
        }
    }
}

/// Returns all faults of a fit; empty if there are none.
pub fn faults(problem: &Problem, fit: &Fit) -> Vec<Fault> {
    let name = |i: usize| fit.parameters[i].name.clone();
    let mut faults = Vec::new();
    if matches!(fit.stop, Stop::Evaluations | Stop::Failed) {
        faults.push(Fault::NotConverged);
    }
    let at_bound = fit.uncertainty.at_bound.iter();
    faults.extend(at_bound.map(|&i| Fault::AtBound { name: name(i), value: fit.parameters[i].value }));
    if !fit.uncertainty.undetermined.is_empty() {
        faults.push(Fault::Singular { names: fit.uncertainty.undetermined.iter().map(|&i| name(i)).collect() });
    }
    for (k, &i) in fit.free.iter().enumerate() {
        // The error of an angle is not compared with its value, which may be near 0.
        let has_size = fit.parameters[i].least >= 0.0;
        if let Some(sigma) = fit.uncertainty.sigma(i).filter(|sigma| has_size && *sigma > fit.parameters[i].value) {
            faults.push(Fault::Unconstrained { name: name(i), value: fit.parameters[i].value, sigma });
        }
        for &j in &fit.free[..k] {
            if let Some(correlation) = fit.uncertainty.correlation(i, j).filter(|c| c.abs() > DEGENERATE) {
                faults.push(Fault::Degenerate { first: name(j), other: name(i), correlation });
            }
        }
    }
    let counts = points_behind(problem, fit);
    let least = LEAST_POINTS.max((LEAST_SHARE * problem.points().len() as f64) as usize);
    for (&i, points) in fit.free.iter().zip(counts) {
        if points < least && fit.parameters[i].least >= 0.0 && !fit.uncertainty.at_bound.contains(&i) {
            faults.push(Fault::FewPoints { name: name(i), points });
        }
    }
    faults.extend(poor_axes(problem.points()).into_iter().map(Fault::Coverage));
    faults
}

/// Returns the number of points that depend on each free parameter p: |p dm/dp| > 0.1 mag.
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
            *count += slope[..lanes].iter().filter(|slope| (*slope * values[i]).abs() > DEPENDENT_MAG).count();
        }
    }
    counts
}

/// One axis of the viewing geometry.
struct Axis {
    name: &'static str,
    angle_rad: fn(&ViewingGeometry) -> f64,
    cell_deg: f64,
    /// Range that must be covered; `None` for the observed range.
    whole_deg: Option<[f64; 2]>,
}

const AXES: [Axis; 3] = [
    Axis { name: "Sun's latitudes", angle_rad: |g| g.sun_latitude_rad, cell_deg: 5.0, whole_deg: None },
    Axis {
        name: "observer's longitudes from the Sun",
        angle_rad: |g| g.folded().observer_longitude_rad,
        cell_deg: 30.0,
        whole_deg: Some([0.0, 180.0]),
    },
    Axis { name: "observer's latitudes", angle_rad: |g| g.observer_latitude_rad, cell_deg: 15.0, whole_deg: None },
];

/// Returns the axes that are poorly covered.
fn poor_axes(points: &[FitPoint]) -> Vec<PoorAxis> {
    AXES.iter().filter_map(|axis| poor(axis, points)).collect()
}

fn poor(axis: &Axis, points: &[FitPoint]) -> Option<PoorAxis> {
    let mut angles_deg: Vec<f64> = points.iter().map(|point| (axis.angle_rad)(&point.geometry).to_degrees()).collect();
    angles_deg.sort_by(f64::total_cmp);
    let seen = [STRAY_SHARE, 1.0 - STRAY_SHARE].map(|share| quantile(&angles_deg, share));
    let cell = axis.cell_deg;
    let is_narrow = axis.whole_deg.is_none() && seen[1] - seen[0] < LEAST_CELLS * cell;
    // The division comes first, so that rounding does not create a bin beyond 180 degrees.
    let [from, to] = axis.whole_deg.unwrap_or(seen).map(|end| end / cell);
    let counts = |k: i32| {
        let [low, high] = [f64::from(k) * cell, f64::from(k + 1) * cell];
        let below = |end: f64| angles_deg.partition_point(|angle| *angle < end);
        // The last bin of an axis with a fixed range includes the end of the range.
        let beyond = if axis.whole_deg.is_some_and(|whole| high >= whole[1]) { angles_deg.len() } else { below(high) };
        ([low, high], beyond - below(low))
    };
    let thin: Vec<_> =
        (from.ceil() as i32..to.floor() as i32).map(counts).filter(|(_, count)| *count < LEAST_IN_CELL).collect();
    let narrow = is_narrow.then_some(seen);
    (narrow.is_some() || !thin.is_empty()).then_some(PoorAxis { name: axis.name, thin, narrow })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every degree of longitude at each of these latitudes of Sun and observer.
    fn seen(suns_deg: &[f64], latitudes_deg: &[f64], keep: impl Fn(f64) -> bool) -> Vec<FitPoint> {
        let longitudes = || (0..180).map(|i| f64::from(i) + 0.5).filter(|longitude| keep(*longitude));
        let all = suns_deg.iter().flat_map(|sun| latitudes_deg.iter().map(move |latitude| (*sun, *latitude)));
        all.flat_map(|(sun, latitude)| longitudes().map(move |longitude| [sun, longitude, latitude]))
            .map(|angles| {
                let [sun, longitude, latitude] = angles.map(f64::to_radians);
                let geometry = ViewingGeometry::from_angles(sun, longitude, latitude, 1000.0, 550.0);
                FitPoint {
                    geometry: geometry.expect("a geometry"),
                    magnitude: 6.0,
                    sigma_mag: 0.1,
                    weight: 1.0,
                    group: 0,
                }
            })
            .collect()
    }

    const SUNS: [f64; 4] = [-21.0, -17.0, -12.0, -7.0];
    const LATITUDES: [f64; 4] = [-80.0, -65.0, -50.0, -35.0];

    #[test]
    fn verif_gaps_and_narrow_ranges_are_named() {
        assert_eq!(poor_axes(&seen(&SUNS, &LATITUDES, |_| true)), []);
        // Nine points of a sector are too few, ten are enough.
        for (end, count) in [(99.0, 9), (100.0, 10)] {
            let few =
                seen(&SUNS[1..2], &LATITUDES[1..2], |longitude| !(90.0..120.0).contains(&longitude) || longitude < end);
            let found = poor_axes(&few).into_iter().find(|axis| axis.name.contains("longitudes"));
            let expected = (count < 10).then(|| vec![([90.0, 120.0], count)]);
            assert_eq!(found.map(|axis| axis.thin), expected);
        }
        let gap = poor_axes(&seen(&[-21.0, -17.0, -7.0], &LATITUDES, |_| true));
        assert_eq!(gap, [PoorAxis { name: "Sun's latitudes", thin: vec![([-15.0, -10.0], 0)], narrow: None }]);
        let gap = poor_axes(&seen(&SUNS, &[-80.0, -50.0, -35.0], |_| true));
        assert_eq!(gap, [PoorAxis { name: "observer's latitudes", thin: vec![([-75.0, -60.0], 0)], narrow: None }]);
        let narrow = poor_axes(&seen(&[-12.0, -9.0], &LATITUDES, |_| true));
        assert_eq!((narrow.len(), narrow[0].name), (1, "Sun's latitudes"));
        assert!(narrow[0].narrow.is_some_and(|[from, to]| (from + 12.0).abs() < 0.1 && (to + 9.0).abs() < 0.1));
    }
}

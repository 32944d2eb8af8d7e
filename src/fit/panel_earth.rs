//! The Earth's light on lists of panels at each point, ready for any coefficients.
//!
//! Light is linear in the weight of each law; what a law of weight 1 makes of the Earth is computed once for each point, and where a
//! parameter bends it (an exponent, a width, a slope) at sixteen values of that, between which it is interpolated.

use rayon::prelude::*;

use crate::photometry::panels::{Coefficient, LawSpec, PanelsSpec};

use super::log_nodes::LogNodes;
use super::point::FitPoint;

/// Values of a bending parameter at which light is known: between them it is good to 1e-3 of itself.
const NODES: usize = 16;

/// All laws on fronts that the Earth lights.
#[derive(Default)]
pub(super) struct PanelEarth {
    laws: Vec<EarthLaw>,
}

/// One of them.
struct EarthLaw {
    weight: Number,
    bent: Option<(Number, LogNodes<NODES>)>,
    /// `(n_point)` of `(n_node)`, m² sr⁻¹ of a weight of 1; one node where nothing bends it.
    light: Vec<Vec<f64>>,
}

/// A number, or the parameter of this index.
#[derive(Copy, Clone)]
enum Number {
    Fixed(f64),
    Parameter(usize),
}

impl Number {
    fn of(spec: &PanelsSpec, coefficient: &Coefficient) -> Self {
        match coefficient {
            Coefficient::Number(value) => Self::Fixed(*value),
            // Files are validated: every name is that of a parameter.
            Coefficient::Parameter(name) => {
                let place = spec.parameters.iter().position(|parameter| parameter.name == *name);
                place.map_or(Self::Fixed(0.0), Self::Parameter)
            }
        }
    }

    fn value(self, x: &[f64]) -> f64 {
        match self {
            Self::Fixed(value) => value,
            Self::Parameter(place) => x[place],
        }
    }
}

impl PanelEarth {
    /// For these points; `None` where two parameters bend one law, for which there is no such table.
    pub fn new(spec: &PanelsSpec, points: &[FitPoint]) -> Option<Self> {
        let ranges = spec.ranges();
        let mut laws = Vec::new();
        for (number, panel) in spec.panels.iter().enumerate().filter(|(_, panel)| panel.earthshine) {
            for law in &panel.front {
                let (weight, bending) = parts(law)?;
                let weight = Number::of(spec, weight);
                let (bent, places) = match bending.map(|coefficient| Number::of(spec, coefficient)) {
                    Some(Number::Parameter(place)) => {
                        let nodes = LogNodes::<NODES>::new(ranges[place]);
                        (Some((Number::Parameter(place), nodes.clone())), nodes.at.to_vec())
                    }
                    Some(Number::Fixed(value)) => (None, vec![value]),
                    None => (None, vec![1.0]),
                };
                // One panel with one law of weight 1 in the Earth's light, the others as they stand for what they hide.
                let alone = |place: &f64| {
                    let mut alone = spec.clone();
                    alone.panels.iter_mut().enumerate().for_each(|(other, panel)| panel.earthshine = other == number);
                    alone.panels[number].front = vec![unit(law, *place)];
                    alone.assemble(&[])
                };
                let assemblies: Vec<_> = places.iter().map(alone).collect();
                let of_point = |point: &FitPoint| {
                    assemblies.iter().map(|assembly| assembly.earthshine_m2_sr(&point.geometry)).collect::<Vec<f64>>()
                };
                laws.push(EarthLaw { weight, bent, light: points.par_iter().map(of_point).collect() });
            }
        }
        Some(Self { laws })
    }

    /// What each law counts for with these parameters, node by node.
    pub fn weights(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let of_law = |law: &EarthLaw| {
            let weight = law.weight.value(x);
            match &law.bent {
                Some((number, nodes)) => nodes.weights(number.value(x)).iter().map(|share| weight * share).collect(),
                None => vec![weight],
            }
        };
        self.laws.iter().map(of_law).collect()
    }

    /// Light of one point, m² sr⁻¹.
    pub fn m2_sr(&self, weights: &[Vec<f64>], point: usize) -> f64 {
        let of_law = |(law, weights): (&EarthLaw, &Vec<f64>)| -> f64 {
            law.light[point].iter().zip(weights).map(|(light, weight)| light * weight).sum()
        };
        self.laws.iter().zip(weights).map(of_law).sum()
    }
}

/// The coefficient that a law is proportional to, and the one that bends it; `None` where there are two such.
fn parts(law: &LawSpec) -> Option<(&Coefficient, Option<&Coefficient>)> {
    /// A law without coefficients is taken once.
    const ONCE: &Coefficient = &Coefficient::Number(1.0);
    match law {
        LawSpec::Lambert { albedo } => Some((albedo, None)),
        LawSpec::Phong { weight, exponent }
        | LawSpec::Straight { weight, exponent }
        | LawSpec::Retro { weight, exponent } => Some((weight, Some(exponent))),
        LawSpec::Facets { weight, slope } => Some((weight, Some(slope))),
        LawSpec::Gaussian { peak_per_sr, width } => Some((peak_per_sr, Some(width))),
        LawSpec::Abg { a, b: Coefficient::Number(_), g: Coefficient::Number(_) } => Some((a, None)),
        LawSpec::Abg { .. } => None,
        LawSpec::Binomial { .. } => Some((ONCE, None)),
    }
}

/// The same law with a weight of 1, bent by this number.
fn unit(law: &LawSpec, bent: f64) -> LawSpec {
    let (one, bent) = (Coefficient::Number(1.0), Coefficient::Number(bent));
    match law.clone() {
        LawSpec::Lambert { .. } => LawSpec::Lambert { albedo: one },
        LawSpec::Phong { .. } => LawSpec::Phong { weight: one, exponent: bent },
        LawSpec::Straight { .. } => LawSpec::Straight { weight: one, exponent: bent },
        LawSpec::Retro { .. } => LawSpec::Retro { weight: one, exponent: bent },
        LawSpec::Facets { .. } => LawSpec::Facets { weight: one, slope: bent },
        LawSpec::Gaussian { .. } => LawSpec::Gaussian { peak_per_sr: one, width: bent },
        LawSpec::Abg { b, g, .. } => LawSpec::Abg { a: one, b, g },
        binomial @ LawSpec::Binomial { .. } => binomial,
    }
}

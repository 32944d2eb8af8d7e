//! Earthshine on lists of panels at each point, for any coefficients.
//!
//! Light is linear in the weight of each law, so a law of weight 1 is computed once for each point. Where a parameter
//! bends the law (an exponent, a width, a slope) it is computed at sixteen values of it and interpolated.

use rayon::prelude::*;

use crate::photometry::panels::{Coefficient, LawSpec, PanelsSpec};

use super::log_nodes::LogNodes;
use super::point::FitPoint;

/// Values of a bending parameter: interpolation is good to 1e-3 of the light.
const NODES: usize = 16;

/// All laws on fronts that receive earthshine.
#[derive(Default)]
pub(super) struct PanelEarth {
    laws: Vec<EarthLaw>,
}

struct EarthLaw {
    /// Index of the parameter that light is proportional to; `None` for a number, which is in the light.
    weight: Option<usize>,
    /// Index of the parameter that bends the law, and its values.
    bent: Option<(usize, LogNodes<NODES>)>,
    /// `(n_point)` of `(n_node)`, m² sr⁻¹; one node where nothing bends the law.
    light: Vec<Vec<f64>>,
}

impl PanelEarth {
    /// Returns `None` where a law depends on parameters in another way: earthshine is then computed each time.
    pub fn new(spec: &PanelsSpec, points: &[FitPoint]) -> Option<Self> {
        let mut laws = Vec::new();
        for (number, panel) in spec.panels.iter().enumerate().filter(|(_, panel)| panel.earthshine) {
            for law in &panel.front {
                // The other panels stay, since they may hide this one.
                let mut alone = spec.clone();
                alone.panels.iter_mut().enumerate().for_each(|(other, panel)| panel.earthshine = other == number);
                alone.panels[number].front = vec![law.clone()];
                laws.push(EarthLaw::new(&alone, law, points)?);
            }
        }
        Some(Self { laws })
    }

    /// Weights of the laws at these parameters, node by node.
    pub fn weights(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let of_law = |law: &EarthLaw| {
            let weight = law.weight.map_or(1.0, |place| x[place]);
            match &law.bent {
                Some((place, nodes)) => nodes.weights(x[*place]).iter().map(|share| weight * share).collect(),
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

impl EarthLaw {
    /// `alone` has earthshine on the panel of this law alone, and no other law there.
    fn new(alone: &PanelsSpec, law: &LawSpec, points: &[FitPoint]) -> Option<Self> {
        let place = |coefficient: &Coefficient| match coefficient {
            Coefficient::Number(_) => None,
            Coefficient::Parameter(name) => alone.parameters.iter().position(|parameter| parameter.name == *name),
        };
        let (linear, bending): (Vec<_>, Vec<_>) = law.terms().into_iter().partition(|term| term.is_linear);
        let weight = linear.iter().find_map(|term| place(term.coefficient));
        let bent = bending.iter().find_map(|term| place(term.coefficient));
        // One parameter of two that bend a law (ABg) moves over a range for which sixteen values are too few.
        if bent.is_some() && (bending.len() > 1 || bent == weight) {
            return None;
        }
        let bent = bent.map(|place| (place, LogNodes::<NODES>::new(alone.ranges()[place])));
        let mut values: Vec<f64> = alone.parameters.iter().map(|parameter| parameter.value).collect();
        if let Some(place) = weight {
            values[place] = 1.0;
        }
        let assemblies: Vec<_> = match &bent {
            Some((place, nodes)) => {
                let at = |value: &f64| {
                    values[*place] = *value;
                    alone.assemble(&values)
                };
                nodes.at.iter().map(at).collect()
            }
            None => vec![alone.assemble(&values)],
        };
        let of_point = |point: &FitPoint| {
            assemblies.iter().map(|assembly| assembly.earthshine_m2_sr(&point.geometry)).collect::<Vec<f64>>()
        };
        Some(Self { weight, bent, light: points.par_iter().map(of_point).collect() })
    }
}

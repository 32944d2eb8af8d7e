//! Earthshine on lists of panels at each point, for any coefficients.
//!
//! Light is linear in the weight of each law, so a law of weight 1 is computed once for each point. If a parameter
//! changes the shape of the law (an exponent, a width, a slope), it is computed at sixteen values of it and
//! interpolated.

use rayon::prelude::*;

use crate::photometry::panels::{Coefficient, LawSpec, PanelsSpec};

use super::log_nodes::LogNodes;
use super::point::FitPoint;

/// Number of values of a shape parameter: the interpolation is accurate to 1e-3 of the light.
const NODES: usize = 16;

/// All laws on fronts that receive earthshine.
#[derive(Default)]
pub(super) struct PanelEarth {
    laws: Vec<EarthLaw>,
}

struct EarthLaw {
    /// Index of the parameter to which light is proportional; `None` for a number, which is included in the light.
    weight: Option<usize>,
    /// Index of the shape parameter, and its values.
    shape: Option<(usize, LogNodes<NODES>)>,
    /// `(n_point)` of `(n_node)`, m² sr⁻¹; one node without a shape parameter.
    light: Vec<Vec<f64>>,
}

impl PanelEarth {
    /// Returns `None` if a law depends on parameters in another way: earthshine is then computed each time.
    pub fn new(spec: &PanelsSpec, points: &[FitPoint]) -> Option<Self> {
        let mut laws = Vec::new();
        for (number, panel) in spec.panels.iter().enumerate().filter(|(_, panel)| panel.earthshine) {
            for law in &panel.front {
                // The other panels are kept, since they may hide this one.
                let mut isolated = spec.clone();
                isolated.panels.iter_mut().enumerate().for_each(|(other, panel)| panel.earthshine = other == number);
                isolated.panels[number].front = vec![law.clone()];
                laws.push(EarthLaw::new(&isolated, law, points)?);
            }
        }
        Some(Self { laws })
    }

    /// Weights of the laws at these parameters, node by node.
    pub fn weights(&self, x: &[f64]) -> Vec<Vec<f64>> {
        let of_law = |law: &EarthLaw| {
            let weight = law.weight.map_or(1.0, |index| x[index]);
            match &law.shape {
                Some((index, nodes)) => nodes.weights(x[*index]).iter().map(|share| weight * share).collect(),
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
    /// `isolated` has earthshine on the panel of this law only, and no other law there.
    fn new(isolated: &PanelsSpec, law: &LawSpec, points: &[FitPoint]) -> Option<Self> {
        let index = |coefficient: &Coefficient| match coefficient {
            Coefficient::Number(_) => None,
            Coefficient::Parameter(name) => isolated.parameters.iter().position(|parameter| parameter.name == *name),
        };
        let (linear, bending): (Vec<_>, Vec<_>) = law.terms().into_iter().partition(|term| term.is_linear);
        let weight = linear.iter().find_map(|term| index(term.coefficient));
        let shape = bending.iter().find_map(|term| index(term.coefficient));
        // If two parameters change the shape of a law (ABg), sixteen values are too few for the range of one of them.
        if shape.is_some() && (bending.len() > 1 || shape == weight) {
            return None;
        }
        let shape = shape.map(|index| (index, LogNodes::<NODES>::new(isolated.ranges()[index])));
        let mut values: Vec<f64> = isolated.parameters.iter().map(|parameter| parameter.value).collect();
        if let Some(index) = weight {
            values[index] = 1.0;
        }
        let assemblies: Vec<_> = match &shape {
            Some((index, nodes)) => {
                let at = |value: &f64| {
                    values[*index] = *value;
                    isolated.assemble(&values)
                };
                nodes.at.iter().map(at).collect()
            }
            None => vec![isolated.assemble(&values)],
        };
        let of_point = |point: &FitPoint| {
            assemblies.iter().map(|assembly| assembly.earthshine_m2_sr(&point.geometry)).collect::<Vec<f64>>()
        };
        Some(Self { weight, shape, light: points.par_iter().map(of_point).collect() })
    }
}

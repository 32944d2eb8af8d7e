//! Satellites of many panels as a form, including their earthshine.
//!
//! Cosines, areas and obstruction do not depend on the parameters and are computed once for each point, as is the
//! earthshine by each reflection law. The laws are then evaluated for each set of parameters. Derivatives are
//! finite differences.
//!
//! The light of a law is proportional to its weight, so that earthshine by a law of weight 1 is computed once for each
//! point. If a parameter changes the shape of the law (an exponent, a width, a slope), earthshine is computed for
//! sixteen values of this parameter and interpolated.

use rayon::prelude::*;

use super::form::{BLOCK, Evaluated, Form, LEAST_LIT_M2, LEAST_M2_SR, Parameter, Prepared};
use super::linear_starts::{self, Basis};
use super::log_nodes::LogNodes;
use super::point::FitPoint;
use super::two_panel_form::TwoPanelForm;
use crate::photometry::brdf::{Brdf, Law};
use crate::photometry::panels::{AttitudeSpec, Coefficient, LawSpec, LitFace, PanelAssembly, PanelsSpec};
use crate::photometry::{Coefficients, Earthshine, SatelliteShape, StandardMagnitude};

/// Panels of a model file, with reflection laws and spheres that can be fitted and attitudes that are fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelsForm {
    /// Panels and laws, with the current values of the parameters.
    pub spec: PanelsSpec,
    /// Model of earthshine, for the panels that receive it.
    pub earthshine: Earthshine,
    /// Magnitude of the Sun, which sets the zero point.
    pub sun_magnitude: f64,
}

impl Form for PanelsForm {
    fn name(&self) -> String {
        "panels".to_owned()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let named = self.spec.parameters.iter().zip(self.spec.ranges());
        named
            .map(|(parameter, [least, greatest])| Parameter::new(&parameter.name, parameter.value, least, greatest))
            .collect()
    }

    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared> {
        let assembly = self.spec.assemble(&[]);
        let seen = |point: &FitPoint| PointGeometry {
            faces: assembly.lit_faces(point.geometry.to_sun().vector(), point.geometry.to_observer().vector()),
            phase_rad: point.geometry.phase_angle_rad(),
        };
        let zero_mag = StandardMagnitude::from_reflection(1.0, self.sun_magnitude).map_or(f64::NAN, |unit| unit.0);
        Box::new(PreparedPanels {
            form: self.clone(),
            points: points.to_vec(),
            seen: points.par_iter().map(seen).collect(),
            has_spheres: !assembly.spheres().is_empty(),
            earth: match self.earthshine {
                Earthshine::Computed => PanelEarth::new(&self.spec, points),
                Earthshine::Off => Some(PanelEarth::default()),
            },
            zero_mag,
        })
    }
}

impl PanelsForm {
    /// Returns the chassis and solar array of Lu (2024) with the sizes of the panel that faces down and of the panel
    /// that follows the Sun's azimuth; `None` if either is missing.
    pub fn as_two_panels(&self) -> Option<TwoPanelForm> {
        let of = |is: fn(&AttitudeSpec) -> bool| self.spec.panels.iter().find(|panel| is(&panel.attitude));
        let base = of(|attitude| matches!(attitude, AttitudeSpec::Nadir {}))?;
        let sail = of(|attitude| matches!(attitude, AttitudeSpec::SunAzimuth { .. }))?;
        let length = |[from, to]: [f64; 2]| to - from;
        Some(TwoPanelForm {
            shape: SatelliteShape {
                sail_length_m: length(sail.v_m),
                sail_width_m: length(sail.u_m),
                base_length_m: length(base.v_m),
                base_width_m: length(base.u_m),
                panel_offset_deg: 0.0,
            },
            coefficients: Coefficients { c1: 0.0, c2: 0.0, c3: 0.0, c4: 0.0, c5: 0.0, n_sail: 1.0, n_base: 1.0 },
            earthshine: self.earthshine,
            blocking: true,
            sun_magnitude: self.sun_magnitude,
        })
    }
}

/// Lit panels and directions for one point.
struct PointGeometry {
    faces: Vec<LitFace>,
    phase_rad: f64,
}

struct PreparedPanels {
    form: PanelsForm,
    points: Vec<FitPoint>,
    seen: Vec<PointGeometry>,
    has_spheres: bool,
    /// Precomputed earthshine; `None` if it must be computed for each set of parameters.
    earth: Option<PanelEarth>,
    zero_mag: f64,
}

/// The reflection laws for one set of parameters.
struct PanelsAt<'a> {
    prepared: &'a PreparedPanels,
    assembly: PanelAssembly,
    /// Weights for the interpolation of earthshine, for each law.
    earth: Vec<Vec<f64>>,
}

impl PreparedPanels {
    fn with(&self, x: &[f64]) -> PanelsAt<'_> {
        let earth = self.earth.as_ref().map(|earth| earth.weights(x)).unwrap_or_default();
        PanelsAt { prepared: self, assembly: self.form.spec.assemble(x), earth }
    }
}

impl PanelsAt<'_> {
    /// Returns the reflected light of one point, m² sr⁻¹.
    fn light_m2_sr(&self, point: usize) -> f64 {
        let seen = &self.prepared.seen[point];
        let of_face = |face: &LitFace| {
            let laws: &[Law] = self.assembly.laws(face.panel, face.face);
            laws.iter().map(|law| law.value_per_sr(&face.incidence)).sum::<f64>() * face.open_m2
        };
        let sunlight: f64 = seen.faces.iter().map(of_face).sum();
        let spheres: f64 = self.assembly.spheres().iter().map(|sphere| sphere.m2_sr(seen.phase_rad)).sum();
        let earth = match &self.prepared.earth {
            Some(earth) => earth.m2_sr(&self.earth, point),
            None => self.assembly.earthshine_m2_sr(&self.prepared.points[point].geometry),
        };
        sunlight + spheres + earth
    }
}

impl Prepared for PreparedPanels {
    fn explains(&self, point: usize) -> bool {
        self.has_spheres || self.seen[point].faces.iter().any(|face| face.open_m2 > LEAST_LIT_M2)
    }

    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a> {
        Box::new(self.with(x))
    }

    fn starts(&self, x: &[f64], free: &[usize], observed: &[(f64, f64)]) -> Vec<Vec<f64>> {
        let (linear, bent): (Vec<usize>, Vec<usize>) = free.iter().partition(|&&i| self.form.spec.is_linear(i));
        let parameters = self.form.parameters();
        linear_starts::search(self, &parameters, x, &linear, &bent, observed, self.zero_mag)
    }
}

/// The light is linear in some of the parameters.
impl Basis for PreparedPanels {
    fn light(&self, x: &[f64]) -> Vec<f64> {
        let at = self.with(x);
        (0..self.points.len()).into_par_iter().map(|point| at.light_m2_sr(point)).collect()
    }
}

impl Evaluated for PanelsAt<'_> {
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]) {
        let from = block * BLOCK;
        let lanes = BLOCK.min(self.prepared.points.len() - from);
        *out = [0.0; BLOCK];
        for (lane, out) in out[..lanes].iter_mut().enumerate() {
            let light = self.light_m2_sr(from + lane).max(LEAST_M2_SR);
            *out = self.prepared.zero_mag - 2.5 * light.log10();
        }
    }
}

/// Number of values of a shape parameter for which earthshine is computed. The interpolation is accurate to 1e-3 of the
/// light.
const NODES: usize = 16;

/// Earthshine by all laws on the fronts of the panels that receive it.
#[derive(Default)]
pub(super) struct PanelEarth {
    laws: Vec<EarthLaw>,
}

struct EarthLaw {
    /// Index of the parameter that is the weight of the law; `light` is then that of weight 1. `None` if the weight is
    /// fixed; `light` is then multiplied by it.
    weight: Option<usize>,
    /// Index of the parameter that changes the shape of the law, and its values at the nodes.
    shape: Option<(usize, LogNodes<NODES>)>,
    /// Light at the nodes, m² sr⁻¹: for each point one number per node. There is one node if no parameter changes the
    /// shape.
    light: Vec<Vec<f64>>,
}

impl PanelEarth {
    /// Returns `None` if one weight and one shape parameter do not describe a law; earthshine is then computed for each
    /// set of parameters.
    pub fn new(spec: &PanelsSpec, points: &[FitPoint]) -> Option<Self> {
        let mut laws = Vec::new();
        for (number, panel) in spec.panels.iter().enumerate().filter(|(_, panel)| panel.earthshine) {
            for law in &panel.front {
                // The other panels are kept, because they may hide this one.
                let mut isolated = spec.clone();
                isolated.panels.iter_mut().enumerate().for_each(|(other, panel)| panel.earthshine = other == number);
                isolated.panels[number].front = vec![law.clone()];
                laws.push(EarthLaw::new(&isolated, law, points)?);
            }
        }
        Some(Self { laws })
    }

    /// Returns the weights of the nodes of each law for these parameters.
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

    /// Returns the earthshine of one point, m² sr⁻¹.
    pub fn m2_sr(&self, weights: &[Vec<f64>], point: usize) -> f64 {
        let of_law = |(law, weights): (&EarthLaw, &Vec<f64>)| -> f64 {
            law.light[point].iter().zip(weights).map(|(light, weight)| light * weight).sum()
        };
        self.laws.iter().zip(weights).map(of_law).sum()
    }
}

impl EarthLaw {
    /// Tabulates the earthshine of one law; `isolated` has earthshine only on the panel of this law, and no other law
    /// there.
    fn new(isolated: &PanelsSpec, law: &LawSpec, points: &[FitPoint]) -> Option<Self> {
        let index = |coefficient: &Coefficient| match coefficient {
            Coefficient::Number(_) => None,
            Coefficient::Parameter(name) => isolated.parameters.iter().position(|parameter| parameter.name == *name),
        };
        let (linear, bending): (Vec<_>, Vec<_>) = law.terms().into_iter().partition(|term| term.is_linear);
        let weight = linear.iter().find_map(|term| index(term.coefficient));
        let shape = bending.iter().find_map(|term| index(term.coefficient));
        // If two parameters change the shape of a law (ABg), interpolation in one of them is not sufficient.
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

//! Any list of panels and spheres as something to be fitted: the parameters that its model file names.
//!
//! What geometry makes of the panels (cosines, areas, what is hidden) does not depend on the parameters: it is made once for each
//! point. Laws are then asked with each set of parameters; derivatives are differences of those laws alone that a parameter moves.

use rayon::prelude::*;

use crate::photometry::brdf::{Brdf, Law};
use crate::photometry::panels::{Face, LitFace, PanelAssembly, PanelsSpec};
use crate::photometry::{Earthshine, StandardMagnitude};

use super::form::{BLOCK, Evaluated, Form, Parameter, Prepared};
use super::linear_starts::{self, Basis};
use super::point::FitPoint;

/// Panels of a model file. Attitudes are not fitted, but laws and spheres are.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelsForm {
    /// Panels, laws, and parameters at their values.
    pub spec: PanelsSpec,
    /// Whether the Earth's light is part of the model, on the panels that receive it.
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
        let seen = |point: &FitPoint| Seen {
            faces: assembly.lit_faces(point.geometry.to_sun().vector(), point.geometry.to_observer().vector()),
            phase_rad: point.geometry.phase_angle_rad(),
        };
        let zero_mag = StandardMagnitude::from_reflection(1.0, self.sun_magnitude).map_or(f64::NAN, |unit| unit.0);
        Box::new(PreparedPanels {
            form: self.clone(),
            points: points.to_vec(),
            seen: points.par_iter().map(seen).collect(),
            has_spheres: false, // TEMP
            zero_mag,
        })
    }
}

/// What one point sees.
struct Seen {
    faces: Vec<LitFace>,
    phase_rad: f64,
}

struct PreparedPanels {
    form: PanelsForm,
    points: Vec<FitPoint>,
    seen: Vec<Seen>,
    has_spheres: bool,
    zero_mag: f64,
}

/// Less than this of all panels together is nothing lit that is seen, m².
const LEAST_LIT_M2: f64 = 1e-6;
/// Light is never taken as less than this, m² sr⁻¹.
const LEAST_M2_SR: f64 = 1e-12;

impl PreparedPanels {
    /// Reflected light of one point, m² sr⁻¹.
    fn light_m2_sr(&self, assembly: &PanelAssembly, point: usize) -> f64 {
        let seen = &self.seen[point];
        let of_face = |face: &LitFace| {
            let laws: &[Law] = assembly.laws(face.panel, face.face);
            laws.iter().map(|law| law.value_per_sr(&face.incidence)).sum::<f64>() * face.open_m2
        };
        let sunlight: f64 = seen.faces.iter().map(of_face).sum();
        let spheres: f64 = 0.0 * seen.phase_rad; // TEMP
        let earth = match self.form.earthshine {
            Earthshine::Computed => assembly.earthshine_m2_sr(&self.points[point].geometry),
            Earthshine::Off => 0.0,
        };
        sunlight + spheres + earth
    }
}

impl Prepared for PreparedPanels {
    fn explains(&self, point: usize) -> bool {
        let is_seen = |face: &LitFace| face.open_m2 > LEAST_LIT_M2 && has_laws(&self.form.spec, face);
        self.has_spheres || self.seen[point].faces.iter().any(is_seen)
    }

    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a> {
        Box::new(PanelsAt { prepared: self, assembly: self.form.spec.assemble(x) })
    }

    fn starts(&self, x: &[f64], free: &[usize], observed: &[(f64, f64)]) -> Vec<Vec<f64>> {
        let (linear, bent): (Vec<usize>, Vec<usize>) = free.iter().partition(|&&i| self.form.spec.is_linear(i));
        let parameters = self.form.parameters();
        linear_starts::search(self, &parameters, x, &linear, &bent, observed, self.zero_mag)
    }
}

fn has_laws(spec: &PanelsSpec, face: &LitFace) -> bool {
    let panel = &spec.panels[face.panel];
    !match face.face {
        Face::Front => panel.front.is_empty(),
        Face::Back => panel.back.is_empty(),
        Face::Through => panel.through.is_empty(),
    }
}

/// Light is linear in some parameters: their basis functions are light with one of them 1 and the others 0.
impl Basis for PreparedPanels {
    fn light(&self, x: &[f64]) -> Vec<f64> {
        let assembly = self.form.spec.assemble(x);
        (0..self.points.len()).into_par_iter().map(|point| self.light_m2_sr(&assembly, point)).collect()
    }
}

struct PanelsAt<'a> {
    prepared: &'a PreparedPanels,
    assembly: PanelAssembly,
}

impl Evaluated for PanelsAt<'_> {
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]) {
        let from = block * BLOCK;
        let lanes = BLOCK.min(self.prepared.points.len() - from);
        *out = [0.0; BLOCK];
        for (lane, out) in out[..lanes].iter_mut().enumerate() {
            let light = self.prepared.light_m2_sr(&self.assembly, from + lane).max(LEAST_M2_SR);
            *out = self.prepared.zero_mag - 2.5 * light.log10();
        }
    }
}

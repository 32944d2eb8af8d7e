//! Derivatives of the light of panels with respect to the parameters of their laws and spheres.
//!
//! In addition to the fitted panels, only the laws and spheres that refer to a parameter are evaluated: cosines, areas
//! and obstruction do not depend on the parameters.

use nalgebra::Vector3;

use super::assembly::{Face, PanelAssembly};
use super::panel_file::PanelsSpec;
use super::shapes::Sphere;
use crate::photometry::brdf::{Brdf, Law};

/// Largest number of parameters of a file.
pub(in crate::photometry) const MOST_PARAMETERS: usize = 64;

/// Laws and spheres with one parameter moved up and down.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::photometry) struct PanelSensitivity {
    laws: Vec<Moved<(usize, Face), Law>>,
    spheres: Vec<Moved<(), Sphere>>,
}

/// A law or sphere with a parameter above and below its value.
#[derive(Clone, Debug, PartialEq)]
struct Moved<Place, Part> {
    place: Place,
    parameter: usize,
    /// Difference of the parameter between `up` and `down`.
    difference: f64,
    up: Part,
    down: Part,
}

impl PanelSensitivity {
    /// Prepares derivatives with these steps of the parameters; a parameter with a step of 0 is not varied.
    pub fn new(spec: &PanelsSpec, steps: &[f64]) -> Self {
        let values: Vec<f64> = spec.parameters.iter().map(|parameter| parameter.value).collect();
        let mut all = Self::default();
        for (parameter, &step) in steps.iter().enumerate().filter(|(_, step)| **step > 0.0) {
            let moved = |by: f64| {
                let mut values = values.clone();
                values[parameter] += by;
                spec.assemble(&values)
            };
            let (up, down, difference) = (moved(step), moved(-step), 2.0 * step);
            for panel in 0..up.names().count() {
                for face in [Face::Front, Face::Back, Face::Through] {
                    let pairs = up.laws(panel, face).iter().zip(down.laws(panel, face));
                    all.laws.extend(pairs.filter(|(up, down)| up != down).map(|(up, down)| Moved {
                        place: (panel, face),
                        parameter,
                        difference,
                        up: up.clone(),
                        down: down.clone(),
                    }));
                }
            }
            let pairs = up.spheres().iter().zip(down.spheres());
            all.spheres.extend(pairs.filter(|(up, down)| up != down).map(|(up, down)| Moved {
                place: (),
                parameter,
                difference,
                up: up.clone(),
                down: down.clone(),
            }));
        }
        all
    }

    /// Returns the derivatives of the sunlight with respect to the parameters, and the sunlight of the `fitted`
    /// assembly, m² sr⁻¹. The directions are those of [`PanelAssembly::b_total_m2_sr`].
    pub fn gradient(
        &self,
        fitted: &PanelAssembly,
        to_sun: &Vector3<f64>,
        to_observer: &Vector3<f64>,
    ) -> ([f64; MOST_PARAMETERS], f64) {
        let mut gradient = [0.0; MOST_PARAMETERS];
        let mut total: f64 = fitted.sphere_parts(to_sun, to_observer).sum();
        let phase_rad = to_sun.dot(to_observer).clamp(-1.0, 1.0).acos();
        for moved in &self.spheres {
            gradient[moved.parameter] += (moved.up.m2_sr(phase_rad) - moved.down.m2_sr(phase_rad)) / moved.difference;
        }
        fitted.each_lit_face(to_sun, to_observer, |lit| {
            if lit.open_m2 <= 0.0 {
                return;
            }
            let value = |law: &Law| law.value_per_sr(&lit.incidence) * lit.open_m2;
            total += fitted.laws(lit.panel, lit.face).iter().map(value).sum::<f64>();
            for moved in self.laws.iter().filter(|moved| moved.place == (lit.panel, lit.face)) {
                gradient[moved.parameter] += (value(&moved.up) - value(&moved.down)) / moved.difference;
            }
        });
        (gradient, total)
    }
}

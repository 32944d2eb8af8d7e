//! Simple forms that depend only on the phase angle: a diffuse sphere and a polynomial.

use crate::photometry::{DiffuseSphere, StandardMagnitude};

use super::form::{BLOCK, Evaluated, Form, Parameter, Prepared};
use super::point::FitPoint;

/// Bounds of the parameters of both forms, mag.
const MAGNITUDES: [f64; 2] = [-30.0, 60.0];

/// Diffuse (Lambertian) sphere. Its only parameter is the magnitude at 1000 km and a phase angle of 90°.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct SphereForm;

/// Polynomial m = Σ aᵢ φⁱ in the reduced phase angle φ = (phase - 90°)/90°.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PhaseForm {
    /// Highest power of the polynomial.
    pub degree: usize,
}

impl Form for SphereForm {
    fn name(&self) -> String {
        "diffuse_sphere".to_owned()
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter::new("half_lit_mag", 6.0, MAGNITUDES[0], MAGNITUDES[1])]
    }

    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared> {
        let sphere = DiffuseSphere { half_lit: StandardMagnitude(0.0) };
        let row = |point: &FitPoint| {
            let offset = sphere.standard_magnitude(point.geometry.phase_angle_rad()).map_or(f64::NAN, |m| m.0);
            (offset, vec![1.0])
        };
        Box::new(Linear::new(points.iter().map(row)))
    }
}

impl Form for PhaseForm {
    fn name(&self) -> String {
        format!("phase_polynomial_{}", self.degree)
    }

    fn parameters(&self) -> Vec<Parameter> {
        let of = |power: usize| {
            let start = if power == 0 { 6.0 } else { 0.0 };
            Parameter::new(&format!("a{power}"), start, MAGNITUDES[0], MAGNITUDES[1])
        };
        (0..=self.degree).map(of).collect()
    }

    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared> {
        let row = |point: &FitPoint| {
            let phase = point.geometry.phase_angle_rad() / std::f64::consts::FRAC_PI_2 - 1.0;
            (0.0, (0..=self.degree as i32).map(|power| phase.powi(power)).collect())
        };
        Box::new(Linear::new(points.iter().map(row)))
    }
}

/// A form whose magnitudes are linear in its parameters.
struct Linear {
    offsets: Vec<[f64; BLOCK]>,
    /// Factors by which the parameters are multiplied: for each block, one column per parameter.
    columns: Vec<Vec<[f64; BLOCK]>>,
}

struct LinearAt<'a> {
    linear: &'a Linear,
    x: Vec<f64>,
}

impl Linear {
    fn new(rows: impl Iterator<Item = (f64, Vec<f64>)>) -> Self {
        let (mut offsets, mut columns) = (Vec::new(), Vec::<Vec<[f64; BLOCK]>>::new());
        for (i, (offset, row)) in rows.enumerate() {
            if i % BLOCK == 0 {
                offsets.push([0.0; BLOCK]);
                columns.push(vec![[0.0; BLOCK]; row.len()]);
            }
            offsets[i / BLOCK][i % BLOCK] = offset;
            for (column, value) in columns[i / BLOCK].iter_mut().zip(row) {
                column[i % BLOCK] = value;
            }
        }
        Self { offsets, columns }
    }
}

impl Prepared for Linear {
    fn explains(&self, point: usize) -> bool {
        // The dark side of a sphere has no magnitude.
        self.offsets[point / BLOCK][point % BLOCK].is_finite()
    }

    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a> {
        Box::new(LinearAt { linear: self, x: x.to_vec() })
    }

    fn starts(&self, x: &[f64], _free: &[usize], _observed: &[(f64, f64)]) -> Vec<Vec<f64>> {
        // The cost of a linear form has a single minimum.
        vec![x.to_vec()]
    }
}

impl Evaluated for LinearAt<'_> {
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]) {
        *out = self.linear.offsets[block];
        for (column, x) in self.linear.columns[block].iter().zip(&self.x) {
            for lane in 0..BLOCK {
                out[lane] += x * column[lane];
            }
        }
    }
}

//! The two-panel law of Lu (2024, section 2) as a form with seven coefficients and the panel offset.
//!
//! The geometry of the points is prepared in blocks: directions, projected areas, and earthshine on the chassis.
//! `two_panel_kernel` then computes magnitudes from the coefficients.

use rayon::prelude::*;

use super::form::{BLOCK, Evaluated, Form, LEAST_LIT_M2, Moved, Parameter, Prepared, Sloped};
use super::linear_starts::{self, Basis};
use super::log_nodes::LogNodes;
use super::point::FitPoint;
use super::two_panel_kernel::{EarthBlock, Evaluation, NODES, SLOPES, lit_panels};
use crate::photometry::two_panel::{Directions, LitPanels, chassis_earthshine};
use crate::photometry::{BrightnessModel, ChassisAndSail, Coefficients, Earthshine, SatelliteShape, StandardMagnitude};

/// Order of the coefficients, as in model files.
const NAMES: [&str; 8] = ["c1", "c2", "c3", "c4", "c5", "n_sail", "n_base", "panel_offset_deg"];
/// Index of the panel offset.
const OFFSET: usize = 7;
/// Bounds of the exponents. Below the lower bound a lobe resembles a second diffuse law; above the upper bound it is
/// narrower than the variation of attitudes.
const EXPONENTS: [f64; 2] = [0.5, 200.0];
/// Bounds of the panel offset, degrees.
const OFFSETS_DEG: [f64; 2] = [-30.0, 30.0];

/// Step of the panel offset for numerical derivatives, degrees.
const OFFSET_STEP_DEG: f64 = 1e-4;

/// Index of the first parameter on which the light depends nonlinearly.
const FIRST_EXPONENT: usize = 5;

/// Chassis and solar array of given sizes, with eight parameters, any of which can be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoPanelForm {
    /// Sizes of the panels, and the panel offset that is used if it is not fitted.
    #[doc(hidden)]
    pub shape: SatelliteShape,
    /// Values of the coefficients that are not fitted.
    #[doc(hidden)]
    pub coefficients: Coefficients,
    /// Model of earthshine on the chassis.
    pub earthshine: Earthshine,
    /// If false, the chassis neither hides nor shades the solar array, as in other published two-panel models.
    pub blocking: bool,
    /// Magnitude of the Sun, which sets the zero point.
    pub sun_magnitude: f64,
}

impl TwoPanelForm {
    /// Returns the form with the sizes, coefficients and band of a model, with blocking; `None` if the model has no two
    /// panels.
    pub fn from_model(model: &BrightnessModel, earthshine: Earthshine) -> Option<Self> {
        let file = model.file()?;
        let (band, system) = model.band();
        Some(Self {
            shape: file.shape?,
            coefficients: file.coefficients?,
            earthshine,
            blocking: true,
            sun_magnitude: band.sun_magnitude(system),
        })
    }
}

impl Form for TwoPanelForm {
    fn name(&self) -> String {
        "two_panel".to_owned()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let c = &self.coefficients;
        let values = [c.c1, c.c2, c.c3, c.c4, c.c5, c.n_sail, c.n_base, self.shape.panel_offset_deg];
        let bounds = |i: usize| match i {
            0..5 => [0.0, 1.0],
            OFFSET => OFFSETS_DEG,
            _ => EXPONENTS,
        };
        let parameter = |i: usize| {
            let parameter = Parameter::new(NAMES[i], values[i], bounds(i)[0], bounds(i)[1]);
            if i == OFFSET { Parameter { step: OFFSET_STEP_DEG, ..parameter } } else { parameter }
        };
        (0..NAMES.len()).map(parameter).collect()
    }

    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared> {
        Box::new(PreparedPoints::new(self, points))
    }
}

/// All points, prepared in blocks. Elements beyond the last point are dark.
struct PreparedPoints {
    form: TwoPanelForm,
    count: usize,
    directions: Vec<Directions<BLOCK>>,
    lit: Vec<LitPanels<BLOCK>>,
    /// Earthshine of each block; empty without earthshine.
    earth: Vec<EarthBlock>,
    exponents: LogNodes<NODES>,
    zero_mag: f64,
}

impl PreparedPoints {
    fn new(form: &TwoPanelForm, points: &[FitPoint]) -> Self {
        let exponents = LogNodes::new(EXPONENTS);
        let earth = match form.earthshine {
            Earthshine::Computed => {
                points.par_chunks(BLOCK).map(|block| earth_block(form, block, &exponents)).collect()
            }
            Earthshine::Off => Vec::new(),
        };
        let mut prepared = Self {
            form: form.clone(),
            count: points.len(),
            directions: points.par_chunks(BLOCK).map(directions).collect(),
            lit: Vec::new(),
            earth,
            exponents,
            zero_mag: StandardMagnitude::from_reflection(1.0, form.sun_magnitude).map_or(f64::NAN, |unit| unit.0),
        };
        prepared.lit = prepared.lit_at(form.shape.panel_offset_deg);
        prepared
    }

    /// Returns the projected areas for a panel offset; empty for an invalid shape.
    fn lit_at(&self, panel_offset_deg: f64) -> Vec<LitPanels<BLOCK>> {
        let shape = SatelliteShape { panel_offset_deg, ..self.form.shape };
        let Some(panels) = ChassisAndSail::new(&shape) else { return Vec::new() };
        let blocking = self.form.blocking;
        self.directions.par_iter().map(|directions| lit_panels(&panels, directions, blocking)).collect()
    }

    fn with(&self, x: &[f64]) -> Evaluation<'_> {
        let offset_deg = x[OFFSET];
        let is_moved = offset_deg != self.form.shape.panel_offset_deg;
        Evaluation {
            c: std::array::from_fn(|k| x[k]),
            exponents: [x[FIRST_EXPONENT], x[FIRST_EXPONENT + 1]],
            zero_mag: self.zero_mag,
            lit: if is_moved { self.lit_at(offset_deg).into() } else { self.lit.as_slice().into() },
            earth: &self.earth,
            earth_weights: self.exponents.weights(x[FIRST_EXPONENT + 1]),
        }
    }
}

fn directions(points: &[FitPoint]) -> Directions<BLOCK> {
    let mut block = Directions { sun: [[0.0; BLOCK]; 2], observer: [[0.0; BLOCK]; 3] };
    for (lane, point) in points.iter().enumerate() {
        let directions = Directions::new(point.geometry.to_sun().vector(), point.geometry.to_observer().vector());
        block.sun.iter_mut().zip(directions.sun).for_each(|(column, [value])| column[lane] = value);
        block.observer.iter_mut().zip(directions.observer).for_each(|(column, [value])| column[lane] = value);
    }
    block
}

fn earth_block(form: &TwoPanelForm, points: &[FitPoint], exponents: &LogNodes<NODES>) -> EarthBlock {
    let base_m2 = form.shape.base_length_m * form.shape.base_width_m;
    let mut block = EarthBlock { diffuse: [0.0; BLOCK], glossy: Box::new([[0.0; BLOCK]; NODES]) };
    for (lane, point) in points.iter().enumerate() {
        for (exponent, row) in exponents.at.iter().zip(block.glossy.iter_mut()) {
            let [glossy, diffuse] = chassis_earthshine(base_m2, &point.geometry, *exponent);
            row[lane] = glossy as f32;
            block.diffuse[lane] = diffuse;
            if diffuse == 0.0 {
                break;
            }
        }
    }
    block
}

impl Prepared for PreparedPoints {
    fn explains(&self, point: usize) -> bool {
        let (block, lane) = (point / BLOCK, point % BLOCK);
        let lit_m2 = |lit: &LitPanels<BLOCK>| lit.front_m2[lane] + lit.through_m2[lane] + lit.base_m2[lane];
        self.lit.get(block).is_some_and(|lit| lit_m2(lit) > LEAST_LIT_M2)
    }

    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a> {
        Box::new(self.with(x))
    }

    fn with_slopes<'a>(&'a self, x: &[f64], free: &[usize], parameters: &[Parameter]) -> Box<dyn Sloped + 'a> {
        // Derivatives with respect to the offset are differences, because the outlines of hidden areas have corners.
        let by_offset = |column| (column, Moved::new(x, OFFSET, &parameters[OFFSET], |x| self.with(x)));
        let slopes_by_offset = free.iter().position(|&i| i == OFFSET).map(by_offset);
        Box::new(Slopes {
            at: self.with(x),
            earth_slopes: self.exponents.slopes(x[FIRST_EXPONENT + 1]),
            free: free.to_vec(),
            slopes_by_offset,
        })
    }

    fn starts(&self, x: &[f64], free: &[usize], observed: &[(f64, f64)]) -> Vec<Vec<f64>> {
        let among =
            |span: std::ops::Range<usize>| free.iter().copied().filter(|i| span.contains(i)).collect::<Vec<_>>();
        let (linear, bent) = (among(0..FIRST_EXPONENT), among(FIRST_EXPONENT..OFFSET));
        linear_starts::search(self, &self.form.parameters(), x, &linear, &bent, observed, self.zero_mag)
    }
}

impl Basis for PreparedPoints {
    fn light(&self, x: &[f64]) -> Vec<f64> {
        let at = self.with(x);
        let mut out = [0.0; BLOCK];
        let mut light = Vec::with_capacity(self.lit.len() * BLOCK);
        for block in 0..self.lit.len() {
            at.magnitudes(block, &mut out);
            light.extend(out.iter().map(|magnitude| 10_f64.powf(0.4 * (self.zero_mag - magnitude))));
        }
        light.truncate(self.count);
        light
    }
}

struct Slopes<'a> {
    at: Evaluation<'a>,
    earth_slopes: [f64; NODES],
    free: Vec<usize>,
    /// Column of the panel offset among the free parameters, and the form at slightly smaller and larger offsets.
    slopes_by_offset: Option<(usize, Moved<Evaluation<'a>>)>,
}

impl Sloped for Slopes<'_> {
    fn magnitudes_and_slopes(&self, block: usize, out: &mut [f64; BLOCK], slopes: &mut [[f64; BLOCK]]) {
        let mut all = [[0.0; BLOCK]; SLOPES];
        self.at.magnitudes_and_slopes(block, &self.earth_slopes, out, &mut all);
        for (column, &parameter) in slopes.iter_mut().zip(&self.free) {
            if let Some(slope) = all.get(parameter) {
                *column = *slope;
            }
        }
        if let Some((column, moved)) = &self.slopes_by_offset {
            moved.slope(block, &mut slopes[*column]);
        }
    }
}

//! What the geometry of each point makes of the two panels, in blocks.

use rayon::prelude::*;

use crate::fit::form::{BLOCK, Evaluated, Form, LEAST_LIT_M2, Moved, Parameter, Prepared, Sloped};
use crate::fit::linear_starts::{self, Basis};
use crate::fit::log_nodes::LogNodes;
use crate::fit::point::FitPoint;
use crate::photometry::{Coefficients, Earthshine, SatelliteModel, SatelliteShape, StandardMagnitude};

use super::earth::{EarthBlock, NODES};
use super::kernel::{At, Numbers};
use super::shape::{EXPONENTS, OFFSET, TwoPanelForm};

/// ln cos θ where the mirror cosine is not positive: any power of it is 0.
const NO_LOBE: f64 = -1e5;

/// One block of points: cosines times areas that light reaches and leaves, m², and logarithms of the mirror cosines.
///
/// Lanes beyond the last point hold a front of 1 m² and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Block {
    pub front_m2: [f64; BLOCK],
    pub through_m2: [f64; BLOCK],
    pub base_m2: [f64; BLOCK],
    pub ln_sail: [f64; BLOCK],
    pub ln_base: [f64; BLOCK],
}

/// All points.
pub(super) struct Columns {
    form: TwoPanelForm,
    points: Vec<FitPoint>,
    blocks: Vec<Block>,
    /// One for each block; none where earthshine is off.
    earth: Vec<EarthBlock>,
    exponents: LogNodes<NODES>,
    zero_mag: f64,
}

impl Columns {
    pub fn new(form: &TwoPanelForm, points: &[FitPoint]) -> Self {
        let exponents = LogNodes::new(EXPONENTS);
        let earth = match form.earthshine {
            Earthshine::Computed => {
                points.par_chunks(BLOCK).map(|block| EarthBlock::new(form, block, &exponents)).collect()
            }
            Earthshine::Off => Vec::new(),
        };
        Self {
            form: form.clone(),
            points: points.to_vec(),
            blocks: Self::blocks(form, points, form.shape.panel_offset_deg),
            earth,
            exponents,
            zero_mag: StandardMagnitude::from_reflection(1.0, form.sun_magnitude).map_or(f64::NAN, |unit| unit.0),
        }
    }

    fn blocks(form: &TwoPanelForm, points: &[FitPoint], panel_offset_deg: f64) -> Vec<Block> {
        let Some(model) = model(form, panel_offset_deg) else { return Vec::new() };
        points.par_chunks(BLOCK).map(|points| Block::new(&model, form.blocking, points)).collect()
    }

    /// What the kernel needs of parameters; its panels are those of the offset that they name.
    fn with(&self, x: &[f64]) -> At<'_> {
        let offset = x[OFFSET];
        let moved = offset != self.form.shape.panel_offset_deg;
        At {
            numbers: Numbers::new(x, self.zero_mag),
            blocks: if moved {
                Self::blocks(&self.form, &self.points, offset).into()
            } else {
                self.blocks.as_slice().into()
            },
            earth: &self.earth,
            weights: self.exponents.weights(x[6]),
        }
    }
}

/// Panels without laws; `None` where the shape makes none.
fn model(form: &TwoPanelForm, panel_offset_deg: f64) -> Option<SatelliteModel> {
    let black = Coefficients { c1: 0.0, c2: 0.0, c3: 0.0, c4: 0.0, c5: 0.0, n_sail: 1.0, n_base: 1.0 };
    SatelliteModel::new(&SatelliteShape { panel_offset_deg, ..form.shape }, &black)
}

impl Block {
    fn new(model: &SatelliteModel, blocking: bool, points: &[FitPoint]) -> Self {
        let mut block = Self {
            front_m2: [1.0; BLOCK],
            through_m2: [0.0; BLOCK],
            base_m2: [0.0; BLOCK],
            ln_sail: [NO_LOBE; BLOCK],
            ln_base: [NO_LOBE; BLOCK],
        };
        let logarithm = |cosine: f64| if cosine > 0.0 { cosine.ln().max(NO_LOBE) } else { NO_LOBE };
        for (lane, point) in points.iter().enumerate() {
            let faces = model.faces(point.geometry.to_sun().vector(), point.geometry.to_observer().vector());
            let open = |lost: f64| if blocking { 1.0 - lost } else { 1.0 };
            block.front_m2[lane] = faces.sail_front_m2 * open(faces.blocked.shadow_or_hidden);
            block.through_m2[lane] = faces.sail_through_m2 * open(faces.blocked.shadow);
            block.base_m2[lane] = faces.base_front_m2;
            block.ln_sail[lane] = logarithm(faces.cos_sail_mirror);
            block.ln_base[lane] = logarithm(faces.cos_base_mirror);
        }
        block
    }
}

impl Prepared for Columns {
    fn explains(&self, point: usize) -> bool {
        let (block, lane) = (point / BLOCK, point % BLOCK);
        self.blocks.get(block).is_some_and(|b| b.front_m2[lane] + b.through_m2[lane] + b.base_m2[lane] > LEAST_LIT_M2)
    }

    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a> {
        Box::new(self.with(x))
    }

    fn with_slopes<'a>(&'a self, x: &[f64], free: &[usize], parameters: &[Parameter]) -> Box<dyn Sloped + 'a> {
        // The blocked shapes have corners: by differences.
        let by_offset = |column| (column, Moved::new(x, OFFSET, &parameters[OFFSET], |x| self.with(x)));
        let slopes_by_offset = free.iter().position(|&i| i == OFFSET).map(by_offset);
        Box::new(Slopes {
            at: self.with(x),
            slopes: self.exponents.slopes(x[6]),
            free: free.to_vec(),
            slopes_by_offset,
        })
    }

    fn starts(&self, x: &[f64], free: &[usize], observed: &[(f64, f64)]) -> Vec<Vec<f64>> {
        let among =
            |span: std::ops::Range<usize>| free.iter().copied().filter(|i| span.contains(i)).collect::<Vec<_>>();
        let (linear, bent) = (among(0..LINEAR), among(LINEAR..OFFSET));
        linear_starts::search(self, &self.form.parameters(), x, &linear, &bent, observed, self.zero_mag)
    }
}

/// Light is linear in c1 to c5.
const LINEAR: usize = 5;

impl Basis for Columns {
    fn light(&self, x: &[f64]) -> Vec<f64> {
        let at = self.with(x);
        let mut out = [0.0; BLOCK];
        let mut light = Vec::with_capacity(self.blocks.len() * BLOCK);
        for block in 0..self.blocks.len() {
            at.magnitudes(block, &mut out);
            light.extend(out.iter().map(|magnitude| 10_f64.powf(0.4 * (self.zero_mag - magnitude))));
        }
        light.truncate(self.points.len());
        light
    }
}

struct Slopes<'a> {
    at: At<'a>,
    slopes: Vec<f64>,
    free: Vec<usize>,
    /// Its column among the free, and the model on both sides.
    slopes_by_offset: Option<(usize, Moved<At<'a>>)>,
}

impl Sloped for Slopes<'_> {
    fn magnitudes_and_slopes(&self, block: usize, out: &mut [f64; BLOCK], slopes: &mut [[f64; BLOCK]]) {
        let all = self.at.magnitudes_and_slopes(block, &self.slopes, out);
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

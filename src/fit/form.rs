//! Interface of a form of brightness law with free parameters, evaluated in blocks of points.

use super::point::FitPoint;

/// Points per block, so that a block stays in the level-1 cache.
pub const BLOCK: usize = 128;

/// Least total lit and visible area of all panels, m².
pub(super) const LEAST_LIT_M2: f64 = 1e-6;
/// Least light of a point, m² sr⁻¹ (magnitude 33 at 1000 km), so that the cost of a black model is finite.
pub(super) const LEAST_M2_SR: f64 = 1e-12;

/// Parameter of a form.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name as in model files.
    pub name: String,
    /// Value if it is not fitted.
    pub value: f64,
    /// Lower bound.
    pub least: f64,
    /// Upper bound.
    pub greatest: f64,
    /// Step for derivatives by differences.
    pub step: f64,
}

impl Parameter {
    /// A parameter with a step of 1e-5 of the interval between its bounds.
    pub fn new(name: &str, value: f64, least: f64, greatest: f64) -> Self {
        Self { name: name.to_owned(), value, least, greatest, step: 1e-5 * (greatest - least) }
    }
}

/// Form of brightness law.
pub trait Form: Sync {
    /// Name for tables.
    fn name(&self) -> String;
    /// Parameters in order.
    fn parameters(&self) -> Vec<Parameter>;
    /// Precomputes everything that depends on the points only.
    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared>;
}

/// Form with precomputed points, in blocks of [`BLOCK`].
pub trait Prepared: Sync + Send {
    /// True if the form gives a magnitude for a point; false where no lit surface is visible.
    fn explains(&self, point: usize) -> bool;
    /// Form with the values of all parameters, in their order.
    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a>;
    /// Starting values for descents, best first. Parameters in `free` vary, the others keep their values in `x`;
    /// `observed` contains magnitude and 1/σ of each point.
    fn starts(&self, x: &[f64], free: &[usize], observed: &[(f64, f64)]) -> Vec<Vec<f64>>;
    /// Form with derivatives by the parameters in `free`; the default uses central differences.
    fn with_slopes<'a>(&'a self, x: &[f64], free: &[usize], parameters: &[Parameter]) -> Box<dyn Sloped + 'a> {
        let moved = |&i: &usize| Moved::new(x, i, &parameters[i], |x| self.at(x));
        Box::new(Differences { middle: self.at(x), moved: free.iter().map(moved).collect() })
    }
}

/// Magnitudes at 1000 km for given parameters.
pub trait Evaluated: Sync + Send {
    /// Computes one block of points; lanes beyond the last point receive any finite number.
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]);
}

/// Magnitudes and their derivatives.
pub trait Sloped: Sync + Send {
    /// Computes one block; `slopes` has one column per free parameter.
    fn magnitudes_and_slopes(&self, block: usize, out: &mut [f64; BLOCK], slopes: &mut [[f64; BLOCK]]);
}

/// Derivatives by central differences.
struct Differences<'a> {
    middle: Box<dyn Evaluated + 'a>,
    moved: Vec<Moved<Box<dyn Evaluated + 'a>>>,
}

/// A form with one parameter increased and decreased, for a central difference.
pub(super) struct Moved<E> {
    up: E,
    down: E,
    per_step: f64,
}

impl<E: Evaluated> Moved<E> {
    /// Moves the parameter of this index one step up and one step down from `x`, within its bounds, outside which a law
    /// may be undefined.
    pub fn new(x: &[f64], index: usize, parameter: &Parameter, at: impl Fn(&[f64]) -> E) -> Self {
        let (mut up, mut down) = (x.to_vec(), x.to_vec());
        up[index] = (x[index] + parameter.step).min(parameter.greatest);
        down[index] = (x[index] - parameter.step).max(parameter.least);
        let per_step = 1.0 / (up[index] - down[index]).max(f64::MIN_POSITIVE);
        Self { up: at(&up), down: at(&down), per_step }
    }

    /// Derivative of the magnitudes of one block.
    pub fn slope(&self, block: usize, slope: &mut [f64; BLOCK]) {
        let mut down_mag = [0.0; BLOCK];
        self.up.magnitudes(block, slope);
        self.down.magnitudes(block, &mut down_mag);
        for (slope, down) in slope.iter_mut().zip(&down_mag) {
            *slope = (*slope - down) * self.per_step;
        }
    }
}

impl<E: Evaluated + ?Sized> Evaluated for Box<E> {
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]) {
        (**self).magnitudes(block, out);
    }
}

impl Sloped for Differences<'_> {
    fn magnitudes_and_slopes(&self, block: usize, out: &mut [f64; BLOCK], slopes: &mut [[f64; BLOCK]]) {
        self.middle.magnitudes(block, out);
        for (moved, slope) in self.moved.iter().zip(slopes) {
            moved.slope(block, slope);
        }
    }
}

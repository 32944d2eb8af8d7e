//! Interface of a form: a brightness law with free parameters, evaluated in blocks of points.

use super::point::FitPoint;

/// Number of points per block, chosen such that a block fits into the level-1 cache.
pub const BLOCK: usize = 128;

/// Smallest total lit and visible area of all panels, m², for which a form gives a magnitude.
pub(super) const LEAST_LIT_M2: f64 = 1e-6;
/// Smallest light of a point, m² sr⁻¹ (magnitude 33 at 1000 km). It keeps the cost of a black model finite.
pub(super) const LEAST_M2_SR: f64 = 1e-12;

/// Parameter of a form, with its value and bounds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Parameter {
    /// Name, as in model files.
    pub name: String,
    /// Value that is used if the parameter is not fitted.
    pub value: f64,
    /// Lower bound.
    pub least: f64,
    /// Upper bound.
    pub greatest: f64,
    /// Step for numerical derivatives.
    pub step: f64,
}

impl Parameter {
    /// Creates a parameter whose step is 1e-5 of the interval between its bounds.
    pub fn new(name: &str, value: f64, least: f64, greatest: f64) -> Self {
        Self { name: name.to_owned(), value, least, greatest, step: 1e-5 * (greatest - least) }
    }
}

/// Form of a brightness law with free parameters.
pub trait Form: Sync {
    /// Returns the name for tables.
    fn name(&self) -> String;
    /// Returns the parameters, in the order in which `Prepared` takes their values.
    fn parameters(&self) -> Vec<Parameter>;
    /// Precomputes everything that depends only on the points.
    #[doc(hidden)]
    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared>;
}

/// A form prepared for a list of points, which are evaluated in blocks of [`BLOCK`].
pub trait Prepared: Sync + Send {
    /// Returns true if the form gives a magnitude for a point; false if no lit surface is visible.
    fn explains(&self, point: usize) -> bool;
    /// Returns the form for given values of all parameters, in their order.
    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a>;
    /// Returns starting values for descents, the best first. The parameters in `free` vary; the others keep their
    /// values in `x`. `observed` contains the magnitude and 1/σ of each point.
    fn starts(&self, x: &[f64], free: &[usize], observed: &[(f64, f64)]) -> Vec<Vec<f64>>;
    /// Returns the form with derivatives with respect to the parameters in `free`; by default these are central
    /// differences.
    fn with_slopes<'a>(&'a self, x: &[f64], free: &[usize], parameters: &[Parameter]) -> Box<dyn Sloped + 'a> {
        let moved = |&i: &usize| Moved::new(x, i, &parameters[i], |x| self.at(x));
        Box::new(Differences { middle: self.at(x), moved: free.iter().map(moved).collect() })
    }
}

/// Magnitudes at 1000 km for given values of the parameters.
pub trait Evaluated: Sync + Send {
    /// Computes one block of points. Elements beyond the last point may be set to any finite number.
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]);
}

/// Magnitudes at 1000 km and their derivatives.
pub trait Sloped: Sync + Send {
    /// Computes one block of points; `slopes` has one column per free parameter.
    fn magnitudes_and_slopes(&self, block: usize, out: &mut [f64; BLOCK], slopes: &mut [[f64; BLOCK]]);
}

/// Derivatives by central differences.
struct Differences<'a> {
    middle: Box<dyn Evaluated + 'a>,
    moved: Vec<Moved<Box<dyn Evaluated + 'a>>>,
}

/// A form with one parameter increased and decreased by a step, for a central difference.
pub(super) struct Moved<E> {
    up: E,
    down: E,
    per_step: f64,
}

impl<E: Evaluated> Moved<E> {
    /// Changes the parameter with this index by one step up and one step down from `x`. Both values are kept within the
    /// bounds, outside which a law may be undefined.
    pub fn new(x: &[f64], index: usize, parameter: &Parameter, at: impl Fn(&[f64]) -> E) -> Self {
        let (mut up, mut down) = (x.to_vec(), x.to_vec());
        up[index] = (x[index] + parameter.step).min(parameter.greatest);
        down[index] = (x[index] - parameter.step).max(parameter.least);
        let per_step = 1.0 / (up[index] - down[index]).max(f64::MIN_POSITIVE);
        Self { up: at(&up), down: at(&down), per_step }
    }

    /// Computes the derivative of the magnitudes of one block.
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

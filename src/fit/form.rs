//! A form of brightness law with parameters to be found, asked block by block.

use super::point::FitPoint;

/// Points that are worked on together: their numbers stay in the nearest cache.
pub const BLOCK: usize = 128;

/// Less than this of all panels together is nothing lit that is seen, m².
pub(super) const LEAST_LIT_M2: f64 = 1e-6;
/// Light is never taken as less than this, m² sr⁻¹: a magnitude of 33 at 1000 km. A black model is bad, not infinitely so.
pub(super) const LEAST_M2_SR: f64 = 1e-12;

/// One number of a form.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// As in model files.
    pub name: String,
    /// Where it stands when it is not fitted.
    pub value: f64,
    /// It may not be less.
    pub least: f64,
    /// It may not be greater.
    pub greatest: f64,
    /// A step that changes magnitudes by a little, for derivatives by differences.
    pub step: f64,
}

impl Parameter {
    /// With a step of 1e-5 of the room between its bounds.
    pub fn new(name: &str, value: f64, least: f64, greatest: f64) -> Self {
        Self { name: name.to_owned(), value, least, greatest, step: 1e-5 * (greatest - least) }
    }
}

/// A form of law, before it has seen points.
pub trait Form: Sync {
    /// What it is called in tables.
    fn name(&self) -> String;
    /// Its parameters.
    fn parameters(&self) -> Vec<Parameter>;
    /// The form made ready for these points.
    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared>;
}

/// A form over given points, in blocks of [`BLOCK`].
pub trait Prepared: Sync + Send {
    /// True where it says something of a point: where nothing lit is seen it does not, and the point cannot be fitted.
    fn explains(&self, point: usize) -> bool;
    /// With parameters (all of them, in their order) put in.
    fn at<'a>(&'a self, x: &[f64]) -> Box<dyn Evaluated + 'a>;
    /// Starting places that are worth going down from, best first; all of `free` may be moved, the others stand in `x`.
    ///
    /// `observed` are magnitudes and 1/σ of the points.
    fn starts(&self, x: &[f64], free: &[usize], observed: &[(f64, f64)]) -> Vec<Vec<f64>>;
    /// With parameters put in, ready to tell derivatives by those of `free`; by central differences unless a form knows better.
    fn with_slopes<'a>(&'a self, x: &[f64], free: &[usize], parameters: &[Parameter]) -> Box<dyn Sloped + 'a> {
        let moved = |&i: &usize| Moved::new(x, i, &parameters[i], |x| self.at(x));
        Box::new(Differences { middle: self.at(x), moved: free.iter().map(moved).collect() })
    }
}

/// Magnitudes at 1000 km.
pub trait Evaluated: Sync + Send {
    /// Of one block of points; lanes beyond the last point hold any finite number.
    fn magnitudes(&self, block: usize, out: &mut [f64; BLOCK]);
}

/// Magnitudes and their derivatives.
pub trait Sloped: Sync + Send {
    /// Of one block; `slopes` has one column for each free parameter.
    fn magnitudes_and_slopes(&self, block: usize, out: &mut [f64; BLOCK], slopes: &mut [[f64; BLOCK]]);
}

/// Derivatives by central differences.
struct Differences<'a> {
    middle: Box<dyn Evaluated + 'a>,
    moved: Vec<Moved<Box<dyn Evaluated + 'a>>>,
}

/// A form with one parameter moved both ways, and one over the way between.
pub(super) struct Moved<E> {
    up: E,
    down: E,
    per_step: f64,
}

impl<E: Evaluated> Moved<E> {
    /// `parameter`, the one of this index, a step up and a step down from `x`, as far as its bounds allow: no law is asked where it means nothing.
    pub fn new(x: &[f64], index: usize, parameter: &Parameter, at: impl Fn(&[f64]) -> E) -> Self {
        let (mut up, mut down) = (x.to_vec(), x.to_vec());
        up[index] = (x[index] + parameter.step).min(parameter.greatest);
        down[index] = (x[index] - parameter.step).max(parameter.least);
        let per_step = 1.0 / (up[index] - down[index]).max(f64::MIN_POSITIVE);
        Self { up: at(&up), down: at(&down), per_step }
    }

    /// The derivative of the magnitudes of one block, by central differences.
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

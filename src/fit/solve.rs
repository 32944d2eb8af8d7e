//! Least-squares fits from several starting points.

use nalgebra::DMatrix;
use sha2::{Digest, Sha256};

use super::covariance::{CovarianceKind, FitUncertainty, uncertainty};
use super::error;
use super::form::{Form, Parameter, Prepared};
use super::inference::{LeastSquares, Minimum, Stop, minimise};
use super::objective::{Loss, Objective};
use super::point::{FitPoint, weigh};
use super::statistics::{ResidualStatistics, group_correlation};
use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

/// Settings of a fit.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct FitSettings {
    /// Names of the free parameters; all others keep their values.
    pub free: Vec<String>,
    /// Parameters that are held at other values than those of the form.
    pub held: Vec<(String, f64)>,
    /// Loss function of the residuals.
    pub loss: Loss,
    /// Rules that end a descent.
    #[doc(hidden)]
    pub least_squares: LeastSquares,
}

impl FitSettings {
    /// Returns settings for least squares with these free parameters.
    pub fn free(names: &[&str]) -> Self {
        Self { free: names.iter().map(|&name| name.to_owned()).collect(), ..Self::default() }
    }
}

/// A form prepared for the points for which it gives a magnitude.
pub struct Problem {
    form: String,
    prepared: Box<dyn Prepared>,
    parameters: Vec<Parameter>,
    free: Vec<usize>,
    points: Vec<FitPoint>,
    /// Indices of the kept points in the list that was given.
    kept: Vec<usize>,
    settings: FitSettings,
}

/// Result of a fit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Fit {
    /// Name of the form.
    pub form: String,
    /// All parameters with their fitted values.
    pub parameters: Vec<Parameter>,
    /// Indices of the free parameters.
    pub free: Vec<usize>,
    /// Half the sum of the losses.
    pub cost: f64,
    /// Final cost of each descent, in the order of the starting points.
    pub costs: Vec<f64>,
    /// Reason for which the best descent stopped.
    #[doc(hidden)]
    pub stop: Stop,
    /// Uncertainty of the parameters.
    pub uncertainty: FitUncertainty,
    /// Indices of the fitted points in the list that was given. For the other points the form gives no magnitude.
    pub kept: Vec<usize>,
    /// Observed minus computed magnitudes of the fitted points.
    pub residuals_mag: Vec<f64>,
}

impl Problem {
    /// Checks the points, drops those for which the form gives no magnitude, and prepares the form.
    ///
    /// # Errors
    /// A parameter is unknown, a magnitude or its error is invalid, or there are too few points
    /// ([`TooFewData`](ErrorKind::TooFewData)).
    pub fn new(form: &dyn Form, points: &[FitPoint], settings: &FitSettings) -> Result<Self, Error> {
        let mut parameters = form.parameters();
        let names: Vec<String> = parameters.iter().map(|parameter| parameter.name.clone()).collect();
        let index = |name: &String| {
            names.iter().position(|known| known == name).ok_or_else(|| {
                Error::new(
                    ErrorKind::Invalid,
                    format!("unknown parameter {:?} of the model {}", Quoted::new(name), form.name()),
                )
                .allowing(names.join(", "))
            })
        };
        for (name, value) in &settings.held {
            parameters[index(name)?].value = *value;
        }
        let mut free = settings.free.iter().map(index).collect::<Result<Vec<_>, _>>()?;
        free.sort_unstable();
        free.dedup();
        for (index, point) in points.iter().enumerate() {
            let wrong = |quantity, given, allowed| {
                Error::new(ErrorKind::Invalid, format!("point {index}: {quantity} is {given}")).allowing(allowed)
            };
            if !(point.sigma_mag > 0.0 && point.sigma_mag.is_finite()) {
                return Err(wrong("sigma_mag", point.sigma_mag, "a positive number"));
            }
            if !(point.weight > 0.0 && point.weight.is_finite()) {
                return Err(wrong("weight", point.weight, "a positive number"));
            }
            if !(-30.0..=60.0).contains(&point.magnitude) {
                return Err(wrong("magnitude", point.magnitude, "-30 to 60"));
            }
        }
        let mut prepared = form.prepare(points);
        let kept: Vec<usize> = (0..points.len()).filter(|&i| prepared.explains(i)).collect();
        if kept.is_empty() {
            return Err(error::no_points(points.len(), &form.name()));
        }
        if kept.len() <= free.len() {
            let names = free.iter().map(|&i| parameters[i].name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(error::too_few(kept.len(), free.len(), &names, free.len() + 1));
        }
        let explained: Vec<FitPoint> = kept.iter().map(|&i| points[i]).collect();
        if kept.len() < points.len() {
            prepared = form.prepare(&explained);
        }
        Ok(Self { form: form.name(), prepared, parameters, free, points: explained, kept, settings: settings.clone() })
    }

    /// Returns the cost as a function of the free parameters.
    pub fn objective(&self) -> Objective<'_> {
        Objective::new(&*self.prepared, self.parameters.clone(), self.free.clone(), &self.points, self.settings.loss)
    }

    /// Returns the form, prepared for the points that were kept.
    #[doc(hidden)]
    pub fn prepared(&self) -> &dyn Prepared {
        &*self.prepared
    }

    /// Returns the points for which the form gives a magnitude.
    pub fn points(&self) -> &[FitPoint] {
        &self.points
    }

    /// Returns the SHA-256 (hexadecimal) of points, form, parameters and loss. It identifies the fit to which a chain
    /// belongs.
    pub fn fingerprint(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(&self.form);
        for parameter in &self.parameters {
            hash.update(&parameter.name);
            [parameter.value, parameter.least, parameter.greatest].iter().for_each(|x| hash.update(x.to_le_bytes()));
        }
        self.free.iter().for_each(|i| hash.update((*i as u64).to_le_bytes()));
        hash.update(format!("{:?}", self.settings.loss));
        // The residuals at the initial values identify the form and the geometry.
        let residuals = self.objective().residuals_mag(&self.free_values(), self.points.len());
        for (point, residual) in self.points.iter().zip(residuals) {
            [point.magnitude, point.sigma_mag, point.weight, residual]
                .iter()
                .for_each(|x| hash.update(x.to_le_bytes()));
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    fn free_values(&self) -> Vec<f64> {
        self.free.iter().map(|&i| self.parameters[i].value).collect()
    }

    /// Minimises the cost from one starting point of the free parameters.
    #[doc(hidden)]
    pub fn descend(&self, start: &[f64]) -> Minimum {
        let objective = self.objective();
        let bounds = |end: fn(&Parameter) -> f64| objective.free_parameters().map(end).collect::<Vec<f64>>();
        let (least, greatest) = (bounds(|p| p.least), bounds(|p| p.greatest));
        minimise(&objective, start, &least, &greatest, &self.settings.least_squares)
    }

    /// Minimises the cost from every starting point that the form proposes, and returns the best minimum.
    ///
    /// # Errors
    /// No descent reaches a finite cost.
    pub fn solve(&self) -> Result<Fit, Error> {
        let starts = self.objective().starts();
        let mut ends: Vec<Minimum> = starts.iter().map(|start| self.descend(start)).collect();
        let costs: Vec<f64> = ends.iter().map(|end| end.cost).collect();
        ends.retain(|end| end.cost.is_finite());
        let best = ends.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        best.map(|best| self.fit_at(best, costs)).ok_or_else(|| error::no_minimum(starts.len()))
    }

    /// Returns the fit, with its uncertainty, at a minimum.
    fn fit_at(&self, minimum: Minimum, costs: Vec<f64>) -> Fit {
        let objective = self.objective();
        let mut parameters = self.parameters.clone();
        for (parameter, value) in parameters.iter_mut().zip(objective.all(&minimum.x)) {
            parameter.value = value;
        }
        let (scores, curvature) = objective.scores(&minimum.x, self.points.len());
        // The curvature of a robust loss is negative for outliers. If the sum is not positive definite, the
        // Gauss-Newton curvature is used instead.
        let is_definite = curvature.clone().cholesky().is_some();
        let curvature: &DMatrix<f64> = if is_definite { &curvature } else { &minimum.curvature };
        let groups: Vec<u32> = self.points.iter().map(|point| point.group).collect();
        let effective: f64 = self.points.iter().map(|point| point.weight).sum();
        Fit {
            form: self.form.clone(),
            uncertainty: uncertainty(curvature, &scores, &groups, &parameters, &self.free, minimum.cost, effective),
            parameters,
            free: self.free.clone(),
            cost: minimum.cost,
            costs,
            stop: minimum.stop,
            kept: self.kept.clone(),
            residuals_mag: objective.residuals_mag(&minimum.x, self.points.len()),
        }
    }
}

/// Sets the weights of single measurements by the correlation of the residuals within their groups, measured with a fit
/// to the points as they are, and returns this correlation.
///
/// # Errors
/// The errors of [`Problem::new`] and [`Problem::solve`].
pub fn weigh_groups(form: &dyn Form, points: &mut [FitPoint], settings: &FitSettings) -> Result<f64, Error> {
    let fit = Problem::new(form, points, settings)?.solve()?;
    let groups: Vec<u32> = fit.kept.iter().map(|&index| points[index].group).collect();
    let correlation = group_correlation(&fit.residuals_mag, &groups);
    weigh(points, correlation);
    Ok(correlation)
}

impl Fit {
    /// Returns the values of all parameters, in order.
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// Replaces the covariance of all parameters, `(n_parameter, n_parameter)`. It remains `None` if the curvature is
    /// singular.
    #[doc(hidden)]
    pub fn with_covariance(mut self, covariance: Vec<Vec<f64>>, kind: CovarianceKind) -> Self {
        if let Some(own) = &mut self.uncertainty.covariance {
            (*own, self.uncertainty.kind) = (covariance, kind);
        }
        self
    }

    /// Returns the weighted statistics of the residuals; `points` are the points that were given to the fit. `None` for
    /// a fit without points.
    #[doc(hidden)]
    pub fn statistics(&self, points: &[FitPoint]) -> Option<ResidualStatistics> {
        let weights = self.kept.iter().map(|&index| points[index].weight);
        ResidualStatistics::weighted(self.residuals_mag.iter().copied().zip(weights))
    }

    /// Returns the value of a parameter; `None` for an unknown name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|parameter| parameter.name == name).map(|parameter| parameter.value)
    }
}

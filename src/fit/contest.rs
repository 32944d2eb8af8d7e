//! Forms of law against one another on the same points and the same unseen folds.

use crate::photometry::{Coefficients, Earthshine};

use super::comparison::aic;
use super::cross_validation::cross_validate;
use super::error::FitError;
use super::form::Form;
use super::phase::{PhaseForm, SphereForm};
use super::point::FitPoint;
use super::solve::{FitSettings, Problem};
use super::statistics::{Spread, honest_sigma_mag, share_within};
use super::two_panel::TwoPanelForm;

/// A form with what is free in it.
pub struct Entrant {
    /// What it is called.
    pub name: String,
    /// The form.
    pub form: Box<dyn Form>,
    /// Names of its free parameters.
    pub free: Vec<String>,
}

/// How one did.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// What it is called.
    pub name: String,
    /// Free parameters.
    pub parameters: usize,
    /// Residuals of the points it was fitted to.
    pub in_sample: Spread,
    /// Residuals of points that were held out.
    pub held_out: Spread,
    /// The same, point by point, in the order of the points; not a number where it says nothing of one.
    pub held_out_mag: Vec<f64>,
    /// Akaike's criterion in sample.
    pub aic: f64,
    /// Sigma that held 68.3 % of the points held out.
    pub honest_sigma_mag: f64,
    /// Share of each fold's points within the honest sigma of the *other* folds: what an announced sigma is worth on unseen points.
    pub within_one_sigma: f64,
}

/// Every entrant fitted and held out; points that any of them says nothing of are left to none, so that all answer for the same.
///
/// # Errors
/// Those of [`Problem`] and [`cross_validate`]; [`FitError::Empty`] where no point is common to all.
pub fn contest(
    entrants: &[Entrant],
    points: &[FitPoint],
    settings: &FitSettings,
    folds: usize,
) -> Result<(Vec<FitPoint>, Vec<Standing>), FitError> {
    let prepared: Vec<_> = entrants.iter().map(|entrant| entrant.form.prepare(points)).collect();
    let common: Vec<FitPoint> =
        (0..points.len()).filter(|&i| prepared.iter().all(|form| form.explains(i))).map(|i| points[i]).collect();
    drop(prepared);
    let standing = |entrant: &Entrant| {
        // What is held of one form may be unknown to another.
        let names: Vec<String> = entrant.form.parameters().into_iter().map(|parameter| parameter.name).collect();
        let held = settings.held.iter().filter(|(name, _)| names.contains(name) && !entrant.free.contains(name));
        let settings = FitSettings { free: entrant.free.clone(), held: held.cloned().collect(), ..settings.clone() };
        let fit = Problem::new(&*entrant.form, &common, &settings)?.solve()?;
        let held = cross_validate(&*entrant.form, &common, &settings, folds)?;
        let empty = || FitError::Empty { given: common.len(), unexplained: common.len(), form: entrant.name.clone() };
        let in_sample = Spread::of(&fit.residuals_mag).ok_or_else(empty)?;
        Ok(Standing {
            name: entrant.name.clone(),
            parameters: entrant.free.len(),
            in_sample,
            held_out: Spread::of(&held.residuals_mag).ok_or_else(empty)?,
            aic: aic(in_sample.rms_mag, in_sample.n, entrant.free.len()),
            honest_sigma_mag: honest_sigma_mag(&held.residuals_mag),
            within_one_sigma: within_of_others(&held.residuals_mag, &held.folds),
            held_out_mag: held.residuals_mag,
        })
    };
    let standings = entrants.iter().map(standing).collect::<Result<_, FitError>>()?;
    Ok((common, standings))
}

/// The share of points within the honest sigma that the other folds announce.
fn within_of_others(residuals_mag: &[f64], folds: &[usize]) -> f64 {
    let count = folds.iter().max().map_or(0, |last| last + 1);
    let (mut inside, mut all) = (0.0, 0.0);
    for fold in 0..count {
        let split = |same: bool| {
            let part = residuals_mag.iter().zip(folds).filter(|(r, f)| r.is_finite() && (**f == fold) == same);
            part.map(|(r, _)| *r).collect::<Vec<f64>>()
        };
        let (held, others) = (split(true), split(false));
        if !held.is_empty() {
            inside += share_within(&held, honest_sigma_mag(&others)) * held.len() as f64;
            all += held.len() as f64;
        }
    }
    inside / all
}

/// What every form has to beat: a diffuse sphere, a quadratic in the phase angle, and, where the satellite has chassis and sail, two
/// Phong panels that hide nothing of one another and let no light through.
pub fn baselines(of: Option<&TwoPanelForm>) -> Vec<Entrant> {
    let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<String>>();
    let mut entrants = vec![
        Entrant { name: "diffuse sphere".to_owned(), form: Box::new(SphereForm), free: names(&["half_lit_mag"]) },
        Entrant {
            name: "quadratic in phase".to_owned(),
            form: Box::new(PhaseForm { degree: 2 }),
            free: names(&["a0", "a1", "a2"]),
        },
    ];
    entrants.extend(of.map(|of| Entrant {
        name: "two Phong panels".to_owned(),
        form: Box::new(TwoPanelForm {
            coefficients: Coefficients { c3: 0.0, ..of.coefficients },
            earthshine: Earthshine::Off,
            blocking: false,
            ..of.clone()
        }),
        free: names(&["c1", "c2", "c4", "c5", "n_sail", "n_base"]),
    }));
    entrants
}

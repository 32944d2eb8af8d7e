//! Forms of law against one another on the same points and the same unseen folds.

use super::measurements::{Measurements, ReduceOptions};
use crate::photometry::{Coefficients, Earthshine};

use super::comparison::aic_under;
use super::cross_validation::{Folds, HeldOut, common, cross_validate_all};
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
    /// The same, point by point, fold by fold.
    pub held_out_mag: Vec<f64>,
    /// Akaike's criterion in sample ([`aic_under`]).
    pub aic: f64,
    /// Sigma that held 68.3 % of the points held out.
    pub honest_sigma_mag: f64,
    /// Share of each fold's points within the honest sigma of the *other* folds: what an announced sigma is worth on unseen points.
    pub within_one_sigma: f64,
}

/// Every entrant fitted and held out; points that any of them says nothing of are left to none, so that all answer for the same.
///
/// `points` are fitted in sample; where they are pixels, `tracks` are the measurements behind them and how these are reduced, and whole
/// tracks are held out.
///
/// # Errors
/// Those of [`Problem`] and [`Folds`]; [`FitError::Empty`] and [`FitError::NoneUnseen`] where no point is common to all.
pub fn contest(
    entrants: &[Entrant],
    points: &[FitPoint],
    tracks: Option<(&Measurements, ReduceOptions)>,
    settings: &FitSettings,
    folds: usize,
) -> Result<Vec<Standing>, FitError> {
    let points = common(entrants.iter().map(|entrant| &*entrant.form), points.to_vec());
    let with_settings = |entrant: &Entrant| {
        // What is held of one form may be unknown to another.
        let names: Vec<String> = entrant.form.parameters().into_iter().map(|parameter| parameter.name).collect();
        let held = settings.held.iter().filter(|(name, _)| names.contains(name) && !entrant.free.contains(name));
        FitSettings { free: entrant.free.clone(), held: held.cloned().collect(), ..settings.clone() }
    };
    let forms: Vec<(&dyn Form, FitSettings)> =
        entrants.iter().map(|entrant| (&*entrant.form, with_settings(entrant))).collect();
    let dealt = match tracks {
        Some((measurements, options)) => Folds::of_tracks(measurements, options, folds)?,
        None => Folds::of_points(&points, folds)?,
    };
    let held = cross_validate_all(&forms, &dealt)?;
    let sigmas_mag: Vec<f64> = points.iter().map(|point| point.sigma_mag).collect();
    let standing = |((entrant, (form, settings)), held): ((&Entrant, &(&dyn Form, FitSettings)), HeldOut)| {
        let fit = Problem::new(*form, &points, settings)?.solve()?;
        let empty = || FitError::Empty { given: points.len(), unexplained: points.len(), form: entrant.name.clone() };
        let in_sample = Spread::of(&fit.residuals_mag).ok_or_else(empty)?;
        Ok(Standing {
            name: entrant.name.clone(),
            parameters: entrant.free.len(),
            in_sample,
            held_out: Spread::of(&held.residuals_mag).ok_or(FitError::NoneUnseen { folds })?,
            aic: aic_under(settings.loss, &fit.residuals_mag, &sigmas_mag, entrant.free.len()),
            honest_sigma_mag: honest_sigma_mag(&held.residuals_mag),
            within_one_sigma: within_of_others(&held.residuals_mag, &held.folds),
            held_out_mag: held.residuals_mag,
        })
    };
    entrants.iter().zip(&forms).zip(held).map(standing).collect()
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

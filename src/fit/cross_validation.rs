//! Comparison of brightness laws (forms) by their predictions for points that were not fitted.
//!
//! Single measurements are held out in groups (tracks, nights). Pixels cannot be held out in this way, because one
//! track contributes to many pixels and would be among the fitted and the predicted ones. For pixels, the tracks are
//! divided into folds. A form is fitted to the pixels made of all folds but one, and compared with the pixels made of
//! the remaining fold. A fold contains a fraction of 1/folds of the points. The thresholds on the numbers of points and
//! tracks are therefore divided by the number of folds and rounded up; the limit on the spread is unchanged.

use rayon::prelude::*;

use super::error;
use super::form::{BLOCK, Form};
use super::jackknife::TrackSets;
use super::measurements::{Measurements, ReduceOptions};
use super::phase::{PhaseForm, SphereForm};
use super::point::{FitPoint, points_of_pixels};
use super::solve::{FitSettings, Problem};
use super::statistics::{ResidualStatistics, aic_under, share_within, weighted_sigma_68_mag};
use super::two_panel_form::TwoPanelForm;
use crate::error::{Error, ErrorKind};
use crate::photometry::{Coefficients, Earthshine};

/// A form that is compared with others, and its free parameters.
pub struct CompetingForm {
    /// Name for tables.
    pub name: String,
    /// Form of the brightness law.
    pub form: Box<dyn Form>,
    /// Names of the free parameters.
    pub free: Vec<String>,
}

/// Result of the comparison for one form.
#[derive(Clone, Debug, PartialEq)]
pub struct FormScore {
    /// Name of the form.
    pub name: String,
    /// Number of free parameters.
    pub parameters: usize,
    /// Weighted statistics of the residuals of the fitted points.
    pub in_sample: ResidualStatistics,
    /// Weighted statistics of the residuals of the points that were held out.
    pub held_out: ResidualStatistics,
    /// The points that were held out, fold by fold.
    pub held_out_points: Vec<HeldOutPoint>,
    /// Akaike's criterion in sample: n ln(RMS²) + 2k for squares, Σ ρ + 2k for a robust loss.
    pub aic: f64,
    /// Sigma that contains 68.3 % of the weight of the residuals of the points that were held out, mag.
    pub sigma_68_mag: f64,
    /// Fraction of the weight of the points of each fold whose residual is within the sigma of the *other* folds. It
    /// shows whether a
    /// predicted sigma holds for new points.
    pub within_one_sigma: f64,
}

/// Magnitude that was held out of the fit that predicts it.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct HeldOutPoint {
    /// Observed magnitude at 1000 km.
    pub observed_mag: f64,
    /// Predicted magnitude at 1000 km.
    pub predicted_mag: f64,
    /// Fold in which the point was held out.
    pub fold: usize,
    /// Weight of the point.
    pub weight: f64,
    /// Group of the point: track, night or pass.
    pub group: u32,
}

impl HeldOutPoint {
    /// Returns observed less predicted magnitude.
    pub fn residual_mag(&self) -> f64 {
        self.observed_mag - self.predicted_mag
    }

    /// Returns the residual and its weight.
    pub fn weighted_residual(&self) -> (f64, f64) {
        (self.residual_mag(), self.weight)
    }
}

/// Fits and cross-validates every form on the points that all forms explain.
///
/// `points` are the points that are fitted. If they are pixels, `tracks` are the measurements from which they were made
/// and the options of the reduction, and whole tracks are held out.
///
/// # Errors
/// * the errors of [`Problem`];
/// * [`TooFewData`](ErrorKind::TooFewData) for fewer than two folds, for fewer groups than folds, and if there is no
///   point for which all forms give a magnitude.
pub fn compare_forms(
    forms: &[CompetingForm],
    points: &[FitPoint],
    tracks: Option<(&Measurements, ReduceOptions)>,
    settings: &FitSettings,
    folds: usize,
) -> Result<Vec<FormScore>, Error> {
    let points = common(forms.iter().map(|competing| &*competing.form), points.to_vec());
    let with_settings = |competing: &CompetingForm| {
        // A parameter that is held in one form may not exist in another.
        let names: Vec<String> = competing.form.parameters().into_iter().map(|parameter| parameter.name).collect();
        let held = settings.held.iter().filter(|(name, _)| names.contains(name) && !competing.free.contains(name));
        FitSettings { free: competing.free.clone(), held: held.cloned().collect(), ..settings.clone() }
    };
    type Fitted<'a> = (&'a dyn Form, FitSettings);
    let fitted: Vec<Fitted<'_>> = forms.iter().map(|competing| (&*competing.form, with_settings(competing))).collect();
    let split = match tracks {
        Some((measurements, options)) => Folds::of_tracks(measurements, options, folds)?,
        None => Folds::of_points(&points, folds)?,
    };
    let held_out = cross_validate(&fitted, &split)?;
    let score = |((competing, (form, settings)), held_out): ((&CompetingForm, &Fitted<'_>), Vec<HeldOutPoint>)| {
        let fit = Problem::new(*form, &points, settings)?.solve()?;
        let residuals: Vec<(f64, f64)> = held_out.iter().map(HeldOutPoint::weighted_residual).collect();
        let finite = residuals.iter().copied().filter(|(residual, _)| residual.is_finite());
        let empty = || error::no_points(points.len(), &competing.name);
        Ok(FormScore {
            name: competing.name.clone(),
            parameters: competing.free.len(),
            in_sample: fit.statistics(&points).ok_or_else(empty)?,
            held_out: ResidualStatistics::weighted(finite).ok_or_else(|| Error::new(ErrorKind::TooFewData, format!("none of {folds} folds contains a test point: the sky pixels have too few points, or no model has a lit surface there")))?,
            aic: aic_under(settings.loss, &fit.residuals_mag, &points, competing.free.len()),
            sigma_68_mag: weighted_sigma_68_mag(&residuals),
            within_one_sigma: within_sigma_of_other_folds(&held_out),
            held_out_points: held_out,
        })
    };
    forms.iter().zip(&fitted).zip(held_out).map(score).collect()
}

/// Returns simple forms for comparison: a diffuse sphere, a quadratic in the phase angle, and, for satellites with
/// chassis and solar array, two Phong panels without mutual blocking, transmission or earthshine.
pub fn baseline_forms(of: Option<&TwoPanelForm>) -> Vec<CompetingForm> {
    let form = |name: &str, form: Box<dyn Form>, free: &[&str]| CompetingForm {
        name: name.to_owned(),
        form,
        free: free.iter().map(|&name| name.to_owned()).collect(),
    };
    let mut forms = vec![
        form("diffuse sphere", Box::new(SphereForm), &["half_lit_mag"]),
        form("quadratic in phase", Box::new(PhaseForm { degree: 2 }), &["a0", "a1", "a2"]),
    ];
    forms.extend(of.map(|of| {
        let panels = TwoPanelForm {
            coefficients: Coefficients { c3: 0.0, ..of.coefficients },
            earthshine: Earthshine::Off,
            blocking: false,
            ..of.clone()
        };
        form("two Phong panels", Box::new(panels), &["c1", "c2", "c4", "c5", "n_sail", "n_base"])
    }));
    forms
}

/// Division of the data into folds.
struct Folds<'a> {
    of: Source<'a>,
    count: usize,
}

enum Source<'a> {
    /// Single measurements, with the fold of each.
    Points(&'a [FitPoint], Vec<usize>),
    Tracks(TrackSets<'a>, ReduceOptions),
}

/// The fitted and the predicted points of one fold.
struct Split {
    seen: Vec<FitPoint>,
    held_out: Vec<FitPoint>,
}

impl<'a> Folds<'a> {
    /// Divides single measurements into folds. Groups are assigned in the order of their numbers and never split.
    fn of_points(points: &'a [FitPoint], count: usize) -> Result<Self, Error> {
        let mut groups: Vec<u32> = points.iter().map(|point| point.group).collect();
        groups.sort_unstable();
        groups.dedup();
        let count = checked(count, groups.len())?;
        let rank = |group: u32| groups.partition_point(|&other| other < group);
        let folds = points.iter().map(|point| rank(point.group) % count).collect();
        Ok(Self { of: Source::Points(points, folds), count })
    }

    /// Divides the tracks (or nights) behind pixels into folds; both parts of each fold are reduced with `options`.
    fn of_tracks(measurements: &'a Measurements, options: ReduceOptions, count: usize) -> Result<Self, Error> {
        let tracks = TrackSets::new(measurements, count);
        let count = checked(count, tracks.groups)?;
        Ok(Self { of: Source::Tracks(tracks, options), count })
    }

    fn split(&self, fold: usize) -> Result<Split, Error> {
        match &self.of {
            Source::Points(points, folds) => {
                let side = |held: bool| {
                    let there = points.iter().zip(folds).filter(|(_, of)| (**of == fold) == held);
                    there.map(|(point, _)| *point).collect::<Vec<FitPoint>>()
                };
                Ok(Split { seen: side(false), held_out: side(true) })
            }
            Source::Tracks(tracks, options) => {
                let share = |least: u32| least.div_ceil(self.count as u32);
                let fewer = ReduceOptions {
                    least_count: share(options.least_count),
                    least_tracks: share(options.least_tracks),
                    ..*options
                };
                Ok(Split {
                    seen: points_of_pixels(&tracks.reduced(*options, |of| of != fold)?),
                    held_out: points_of_pixels(&tracks.reduced(fewer, |of| of == fold)?),
                })
            }
        }
    }
}

fn checked(count: usize, groups: usize) -> Result<usize, Error> {
    if count < 2 || groups < count {
        Err(Error::new(ErrorKind::TooFewData, format!("{groups} tracks or nights for {count} folds"))
            .allowing("2 to the number of tracks or nights (--folds)"))
    } else {
        Ok(count)
    }
}

/// Fits each form without one fold at a time and predicts that fold, on the points that all forms explain.
fn cross_validate(forms: &[(&dyn Form, FitSettings)], folds: &Folds) -> Result<Vec<Vec<HeldOutPoint>>, Error> {
    // Points of each form in each fold.
    let parts: Vec<Vec<Vec<HeldOutPoint>>> = (0..folds.count)
        .into_par_iter()
        .map(|fold| {
            let split = folds.split(fold)?;
            let only_forms = || forms.iter().map(|(form, _)| *form);
            let (seen, held_out) = (common(only_forms(), split.seen), common(only_forms(), split.held_out));
            let predictions = |(form, settings): &(&dyn Form, FitSettings)| {
                let fit = Problem::new(*form, &seen, settings)?.solve()?;
                let predicted = predict(*form, &held_out, &fit.values());
                let of = |(point, predicted_mag): (&FitPoint, f64)| HeldOutPoint {
                    observed_mag: point.magnitude,
                    predicted_mag,
                    fold,
                    weight: point.weight,
                    group: point.group,
                };
                Ok(held_out.iter().zip(predicted).map(of).collect())
            };
            forms.iter().map(predictions).collect()
        })
        .collect::<Result<_, Error>>()?;
    Ok((0..forms.len()).map(|k| parts.iter().flat_map(|part| part[k].iter().copied()).collect()).collect())
}

/// Fraction of the weight within the sigma of the other folds.
fn within_sigma_of_other_folds(held_out: &[HeldOutPoint]) -> f64 {
    let count = held_out.iter().map(|point| point.fold + 1).max().unwrap_or(0);
    let (mut inside, mut all) = (0.0, 0.0);
    for fold in 0..count {
        let side = |same: bool| {
            let part = held_out.iter().filter(|point| (point.fold == fold) == same);
            part.map(HeldOutPoint::weighted_residual).filter(|(r, _)| r.is_finite()).collect::<Vec<_>>()
        };
        let (own, others) = (side(true), side(false));
        let n: f64 = own.iter().map(|(_, weight)| weight).sum();
        if let Some(share) = share_within(own, weighted_sigma_68_mag(&others)) {
            inside += share * n;
            all += n;
        }
    }
    inside / all
}

/// Returns the points for which all forms give a magnitude.
fn common<'f>(forms: impl Iterator<Item = &'f dyn Form>, points: Vec<FitPoint>) -> Vec<FitPoint> {
    forms.fold(points, |points, form| {
        let prepared = form.prepare(&points);
        (0..points.len()).filter(|&i| prepared.explains(i)).map(|i| points[i]).collect()
    })
}

/// Returns the magnitudes at 1000 km that a form predicts with the parameters `x` (all parameters, in order); NaN for
/// points for which the form gives no magnitude.
pub fn predict(form: &dyn Form, points: &[FitPoint], x: &[f64]) -> Vec<f64> {
    let prepared = form.prepare(points);
    let evaluated = prepared.at(x);
    let mut out = [0.0; BLOCK];
    let mut predicted = Vec::with_capacity(points.len());
    for i in 0..points.len() {
        if i % BLOCK == 0 {
            evaluated.magnitudes(i / BLOCK, &mut out);
        }
        predicted.push(if prepared.explains(i) { out[i % BLOCK] } else { f64::NAN });
    }
    predicted
}

#[cfg(test)]
mod tests {
    use super::super::measurements::{Measurement, reduce};
    use super::*;
    use crate::fit::rms;
    use crate::geometry::ViewingGeometry;
    use crate::photometry::StandardMagnitude;

    /// Six tracks of 200 points, each with its own range of phase angles and an offset of 0.5 mag up or down. The
    /// magnitudes follow no brightness law.
    fn tracks() -> Measurements {
        let mut seen = Measurements::default();
        for group in 0..6_u32 {
            seen.groups.push(group.to_string());
            let offset_mag = if group % 2 == 0 { 0.5 } else { -0.5 };
            for i in 0..200 {
                let longitude = 0.2 + 0.45 * (f64::from(group) + f64::from(i) / 200.0);
                let geometry = ViewingGeometry::from_angles(-0.2, longitude, -0.5, 1000.0, 550.0).expect("a geometry");
                let magnitude = StandardMagnitude(6.0 + offset_mag + 0.002 * f64::from(i % 7));
                seen.points.push(Measurement {
                    magnitude,
                    sigma_mag: None,
                    geometry,
                    group,
                    norad_id: None,
                    epoch: None,
                    grazing_height_km: None,
                    lit_fraction: 1.0,
                });
            }
        }
        seen
    }

    fn options() -> ReduceOptions {
        ReduceOptions { least_count: 3, ..ReduceOptions::default() }
    }

    #[test]
    fn verif_pixels_of_a_track_that_is_held_out_are_not_seen() {
        let seen = tracks();
        // Six coefficients can reproduce the offsets of six tracks.
        let form = PhaseForm { degree: 5 };
        let settings = FitSettings::free(&["a0", "a1", "a2", "a3", "a4", "a5"]);
        let points = points_of_pixels(&reduce(&seen.points, options()).expect("pixels"));
        let held_out = |folds: Result<Folds, Error>| {
            let held =
                cross_validate(&[(&form, settings.clone())], &folds.expect("folds")).expect("predictions").remove(0);
            rms(&held.iter().map(HeldOutPoint::residual_mag).collect::<Vec<_>>())
        };
        let (by_pixel, by_track) =
            (held_out(Folds::of_points(&points, 6)), held_out(Folds::of_tracks(&seen, options(), 6)));
        // Neighbouring pixels reveal a track's offset; other tracks do not.
        assert!(by_pixel < 0.5 && by_track > 1.0, "{by_pixel} {by_track}");
    }

    #[test]
    fn verif_each_track_is_on_one_side_and_unseen_once() {
        let seen = tracks();
        let folds = Folds::of_tracks(&seen, ReduceOptions { least_count: 1, ..options() }, 3).expect("folds");
        let whole =
            points_of_pixels(&reduce(&seen.points, ReduceOptions { least_count: 1, ..options() }).expect("pixels"));
        let mut held_out = 0;
        for fold in 0..3 {
            let split = folds.split(fold).expect("two sides");
            let [fitted, judged] = [split.seen.len(), split.held_out.len()];
            assert!((40..56).contains(&fitted) && (20..28).contains(&judged), "{fitted} {judged}");
            held_out += judged;
        }
        // Pixels that two tracks share are counted for both.
        assert!((whole.len()..whole.len() + 6).contains(&held_out), "{held_out} {}", whole.len());
        for count in [0, 1, 7] {
            let error = Folds::of_tracks(&seen, options(), count).err().map(|error| error.to_string());
            assert!(error.is_some_and(|error| error.contains("6 tracks or nights for ")));
        }
    }

    #[test]
    fn verif_thresholds_on_numbers_are_divided() {
        let seen = tracks();
        // 1,200 points are in some 70 pixels. With a sixth of the points, no pixel reaches the undivided threshold.
        let most =
            reduce(&seen.points, options()).expect("pixels").pixels.iter().map(|p| p.count).max().expect("a pixel");
        let strict = ReduceOptions { least_count: most, ..options() };
        let folds = Folds::of_tracks(&seen, strict, 6).expect("folds");
        let held_out: usize = (0..6).map(|fold| folds.split(fold).expect("two sides").held_out.len()).sum();
        assert!(held_out > 10, "{held_out}");
    }
}

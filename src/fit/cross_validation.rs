//! What a form says of points that it has not seen.
//!
//! Single measurements are held out by the group (track, night). Pixels are not: a track gives to many of them, and would be on both sides.
//! There the tracks are dealt into folds, and each side is reduced by itself: a form is fitted to the pixels of all folds but one, and held
//! against the pixels that this one makes alone. Those have a share of 1/folds of the points, so thresholds on their numbers are that share
//! of those on the side that is fitted (rounded up); the limit of their spread is the same.

use rayon::prelude::*;

use super::measurements::{Measurements, ReduceOptions};

use super::error::FitError;
use super::form::{BLOCK, Form};
use super::observed::points_of_pixels;
use super::point::FitPoint;
use super::solve::{FitSettings, Problem};
use super::tracks::Dealt;

/// Residuals of points that were held out of the fit that predicts them.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Observed minus predicted, mag, fold by fold; points that a form says nothing of are not among them.
    pub residuals_mag: Vec<f64>,
    /// Fold in which each of them was held out.
    pub folds: Vec<usize>,
}

/// What is held out in turn: points with what they share, or tracks before they are reduced.
pub struct Folds<'a> {
    of: Source<'a>,
    count: usize,
}

enum Source<'a> {
    /// Points, and the fold of each.
    Points(&'a [FitPoint], Vec<usize>),
    Tracks(Dealt<'a>, ReduceOptions),
}

/// What one fold is judged by.
struct Split {
    seen: Vec<FitPoint>,
    unseen: Vec<FitPoint>,
}

impl<'a> Folds<'a> {
    /// Of single measurements: groups in the order of their numbers, dealt out in turn, so that a group is never split.
    ///
    /// # Errors
    /// [`FitError::Folds`] where there are fewer groups than folds or fewer than two folds.
    pub fn of_points(points: &'a [FitPoint], count: usize) -> Result<Self, FitError> {
        let mut groups: Vec<u32> = points.iter().map(|point| point.group).collect();
        groups.sort_unstable();
        groups.dedup();
        let count = checked(count, groups.len())?;
        let rank = |group: u32| groups.partition_point(|&other| other < group);
        let folds = points.iter().map(|point| rank(point.group) % count).collect();
        Ok(Self { of: Source::Points(points, folds), count })
    }

    /// Of the tracks (or nights) behind pixels, which are reduced with `options` on each side.
    ///
    /// # Errors
    /// [`FitError::Folds`] where there are fewer tracks than folds or fewer than two folds.
    pub fn of_tracks(measurements: &'a Measurements, options: ReduceOptions, count: usize) -> Result<Self, FitError> {
        let dealt = Dealt::new(measurements, count);
        let count = checked(count, dealt.groups)?;
        Ok(Self { of: Source::Tracks(dealt, options), count })
    }

    fn split(&self, fold: usize) -> Result<Split, FitError> {
        match &self.of {
            Source::Points(points, folds) => {
                let side = |held: bool| {
                    let there = points.iter().zip(folds).filter(|(_, of)| (**of == fold) == held);
                    there.map(|(point, _)| *point).collect::<Vec<FitPoint>>()
                };
                Ok(Split { seen: side(false), unseen: side(true) })
            }
            Source::Tracks(dealt, options) => {
                let share = |least: u32| least.div_ceil(self.count as u32);
                let fewer = ReduceOptions {
                    least_count: share(options.least_count),
                    least_tracks: share(options.least_tracks),
                    ..*options
                };
                Ok(Split {
                    seen: points_of_pixels(&dealt.reduced(*options, |of| of != fold)?),
                    unseen: points_of_pixels(&dealt.reduced(fewer, |of| of == fold)?),
                })
            }
        }
    }
}

fn checked(count: usize, groups: usize) -> Result<usize, FitError> {
    if count < 2 || groups < count { Err(FitError::Folds { groups, folds: count }) } else { Ok(count) }
}

/// Fits as often as there are folds, each time without one of them, and predicts that one.
///
/// # Errors
/// Those of [`Problem`] of any fold.
pub fn cross_validate(form: &dyn Form, folds: &Folds, settings: &FitSettings) -> Result<HeldOut, FitError> {
    Ok(cross_validate_all(&[(form, settings.clone())], folds)?.remove(0))
}

/// The same of several forms, one answer for each; points that any of them says nothing of are left to none.
pub(super) fn cross_validate_all(forms: &[(&dyn Form, FitSettings)], folds: &Folds) -> Result<Vec<HeldOut>, FitError> {
    // Residuals of each form in each fold.
    let parts: Vec<Vec<Vec<f64>>> = (0..folds.count)
        .into_par_iter()
        .map(|fold| {
            let split = folds.split(fold)?;
            let only_forms = || forms.iter().map(|(form, _)| *form);
            let (seen, unseen) = (common(only_forms(), split.seen), common(only_forms(), split.unseen));
            let residuals = |(form, settings): &(&dyn Form, FitSettings)| {
                let fit = Problem::new(*form, &seen, settings)?.solve()?;
                let predicted = predict(*form, &unseen, &fit.values());
                Ok(unseen.iter().zip(predicted).map(|(point, predicted)| point.magnitude - predicted).collect())
            };
            forms.iter().map(residuals).collect()
        })
        .collect::<Result<_, FitError>>()?;
    let of_form = |k: usize| {
        let numbered = || parts.iter().enumerate().flat_map(|(fold, part)| part[k].iter().map(move |r| (fold, *r)));
        let (folds, residuals_mag) = numbered().unzip();
        HeldOut { residuals_mag, folds }
    };
    Ok((0..forms.len()).map(of_form).collect())
}

/// The points that all forms say something of.
pub(super) fn common<'f>(forms: impl Iterator<Item = &'f dyn Form>, points: Vec<FitPoint>) -> Vec<FitPoint> {
    forms.fold(points, |points, form| {
        let prepared = form.prepare(&points);
        (0..points.len()).filter(|&i| prepared.explains(i)).map(|i| points[i]).collect()
    })
}

/// Magnitudes at 1000 km that a form with these parameters (all, in order) predicts; not a number where it says nothing.
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
    use crate::fit::{PhaseForm, rms};
    use crate::geometry::ViewingGeometry;
    use crate::photometry::StandardMagnitude;

    /// Six tracks of 200 points, each with a range of phase angles of its own and an offset of 0.5 mag up or down: no law, tracks alone.
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
        // Six coefficients follow six tracks.
        let form = PhaseForm { degree: 5 };
        let settings = FitSettings::free(&["a0", "a1", "a2", "a3", "a4", "a5"]);
        let points = points_of_pixels(&reduce(&seen.points, options()).expect("pixels"));
        let unseen = |folds: Result<Folds, FitError>| {
            let held = cross_validate(&form, &folds.expect("folds"), &settings).expect("predictions");
            assert_eq!(held.residuals_mag.len(), held.folds.len());
            rms(&held.residuals_mag)
        };
        let (by_pixel, by_track) =
            (unseen(Folds::of_points(&points, 6)), unseen(Folds::of_tracks(&seen, options(), 6)));
        // Neighbouring pixels tell a track's offset; other tracks do not.
        assert!(by_pixel < 0.5 && by_track > 1.0, "{by_pixel} {by_track}");
    }

    #[test]
    fn verif_each_track_is_on_one_side_and_unseen_once() {
        let seen = tracks();
        let folds = Folds::of_tracks(&seen, ReduceOptions { least_count: 1, ..options() }, 3).expect("folds");
        let whole =
            points_of_pixels(&reduce(&seen.points, ReduceOptions { least_count: 1, ..options() }).expect("pixels"));
        let mut unseen = 0;
        for fold in 0..3 {
            let split = folds.split(fold).expect("two sides");
            let [fitted, judged] = [split.seen.len(), split.unseen.len()];
            assert!((40..56).contains(&fitted) && (20..28).contains(&judged), "{fitted} {judged}");
            unseen += judged;
        }
        // Pixels that two tracks share are counted for both.
        assert!((whole.len()..whole.len() + 6).contains(&unseen), "{unseen} {}", whole.len());
        for count in [0, 1, 7] {
            assert!(matches!(Folds::of_tracks(&seen, options(), count), Err(FitError::Folds { groups: 6, .. })));
        }
    }

    #[test]
    fn verif_thresholds_on_numbers_are_shared_out() {
        let seen = tracks();
        // 1,200 points in some 70 pixels: none of a sixth of them has as many as all have.
        let most =
            reduce(&seen.points, options()).expect("pixels").pixels.iter().map(|p| p.count).max().expect("a pixel");
        let strict = ReduceOptions { least_count: most, ..options() };
        let folds = Folds::of_tracks(&seen, strict, 6).expect("folds");
        let unseen: usize = (0..6).map(|fold| folds.split(fold).expect("two sides").unseen.len()).sum();
        assert!(unseen > 10, "{unseen}");
    }
}

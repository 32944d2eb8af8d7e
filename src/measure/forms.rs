//! Effect of the form of the point spread function on the light of a streak.

use super::band::Band;
use super::fit::{Amplitude, AssumedForm, Blocks, combined, fit_blocks};
use super::light_errors::error_and_factor;
use super::measurement::Estimate;
use super::streak::{Measuring, Shift, profile_of};
use crate::error::Error;
use crate::math::minimum::minimum;
use crate::streaks::{Optics, RadialProfile, SeeingForm};

/// Forms that a point spread function may have: the wings of stars are between these.
const FORMS: [SeeingForm; 3] =
    [SeeingForm::Gaussian, SeeingForm::Moffat { beta: 3.5 }, SeeingForm::Moffat { beta: 2.5 }];
/// Range of the width of another form relative to that of the assumed one, and accuracy of its logarithm.
const FORM_WIDTHS: [f64; 2] = [0.8, 1.25];
const FORM_WIDTH_TOLERANCE: f64 = 0.02;
/// Another form than the given one is part of the error of the flux if its sum of squares is smaller by this many
/// sigmas.
const FORM_SIGMAS: f64 = 2.0;

impl Measuring<'_> {
    /// Returns the amplitude with the error (one sigma) that the form of the point spread function causes.
    ///
    /// A given form is tested: the error is the difference from the amplitude with the form and the width that fit
    /// best, and zero unless these fit significantly better. If the form is unknown, amplitude and error are mean and
    /// scatter over the forms, weighted by their probabilities exp(-χ²/2).
    pub fn amplitude_of_forms(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
        assumed: &AssumedForm<'_>,
        is_form_known: bool,
    ) -> Estimate {
        let given = self.optics;
        let of = |optics: Optics| -> Option<Amplitude> {
            let profile = profile_of(self.image, self.predicted, &optics).ok()?;
            let drawn = self.drawn_with(&profile, band, shift).ok()??;
            combined(&fit_blocks(band, &band.values, mask, &drawn.template, 0, blocks))
        };
        // The best width depends on the form.
        let with_best_width = |(optics, start): (Optics, Amplitude)| -> Amplitude {
            let at = |ln_ratio: f64| Optics { seeing_arcsec: optics.seeing_arcsec * ln_ratio.exp(), ..optics };
            let ln_ratio = minimum(
                |ln_ratio| of(at(ln_ratio)).map_or(f64::NAN, |amplitude| amplitude.squares),
                FORM_WIDTHS.map(f64::ln),
                (0.0, start.squares),
                FORM_WIDTH_TOLERANCE,
            )
            .0;
            of(at(ln_ratio)).unwrap_or(start)
        };
        let fits = |forms: &mut dyn Iterator<Item = SeeingForm>, seeing_arcsec: f64| -> Vec<(Optics, Amplitude)> {
            forms
                .map(|form| Optics { form, seeing_arcsec, ..given })
                .filter_map(|optics| Some((optics, of(optics)?)))
                .collect()
        };
        let is_width_fitted = given.seeing_arcsec == assumed.seeing_arcsec;
        let mut others = FORMS.into_iter().filter(|form| *form != given.form);
        if !is_form_known {
            let others = fits(&mut others, given.seeing_arcsec).into_iter();
            let others = others.map(|form| if is_width_fitted { with_best_width(form) } else { form.1 });
            let all: Vec<Amplitude> = others.chain([*assumed.amplitude]).collect();
            return mean_by_probability(&all, assumed.squares_of_sigma);
        }
        let by_squares = |first: &Amplitude, other: &Amplitude| first.squares.total_cmp(&other.squares);
        // Forms are compared with a fitted width only if the assumed one has it, too.
        let best = if is_width_fitted {
            fits(&mut others, assumed.seeing_arcsec).into_iter().map(with_best_width).min_by(by_squares)
        } else {
            let all = fits(&mut others.chain([given.form]), assumed.seeing_arcsec).into_iter();
            all.min_by(|first, other| by_squares(&first.1, &other.1)).map(with_best_width)
        };
        let noise = FORM_SIGMAS * FORM_SIGMAS * assumed.squares_of_sigma;
        let best = best.filter(|other| other.squares + noise < assumed.amplitude.squares);
        let value = assumed.amplitude.value;
        Estimate { value, sigma: best.map_or(0.0, |other| (other.value - value).abs()) }
    }

    /// Returns, for a streak too faint to show its form, the relative error (one sigma) of its light because the form
    /// is unknown, and the factor by which it may be brighter.
    pub fn unknown_form_share(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
    ) -> Result<(f64, f64), Error> {
        let others = FORMS.into_iter().filter(|form| *form != self.optics.form);
        let with = |form: SeeingForm| profile_of(self.image, self.predicted, &Optics { form, ..self.optics }).ok();
        let profiles: Vec<RadialProfile> = others.filter_map(with).collect();
        Ok(error_and_factor(&self.responses(&profiles, band, mask, blocks, shift)?))
    }
}

/// Returns mean and scatter of the amplitudes, weighted by the probabilities exp(-χ²/2) of their fits.
fn mean_by_probability(all: &[Amplitude], squares_of_sigma: f64) -> Estimate {
    let least = all.iter().map(|one| one.squares).fold(f64::INFINITY, f64::min);
    // exp(-χ²/2), with χ² = S / S₁ for the sum of squares S and its increase S₁ at one sigma
    let weight = |one: &Amplitude| {
        let chi_square = (one.squares - least) / squares_of_sigma;
        if chi_square > 0.0 { (-0.5 * chi_square).exp() } else { 1.0 }
    };
    let sum: f64 = all.iter().map(weight).sum();
    let mean = |of: &dyn Fn(&Amplitude) -> f64| all.iter().map(|one| weight(one) * of(one)).sum::<f64>() / sum;
    let value = mean(&|one| one.value);
    Estimate { value, sigma: mean(&|one| (one.value - value).powi(2)).sqrt() }
}

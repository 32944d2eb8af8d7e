//! Convolution of the seeing with the ring of the defocused pupil and the disk of the body.

use std::f64::consts::PI;

use crate::error::Error;
use crate::math::quadrature::gauss_legendre;

use super::blur::Blur;
use super::curve::Curve;
use super::seeing::Seeing;

/// Fraction of the flux that the wings beyond the cut contain. The flux is moved inwards, not lost.
const CUT_SHARE: f64 = 1e-4;
/// Brightness of a line, relative to its maximum, at which wings are cut. For a Gaussian this limit is reached at a
/// larger radius than [`CUT_SHARE`].
const CUT_BRIGHTNESS: f64 = 1e-5;

/// Largest accepted radius of the wings, pixels.
const GREATEST_REACH_PIX: f64 = 4000.0;

/// Returns the surface brightness of a point of unit flux as a function of radius.
///
/// # Errors
/// The wings extend beyond 4000 pixels.
pub(super) fn blurred(blur: &Blur) -> Result<Curve, Error> {
    let (seeing, fwhm) = (&blur.seeing, blur.seeing.narrowest_fwhm_pix());
    let (outer, inner, body) = (blur.outer_radius_pix, blur.inner_radius_pix, blur.body_radius_pix);
    let seeing_reach =
        seeing.radius_where(|r| seeing.beyond(r) <= CUT_SHARE && seeing.line(r) <= CUT_BRIGHTNESS * seeing.line(0.0));
    let reach_pix = seeing_reach + blur.flat_radius_pix();
    if reach_pix > GREATEST_REACH_PIX {
        let what = "radius that contains the light (all but 1e-4 of it)";
        let allowed = format!("at most {GREATEST_REACH_PIX} pixels");
        return Err(Error::invalid(what, format!("{reach_pix:.0} pixels"), allowed));
    }
    let rule = Rule { nodes: gauss_legendre(8), step_pix: 1.2 * fwhm };
    let gain = cut_gain(seeing, seeing_reach, &rule);
    // Seeing with its wings cut at R: f(r) (1 + g (r/R)⁴) for r up to R.
    let cut = |r: f64| seeing.at(r) * (1.0 + gain * (r / seeing_reach).powi(4));
    let core = blur.flat_radius_pix() + 2.0 * fwhm;
    let mut profile = Curve::new(2.0 * fwhm, seeing_reach, fwhm, cut);
    if outer > 0.0 {
        profile = Curve::new(core, seeing_reach + outer, fwhm, |r| {
            // The convolution with a ring is the difference of convolutions with two disks.
            let disk = |a: f64| if a > 0.0 { a * a * disk_mean(&profile, a, r, &rule) } else { 0.0 };
            (disk(outer) - disk(inner)) / (outer * outer - inner * inner)
        });
    }
    if body > 0.0 {
        // The edges of a ring occupy only a small part of the range of the integrals over the body, so longer panels
        // are sufficient.
        let rule = Rule { nodes: rule.nodes.clone(), step_pix: rule.step_pix.max(0.01 * outer) };
        profile = Curve::new(core, reach_pix, fwhm, |r| disk_mean(&profile, body, r, &rule));
    }
    let fine = Rule { step_pix: 0.5 * rule.step_pix, ..rule };
    let flux = fine.integrate(0.0, profile.end_pix(), fine.step_pix, |r| 2.0 * PI * r * profile.at(r));
    profile.scale(1.0 / flux);
    Ok(profile)
}

/// Returns the factor g for which the seeing multiplied by 1 + g (r/R)⁴ has unit flux within the radius R. The
/// brightness of the core is unchanged; for a Moffat profile with β = 2.5, the brightness at R/2 grows by a fiftieth.
fn cut_gain(seeing: &Seeing, reach: f64, rule: &Rule) -> f64 {
    let added = |r: f64| 2.0 * PI * r * (r / reach).powi(4) * seeing.at(r);
    seeing.beyond(reach) / rule.integrate(0.0, reach, 0.5 * rule.step_pix, added)
}

/// Gauss-Legendre rule that is applied to several panels, and the length over which profiles are smooth.
struct Rule {
    nodes: Vec<(f64, f64)>,
    step_pix: f64,
}

impl Rule {
    /// Returns the integral from `from` to `to`, in equal panels no longer than `step`; 0 for an empty range.
    fn integrate(&self, from: f64, to: f64, step: f64, function: impl Fn(f64) -> f64) -> f64 {
        let count = ((to - from) / step).ceil().max(0.0);
        let width = (to - from) / count;
        let panel = |panel: usize| {
            let start = from + panel as f64 * width;
            self.nodes.iter().map(|(x, weight)| weight * function(start + x * width)).sum::<f64>()
        };
        if count > 0.0 { width * (0..count as usize).map(panel).sum::<f64>() } else { 0.0 }
    }
}

/// Returns the mean of `profile` over a disk of radius `a` whose centre is at distance `r` from the profile's centre;
/// lengths in pixels.
///
/// A circle of radius s around the profile's centre lies within the disk if s < a - r, and has an arc of angle 2 α in
/// the disk if |r - a| < s < r + a:
///
/// 2 α(s) = 2 arccos((r² + s² - a²) / 2 r s),   mean = 1/(π a²) [ ∫₀^(a-r) 2π s f(s) ds + ∫ 2 α s f(s) ds ].
///
/// The arc grows like a square root from both ends of its range; the substitution s = m - h cos θ makes the integrand
/// smooth.
fn disk_mean(profile: &Curve, a: f64, r: f64, rule: &Rule) -> f64 {
    let full =
        rule.integrate(0.0, (a - r).clamp(0.0, profile.end_pix()), rule.step_pix, |s| 2.0 * PI * s * profile.at(s));
    let (least, greatest) = ((r - a).abs(), r + a);
    let to = greatest.min(profile.end_pix());
    if least >= to {
        return full / (PI * a * a);
    }
    let (middle, half) = (0.5 * (least + greatest), 0.5 * (greatest - least));
    let last_angle = ((middle - to) / half).clamp(-1.0, 1.0).acos();
    let step = 0.5 * rule.step_pix * last_angle / (to - least);
    let arcs = rule.integrate(0.0, last_angle, step, |theta| {
        let (sin, cos) = theta.sin_cos();
        let s = middle - half * cos;
        let alpha = ((r * r + s * s - a * a) / (2.0 * r * s)).clamp(-1.0, 1.0).acos();
        2.0 * alpha * s * profile.at(s) * half * sin
    });
    (full + arcs) / (PI * a * a)
}

//! From the passes of one exposure to its verdict. Pure: no sky is asked here.

use crate::passes::{Exposure, FieldPass};

use super::exposure_flag::{ExposureFlag, Verdict};
use super::policy::Policy;

/// Satellites named in the reasons; under many shells there are dozens.
const NAMED_REASONS: usize = 5;

/// What a verdict needs to know besides the passes.
pub struct Rules<'a> {
    /// The limits.
    pub policy: &'a Policy,
    /// Share of the field's pixels that a pass costs if it comes, [0, 1]; `None` where no telescope says how wide a streak is.
    pub lost_fraction: Option<&'a dyn Fn(&FieldPass) -> f64>,
}

/// Judges an exposure by the passes that cross it, or nearly cross it.
///
/// Dark passes do not count. A near miss counts only where the policy names a `min_probability` and it is at least that
/// probable; all passes count in `p_any`. `avoid` = a crossing at least as probable as the policy asks (0.5 unless it says
/// otherwise) that is brighter, at its peak, than a limit of the policy; or more expected loss than it allows. `streaked` =
/// any other lit crossing. The next clear start of what is not clear is left open: it needs the sky.
pub fn flag(exposure: &Exposure, band: Option<&str>, passes: &[FieldPass], rules: &Rules<'_>) -> ExposureFlag {
    let policy = rules.policy;
    let lit = || passes.iter().filter(|pass| pass.lit);
    let counted: Vec<&FieldPass> = lit().filter(|pass| counts(pass, policy)).collect();
    let nominal = || counted.iter().filter(|pass| pass.is_crossing());

    let mut reasons = Vec::new();
    let mut more_reasons = 0;
    let limits = [
        ("limit", policy.limit_mag.as_ref()),
        ("saturation limit", policy.saturation_mag.as_ref()),
        ("crosstalk limit", policy.crosstalk_mag.as_ref()),
    ];
    let mut avoid = false;
    for pass in counted.iter().filter(|pass| pass.probability >= policy.avoid_probability()) {
        let Some(magnitude) = peak_magnitude(pass) else { continue };
        for (name, limit) in limits {
            if let Some(limit) = limit.and_then(|limit| limit.of(band)).filter(|limit| magnitude < *limit) {
                avoid = true;
                if reasons.len() == NAMED_REASONS {
                    more_reasons += 1;
                    continue;
                }
                reasons.push(format!(
                    "{} reaches mag {magnitude:.2}, brighter than the {name} {limit} (probability {:.2})",
                    pass.norad_id, pass.probability
                ));
            }
        }
    }
    if more_reasons > 0 {
        reasons.push(format!("and {more_reasons} more"));
    }
    let lost = rules
        .lost_fraction
        .map(|lost_fraction| lit().map(|pass| lost_fraction(pass) * pass.probability).sum::<f64>().min(1.0));
    if let (Some(lost), Some(most)) = (lost, policy.max_lost_fraction)
        && lost > most
    {
        avoid = true;
        reasons.push(format!("{lost:.4} of the pixels expected lost, more than {most}"));
    }
    let verdict = match (avoid, counted.is_empty()) {
        (true, _) => Verdict::Avoid,
        (false, false) => Verdict::Streaked,
        (false, true) => Verdict::Clear,
    };
    if verdict == Verdict::Streaked {
        reasons.push(streaked_reason(nominal().count(), counted.len()));
    }
    let clear = verdict == Verdict::Clear;
    ExposureFlag {
        exposure_id: exposure.id.clone(),
        verdict,
        n_streaks: nominal().count(),
        brightest_mag: counted.iter().filter_map(|pass| peak_magnitude(pass)).min_by(f64::total_cmp),
        expected_lost_pixel_fraction: lost,
        p_any: 1.0 - lit().map(|pass| 1.0 - pass.probability.clamp(0.0, 1.0)).product::<f64>(),
        streak_length_deg: nominal().map(|pass| pass.streak_length_rad.to_degrees()).sum(),
        reasons,
        next_clear_start: clear.then_some(exposure.start),
        delay_s: clear.then_some(0.0),
        norad_ids: counted.iter().map(|pass| pass.norad_id).collect(),
    }
}

/// True where a lit pass is a streak to this policy: it crosses, or is a near miss more probable than the policy lets pass.
pub(super) fn counts(pass: &FieldPass, policy: &Policy) -> bool {
    pass.lit && (pass.is_crossing() || policy.min_probability.is_some_and(|least| pass.probability >= least))
}

fn peak_magnitude(pass: &FieldPass) -> Option<f64> {
    pass.peak.as_ref()?.brightness.as_ref().map(|brightness| brightness.magnitude.0)
}

fn streaked_reason(nominal: usize, counted: usize) -> String {
    let near = counted - nominal;
    match (nominal, near) {
        (1, 0) => "1 lit satellite crosses".to_owned(),
        (_, 0) => format!("{nominal} lit satellites cross"),
        (0, 1) => "1 lit satellite may cross".to_owned(),
        (0, _) => format!("{near} lit satellites may cross"),
        _ => format!("{nominal} lit cross, {near} more may"),
    }
}

//! Verdict on one exposure, from the passes that cross it and a policy.

use crate::passes::{CrossingProbability, Exposure, Pass};
use crate::photometry::Brightness;

use super::limits::{Limits, SatelliteLimit};
use super::policy::{Blocking, Policy};
use super::verdict::{Verdict, VerdictKind};

/// Largest number of satellites listed as reasons of one verdict.
const MAX_REASONS: usize = 5;

/// Crossing probabilities and expected loss of an exposure for all satellites together, including near misses.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(super) struct ExpectedLoss {
    /// Probability that at least one satellite crosses while it is lit and brighter than a limit of the policy; that
    /// of `p_crossing` if no limit applies.
    pub p_any: f64,
    /// Probability that at least one lit satellite crosses; with `include_dark`, one that is lit or not.
    pub p_crossing: f64,
    /// True if, for at least one satellite, more than 10 % of the possible delays are outside the range searched. The
    /// other values are then lower limits.
    pub is_lower_limit: bool,
    /// Expected fraction of the pixels lost, [0, 1]; `None` without a telescope.
    pub lost_pixel_fraction: Option<f64>,
    /// Expected cost of the streaks, seconds of open shutter; `None` without a telescope.
    pub streak_cost_s: Option<f64>,
}

impl ExpectedLoss {
    /// Combines satellites whose errors are independent, without the losses that require a telescope. `brighter` is the
    /// probability of each satellite to be brighter than the limit of the policy; without a limit it is empty.
    pub fn new(satellites: &[CrossingProbability], brighter: &[f64]) -> Self {
        let crossing = || satellites.iter().map(|satellite| satellite.probability.clamp(0.0, 1.0));
        let all = std::iter::repeat(&1.0);
        // 1 - Π(1 - p)
        Self {
            p_any: 1.0 - crossing().zip(brighter.iter().chain(all)).map(|(p, above)| 1.0 - p * above).product::<f64>(),
            p_crossing: 1.0 - crossing().map(|p| 1.0 - p).product::<f64>(),
            is_lower_limit: satellites.iter().any(|satellite| satellite.is_lower_limit),
            lost_pixel_fraction: None,
            streak_cost_s: None,
        }
    }
}

/// Judges an exposure by its crossings and near misses. If the verdict is not `clear`, the next starts are not set.
///
/// Passes in the Earth's shadow are ignored, except with `include_dark`. A near miss counts only if the policy has a
/// `min_probability` and the crossing probability is at least that. The verdict is `avoid` if, for one pass that
/// counts, the probability that it crosses and is brighter at its peak than the limit is at least `min_probability`
/// (0.5 if omitted), or if the cost of the streaks exceeds `max_cost_s`. Otherwise it is `streaked` if any pass counts,
/// and `clear` if none does.
pub(super) fn judge_exposure(
    exposure: &Exposure,
    limits: &Limits<'_>,
    passes: &[Pass],
    expected: &ExpectedLoss,
    policy: &Policy,
) -> Verdict {
    let counted: Vec<&Pass> = passes.iter().filter(|pass| is_counted(pass, policy)).collect();
    let nominal = || counted.iter().filter(|pass| pass.is_crossing());

    let above = counted.iter().filter_map(|pass| Some((*pass, limits.of_pass(pass)?, peak_brightness(pass)?))).filter(
        |(pass, limit, brightness)| {
            pass.probability * brightness.probability_brighter_than(limit.limit_mag) >= policy.avoid_probability()
        },
    );
    let mut reasons: Vec<String> = above.map(|(pass, limit, brightness)| reason(pass, brightness, &limit)).collect();
    if reasons.len() > MAX_REASONS {
        let more = reasons.len() - MAX_REASONS;
        reasons.truncate(MAX_REASONS);
        reasons.push(format!("and {more} more"));
    }
    let ExpectedLoss { streak_cost_s, .. } = *expected;
    if let (Some(cost_s), Some(most_s)) = (streak_cost_s, policy.max_cost_s)
        && cost_s > most_s
    {
        reasons.push(format!("expected cost of streaks {} s, more than {most_s} s", text_above(cost_s, most_s)));
    }
    let avoid = !reasons.is_empty();
    let verdict = match (avoid, counted.is_empty()) {
        (true, _) => VerdictKind::Avoid,
        (false, false) => VerdictKind::Streaked,
        (false, true) => VerdictKind::Clear,
    };
    if verdict == VerdictKind::Streaked {
        reasons.push(streaked_reason(nominal().count(), counted.len(), policy.include_dark));
    }
    let clear = verdict == VerdictKind::Clear;
    Verdict {
        exposure_id: exposure.id.clone(),
        kind: verdict,
        n_streaks: nominal().count(),
        brightest_mag: counted
            .iter()
            .filter_map(|pass| peak_brightness(pass))
            .map(|brightness| brightness.magnitude.0)
            .min_by(f64::total_cmp),
        expected_lost_pixel_fraction: expected.lost_pixel_fraction,
        streak_cost_s,
        p_any: expected.p_any,
        p_crossing: expected.p_crossing,
        p_any_is_lower_limit: expected.is_lower_limit,
        streak_length_deg: nominal()
            .map(|pass| policy.streak_length_rad(pass).to_degrees())
            .fold(0.0, |sum, length_deg| sum + length_deg),
        reasons,
        next_clear_start: clear.then_some(exposure.start),
        delay_s: clear.then_some(0.0),
        next_acceptable_start: clear.then_some(exposure.start),
        acceptable_delay_s: clear.then_some(0.0),
        norad_ids: counted.iter().map(|pass| pass.norad_id).collect(),
        // The caller sets the passes, ages and latenesses.
        passes: Vec::new(),
        elements_age_days: None,
        late_s: None,
    }
}

/// Formats a number above `most` with two significant digits and at least two decimals. More decimals are added until
/// the rounded text is above `most`.
fn text_above(number: f64, most: f64) -> String {
    let decimals = (1.0 - number.log10().floor()).clamp(2.0, 17.0) as usize;
    let shown = |decimals: usize| format!("{number:.decimals$}");
    (decimals..17)
        .map(shown)
        .find(|text| text.parse().is_ok_and(|shown: f64| shown > most))
        .unwrap_or(number.to_string())
}

/// Returns the text that explains why a pass exceeds the limit.
fn reason(pass: &Pass, brightness: &Brightness, limit: &SatelliteLimit) -> String {
    let Brightness { sigma_mag, source, .. } = brightness;
    let brighter = percent(brightness.probability_brighter_than(limit.limit_mag));
    // A surface brightness is compared with that of the streak. Rounding removes the errors of the conversion.
    let (limit_mag, magnitude, unit) = match limit.surface_less_mag {
        Some(less_mag) => {
            let limit_mag_arcsec2 = ((limit.limit_mag + less_mag) * 1e6).round() / 1e6;
            (limit_mag_arcsec2, brightness.magnitude.0 + less_mag, " mag/arcsec2")
        }
        None => (limit.limit_mag, brightness.magnitude.0, ""),
    };
    let crossing = match percent(pass.probability).as_str() {
        "100" | ">99" => String::new(),
        percent => format!(", {percent} % of crossing"),
    };
    let norad_id = pass.norad_id;
    format!(
        "{norad_id}: {brighter} % chance of being brighter than {limit_mag}{unit} ({magnitude:.2} +- {sigma_mag:.2}, {source}){crossing}"
    )
}

/// Returns a probability in whole per cent. Only probabilities of exactly 0 and 1 give `0` and `100`.
fn percent(probability: f64) -> String {
    match 100.0 * probability {
        0.0 => "0".to_owned(),
        percent if percent < 1.0 => "<1".to_owned(),
        percent if (99.0..100.0).contains(&percent) => ">99".to_owned(),
        percent => format!("{percent:.0}"),
    }
}

/// Returns true for a lit crossing (or any with `include_dark`), and for such a near miss whose probability is at least
/// the `min_probability` of the policy.
pub(super) fn is_counted(pass: &Pass, policy: &Policy) -> bool {
    (pass.lit || policy.include_dark)
        && (pass.is_crossing() || policy.min_probability.is_some_and(|least| pass.probability >= least))
}

/// Returns true if a pass blocks the start of an exposure. The pass must count. With [`Blocking::Avoid`], if a limit
/// applies, the probability that it crosses and is brighter than the limit must also be at least
/// `min_probability` (0.5 if omitted).
pub(super) fn blocks(pass: &Pass, limits: &Limits<'_>, blocking: Blocking, policy: &Policy) -> bool {
    let exceeds_limit = || {
        limits.of_pass(pass).is_none_or(|limit| {
            pass.probability * pass.probability_brighter_than(limit.limit_mag) >= policy.avoid_probability()
        })
    };
    is_counted(pass, policy) && (blocking == Blocking::Any || exceeds_limit())
}

/// Returns the brightness of a pass at its peak; `None` if the satellite is not visible.
pub(super) fn peak_brightness(pass: &Pass) -> Option<&Brightness> {
    pass.peak.as_ref()?.brightness.as_ref()
}

fn streaked_reason(nominal: usize, counted: usize, include_dark: bool) -> String {
    let near = counted - nominal;
    let text = match (nominal, near) {
        (1, 0) => "1 lit satellite crosses".to_owned(),
        (_, 0) => format!("{nominal} lit satellites cross"),
        (0, 1) => "1 lit satellite may cross".to_owned(),
        (0, _) => format!("{near} lit satellites may cross"),
        _ => format!("{nominal} lit cross, {near} more may"),
    };
    if include_dark { text.replace(" lit", "") } else { text }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use hifitime::Epoch;

    use super::*;
    use crate::elements::NoradId;
    use crate::frames::{Direction, Position};
    use crate::geometry::{Illumination, ViewingGeometry};
    use crate::orbit::PositionSource;
    use crate::passes::{Chord, TrackPoint};
    use crate::photometry::{Brightness, ErrorDistribution, Magnitude, MagnitudeSource};

    #[test]
    fn nearly_certain_is_not_certain() {
        let texts = [0.0, 0.005, 0.01, 0.5, 0.985, 0.995, 1.0 - 1e-12, 1.0].map(percent);
        assert_eq!(texts, ["0", "<1", "1", "50", "98", ">99", ">99", "100"]);
    }

    fn exposure() -> Exposure {
        Exposure {
            id: "e".into(),
            start: Epoch::from_gregorian_utc_at_midnight(2024, 8, 14),
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(1.0, 0.5),
            rotation_rad: 0.0,
        }
    }

    /// Test pass; only the fields used by verdicts have meaningful values.
    fn pass(norad_id: u32, peak_mag: Option<f64>, probability: f64) -> Pass {
        let observer = Position::new(6378.0, 0.0, 0.0);
        let geometry =
            ViewingGeometry::new(&Position::new(6928.0, 100.0, 0.0), &observer, &Position::new(0.0, 1.5e8, 0.0));
        let point = TrackPoint {
            epoch: exposure().start,
            direction: exposure().pointing,
            altitude_rad: Some(1.0),
            azimuth_rad: Some(0.0),
            range_km: 559.0,
            height_km: 550.0,
            geometry: geometry.expect("a geometry"),
            illumination: Illumination::Sunlit,
            brightness: peak_mag.map(|magnitude| Brightness {
                magnitude: Magnitude(magnitude),
                sigma_mag: 0.5,
                scatter_mag: 0.5,
                error_distribution: ErrorDistribution::NORMAL,
                source: MagnitudeSource::Prior,
                in_fitted_range: true,
                grey_reflectance: false,
            }),
        };
        Pass {
            norad_id: NoradId(norad_id),
            element_index: norad_id as usize,
            chords: vec![Chord { enter_s: 3.0, exit_s: 8.0 }],
            lit_chords: vec![Chord { enter_s: 3.0, exit_s: 8.0 }],
            enter: point.clone(),
            mid: point.clone(),
            exit: point.clone(),
            peak: peak_mag.is_some().then_some(point),
            min_separation_rad: 0.0,
            streak_length_rad: TAU / 360.0,
            track_length_rad: TAU / 360.0,
            position_angle_rad: 0.0,
            angular_rate_rad_s: 0.01,
            position_source: PositionSource::ElementSet,
            element_age_days: 0.0,
            along_track_sigma_s: 0.1,
            cross_track_sigma_rad: 0.0,
            probability,
            lit: true,
            samples: Vec::new(),
        }
    }

    fn probabilities(passes: &[Pass]) -> Vec<CrossingProbability> {
        let lit = passes.iter().filter(|pass| pass.lit);
        lit.map(|pass| CrossingProbability {
            element_index: pass.element_index,
            probability: pass.probability,
            streak_length_rad: pass.probability * pass.streak_length_rad,
            along_track_sigma_s: pass.along_track_sigma_s,
            geometry: pass.mid.geometry,
            lit_fraction: 1.0,
            angular_rate_rad_s: pass.angular_rate_rad_s,
            is_lower_limit: false,
        })
        .collect()
    }

    fn judge(passes: &[Pass], policy: &str) -> Verdict {
        let policy = Policy::from_toml(policy).unwrap();
        let satellites = probabilities(passes);
        let brighter: Vec<f64> = policy.limit_mag_in(Some("r")).map_or(Vec::new(), |limit_mag| {
            let lit = passes.iter().filter(|pass| pass.lit);
            lit.map(|pass| pass.probability_brighter_than(limit_mag)).collect()
        });
        // The losses of near misses and crossings are added.
        let sum: f64 = satellites.iter().map(|satellite| satellite.probability).sum();
        let expected = ExpectedLoss {
            lost_pixel_fraction: Some(0.01 * sum),
            streak_cost_s: Some(0.3 * sum),
            ..ExpectedLoss::new(&satellites, &brighter)
        };
        judge_exposure(&exposure(), &Limits::of_mag(policy.limit_mag_in(Some("r"))), passes, &expected, &policy)
    }

    fn verdict(passes: &[Pass], policy: &str) -> VerdictKind {
        judge(passes, policy).kind
    }

    #[test]
    fn verdicts_without_a_policy_are_those_of_the_limit() {
        assert_eq!(verdict(&[], "limit_mag = 7"), VerdictKind::Clear);
        // With a sigma of 0.5 mag, a magnitude 0.1 mag brighter than the limit exceeds it with a probability of 0.579.
        assert_eq!(verdict(&[pass(1, Some(6.9), 0.87)], "limit_mag = 7"), VerdictKind::Avoid);
        assert_eq!(verdict(&[pass(1, Some(6.9), 0.86)], "limit_mag = 7"), VerdictKind::Streaked);
        assert_eq!(verdict(&[pass(1, Some(6.9), 0.86)], "limit_mag = 7\nmin_probability = 0.4"), VerdictKind::Avoid);
        // Streaked: fainter than the limit, less probable than 0.5, of unknown brightness, or without a limit.
        assert_eq!(verdict(&[pass(1, Some(7.01), 1.0)], "limit_mag = 7"), VerdictKind::Streaked);
        assert_eq!(verdict(&[pass(1, Some(2.0), 0.49)], "limit_mag = 7"), VerdictKind::Streaked);
        assert_eq!(verdict(&[pass(1, None, 1.0)], "limit_mag = 7"), VerdictKind::Streaked);
        assert_eq!(verdict(&[pass(1, Some(2.0), 1.0)], ""), VerdictKind::Streaked);
        let dark = Pass { lit: false, ..pass(1, None, 1.0) };
        let flag = judge(&[dark], "limit_mag = 7");
        assert_eq!((flag.kind, flag.n_streaks, flag.p_any, flag.norad_ids.len()), (VerdictKind::Clear, 0, 0.0, 0));
    }

    #[test]
    fn numbers_behind_a_verdict() {
        let passes = [pass(7, Some(6.5), 0.8), pass(3, Some(5.5), 0.6), pass(9, None, 1.0)];
        let flag = judge(&passes, "limit_mag = 6");
        assert_eq!(flag.n_streaks, 3);
        assert_eq!(flag.brightest_mag, Some(5.5));
        assert_eq!(flag.norad_ids, [NoradId(7), NoradId(3), NoradId(9)]);
        assert!((flag.p_crossing - 1.0).abs() < 1e-12);
        // The factors are Φ(-1) and Φ(1). A satellite of unknown brightness has probability 0 of being brighter.
        let expected = 1.0 - (1.0 - 0.8 * 0.158_655_254) * (1.0 - 0.6 * 0.841_344_746);
        assert!((flag.p_any - expected).abs() < 1e-8, "{}", flag.p_any);
        assert!((flag.streak_length_deg - 3.0).abs() < 1e-9);
        assert!((flag.expected_lost_pixel_fraction.unwrap() - 0.024).abs() < 1e-12);
        assert_eq!(flag.reasons, ["3: 84 % chance of being brighter than 6 (5.50 +- 0.50, prior), 60 % of crossing"]);
        let two = judge(&[pass(7, Some(6.5), 0.8), pass(3, Some(5.5), 0.5)], "");
        assert!((two.p_any - 0.9).abs() < 1e-12 && two.p_any == two.p_crossing);
        assert_eq!((two.reasons.as_slice(), two.delay_s), (["2 lit satellites cross".to_owned()].as_slice(), None));
    }

    #[test]
    fn near_misses_count_if_the_policy_has_a_probability() {
        let near =
            Pass { chords: Vec::new(), streak_length_rad: 0.0, track_length_rad: 0.0, ..pass(1, Some(5.0), 0.3) };
        let free = judge(std::slice::from_ref(&near), "limit_mag = 7");
        assert_eq!((free.kind, free.n_streaks), (VerdictKind::Clear, 0));
        // A near miss that does not count still adds to the probability of a clear exposure.
        assert!((free.p_crossing - 0.3).abs() < 1e-12 && free.p_any < free.p_crossing);
        let counted = judge(std::slice::from_ref(&near), "limit_mag = 7\nmin_probability = 0.2");
        assert_eq!((counted.kind, counted.n_streaks, counted.norad_ids.len()), (VerdictKind::Avoid, 0, 1));
        assert_eq!(verdict(std::slice::from_ref(&near), "min_probability = 0.2"), VerdictKind::Streaked);
        assert_eq!(verdict(&[near], "limit_mag = 7\nmin_probability = 0.4"), VerdictKind::Clear);
    }

    #[test]
    fn numbers_are_shown_with_enough_digits_to_differ_from_their_limit() {
        for (number, most, expected) in [
            (2.4194, 0.5, "2.42"),
            (0.0672, 0.06, "0.067"),
            (0.000_010_02, 0.000_01, "0.00001002"),
            (30.0, 5.0, "30.00"),
        ] {
            assert_eq!(text_above(number, most), expected);
        }
    }

    #[test]
    fn every_rule_of_a_policy_can_forbid() {
        let passes = [pass(1, Some(5.0), 1.0)];
        for (policy, expected, word) in [
            ("limit_mag = 5.1", VerdictKind::Avoid, "brighter than 5.1 (5.00 +- 0.50, prior)"),
            ("limit_mag = 4.9", VerdictKind::Streaked, "crosses"),
            ("limit_mag = {r = 5.1, g = 0}", VerdictKind::Avoid, "brighter than 5.1 ("),
            ("limit_mag = {g = 9}", VerdictKind::Streaked, "crosses"),
            ("limit_mag = {g = 0, default = 9}", VerdictKind::Avoid, "brighter than 9 ("),
            ("max_cost_s = 0.29", VerdictKind::Avoid, "expected cost of streaks 0.30 s, more than 0.29 s"),
            ("max_cost_s = 0.31", VerdictKind::Streaked, "crosses"),
        ] {
            let flag = judge(&passes, policy);
            assert_eq!(flag.kind, expected, "{policy}");
            assert!(flag.reasons[0].contains(word), "{policy}: {:?}", flag.reasons);
        }
    }

    #[test]
    fn satellites_that_exceed_a_limit_block_or_all_without_a_limit() {
        let blocked = |pass: &Pass, policy: &str| {
            let policy = Policy::from_toml(policy).unwrap();
            blocks(pass, &Limits::of_mag(policy.limit_mag_in(Some("r"))), policy.blocking, &policy)
        };
        let bright = pass(1, Some(5.0), 1.0);
        assert!(blocked(&bright, "limit_mag = 7") && blocked(&bright, "") && blocked(&bright, "limit_mag = {g = 0}"));
        assert!(!blocked(&bright, "limit_mag = 4.9") && blocked(&bright, "limit_mag = 4.9\nblocking = 'any'"));
        let dark = Pass { lit: false, ..bright.clone() };
        assert!(!blocked(&dark, "limit_mag = 7") && !blocked(&dark, "blocking = 'any'"));
        // Lit, with unknown brightness: blocks only if the policy has no limits.
        let unseen = pass(1, None, 1.0);
        assert!(blocked(&unseen, "") && !blocked(&unseen, "limit_mag = 7"));
        // A crossing with a probability below 0.5 is not avoided.
        let doubtful = pass(1, Some(5.0), 0.3);
        assert!(!blocked(&doubtful, "limit_mag = 7") && blocked(&doubtful, "limit_mag = 7\nblocking = 'any'"));
        let near = Pass { chords: Vec::new(), ..doubtful };
        assert!(!blocked(&near, "") && blocked(&near, "limit_mag = 7\nmin_probability = 0.2"));
        // Probability 0.3 of crossing, and Φ(0.2) = 0.58 of being brighter.
        let near = |policy: &str| blocked(&near, &format!("limit_mag = 5.1\nmin_probability = {policy}"));
        assert!(near("0.17") && !near("0.18"));
    }

    #[test]
    fn many_satellites_are_counted_and_the_first_are_listed() {
        let many: Vec<Pass> = (1..=9).map(|id| pass(id, Some(4.0), 1.0)).collect();
        let flag = judge(&many, "limit_mag = 7");
        assert_eq!((flag.reasons.len(), flag.reasons[5].as_str(), flag.norad_ids.len()), (6, "and 4 more", 9));
    }
}

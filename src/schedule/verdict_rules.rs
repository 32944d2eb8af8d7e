//! Verdict on one exposure, from the passes that cross it and a policy.

use crate::passes::{CrossingProbability, Exposure, Pass};
use crate::photometry::Brightness;

use super::policy::{Blocking, LimitKind, MagnitudeLimit, Policy};
use super::verdict::{Verdict, VerdictKind};

/// Largest number of satellites listed as reasons of one verdict.
const MAX_REASONS: usize = 5;

/// Policy and camera limits that determine a verdict.
pub(super) struct Rules<'a> {
    /// The policy.
    pub policy: &'a Policy,
    /// Magnitude limits of the camera; used if the policy has the word `telescope` as a limit.
    pub camera: Option<&'a dyn CameraLimits>,
}

/// Brightness and motion of one satellite in the field of an exposure.
#[derive(Copy, Clone)]
pub(super) struct Light<'a> {
    /// Index of the element set in the catalogue of the sky.
    pub element_index: usize,
    /// Distance from the observer, km.
    pub range_km: f64,
    /// Angular speed, rad/s.
    pub angular_rate_rad_s: f64,
    /// Predicted magnitude with its distribution.
    pub brightness: &'a Brightness,
}

impl<'a> Light<'a> {
    /// Returns the values of a pass at its peak brightness; `None` if the satellite is not visible.
    pub fn of(pass: &'a Pass) -> Option<Self> {
        Some(Self {
            element_index: pass.element_index,
            range_km: pass.mid.range_km,
            angular_rate_rad_s: pass.angular_rate_rad_s,
            brightness: pass.peak.as_ref()?.brightness.as_ref()?,
        })
    }
}

/// Magnitude limits of a camera, read from its telescope file. They hold for a satellite at a range of 550 km.
pub(super) trait CameraLimits {
    /// Returns the limit of a kind in a band, magnitudes; `None` if the file has none.
    fn limit_mag(&self, kind: LimitKind, band: Option<&str>) -> Option<f64>;
    /// Returns the magnitude, in this band, of a satellite at a range of 550 km whose streak has the same signal per
    /// pixel.
    fn equivalent_mag_at_550_km(&self, light: &Light<'_>, band: Option<&str>) -> f64;
}

/// Limit of a policy that applies to the band of an exposure.
struct AppliedLimit {
    /// Name of the limit in reasons; empty for `limit_mag`.
    name: &'static str,
    limit_mag: f64,
    /// True for a limit of the camera, which holds at a range of 550 km.
    is_of_camera: bool,
}

impl Rules<'_> {
    /// Returns the limits of the policy that apply to a band.
    fn limits(&self, band: Option<&str>) -> impl Iterator<Item = AppliedLimit> {
        let limits = [
            ("", None, self.policy.limit_mag.as_ref()),
            ("saturation limit ", Some(LimitKind::Saturation), self.policy.saturation_mag.as_ref()),
            ("crosstalk limit ", Some(LimitKind::Crosstalk), self.policy.crosstalk_mag.as_ref()),
        ];
        limits.into_iter().filter_map(move |(name, kind, limit)| {
            let of_camera = matches!(limit, Some(MagnitudeLimit::OfTelescope(_))).then_some(self.camera).flatten();
            let limit_mag = match (kind, of_camera) {
                (Some(kind), Some(camera)) => camera.limit_mag(kind, band)?,
                _ => limit?.of(band)?,
            };
            Some(AppliedLimit { name, limit_mag, is_of_camera: of_camera.is_some() })
        })
    }

    /// Returns the probability that a satellite is brighter than a limit. For a limit of the camera it also returns the
    /// equivalent magnitude at 550 km.
    fn probability_above(&self, limit: &AppliedLimit, light: &Light<'_>, band: Option<&str>) -> (f64, Option<f64>) {
        let seen_mag =
            self.camera.filter(|_| limit.is_of_camera).map(|camera| camera.equivalent_mag_at_550_km(light, band));
        // Converts a camera limit to the band and range of the predicted magnitude.
        let limit_mag = seen_mag.map_or(limit.limit_mag, |seen| limit.limit_mag + light.brightness.magnitude.0 - seen);
        (light.brightness.probability_brighter_than(limit_mag), seen_mag)
    }

    /// Returns true if a magnitude limit applies to the band.
    pub fn has_limit(&self, band: Option<&str>) -> bool {
        self.limits(band).next().is_some()
    }

    /// Returns the largest probability, over all limits that apply to the band, that a satellite is brighter than the
    /// limit. It is 0 for a satellite that is not visible, and `None` if no limit applies.
    pub fn probability_brighter(&self, light: Option<Light<'_>>, band: Option<&str>) -> Option<f64> {
        self.limits(band)
            .map(|limit| light.map_or(0.0, |light| self.probability_above(&limit, &light, band).0))
            .reduce(f64::max)
    }
}

/// Crossing probabilities and expected loss of an exposure for all satellites together, including near misses.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(super) struct ExpectedLoss {
    /// Probability that at least one lit satellite crosses and is brighter than a limit of the policy; equal to
    /// `p_crossing` if no limit applies.
    pub p_any: f64,
    /// Probability that at least one lit satellite crosses.
    pub p_crossing: f64,
    /// True if, for at least one satellite, more than 10 % of the possible delays are outside the range searched. The
    /// other values are then lower limits.
    pub is_lower_limit: bool,
    /// Expected fraction of the pixels lost, [0, 1]; `None` without a telescope.
    pub lost_pixel_fraction: Option<f64>,
}

impl ExpectedLoss {
    /// Combines satellites whose errors are independent. `brighter` returns the probability that a satellite is
    /// brighter than a limit (1 without limits). `lost_fraction` returns the expected fraction of pixels lost to a
    /// satellite; it requires a telescope.
    pub fn of(
        satellites: &[CrossingProbability],
        brighter: &dyn Fn(&CrossingProbability) -> f64,
        lost_fraction: Option<&dyn Fn(&CrossingProbability) -> f64>,
    ) -> Self {
        // 1 - Π(1 - p)
        let any = |of: &dyn Fn(&CrossingProbability) -> f64| {
            1.0 - satellites.iter().map(|one| 1.0 - one.probability.clamp(0.0, 1.0) * of(one)).product::<f64>()
        };
        Self {
            p_any: any(brighter),
            p_crossing: any(&|_| 1.0),
            is_lower_limit: satellites.iter().any(|one| one.is_lower_limit),
            lost_pixel_fraction: lost_fraction
                .map(|lost_fraction| satellites.iter().map(lost_fraction).fold(0.0, |sum, lost| sum + lost).min(1.0)),
        }
    }
}

/// Judges an exposure by its crossings and near misses. If the verdict is not `clear`, the next starts are not set.
///
/// Passes in the Earth's shadow are ignored. A near miss counts only if the policy has a `min_probability` and the
/// crossing probability is at least that. The verdict is `avoid` if, for one pass that counts, the probability that it
/// crosses and is brighter at its peak than a limit is at least `min_probability` (0.5 if omitted), or if the expected
/// loss exceeds `max_lost_fraction`. Otherwise it is `streaked` if any pass counts, and `clear` if none does.
pub(super) fn judge_exposure(
    exposure: &Exposure,
    band: Option<&str>,
    passes: &[Pass],
    expected: &ExpectedLoss,
    rules: &Rules<'_>,
) -> Verdict {
    let policy = rules.policy;
    let lit = || passes.iter().filter(|pass| pass.lit);
    let counted: Vec<&Pass> = lit().filter(|pass| is_counted(pass, policy)).collect();
    let nominal = || counted.iter().filter(|pass| pass.is_crossing());

    let mut reasons = Vec::new();
    let mut more_reasons = 0;
    let mut avoid = false;
    for pass in &counted {
        let Some(light) = Light::of(pass) else { continue };
        for limit in rules.limits(band) {
            let (brighter, seen_mag) = rules.probability_above(&limit, &light, band);
            if pass.probability * brighter < policy.avoid_probability() {
                continue;
            }
            avoid = true;
            if reasons.len() == MAX_REASONS {
                more_reasons += 1;
                continue;
            }
            reasons.push(reason(pass, &light, brighter, &limit, seen_mag, band));
        }
    }
    if more_reasons > 0 {
        reasons.push(format!("and {more_reasons} more"));
    }
    let lost = expected.lost_pixel_fraction;
    if let (Some(lost), Some(most)) = (lost, policy.max_lost_fraction)
        && lost > most
    {
        avoid = true;
        reasons.push(format!("expected loss of {} of the pixels, more than {most}", fraction_above(lost, most)));
    }
    let verdict = match (avoid, counted.is_empty()) {
        (true, _) => VerdictKind::Avoid,
        (false, false) => VerdictKind::Streaked,
        (false, true) => VerdictKind::Clear,
    };
    if verdict == VerdictKind::Streaked {
        reasons.push(streaked_reason(nominal().count(), counted.len()));
    }
    let clear = verdict == VerdictKind::Clear;
    Verdict {
        exposure_id: exposure.id.clone(),
        kind: verdict,
        n_streaks: nominal().count(),
        brightest_mag: counted.iter().filter_map(|pass| peak_magnitude(pass)).min_by(f64::total_cmp),
        expected_lost_pixel_fraction: lost,
        p_any: expected.p_any,
        p_crossing: expected.p_crossing,
        p_any_is_lower_limit: expected.is_lower_limit,
        streak_length_deg: nominal().map(|pass| pass.streak_length_rad.to_degrees()).fold(0.0, |sum, one| sum + one),
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

/// Formats a fraction with two significant digits and at least four decimals. More decimals are added until the rounded
/// text is above `most`.
fn fraction_above(fraction: f64, most: f64) -> String {
    let decimals = (1.0 - fraction.log10().floor()).clamp(4.0, 17.0) as usize;
    let shown = |decimals: usize| format!("{fraction:.decimals$}");
    (decimals..17)
        .map(shown)
        .find(|text| text.parse().is_ok_and(|shown: f64| shown > most))
        .unwrap_or(fraction.to_string())
}

/// Returns the text that explains why a pass exceeds a limit.
fn reason(
    pass: &Pass,
    light: &Light<'_>,
    brighter: f64,
    limit: &AppliedLimit,
    seen_mag: Option<f64>,
    band: Option<&str>,
) -> String {
    let Brightness { magnitude, sigma_mag, source, .. } = light.brightness;
    let AppliedLimit { name, limit_mag, .. } = limit;
    let than = match (seen_mag, *name) {
        (Some(_), name) => format!("the camera's {name}"),
        (None, "") => String::new(),
        (None, name) => format!("the {name}"),
    };
    let equivalent = seen_mag
        .map(|seen| format!("; equivalent to {} {seen:.2} at 550 km", band.unwrap_or_default()))
        .unwrap_or_default();
    let crossing = match percent(pass.probability).as_str() {
        "100" | ">99" => String::new(),
        percent => format!(", {percent} % of crossing"),
    };
    format!(
        "{}: {} % chance of being brighter than {than}{limit_mag} ({magnitude:.2} +- {sigma_mag:.2}, {source}{equivalent}){crossing}",
        pass.norad_id,
        percent(brighter),
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

/// Returns true for a lit crossing, and for a lit near miss whose probability is at least the `min_probability` of the
/// policy.
pub(super) fn is_counted(pass: &Pass, policy: &Policy) -> bool {
    pass.lit && (pass.is_crossing() || policy.min_probability.is_some_and(|least| pass.probability >= least))
}

/// Returns true if a pass blocks the start of an exposure. The pass must count. With [`Blocking::Avoid`], if a limit
/// applies to the band, the probability that it crosses and is brighter than a limit must also be at least
/// `min_probability` (0.5 if omitted).
pub(super) fn blocks(pass: &Pass, band: Option<&str>, blocking: Blocking, rules: &Rules<'_>) -> bool {
    let exceeds_limit = || {
        rules
            .probability_brighter(Light::of(pass), band)
            .is_none_or(|brighter| pass.probability * brighter >= rules.policy.avoid_probability())
    };
    is_counted(pass, rules.policy) && (blocking == Blocking::Any || exceeds_limit())
}

fn peak_magnitude(pass: &Pass) -> Option<f64> {
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
        // The losses of near misses and crossings are added.
        let lost = |one: &CrossingProbability| 0.01 * one.probability;
        let rules = Rules { policy: &policy, camera: None };
        let brighter = |one: &CrossingProbability| {
            let pass = passes.iter().find(|pass| pass.element_index == one.element_index);
            rules.probability_brighter(pass.and_then(Light::of), Some("r")).unwrap_or(1.0)
        };
        let expected = ExpectedLoss::of(&probabilities(passes), &brighter, Some(&lost));
        judge_exposure(&exposure(), Some("r"), passes, &expected, &rules)
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
        let near = Pass { chords: Vec::new(), streak_length_rad: 0.0, ..pass(1, Some(5.0), 0.3) };
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
    fn fractions_are_shown_with_enough_digits_to_differ_from_their_limit() {
        for (fraction, most, expected) in [
            (0.0100, 0.009, "0.0100"),
            (0.000_672, 0.0006, "0.00067"),
            (0.000_023_4, 0.000_01, "0.000023"),
            (0.000_010_02, 0.000_01, "0.00001002"),
            (1.0, 0.5, "1.0000"),
        ] {
            assert_eq!(fraction_above(fraction, most), expected);
        }
    }

    #[test]
    fn every_rule_of_a_policy_can_forbid() {
        let passes = [pass(1, Some(5.0), 1.0)];
        for (policy, expected, word) in [
            (
                "saturation_mag = 5.1",
                VerdictKind::Avoid,
                "brighter than the saturation limit 5.1 (5.00 +- 0.50, prior)",
            ),
            ("crosstalk_mag = 5.1", VerdictKind::Avoid, "crosstalk limit 5.1"),
            ("saturation_mag = 4.9", VerdictKind::Streaked, "crosses"),
            ("limit_mag = {r = 5.1, g = 0}", VerdictKind::Avoid, "brighter than 5.1 ("),
            ("limit_mag = {g = 9}", VerdictKind::Streaked, "crosses"),
            ("limit_mag = {g = 0, default = 9}", VerdictKind::Avoid, "brighter than 9 ("),
            ("max_lost_fraction = 0.009", VerdictKind::Avoid, "expected loss of 0.0100 of the pixels"),
            ("max_lost_fraction = 0.011", VerdictKind::Streaked, "crosses"),
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
            blocks(pass, Some("r"), policy.blocking, &Rules { policy: &policy, camera: None })
        };
        let bright = pass(1, Some(5.0), 1.0);
        assert!(blocked(&bright, "limit_mag = 7") && blocked(&bright, "") && blocked(&bright, "limit_mag = {g = 0}"));
        assert!(!blocked(&bright, "limit_mag = 4.9") && blocked(&bright, "limit_mag = 4.9\nblocking = 'any'"));
        assert!(blocked(&bright, "limit_mag = 4\ncrosstalk_mag = 5.1"));
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

    /// Camera that saturates at g = 3.2; satellites are 0.5 mag brighter at 550 km.
    struct Camera;

    impl CameraLimits for Camera {
        fn limit_mag(&self, kind: LimitKind, band: Option<&str>) -> Option<f64> {
            (kind == LimitKind::Saturation && band == Some("g")).then_some(3.2)
        }

        fn equivalent_mag_at_550_km(&self, light: &Light<'_>, _: Option<&str>) -> f64 {
            light.brightness.magnitude.0 - 0.5
        }
    }

    #[test]
    fn limits_of_the_camera_apply_if_the_policy_refers_to_them() {
        let verdict = |band: &str, magnitude: f64, policy: &str| {
            let policy = Policy::from_toml(policy).unwrap();
            let rules = Rules { policy: &policy, camera: Some(&Camera) };
            let passes = [pass(1, Some(magnitude), 1.0)];
            judge_exposure(&exposure(), Some(band), &passes, &ExpectedLoss::default(), &rules)
        };
        let both = "saturation_mag = 'telescope'\ncrosstalk_mag = 'telescope'";
        let avoided = verdict("g", 3.6, both);
        assert_eq!(avoided.kind, VerdictKind::Avoid);
        assert_eq!(
            avoided.reasons,
            [
                "1: 58 % chance of being brighter than the camera's saturation limit 3.2 (3.60 +- 0.50, prior; equivalent to g 3.10 at 550 km)"
            ]
        );
        assert_eq!(verdict("g", 3.8, both).kind, VerdictKind::Streaked);
        // The band has no limit, or the policy has none.
        assert_eq!(verdict("r", 0.0, both).kind, VerdictKind::Streaked);
        assert_eq!(verdict("g", 0.0, "limit_mag = -1").kind, VerdictKind::Streaked);
        // A number in the policy is compared with the magnitude without conversion to 550 km.
        assert_eq!(verdict("g", 3.6, "saturation_mag = 3.2").kind, VerdictKind::Streaked);
    }

    #[test]
    fn many_satellites_are_counted_and_the_first_are_listed() {
        let many: Vec<Pass> = (1..=9).map(|id| pass(id, Some(4.0), 1.0)).collect();
        let flag = judge(&many, "limit_mag = 7");
        assert_eq!((flag.reasons.len(), flag.reasons[5].as_str(), flag.norad_ids.len()), (6, "and 4 more", 9));
    }
}

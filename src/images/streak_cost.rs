//! Expected loss of an exposure to streaks, in seconds of open shutter.

use super::telescope::Telescope;

/// Satellite that may leave a streak in a field.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PossibleStreak {
    /// Probability that the satellite crosses the field while the shutter is open, [0, 1].
    pub probability: f64,
    /// Expected length of the lit streak in the field, degrees: the length of the streak times the probability.
    pub expected_length_deg: f64,
    /// Width of the streak ([`Telescope::width_arcsec`]), arcsec.
    pub width_arcsec: f64,
    /// Probability that the streak is brighter per pixel than that of a satellite of `bright_mag` at 550 km, [0, 1].
    pub p_bright: f64,
    /// Probability that the satellite is brighter than a hard limit, at which the exposure is lost, [0, 1]; 0 without
    /// a limit.
    pub p_above_limit: f64,
}

/// Cost of streaks in a field of a telescope.
///
/// For an exposure of t seconds in a field of area A, with D = √(4 A / π), the cost is
///
/// ```text
/// t · min(max(1, b), Σ P share)        share = L / D (D w / A + q b)
/// ```
///
/// over all satellites that may cross, with the probability P of a crossing, the lit length L of the streak in the
/// field, the width w of its mask, the probability q that it is brighter per pixel than the streak of a satellite of
/// `bright_mag` at 550 km, and the `bright_share` b of the telescope. For a satellite brighter than a hard limit the
/// share is max(1, b).
#[derive(Copy, Clone, Debug)]
pub struct StreakCost<'a> {
    telescope: &'a Telescope,
    field_area_deg2: f64,
}

impl<'a> StreakCost<'a> {
    /// Creates the cost for a telescope and the area of its field, square degrees.
    pub fn new(telescope: &'a Telescope, field_area_deg2: f64) -> Self {
        Self { telescope, field_area_deg2 }
    }

    /// Returns the diameter of a circle with the area of the field, degrees.
    pub fn field_diameter_deg(&self) -> f64 {
        (4.0 * self.field_area_deg2 / std::f64::consts::PI).sqrt()
    }

    /// Returns the expected share of an exposure that one satellite destroys, P · share.
    pub fn expected_share(&self, streak: &PossibleStreak) -> f64 {
        let PossibleStreak { probability, expected_length_deg, width_arcsec, p_bright, p_above_limit } = *streak;
        let masked = self.telescope.lost_pixel_fraction(expected_length_deg, width_arcsec, self.field_area_deg2);
        let bright = self.telescope.bright_share * expected_length_deg / self.field_diameter_deg();
        // Both limits are limits of the same magnitude, so that the probability of being brighter than one of them but
        // not than the other is the difference of the probabilities.
        probability * p_above_limit * self.largest_share()
            + (1.0 - p_above_limit) * masked
            + (p_bright - p_above_limit).max(0.0) * bright
    }

    /// Returns the cost of an exposure of `exposure_s` seconds, in seconds of open shutter, for the sum of the expected
    /// shares of all satellites.
    pub fn seconds(&self, exposure_s: f64, expected_shares: f64) -> f64 {
        exposure_s * expected_shares.min(self.largest_share())
    }

    /// Returns the largest share of an exposure that streaks can cost: 1, or `bright_share` if it is larger.
    fn largest_share(&self) -> f64 {
        self.telescope.bright_share.max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::ARCSEC_PER_RAD;

    fn rubin(bright_share: f64) -> Telescope {
        Telescope { bright_share, ..Telescope::by_name("rubin").unwrap() }
    }

    fn streak(length_deg: f64, p_bright: f64) -> PossibleStreak {
        PossibleStreak {
            probability: 1.0,
            expected_length_deg: length_deg,
            width_arcsec: 3.2,
            p_bright,
            p_above_limit: 0.0,
        }
    }

    /// Cost of streaks in an exposure of 30 s of Rubin.
    fn cost_s(bright_share: f64, streaks: &[PossibleStreak]) -> f64 {
        let telescope = rubin(bright_share);
        let cost = StreakCost::new(&telescope, telescope.field.area_deg2());
        cost.seconds(30.0, streaks.iter().map(|streak| cost.expected_share(streak)).sum())
    }

    #[test]
    fn verif_terms_of_the_cost() {
        // 3.5 deg through the centre, 6.4 arcsec masked: 30 s · 3.5 · 6.4 / 3600 / 9.621 = 0.0194 s.
        assert!((cost_s(0.08, &[streak(3.5, 0.0)]) - 0.0194).abs() < 1e-4);
        // 8 % of 30 s in addition.
        assert!((cost_s(0.08, &[streak(3.5, 1.0)]) - 2.4194).abs() < 1e-4);
        assert!((cost_s(0.08, &[streak(3.5, 0.25), streak(1.75, 0.5)]) - (1.2 + 1.5 * 0.0194)).abs() < 1e-4);
        // A mask of 60 arcsec costs 0.18 s.
        let telescope = Telescope { mask_arcsec: Some(60.0), ..rubin(0.08) };
        let cost = StreakCost::new(&telescope, telescope.field.area_deg2());
        assert!((cost.seconds(30.0, cost.expected_share(&streak(3.5, 0.0))) - 0.182).abs() < 1e-3);
    }

    #[test]
    fn verif_the_cost_is_limited() {
        let many = [streak(3.5, 1.0); 40];
        assert_eq!([0.08, 1.0, 3.0].map(|bright_share| cost_s(bright_share, &many)), [30.0, 30.0, 90.0]);
    }

    #[test]
    fn verif_a_hard_limit_costs_the_exposure() {
        let above = |p_above_limit: f64, probability: f64| PossibleStreak {
            p_above_limit,
            probability,
            expected_length_deg: 0.1 * probability,
            ..streak(0.0, 1.0)
        };
        assert!((cost_s(0.08, &[above(1.0, 1.0)]) - 30.0).abs() < 1e-12);
        assert!((cost_s(0.08, &[above(1.0, 0.5)]) - 15.0).abs() < 1e-12);
        assert!((cost_s(3.0, &[above(1.0, 0.5)]) - 45.0).abs() < 1e-12);
        // A limit fainter than bright_mag leaves nothing for the other terms but the mask.
        let faint = PossibleStreak { p_bright: 0.2, ..above(0.5, 1.0) };
        assert!((cost_s(0.08, &[faint]) - 15.0).abs() < 0.01);
    }

    #[test]
    fn valid_geostationary_satellites_are_bright_per_pixel_but_short() {
        // 12 mag at 36,000 km and 15 arcsec/s: 0.125 deg in 30 s.
        let telescope = rubin(0.08);
        let equivalent_mag = telescope.equivalent_mag_at_550_km(12.0, 36_000.0, 15.04, 5.0);
        assert!((4.0..6.0).contains(&equivalent_mag), "{equivalent_mag}");
        let width_arcsec = telescope.width_arcsec(36_000.0, 5.0);
        let cost_s = cost_s(0.08, &[PossibleStreak { width_arcsec, ..streak(0.125, 1.0) }]);
        assert!((0.05..0.1).contains(&cost_s), "{cost_s}");
        assert!(width_arcsec < 5.0 / 36e6 * ARCSEC_PER_RAD + 1.0);
    }
}

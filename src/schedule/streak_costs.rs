//! Expected losses of exposures to the satellites that may cross them.

use hifitime::Epoch;

use crate::images::{ARCSEC_PER_RAD, PossibleStreak, StreakCost, Telescope};
use crate::passes::{CrossingProbability, Exposure, Pass, Sky};
use crate::photometry::{Band, Brightness};

use super::flag_request::FlagRequest;
use super::limits::SatelliteLimit;
use super::tables::PassCost;
use super::verdict_rules::{ExpectedLoss, peak_brightness};

/// Returns probabilities and expected losses of one exposure, whose shutter is open for `open_s` if that is shorter.
/// `satellites` and `passes` are those of the exposure.
pub(super) fn expected_of(
    satellites: &[CrossingProbability],
    (exposure, open_s): (&Exposure, Option<f64>),
    band: Option<&str>,
    passes: &[Pass],
    request: &FlagRequest<'_>,
) -> ExpectedLoss {
    let open_s = open_s.unwrap_or(exposure.duration_s);
    let limits = request.limits(band, open_s);
    if limits.is_none() && request.telescope.is_none() {
        return ExpectedLoss::new(satellites, &[]);
    }
    let lights: Vec<Option<Brightness>> =
        satellites.iter().map(|satellite| brightness_of(satellite, exposure.start, passes, request)).collect();
    // A satellite in shadow is not bright, except in bands in which magnitudes include its thermal emission.
    let is_dark = |satellite: &CrossingProbability| {
        if request.photometry.band.has_emission() {
            return false;
        }
        let pass = passes.iter().find(|pass| pass.element_index == satellite.element_index);
        request.policy.include_dark && pass.map_or(satellite.lit_fraction == 0.0, |pass| !pass.lit)
    };
    let of_lit = |satellite: &CrossingProbability, probability: f64| if is_dark(satellite) { 0.0 } else { probability };
    let p_above_limit = |light: Option<&Brightness>, satellite: &CrossingProbability| {
        of_lit(
            satellite,
            p_above(
                light,
                limits.limit_of(satellite.element_index, satellite.geometry.range_km, satellite.angular_rate_rad_s),
            ),
        )
    };
    let above_limit = lights.iter().zip(satellites).map(|(light, satellite)| p_above_limit(light.as_ref(), satellite));
    let brighter: Vec<f64> = if limits.is_none() { Vec::new() } else { above_limit.collect() };
    let expected = ExpectedLoss::new(satellites, &brighter);
    let Some(telescope) = request.telescope else { return expected };
    let area_deg2 = request.field.area_deg2();
    let cost = StreakCost::new(telescope, area_deg2);
    let bright = BrightStreaks::new(telescope, request.sky, band, request.photometry.band);
    let (mut lost, mut shares) = (0.0, 0.0);
    for (satellite, brightness) in satellites.iter().zip(&lights) {
        let width_arcsec =
            telescope.width_arcsec(satellite.geometry.range_km, request.sky.model(satellite.element_index).size_m());
        let expected_length_deg = satellite.streak_length_rad.to_degrees();
        lost += telescope.lost_pixel_fraction(expected_length_deg, width_arcsec, area_deg2);
        let CrossingProbability { element_index, geometry, angular_rate_rad_s, .. } = *satellite;
        shares += cost.expected_share(&PossibleStreak {
            probability: satellite.probability,
            expected_length_deg,
            width_arcsec,
            p_bright: of_lit(
                satellite,
                of_known(brightness.as_ref(), |light| {
                    bright.probability(light, element_index, geometry.range_km, angular_rate_rad_s)
                }),
            ),
            p_above_limit: p_above_limit(brightness.as_ref(), satellite),
        });
    }
    ExpectedLoss {
        lost_pixel_fraction: Some(lost.min(1.0)),
        streak_cost_s: Some(cost.seconds(open_s, shares)),
        ..expected
    }
}

impl FlagRequest<'_> {
    /// Returns the expected cost of one pass, seconds of open shutter, and the probability that its streak is bright
    /// ([`BrightStreaks::probability`]); `None` without a telescope.
    ///
    /// The streak of a crossing has the length of the nominal streak (with `include_dark`, of the whole track in the
    /// field), that of a near miss the mean length of chords through the field. A satellite in shadow is bright only by
    /// thermal emission. `limit_mag` is the hard limit of the exposure, instead of `limit_mag` of the policy. The
    /// shutter of the exposure is open for `open_s` if that is shorter.
    #[doc(hidden)]
    pub fn pass_cost(
        &self,
        (exposure, open_s): (&Exposure, Option<f64>),
        pass: &Pass,
        band: Option<&str>,
        limit_mag: Option<f64>,
    ) -> Option<PassCost> {
        let telescope = self.telescope?;
        let is_seen = pass.lit || self.photometry.band.has_emission();
        if !(is_seen || self.policy.include_dark) {
            return Some(PassCost { streak_cost_s: 0.0, p_bright: 0.0 });
        }
        let cost = StreakCost::new(telescope, self.field.area_deg2());
        let length_deg = if pass.is_crossing() {
            self.policy.streak_length_rad(pass).to_degrees()
        } else {
            // The mean length of the chords of a circle is π/4 times its diameter.
            let mean_chord_deg = std::f64::consts::FRAC_PI_4 * cost.field_diameter_deg();
            mean_chord_deg.min(pass.angular_rate_rad_s.to_degrees() * exposure.duration_s)
        };
        let prior = || self.sky.prior_brightness(pass.element_index, &pass.mid.geometry, self.photometry);
        let brightness = peak_brightness(pass).cloned().or_else(prior);
        let bright = BrightStreaks::new(telescope, self.sky, band, self.photometry.band);
        let of_seen = |probability: f64| if is_seen { probability } else { 0.0 };
        let open_s = open_s.unwrap_or(exposure.duration_s);
        let limits = self.limits(band, open_s).with_limit_mag(limit_mag);
        let range_km = pass.mid.range_km;
        let p_bright = of_seen(of_known(brightness.as_ref(), |light| {
            bright.probability(light, pass.element_index, range_km, pass.angular_rate_rad_s)
        }));
        let share = cost.expected_share(&PossibleStreak {
            probability: pass.probability,
            expected_length_deg: pass.probability * length_deg,
            width_arcsec: telescope.width_arcsec(range_km, self.sky.model(pass.element_index).size_m()),
            p_bright,
            p_above_limit: of_seen(p_above(brightness.as_ref(), limits.of_pass(pass))),
        });
        Some(PassCost { streak_cost_s: cost.seconds(open_s, share), p_bright })
    }
}

/// Comparison of streaks with the `bright_mag` of a telescope. As for magnitude limits, the band of the exposure
/// selects the value, which is compared with magnitudes in the band of the prediction. Without a band of the exposure,
/// the latter band selects it.
#[derive(Copy, Clone, Debug)]
pub struct BrightStreaks<'a> {
    telescope: &'a Telescope,
    sky: &'a Sky,
    bright_mag: f64,
}

impl<'a> BrightStreaks<'a> {
    /// Creates the comparison for exposures in a band, or without a known one, with magnitudes in the band `predicted`.
    pub fn new(telescope: &'a Telescope, sky: &'a Sky, band: Option<&str>, predicted: Band) -> Self {
        Self { telescope, sky, bright_mag: telescope.bright_mag_in(band.or(Some(predicted.name()))) }
    }

    /// Returns the probability that the streak of a satellite is brighter per pixel than that of a satellite of
    /// `bright_mag` at 550 km.
    pub fn probability(
        &self,
        brightness: &Brightness,
        element_index: usize,
        range_km: f64,
        angular_rate_rad_s: f64,
    ) -> f64 {
        let magnitude = brightness.magnitude.0;
        let rate_arcsec_s = angular_rate_rad_s * ARCSEC_PER_RAD;
        let size_m = self.sky.model(element_index).size_m();
        let equivalent_mag = self.telescope.equivalent_mag_at_550_km(magnitude, range_km, rate_arcsec_s, size_m);
        // The apparent magnitude at which the equivalent magnitude is `bright_mag`.
        brightness.probability_brighter_than(self.bright_mag + magnitude - equivalent_mag)
    }
}

/// Returns the probability that a satellite is brighter than a hard limit; 0 without one.
fn p_above(brightness: Option<&Brightness>, limit: Option<SatelliteLimit>) -> f64 {
    limit.map_or(0.0, |limit| of_known(brightness, |light| light.probability_brighter_than(limit.limit_mag)))
}

/// Returns a probability that depends on the brightness, and 1 if that is unknown.
fn of_known(brightness: Option<&Brightness>, probability: impl Fn(&Brightness) -> f64) -> f64 {
    brightness.map_or(1.0, probability)
}

/// Returns the brightness of a satellite that may cross an exposure: at the peak of its pass, or, for a near miss
/// without a pass, at the point of its track nearest to the field centre. If it is unknown there, or the satellite is
/// in the Earth's shadow there, that of the sunlit part of the track (also in K, where emission is much fainter), or
/// else the prior of its orbit.
fn brightness_of(
    satellite: &CrossingProbability,
    epoch: Epoch,
    passes: &[Pass],
    request: &FlagRequest<'_>,
) -> Option<Brightness> {
    let FlagRequest { sky, photometry, .. } = request;
    let CrossingProbability { element_index, geometry, lit_fraction, .. } = satellite;
    let pass = passes.iter().find(|pass| pass.element_index == *element_index);
    if let Some(brightness) = pass.and_then(peak_brightness) {
        return Some(brightness.clone());
    }
    let nearest = |lit_fraction| sky.brightness_in(*element_index, epoch, geometry, lit_fraction, photometry);
    let lit_fraction = if photometry.band.is_thermal() || *lit_fraction > 0.0 || request.policy.include_dark {
        *lit_fraction
    } else {
        1.0
    };
    nearest(lit_fraction)
        .or_else(|| nearest(1.0))
        .or_else(|| sky.prior_brightness(*element_index, geometry, photometry))
}

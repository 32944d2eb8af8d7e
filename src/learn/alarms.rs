//! Alarms: passes whose light is improbable under the learned magnitudes, trends of a satellite's offset, and periodic
//! light along a pass (tumbling).

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::{LN_2, TAU};

use hifitime::Epoch;
use rayon::prelude::*;

use super::pass::Pass;
use crate::elements::{Generation, NoradId};
use crate::frames::seconds_between;
use crate::math::quantile::median;
use crate::output::{Column, Kind, Table, Value};
use crate::passes::{LEARNED_ERRORS, LearnedFile, LearnedMagnitude, LearnedSatellite};

/// Half width that contains 68.27 % of Student's t with four degrees of freedom, in units of its scale.
const HALF_WIDTH: f64 = 1.1416;
/// Fewest passes, and shortest interval, from which a trend is computed.
const LEAST_FOR_TREND: usize = 5;
const SHORTEST_TREND_DAYS: f64 = 14.0;
/// Fewest measurements of a pass in which periods are searched.
const LEAST_FOR_PERIOD: usize = 60;
/// Number of periods in a pass below which light is not periodic but a slow change.
const LEAST_PERIODS: usize = 4;
/// Degree of the polynomial in time that is subtracted before the search for periods.
const DEGREE: usize = 3;
/// Smallest and largest number of frequencies on each side from which the background of a frequency is computed.
const BACKGROUND: [usize; 2] = [16, 32];
/// Frequencies nearer than this number of steps contain the same signal and are not used for the background.
const OWN: usize = 3;
/// The variance of the median of n exponential values is 1/(0.48 n) of its square.
const MEDIAN_COUNT: f64 = 0.48;

/// Kind of alarm.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum AlarmKind {
    /// The light of a pass is improbable.
    Brightness,
    /// The offset of a satellite changes with time.
    Trend,
    /// The light of a pass is periodic.
    Period,
}

impl AlarmKind {
    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brightness => "brightness",
            Self::Trend => "trend",
            Self::Period => "period",
        }
    }
}

/// Improbable light of a satellite.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Alarm {
    /// Kind of alarm.
    pub alarm: AlarmKind,
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Kind of satellite.
    pub kind: Generation,
    /// Time of the first measurement.
    pub first: Epoch,
    /// Time of the last measurement.
    pub last: Epoch,
    /// Number of passes.
    pub passes: usize,
    /// Median difference from the learned magnitude, mag (brightness); change of the offset, mag/day (trend);
    /// amplitude, mag (period).
    pub value: f64,
    /// One sigma of the value that is expected without an alarm.
    pub sigma: f64,
    /// Period of the light, seconds.
    pub period_s: Option<f64>,
    /// Probability of a value as far from 0 or farther.
    pub p_value: f64,
    /// Number of passes (brightness), satellites (trend) or frequencies of all passes (period) that were tested.
    pub looks: usize,
    /// Upper limit of the probability that any of these has such a value: `p_value` times `looks`, at most 1.
    pub p_after_looks: f64,
}

/// Alarms with the numbers of passes, satellites and frequencies that were tested.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Alarms {
    /// Alarms, by kind of alarm, satellite and time.
    pub alarms: Vec<Alarm>,
    /// Number of passes whose light was tested.
    pub passes: usize,
    /// Number of satellites whose trend was tested.
    pub trends: usize,
    /// Number of passes in which periods were searched.
    pub searched: usize,
    /// Number of passes of kinds that are not in the learned file.
    pub not_learned: usize,
}

/// Returns the probability of a difference as large as this, in sigmas, of either sign.
fn two_sided(sigmas: f64) -> f64 {
    2.0 * LEARNED_ERRORS.cumulative(-sigmas.abs(), 0.0)
}

/// Difference of a pass from the learned magnitude, with the variances of the offset and of the pass, mag and mag².
struct Difference<'p> {
    pass: &'p Pass,
    mag: f64,
    offset_mag2: f64,
    pass_mag2: f64,
}

fn differences<'p>(passes: &'p [Pass], learned: &LearnedFile) -> Vec<Difference<'p>> {
    let satellites: HashMap<u32, &LearnedSatellite> =
        learned.satellites.iter().map(|satellite| (satellite.norad_id, satellite)).collect();
    let own = |pass: &Pass| satellites.get(&pass.norad_id().0).copied().filter(|own| own.kind == pass.kind());
    passes.iter().filter_map(|pass| Some(difference(pass, learned.magnitude_of(pass.kind())?, own(pass)))).collect()
}

fn difference<'p>(pass: &'p Pass, of_kind: &LearnedMagnitude, own: Option<&LearnedSatellite>) -> Difference<'p> {
    let (offset_mag, offset_mag2) = match own {
        Some(own) => (own.offset_mag, own.offset_sigma_mag.powi(2)),
        None => (of_kind.offset_mag, of_kind.offset_sigma_mag.powi(2) + of_kind.satellite_sigma_mag.powi(2)),
    };
    // (1.14 ω)² + σ²/n
    let pass_mag2 =
        (HALF_WIDTH * of_kind.pass_scale_mag).powi(2) + of_kind.point_sigma_mag.powi(2) / pass.points().len() as f64;
    Difference { pass, mag: pass.median_mag() - offset_mag, offset_mag2, pass_mag2 }
}

/// Returns alarms whose probability, multiplied by the number of tests, is below `p_below`.
///
/// The passes should be later than those of the learned file. Their residuals must be relative to its models.
pub fn find_alarms(passes: &[Pass], learned: &LearnedFile, p_below: f64) -> Alarms {
    let differences = differences(passes, learned);
    let mut alarms: Vec<Alarm> = differences.iter().map(brightness).collect();
    let mut satellites: BTreeMap<NoradId, Vec<&Difference>> = BTreeMap::new();
    for difference in &differences {
        satellites.entry(difference.pass.norad_id()).or_default().push(difference);
    }
    let trends: Vec<Alarm> = satellites.values().filter_map(|differences| trend(differences)).collect();
    let periods: Vec<Alarm> = passes.par_iter().filter_map(period).collect();
    let (tested, trends_tested, searched) = (alarms.len(), trends.len(), periods.len());
    alarms.extend(trends);
    alarms.extend(periods);
    let frequencies: usize =
        alarms.iter().filter(|alarm| alarm.alarm == AlarmKind::Period).map(|alarm| alarm.looks).sum();
    for alarm in &mut alarms {
        alarm.looks = match alarm.alarm {
            AlarmKind::Brightness => tested,
            AlarmKind::Trend => trends_tested,
            AlarmKind::Period => frequencies,
        };
        alarm.p_after_looks = (alarm.p_value * alarm.looks as f64).min(1.0);
    }
    alarms.retain(|alarm| alarm.p_after_looks < p_below);
    alarms.sort_by_key(|alarm| (alarm.alarm, alarm.norad_id, alarm.first));
    let not_learned = passes.len() - tested;
    Alarms { alarms, passes: tested, trends: trends_tested, searched, not_learned }
}

/// Returns the time of each pass and its median difference from the learned magnitude, mag, with the sigma that is
/// expected, mag. Passes of kinds that are not in the file are omitted.
pub fn pass_differences(passes: &[Pass], learned: &LearnedFile) -> Vec<(Epoch, f64, f64)> {
    let of = |difference: &Difference| {
        (difference.pass.first(), difference.mag, (difference.offset_mag2 + difference.pass_mag2).sqrt())
    };
    differences(passes, learned).iter().map(of).collect()
}

fn alarm(alarm: AlarmKind, pass: &Pass, value: f64, sigma: f64) -> Alarm {
    Alarm {
        alarm,
        norad_id: pass.norad_id(),
        kind: pass.kind(),
        first: pass.first(),
        last: pass.last(),
        passes: 1,
        value,
        sigma,
        period_s: None,
        p_value: two_sided(value / sigma),
        looks: 1,
        p_after_looks: 1.0,
    }
}

/// Returns the alarm for the brightness of one pass.
fn brightness(difference: &Difference) -> Alarm {
    alarm(
        AlarmKind::Brightness,
        difference.pass,
        difference.mag,
        (difference.offset_mag2 + difference.pass_mag2).sqrt(),
    )
}

/// Weighted linear regression of the differences of a satellite on time. `None` with few passes or a short interval.
fn trend(differences: &[&Difference]) -> Option<Alarm> {
    let first = differences.iter().min_by_key(|difference| difference.pass.first())?.pass;
    let last = differences.iter().max_by_key(|difference| difference.pass.last())?.pass;
    let days =
        |difference: &Difference| seconds_between(first.first(), difference.pass.first()) / crate::constants::DAY_S;
    let longest = differences.iter().map(|difference| days(difference)).fold(0.0, f64::max);
    if differences.len() < LEAST_FOR_TREND || longest < SHORTEST_TREND_DAYS {
        return None;
    }
    let weight: f64 = differences.iter().map(|difference| 1.0 / difference.pass_mag2).sum();
    let mean = |of: &dyn Fn(&Difference) -> f64| {
        differences.iter().map(|difference| of(difference) / difference.pass_mag2).sum::<f64>() / weight
    };
    // slope = Σ w (t - t̄) (y - ȳ) / S, S = Σ w (t - t̄)², σ = 1/√S
    let (t_mean, y_mean) = (mean(&|difference| days(difference)), mean(&|difference| difference.mag));
    let squares = weight * mean(&|difference| (days(difference) - t_mean).powi(2));
    let slope = weight * mean(&|difference| (days(difference) - t_mean) * (difference.mag - y_mean)) / squares;
    let found = alarm(AlarmKind::Trend, first, slope, squares.powf(-0.5));
    Some(Alarm { last: last.last(), passes: differences.len(), ..found })
}

/// Strongest period of a pass. `None` with few measurements.
///
/// The power at each frequency is that of Lomb (1976) and Scargle (1982) after subtraction of a cubic polynomial in
/// time, divided by the median power of frequencies around it, because slow differences from the model, unlike noise,
/// have more power at low frequencies.
fn period(pass: &Pass) -> Option<Alarm> {
    let n = pass.points().len();
    let span_s = seconds_between(pass.first(), pass.last());
    if n < LEAST_FOR_PERIOD || span_s <= 0.0 {
        return None;
    }
    let time_s: Vec<f64> = pass.points().iter().map(|point| seconds_between(pass.first(), point.epoch)).collect();
    let light_mag = detrended(&time_s, pass, span_s);
    // Frequencies k/T, up to half of the mean rate of the measurements.
    let powers: Vec<f64> = (1..=n / 2).map(|k| power(&time_s, &light_mag, TAU * k as f64 / span_s)).collect();
    let peak = |k: usize| {
        let side = k.clamp(BACKGROUND[0], BACKGROUND[1]);
        let near: Vec<f64> = (k.saturating_sub(side)..powers.len().min(k + side + 1))
            .filter(|other| other.abs_diff(k) >= OWN)
            .map(|other| powers[other])
            .collect();
        // p = (1 + r/m)^-m, m = 0.48 n; the median of an exponential distribution is ln 2 times its mean.
        let m = MEDIAN_COUNT * near.len() as f64;
        let ratio = powers[k] * LN_2 / median(near);
        (k, ratio, (1.0 + ratio / m).powf(-m))
    };
    let looks = powers.len() - (LEAST_PERIODS - 1);
    let (k, ratio, p_value) = (LEAST_PERIODS - 1..powers.len()).map(peak).min_by(|a, b| a.2.total_cmp(&b.2))?;
    // A sine of amplitude A has the power n A²/4.
    let amplitude = |power: f64| 2.0 * (power / n as f64).sqrt();
    let found = alarm(AlarmKind::Period, pass, amplitude(powers[k]), amplitude(powers[k] / ratio));
    Some(Alarm { period_s: Some(span_s / (k + 1) as f64), p_value, looks, ..found })
}

/// Returns the residuals without a polynomial in time, mag.
fn detrended(time_s: &[f64], pass: &Pass, span_s: f64) -> Vec<f64> {
    // Legendre polynomials, made orthogonal on the times of the measurements (Gram-Schmidt).
    let mut light: Vec<f64> = pass.points().iter().map(|point| point.residual_mag).collect();
    let mut base: Vec<Vec<f64>> = Vec::new();
    for degree in 0..=DEGREE {
        let mut column: Vec<f64> = time_s.iter().map(|t| (2.0 * t / span_s - 1.0).powi(degree as i32)).collect();
        for other in &base {
            remove(&mut column, other);
        }
        remove(&mut light, &column);
        base.push(column);
    }
    light
}

/// Subtracts the projection on a column.
fn remove(from: &mut [f64], column: &[f64]) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let square = dot(column, column);
    if square > 0.0 {
        let share = dot(from, column) / square;
        from.iter_mut().zip(column).for_each(|(value, element)| *value -= share * element);
    }
}

/// Power at an angular frequency (1/s), mag²: (Σ y cos)²/(2 Σ cos²) + (Σ y sin)²/(2 Σ sin²) about the time τ at which
/// sine and cosine are orthogonal.
fn power(time_s: &[f64], light_mag: &[f64], omega: f64) -> f64 {
    // tan 2ωτ = Σ sin 2ωt / Σ cos 2ωt
    let (sine, cosine) = time_s.iter().fold((0.0, 0.0), |(sine, cosine), t| {
        let (s, c) = (2.0 * omega * t).sin_cos();
        (sine + s, cosine + c)
    });
    let phase = 0.5 * sine.atan2(cosine);
    let mut sums = [0.0; 4];
    for (t, y) in time_s.iter().zip(light_mag) {
        let (s, c) = (omega * t - phase).sin_cos();
        for (sum, value) in sums.iter_mut().zip([y * c, c * c, y * s, s * s]) {
            *sum += value;
        }
    }
    let part = |projection: f64, square: f64| if square > 0.0 { 0.5 * projection * projection / square } else { 0.0 };
    part(sums[0], sums[1]) + part(sums[2], sums[3])
}

const COLUMNS: [Column; 13] = [
    Column::new("alarm", Kind::Text, "brightness, trend or period."),
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::new("kind", Kind::Text, "Kind of satellite."),
    Column::time("first_utc", "Time of the first measurement."),
    Column::time("last_utc", "Time of the last measurement."),
    Column::new("passes", Kind::Integer, "Number of passes."),
    Column::real("difference_mag", "mag", 3, "Median difference from the learned magnitude; positive is fainter."),
    Column::real("trend_mag_day", "mag/d", 5, "Change of the offset."),
    Column::real("amplitude_mag", "mag", 3, "Amplitude of the periodic light."),
    Column::real("period_s", "s", 3, "Period of the light; a rotation has one or more of them."),
    Column::real("expected_sigma", "", 5, "One sigma of the value that is expected, in its unit."),
    Column::new("looks", Kind::Integer, "Number of passes, satellites or frequencies that were tested."),
    Column::new(
        "p_after_looks",
        Kind::Text,
        "Probability that any of the tested passes, satellites or frequencies has such a value.",
    ),
];

/// Returns a table with one row for each alarm.
pub fn alarm_table(alarms: &[Alarm]) -> Table {
    let cells = |found: &Alarm| {
        let value_of = |alarm: AlarmKind| -> Value { (found.alarm == alarm).then_some(found.value).into() };
        vec![
            found.alarm.name().into(),
            i64::from(found.norad_id.0).into(),
            found.kind.name().into(),
            found.first.into(),
            found.last.into(),
            found.passes.into(),
            value_of(AlarmKind::Brightness),
            value_of(AlarmKind::Trend),
            value_of(AlarmKind::Period),
            found.period_s.into(),
            found.sigma.into(),
            found.looks.into(),
            format!("{:.1e}", found.p_after_looks).into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: alarms.iter().map(cells).collect() }
}

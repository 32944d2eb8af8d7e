//! Orbit of one satellite from its element sets: one gives the position, the others the mean motion.
//!
//! The mean motion in one element set of a Starlink satellite is uncertain by 0.3 s (V1.5) to 1.5 s (Direct-to-Cell)
//! per day, and mostly with the same sign for all satellites of a day. For a satellite that holds its orbit, the mean
//! motion between the epochs of two element sets is three to ten times better:
//!
//! ```text
//! n_obs = n_o - L / (P Δ),     B* = 0      if |n_obs - (n₀ - 2 τ ṅ/2)| P ≤ 4 s/day + D        rev/day
//! ```
//!
//! where L (seconds) is the lateness of the older set with B* = 0 at the epoch of the newer one, Δ (days) the time
//! between the epochs, P the period and D = |ṅ/2| P. Otherwise the satellite changed its orbit between the epochs: the
//! prediction is that of one set (with 2 τ = -0.45 d in strong drag and for Direct-to-Cell), and its error distribution
//! is wider.
//!
//! A satellite that does not cancel its drag had the mean motion n₀ - ṅ/2 Δ between the epochs. If n_obs agrees with
//! it, the satellite is coasting, and the published drag is applied.
//!
//! With three or more sets, those about 3, 7 and 14 days from the epoch, the position along the track is fitted by a
//! straight line: the mean motion between the epoch and each set gives the phase of the satellite at that set relative
//! to the prediction.
//!
//! A V1.5 that is being lowered changes its mean motion at a nearly constant rate ρ = (n₀ - n_obs) / Δ, several times
//! the published one. It is propagated with the mean motion n₀ - 0.72 ρ at epoch and with the drag of that rate.
//!
//! An element set on the other side of the exposure is preferred, because the error vanishes at both epochs.
//!
//! The Starlinks of a shell keep one mean motion ([`Shells`]). A satellite whose mean motion is within 10 s/day of it
//! is propagated with it, also if it changed its orbit between the epochs. The older sets then improve its position at
//! the epoch.

use std::f64::consts::{PI, TAU};

use hifitime::{Epoch, Unit};
use rayon::prelude::*;

use super::propagator::Propagator;
use super::shells::Shells;
use super::station_keeping::{DragModel, MeanMotion, StarlinkClass, height_km, without_drag};
use super::uncertainty::{OrbitClass, OrbitKind};
use crate::constants::DAY_S;
use crate::elements::{ElementSet, others_of, semi_major_axis_km};

/// Shortest time between two epochs from which a mean motion is computed, days.
const SHORTEST_DAYS: f64 = 2.5;
/// Longest time between two epochs from which a mean motion is computed, days.
const LONGEST_DAYS: f64 = 16.0;
/// Most useful time between two epochs, days: noise of the sets against changes of the orbit.
const BEST_DAYS: f64 = 7.0;
/// Longest time from which a rate is computed, days.
const LONGEST_RATE_DAYS: f64 = 8.0;
/// Times of the further sets in the straight line, days.
const LINE_DAYS: [f64; 2] = [3.0, 14.0];
/// Least time between two sets in the straight line, days.
const LINE_APART_DAYS: f64 = 2.0;
/// Largest phase in the straight line, s.
const LARGEST_PHASE_S: f64 = 3.0;
/// Largest difference between the mean motion of two epochs and that of one set, besides the published drag, s/day.
const GATE_S_DAY: f64 = 4.0;
/// Largest difference between the change of the mean motion and that by the published drag for a satellite that coasts,
/// as a fraction of the latter and in s/day; both are added.
const COASTING_FRACTION: f64 = 0.3;
const COASTING_S_DAY: f64 = 1.0;
/// Largest difference between the mean motion of a satellite and that of its shell, s/day: 0.5 km in height.
const SHELL_S_DAY: f64 = 10.0;
/// Weight of the phase of an older set of a satellite in a shell, relative to that of the set in use.
const PHASE_WEIGHT: f64 = 0.25;
/// Limits of the rate of a V1.5 that is being lowered, rev/day².
const RATES_REV_DAY2: [f64; 2] = [1.5e-3, 1.5e-2];
/// Smallest published ṅ/2, rev/day², and height, km, of a V1.5 that is propagated with a rate.
const RATE_LEAST_CHANGE_REV_DAY2: f64 = -3e-4;
const RATE_LEAST_HEIGHT_KM: f64 = 440.0;
/// Mean motion at epoch of a satellite with a rate: n₀ - 0.72 d × ρ.
const RATE_LAG_DAYS: f64 = 0.72;
/// An element set whose orbit differs by more than this is of another object: angle between the planes, and difference
/// of the distances from the Earth's centre. A V1.5 that is lowered for two weeks reaches 0.6° and 80 km.
const OTHER_PLANE_RAD: f64 = 2.0 * PI / 180.0;
const OTHER_HEIGHT_KM: f64 = 150.0;

/// The elements that SGP4 propagates for a satellite, and the class that determines their errors.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitModel {
    /// Elements for SGP4.
    pub elements: ElementSet,
    /// Class of the errors.
    pub class: OrbitClass,
}

impl OrbitModel {
    /// Returns the orbit of a satellite near the time `moment` from the element set closest to it and from others of
    /// the same satellite, in any order.
    ///
    /// Sets closer than 2.5 days or farther than 16 days, and those of another orbit or with another COSPAR designator,
    /// are not used. Satellites other than Starlinks are propagated with `set` alone.
    pub fn from_sets(set: &ElementSet, others: &[ElementSet], moment: Epoch, drag: DragModel) -> Self {
        Self::from_links(set, &Links::of_class(set, others, moment, drag), drag)
    }

    /// Returns the orbit of each satellite of a catalogue, as [`from_sets`](Self::from_sets), with the mean motions of
    /// the shells that the catalogue contains. `others` must be sorted by catalogue number.
    pub fn of_catalogue(sets: &[ElementSet], others: &[ElementSet], moment: Epoch, drag: DragModel) -> Vec<Self> {
        let of_one = |set: &ElementSet| {
            let links = Links::of_class(set, others_of(others, set.norad_id), moment, drag);
            (Self::from_links(set, &links, drag), links)
        };
        let alone: Vec<(Self, Links)> = sets.par_iter().map(of_one).collect();
        let keeping = alone.iter().filter(|(model, _)| model.keeps_mean_motion());
        let mean_motions = keeping
            .filter_map(|(model, links)| Some((model.elements.inclination_deg, links.best()?.mean_motion_rev_day)));
        let shells = Shells::new(mean_motions.collect());
        let pairs = alone.into_par_iter().zip(sets);
        pairs.map(|((model, links), set)| model.in_shell(set, &links, &shells, moment)).collect()
    }

    /// Returns true if the satellite kept its mean motion between the epochs of two element sets.
    fn keeps_mean_motion(&self) -> bool {
        let OrbitKind::Starlink(class, motion) = self.class.kind else { return false };
        class.has_shells() && motion.is_of_older_sets()
    }

    /// Returns the orbit with the mean motion of the shell of the satellite, if it is in one.
    fn in_shell(self, set: &ElementSet, links: &Links, shells: &Shells, moment: Epoch) -> Self {
        let OrbitKind::Starlink(class, motion) = self.class.kind else { return self };
        let Some(kept) = class.kept_mean_motion(set).filter(|_| class.has_shells()) else { return self };
        // True if a change of the orbit was before the epoch and the exposures.
        let is_before = !links.is_enclosing && links.best().map_or(set.epoch <= moment, |link| link.days < 0.0);
        let mean_motion = match motion {
            _ if motion.is_of_older_sets() => self.elements.mean_motion_rev_day,
            MeanMotion::OneSet | MeanMotion::Changed | MeanMotion::Coasting if is_before => kept,
            _ => return self,
        };
        let Some(shell) = shells.nearest(set.inclination_deg, mean_motion) else { return self };
        let period_s = DAY_S / set.mean_motion_rev_day;
        let is_at_shell = (shell - mean_motion).abs() * period_s <= SHELL_S_DAY;
        let class_alone = self.class;
        let class_with = |motion: MeanMotion| class_alone.with_mean_motion(motion, class_alone.baseline_days);
        if !is_at_shell {
            return match motion {
                MeanMotion::OneSet | MeanMotion::Coasting => self,
                _ => Self { class: class_with(MeanMotion::OffShell), ..self },
            };
        }
        let phases = links.all.iter().map(|link| link.phase_s(shell, period_s));
        let agreeing: Vec<f64> = phases.filter(|phase_s| phase_s.abs() < LARGEST_PHASE_S).collect();
        let shift_s = PHASE_WEIGHT * agreeing.iter().sum::<f64>() / (1.0 + PHASE_WEIGHT * agreeing.len() as f64);
        let motion = if agreeing.is_empty() { MeanMotion::Arrived } else { MeanMotion::Shell };
        Self { elements: ahead(without_drag(set, shell), shift_s), class: class_with(motion) }
    }

    fn from_links(set: &ElementSet, links: &Links, drag: DragModel) -> Self {
        let alone = |elements: ElementSet| Self { elements, class: OrbitClass::from_elements(set, drag) };
        let Some(class) = drag.class_of(set) else { return alone(set.clone()) };
        let kept = class.kept_mean_motion(set);
        let of_one = || drag.propagated(set);
        let Some(nearest) = links.best() else { return alone(of_one()) };
        let with = |elements: ElementSet, motion: MeanMotion, days: f64| Self {
            elements,
            class: OrbitClass::from_elements(set, drag).with_mean_motion(motion, days),
        };
        let period_s = DAY_S / set.mean_motion_rev_day;
        if let Some(kept) = kept {
            let gate_s_day = GATE_S_DAY + set.mean_motion_dot_rev_day2.abs() * period_s;
            let passes = |link: &Link| (link.mean_motion_rev_day - kept).abs() * period_s <= gate_s_day;
            // A satellite that changed its orbit more than 3 days ago has kept it since.
            if let Some(link) = links.by_length().into_iter().find(passes) {
                let plain = without_drag(set, link.mean_motion_rev_day);
                if links.is_enclosing {
                    return with(plain, MeanMotion::Enclosed, link.days);
                }
                let (elements, phases) = links.with_line(plain, link, period_s);
                let has_four = links.all.len() > LINE_DAYS.len() && class != StarlinkClass::Parked;
                let motion = match phases == LINE_DAYS.len() {
                    _ if !has_four => MeanMotion::TwoSets,
                    true => MeanMotion::FourSets,
                    false => MeanMotion::Disagreeing,
                };
                return with(elements, motion, link.days);
            }
        }
        if kept.is_some() && class != StarlinkClass::DirectToCell && is_coasting(set, nearest) {
            return with(set.clone(), MeanMotion::Coasting, nearest.days);
        }
        let is_v15 = matches!(class, StarlinkClass::V15 | StarlinkClass::MovingV15);
        if let Some(elements) = links.rate_link().filter(|_| is_v15).and_then(|link| with_rate(set, link)) {
            return with(elements, MeanMotion::Rate, nearest.days);
        }
        let motion = if class == StarlinkClass::MovingV15 { MeanMotion::NoRate } else { MeanMotion::Changed };
        // The change was before the epoch.
        let changed = if nearest.days < 0.0 && !links.is_enclosing {
            class.mean_motion_after_change(set).map_or_else(|| set.clone(), |n| without_drag(set, n))
        } else {
            of_one()
        };
        with(changed, motion, nearest.days)
    }
}

/// Returns the same elements with the satellite ahead by a time in seconds.
fn ahead(elements: ElementSet, shift_s: f64) -> ElementSet {
    let mean_anomaly_deg = elements.mean_anomaly_deg + 360.0 * shift_s * elements.mean_motion_rev_day / DAY_S;
    ElementSet { mean_anomaly_deg: mean_anomaly_deg.rem_euclid(360.0), ..elements }
}

/// Mean motion between the epoch of an element set and that of another one.
#[derive(Copy, Clone, Debug)]
struct Link {
    /// Days from the epoch to that of the other set; negative if that is older.
    days: f64,
    /// n_obs, rev/day.
    mean_motion_rev_day: f64,
}

impl Link {
    /// Returns the phase of the satellite at the other epoch relative to a prediction with the mean motion n, seconds:
    /// p = (n_obs - n) P d at d days from the epoch, positive where the satellite is ahead of the prediction.
    fn phase_s(&self, mean_motion_rev_day: f64, period_s: f64) -> f64 {
        (self.mean_motion_rev_day - mean_motion_rev_day) * period_s * self.days
    }
}

/// Mean motions between the epoch of an element set and those of others.
#[derive(Default)]
struct Links {
    all: Vec<Link>,
    /// True if the links are to sets on the other side of the exposures.
    is_enclosing: bool,
}

impl Links {
    /// Returns the links that the class of a satellite uses: none for satellites that are being raised or descend, and
    /// for those that are no Starlinks.
    fn of_class(set: &ElementSet, others: &[ElementSet], moment: Epoch, drag: DragModel) -> Self {
        match drag.class_of(set) {
            None | Some(StarlinkClass::Raising | StarlinkClass::Descending) => Self::default(),
            Some(_) if others.is_empty() => Self::default(),
            Some(_) => Self::new(set, others, moment),
        }
    }

    fn new(set: &ElementSet, others: &[ElementSet], moment: Epoch) -> Self {
        let days_to = |epoch: Epoch| (epoch.to_utc_duration() - set.epoch.to_utc_duration()).to_unit(Unit::Day);
        let at_days = days_to(moment);
        let usable: Vec<(f64, &ElementSet)> = others
            .iter()
            .filter(|other| !set.is_of_other_object(other))
            .map(|other| (days_to(other.epoch), other))
            .filter(|(days, _)| (SHORTEST_DAYS..=LONGEST_DAYS).contains(&days.abs()))
            .collect();
        let link = |(days, other): (f64, &ElementSet)| {
            mean_motion_between(set, other).map(|mean_motion_rev_day| Link { days, mean_motion_rev_day })
        };
        // 1. The nearest set on the other side of the exposures.
        let ahead = usable.iter().copied().filter(|(days, _)| days * at_days > 0.0);
        if let Some(enclosing) = ahead.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).and_then(link) {
            return Self { all: vec![enclosing], is_enclosing: true };
        }
        // 2. The sets nearest to 7, 3 and 14 days on this side.
        let behind: Vec<(f64, &ElementSet)> = usable.into_iter().filter(|(days, _)| days * at_days <= 0.0).collect();
        let mut all: Vec<Link> = Vec::new();
        for wanted in [BEST_DAYS, LINE_DAYS[0], LINE_DAYS[1]] {
            let is_apart = |days: f64| all.iter().all(|link| (link.days - days).abs() >= LINE_APART_DAYS);
            let apart = behind.iter().copied().filter(|(days, _)| is_apart(*days));
            let distance = |days: f64| (days.abs() - wanted).abs();
            let found = apart.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
            all.extend(found.and_then(link));
        }
        Self { all, is_enclosing: false }
    }

    /// The link whose mean motion is used.
    fn best(&self) -> Option<Link> {
        self.all.first().copied()
    }

    /// The link whose mean motion is used, then shorter ones.
    fn by_length(&self) -> Vec<Link> {
        let Some(best) = self.best() else { return Vec::new() };
        let shorter = self.all.iter().copied().filter(|link| link.days.abs() < best.days.abs());
        std::iter::once(best).chain(shorter).collect()
    }

    /// The link from which a rate is computed: of an older set, nearest to [`BEST_DAYS`].
    fn rate_link(&self) -> Option<Link> {
        let usable = self.all.iter().copied().filter(|link| (-LONGEST_RATE_DAYS..0.0).contains(&link.days));
        usable.min_by(|a, b| (a.days + BEST_DAYS).abs().total_cmp(&(b.days + BEST_DAYS).abs()))
    }

    /// Adds the straight line through the phases of all sets to elements without drag. Returns the number of further
    /// sets whose phases agree.
    fn with_line(&self, plain: ElementSet, best: Link, period_s: f64) -> (ElementSet, usize) {
        let phase = |link: &Link| (link.days, link.phase_s(best.mean_motion_rev_day, period_s));
        let further = self.all.iter().filter(|link| link.days != best.days);
        let phases: Vec<(f64, f64)> =
            further.map(phase).filter(|(_, phase_s)| phase_s.abs() < LARGEST_PHASE_S).collect();
        if phases.is_empty() {
            return (plain, 0);
        }
        // Least squares of p = a + b d, with the weight 2 for the epoch.
        let points: Vec<(f64, f64, f64)> = [(2.0, 0.0, 0.0), (1.0, best.days, 0.0)]
            .into_iter()
            .chain(phases.iter().map(|&(days, phase_s)| (1.0, days, phase_s)))
            .collect();
        let sum = |term: fn(f64, f64) -> f64| points.iter().map(|&(w, d, p)| w * term(d, p)).sum::<f64>();
        let (w, d, p) = (sum(|_, _| 1.0), sum(|d, _| d), sum(|_, p| p));
        let b = (w * sum(|d, p| d * p) - d * p) / (w * sum(|d, _| d * d) - d * d);
        let a = (p - b * d) / w;
        let mean_motion_rev_day = plain.mean_motion_rev_day + b / period_s;
        (ElementSet { mean_motion_rev_day, ..ahead(plain, a) }, phases.len())
    }
}

/// Returns true if the mean motion changed between two epochs as by the published drag.
fn is_coasting(set: &ElementSet, link: Link) -> bool {
    let rate = set.mean_motion_dot_rev_day2;
    // n(t) = n₀ + 2 (ṅ/2) t, so that n_obs is n at the middle of the interval.
    let by_drag = rate * link.days;
    let period_s = DAY_S / set.mean_motion_rev_day;
    let difference_s_day = (link.mean_motion_rev_day - set.mean_motion_rev_day - by_drag).abs() * period_s;
    rate > 0.0 && difference_s_day <= COASTING_FRACTION * by_drag.abs() * period_s + COASTING_S_DAY
}

/// Returns the elements of a satellite whose mean motion changes at the rate since the epoch of an older set; `None` if
/// it is not a V1.5 that is being lowered.
fn with_rate(set: &ElementSet, link: Link) -> Option<ElementSet> {
    // n(t) = n + 2 ρ t, so that n_obs is n at the middle of the interval.
    let rate = (set.mean_motion_rev_day - link.mean_motion_rev_day) / link.days.abs();
    let [least, most] = RATES_REV_DAY2;
    let is_lowered = rate > least
        && rate < most
        && set.mean_motion_dot_rev_day2 > RATE_LEAST_CHANGE_REV_DAY2
        && height_km(set) > RATE_LEAST_HEIGHT_KM;
    is_lowered.then(|| ElementSet {
        mean_motion_rev_day: set.mean_motion_rev_day - RATE_LAG_DAYS * rate,
        bstar_per_earth_radius: bstar_of_rate(set, rate),
        ..set.clone()
    })
}

/// Returns the B* with which SGP4 changes the mean motion of a circular orbit above 220 km at the rate ρ (rev/day²),
/// n(t) = n + 2 ρ t, 1/earth radii.
fn bstar_of_rate(set: &ElementSet, rate_rev_day2: f64) -> f64 {
    const EARTH_RADIUS_KM: f64 = 6_378.135;
    const J2: f64 = 0.001_082_616;
    const DAY_MIN: f64 = 1440.0;
    let n = set.mean_motion_rev_day * TAU / DAY_MIN;
    let a = semi_major_axis_km(set) / EARTH_RADIUS_KM;
    let (s, q0) = (1.0 + 78.0 / EARTH_RADIUS_KM, 1.0 + 120.0 / EARTH_RADIUS_KM);
    let xi = 1.0 / (a - s);
    let cos2 = set.inclination_deg.to_radians().cos().powi(2);
    // C2 = (q₀ - s)⁴ ξ⁴ n [a + 3/8 J₂ ξ (3 cos²i - 1) 8]        Vallado et al. 2006, sgp4init, for e = 0
    let c2 = (q0 - s).powi(4) * xi.powi(4) * n * (a + 3.0 * J2 * xi * (3.0 * cos2 - 1.0));
    // M gains n 3/2 C1 t² with C1 = B* C2.
    let rate = rate_rev_day2 * TAU / DAY_MIN.powi(2);
    rate / (1.5 * n * c2)
}

/// Returns the mean motion between the epochs of two element sets, rev/day; `None` if they are of different objects, or
/// SGP4 fails.
fn mean_motion_between(set: &ElementSet, other: &ElementSet) -> Option<f64> {
    let (older, newer) = if other.epoch < set.epoch { (other, set) } else { (set, other) };
    let from = Propagator::new(&without_drag(older, older.mean_motion_rev_day)).ok()?;
    let to = Propagator::new(newer).ok()?;
    let minutes = from.minutes_since_epoch(newer.epoch);
    let predicted = from.teme_state(minutes).ok()?;
    let actual = to.teme_state(0.0).ok()?;
    let (r, p) = (actual.position.vector(), predicted.position.vector());
    let normal = r.cross(actual.velocity.vector()).normalize();
    let tilt = normal.angle(&p.cross(predicted.velocity.vector()));
    if tilt > OTHER_PLANE_RAD || (p.norm() - r.norm()).abs() > OTHER_HEIGHT_KM {
        return None;
    }
    // L / P: the predicted position is ahead of the satellite by this number of turns.
    let forward = normal.cross(&r.normalize());
    let turns = p.dot(&forward).atan2(p.dot(&r.normalize())) / TAU;
    let days = minutes / 1440.0;
    let mean_motion = older.mean_motion_rev_day - turns / days;
    // Of the values that differ by whole turns, the one nearest to the mean of the two published mean motions.
    let usual = 0.5 * (older.mean_motion_rev_day + newer.mean_motion_rev_day);
    Some(mean_motion + ((usual - mean_motion) * days).round() / days)
}

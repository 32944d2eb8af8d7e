//! Verdicts on all exposures of a schedule, and their next clear starts.

use std::collections::HashMap;

use crate::error::Error;
use crate::frames::seconds_after;
use crate::math::quantile::median;
use crate::orbit::LeftOut;
use crate::passes::{Exposure, Field, Pass, PassOptions, Predictability, Sky, Viewpoint};
use crate::photometry::PhotometryOptions;

use super::blockers::{Blockers, blockers, intervals};
use super::flag_request::FlagRequest;
use super::horizon::{last_starts_s, lowest_altitudes_over};
use super::policy::{Blocking, Policy};
use super::scheduled::ScheduledExposure;
use super::shift::{Interval, next_clear_start};
use super::starts::{LATE_SIGMAS, LONGEST_ALLOWANCE_S, reason_for_unknown_starts};
use super::streak_costs::expected_of;
use super::verdict::{Verdict, VerdictKind};
use super::verdict_rules::{blocks, is_counted, judge_exposure};

/// Smallest time between a clear exposure with its margins and the entry or exit of a satellite, seconds. Entries and
/// exits are accurate to 1 ms.
pub(super) const GUARD_S: f64 = 0.002;
/// Resolution of clear starts, seconds. They are rounded to later times.
pub(super) const TICK_S: f64 = 0.001;
/// Guard of starts that are found, seconds: it includes the error of rounding to a millisecond.
const SEARCH_GUARD_S: f64 = GUARD_S + TICK_S;
/// Largest number of steps by which a start that fails its check is moved to later times.
const MOST_STEPS: f64 = 60.0;

/// Age and along-track error of the element set of a satellite at an exposure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SatelliteAge {
    /// Time since the epoch of the elements, days; negative if the epoch is later than the exposure.
    pub element_age_days: f64,
    /// Along-track error, seconds: 68 % of the delays are at most this long, early or late.
    pub along_track_sigma_s: f64,
}

impl SatelliteAge {
    /// Returns age and error of the satellite of a pass.
    pub(super) fn from_pass(pass: &Pass) -> Self {
        Self { element_age_days: pass.element_age_days, along_track_sigma_s: pass.along_track_sigma_s }
    }
}

/// Verdicts on rows of a schedule; [`FlagTotals`](super::FlagTotals) sums up many reports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlagReport {
    /// One verdict for each row, in order.
    pub flags: Vec<Verdict>,
    /// Satellites whose position cannot be computed for at least one exposure.
    pub left_out: Vec<LeftOut>,
    /// Satellites that cross or may cross; one entry for each exposure and satellite.
    #[doc(hidden)]
    pub may_cross: Vec<SatelliteAge>,
    /// Number of judged exposures that begin while the Sun's centre is above the horizon of the site.
    pub by_daylight: usize,
}

impl FlagReport {
    fn sort_left_out(&mut self) {
        self.left_out.sort_by_key(|left_out| left_out.element_index);
        self.left_out.dedup_by_key(|left_out| left_out.element_index);
    }
}

/// Judges every row, and finds the next clear and the next acceptable starts. Rows that cannot be judged get the
/// verdict `invalid`.
///
/// The `margin_s` of the policy applies before and after an exposure. An exposure with a crossing only in its margins
/// is `streaked`. For a telescope in orbit, starts are only searched if the policy has a `max_delay_s`: a field of some
/// degrees rarely has a clear start, and the search would take most of the time.
///
/// # Errors
/// Passes cannot be computed.
pub fn flag_exposures(rows: &[&ScheduledExposure], request: &FlagRequest<'_>) -> Result<FlagReport, Error> {
    let mut judged = judge(rows, request)?;
    find_starts(Blocking::Any, &mut judged, rows, request)?;
    find_starts(Blocking::Avoid, &mut judged, rows, request)?;
    let Judged { report, flags, counted, .. } = judged;
    Ok(finished(report, flags, counted))
}

/// Judges every row without margins, and without the next starts of exposures that are not clear.
///
/// It takes less than half the time of [`flag_exposures`].
///
/// # Errors
/// Same as [`flag_exposures`].
pub fn judge_exposures(rows: &[&ScheduledExposure], request: &FlagRequest<'_>) -> Result<FlagReport, Error> {
    let Judged { report, flags, counted, .. } = judge(rows, request)?;
    Ok(finished(report, flags, counted))
}

impl Sky {
    /// Judges one exposure by a policy, with magnitudes in the V band and without a telescope.
    ///
    /// [`flag_exposures`] judges whole schedules, with a telescope and in other bands.
    ///
    /// # Errors
    /// The direction or duration of the exposure is not finite, or its time is outside the years of the
    /// Sun's ephemeris. A pointing below the horizon is not an error: its verdict is [`VerdictKind::Invalid`], with the
    /// reason.
    pub fn judge(&self, exposure: &Exposure, field: &Field, policy: &Policy) -> Result<Verdict, Error> {
        let row = ScheduledExposure {
            id: exposure.id.clone(),
            row: 0,
            band: None,
            open_s: None,
            exposure: Ok(exposure.clone()),
        };
        let photometry = PhotometryOptions::default();
        let request = FlagRequest { sky: self, field, policy, telescope: None, photometry: &photometry };
        let mut report = flag_exposures(&[&row], &request)?;
        Ok(report.flags.pop().unwrap_or_else(|| Verdict::invalid(&exposure.id, "not judged".to_owned())))
    }
}

/// Verdicts at the scheduled starts, before margins and delays are considered.
struct Judged<'a> {
    report: FlagReport,
    /// Verdict of each row; `None` until the row is judged.
    flags: Vec<Option<Verdict>>,
    /// Rows whose pointing is above the horizon while the positions of the satellites are known, with their index.
    above: Vec<(usize, &'a Exposure)>,
    /// Passes that count, by row: lit crossings (with `include_dark` all), and probable near misses if the policy has a
    /// `min_probability`.
    counted: Vec<Vec<Pass>>,
}

fn judge<'a>(rows: &[&'a ScheduledExposure], request: &FlagRequest<'_>) -> Result<Judged<'a>, Error> {
    let mut report = FlagReport::default();
    let mut counted: Vec<Vec<Pass>> = vec![Vec::new(); rows.len()];
    let mut flags: Vec<Option<Verdict>> = vec![None; rows.len()];
    let above: Vec<(usize, &Exposure)> = above_the_horizon(rows, request, &mut flags)?;

    for (_, exposure) in &above {
        request.sky.watch().check()?;
        let sun_is_up = request.sky.sun_altaz(exposure.start).is_ok_and(|sun| sun.altitude_rad > 0.0);
        report.by_daylight += usize::from(sun_is_up);
    }

    let exposures: Vec<Exposure> = above.iter().map(|(_, exposure)| (*exposure).clone()).collect();
    let options = pass_options(request);
    let mut crossings = request.sky.field_passes(&exposures, request.field, &options)?;
    report.left_out.append(&mut crossings.left_out);

    let probabilities = request.sky.probabilities_with(
        &exposures,
        request.field,
        request.policy.include_dark,
        request.photometry.band,
    )?;

    for (((row, exposure), passes), satellites) in above.iter().zip(crossings.by_exposure).zip(probabilities) {
        request.sky.watch().check()?;
        let band = rows[*row].band.as_deref();
        let expected = expected_of(&satellites, (exposure, rows[*row].open_s), band, &passes, request);
        let may_cross: Vec<SatelliteAge> = satellites
            .iter()
            .map(|satellite| SatelliteAge {
                element_age_days: request.sky.element_age_days(satellite.element_index, exposure.start),
                along_track_sigma_s: satellite.along_track_sigma_s,
            })
            .collect();
        let flag = judge_exposure(
            exposure,
            &request.limits(band, rows[*row].open_time_s(exposure)),
            &passes,
            &expected,
            request.policy,
        );
        counted[*row] = passes.into_iter().filter(|pass| is_counted(pass, request.policy)).collect();
        flags[*row] = Some(with_age(
            flag,
            &counted[*row],
            &may_cross,
            &request.sky.predictability(exposure.start, Some(request.field)),
        ));
        report.may_cross.extend(may_cross);
    }
    let is_known = |epoch| !request.sky.predictability(epoch, Some(request.field)).is_unknown();
    let above = above.into_iter().filter(|(_, exposure)| is_known(exposure.start)).collect();
    Ok(Judged { report, flags, above, counted })
}

/// Adds age and lateness of the satellites that decide a verdict, which is `unknown` if positions are not known.
fn with_age(flag: Verdict, counted: &[Pass], may_cross: &[SatelliteAge], known: &Predictability) -> Verdict {
    let crossing: Vec<SatelliteAge> = counted.iter().map(SatelliteAge::from_pass).collect();
    let deciding = if crossing.is_empty() { may_cross } else { &crossing };
    let of =
        |value: fn(&SatelliteAge) -> f64| (!deciding.is_empty()).then(|| median(deciding.iter().map(value).collect()));
    let age_days = known.deciding_age_days();
    match known.reason() {
        Some(reason) => {
            let flag = flag.without_known_positions(reason);
            Verdict { elements_age_days: age_days, late_s: None, ..flag }
        }
        None => Verdict {
            p_any_is_lower_limit: flag.p_any_is_lower_limit || known.misses_many(),
            elements_age_days: of(|satellite| satellite.element_age_days).or(age_days),
            late_s: of(|satellite| satellite.along_track_sigma_s).or(known.late_s),
            ..flag
        },
    }
}

fn finished(mut report: FlagReport, flags: Vec<Option<Verdict>>, counted: Vec<Vec<Pass>>) -> FlagReport {
    report.sort_left_out();
    // No row remains `None`: those above the horizon were judged, the others are invalid.
    let with_passes = |(flag, passes): (Option<Verdict>, Vec<Pass>)| flag.map(|flag| Verdict { passes, ..flag });
    report.flags = flags.into_iter().zip(counted).filter_map(with_passes).collect();
    report
}

/// Returns the pass options for judging exposures.
pub(super) fn pass_options(request: &FlagRequest<'_>) -> PassOptions {
    PassOptions {
        include_dark: request.policy.include_dark,
        min_probability: request.policy.min_probability,
        photometry: *request.photometry,
        ..PassOptions::default()
    }
}

/// Returns the rows whose pointing is above the horizon and within the limits of a telescope in orbit, and sets the
/// verdict of all others to `invalid`.
fn above_the_horizon<'a>(
    rows: &[&'a ScheduledExposure],
    request: &FlagRequest<'_>,
    flags: &mut [Option<Verdict>],
) -> Result<Vec<(usize, &'a Exposure)>, Error> {
    let mut judged: Vec<(usize, &Exposure)> = Vec::with_capacity(rows.len());
    for (row, scheduled) in rows.iter().enumerate() {
        match &scheduled.exposure {
            Ok(exposure) => judged.push((row, exposure)),
            Err(reason) => flags[row] = Some(Verdict::invalid(&scheduled.id, reason.clone())),
        }
    }
    let exposures: Vec<&Exposure> = judged.iter().map(|(_, exposure)| *exposure).collect();
    let earth = |start, end| request.sky.orientation_over(start, end);
    let altitudes_rad = lowest_altitudes_over(&exposures, request.sky.viewpoint(), &earth, request.sky.watch())?;
    let mut altitudes = altitudes_rad.into_iter();
    judged.retain(|(row, exposure)| {
        let altitude_rad = altitudes.next().unwrap_or(f64::NAN);
        if altitude_rad.is_nan() || altitude_rad < 0.0 {
            let reason = below(request.sky.viewpoint(), exposure, altitude_rad);
            flags[*row] = Some(Verdict::invalid(&exposure.id, reason));
        }
        altitude_rad >= 0.0
    });
    let mut within = Vec::with_capacity(judged.len());
    for (row, exposure) in judged {
        request.sky.watch().check()?;
        match request.sky.broken_limit(exposure)? {
            Some(reason) => flags[row] = Some(Verdict::invalid(&exposure.id, reason)),
            None => within.push((row, exposure)),
        }
    }
    Ok(within)
}

/// Returns the reason why a pointing below the horizon or limb cannot be judged.
fn below(viewpoint: &Viewpoint, exposure: &Exposure, altitude_rad: f64) -> String {
    if altitude_rad.is_nan() {
        let name = viewpoint.name();
        let Some(observer) = viewpoint.orbit().filter(|observer| observer.elements_epoch().is_none()) else {
            return format!("cannot compute the position of {name} at that time from its elements");
        };
        let gap = observer.gap_in([exposure.start, seconds_after(exposure.start, exposure.duration_s)]);
        let gap = gap.map_or_else(String::new, |gap| format!(": {gap}"));
        return format!("no ephemeris of {name} covers the whole exposure{gap}");
    }
    match viewpoint {
        Viewpoint::Orbit(observer) if altitude_rad <= -std::f64::consts::FRAC_PI_2 => {
            format!("{} is below the limb height of {} km", viewpoint.name(), observer.limb().height_km)
        }
        Viewpoint::Site(_) => {
            format!("the pointing is below the horizon (altitude {:.1} deg)", altitude_rad.to_degrees())
        }
        Viewpoint::Orbit(_) => {
            format!("the pointing meets the Earth ({:.1} deg below its limb)", -altitude_rad.to_degrees())
        }
    }
}

/// Finds the earliest start that no satellite selected by `blocking` blocks, for all exposures that cannot start as
/// scheduled. With [`Blocking::Any`], an exposure with a crossing only in its margins becomes `streaked`.
fn find_starts(
    blocking: Blocking,
    judged: &mut Judged<'_>,
    rows: &[&ScheduledExposure],
    request: &FlagRequest<'_>,
) -> Result<(), Error> {
    let policy = request.policy;
    let band = |row: usize| rows[row].band.as_deref();
    let seeks = policy.max_delay_s.is_some() || matches!(request.sky.viewpoint(), Viewpoint::Site(_));
    let margin_s = policy.margin_or_default_s();
    let max_delay_s = if seeks { policy.max_delay_or_default_s() } else { 0.0 };
    let Judged { report, flags, above, counted } = judged;
    if blocking == Blocking::Avoid {
        for (row, exposure) in above.iter() {
            let Some(flag) = flags[*row].as_mut() else { continue };
            let start = match policy.has_limit_in(band(*row)) {
                true if flag.kind == VerdictKind::Avoid => continue,
                true => Some((exposure.start, 0.0)),
                false => flag.next_start(Blocking::Any),
            };
            flag.set_next_start(Blocking::Avoid, start);
        }
    }
    let is_searched = |row: usize, kind: VerdictKind| match blocking {
        Blocking::Any if kind == VerdictKind::Clear => margin_s > 0.0,
        Blocking::Any => seeks,
        Blocking::Avoid => {
            seeks
                && policy.has_limit_in(band(row))
                && (kind == VerdictKind::Avoid || kind == VerdictKind::Streaked && margin_s > 0.0)
        }
    };
    let searched: Vec<(usize, &Exposure)> = above
        .iter()
        .filter(|(row, _)| flags[*row].as_ref().is_some_and(|flag| is_searched(*row, flag.kind)))
        .copied()
        .collect();
    let options = PassOptions { without_light: blocking == Blocking::Any, ..pass_options(request) };
    let allowance_s = |pass: &Pass| lateness_allowance_s(pass, policy).min(max_delay_s);
    let blocked = |index: usize, blockers: &Blockers, allowance_s: &dyn Fn(&Pass) -> f64| -> Vec<Interval> {
        let (row, exposure) = searched[index];
        let limits = request.limits(band(row), rows[row].open_time_s(exposure));
        let is_blocking = |pass: &Pass| blocks(pass, &limits, blocking, policy);
        // The passes of the verdict are added because the search over the longer interval may omit one that only just
        // enters the field.
        let now = counted[row]
            .iter()
            .filter(|pass| is_blocking(pass))
            .flat_map(|pass| intervals(pass, exposure, 0.0, allowance_s(pass)));
        now.chain(blockers.intervals(exposure, is_blocking, allowance_s)).collect()
    };
    let has_start = |index: usize, blockers: &Blockers, delay_s: f64| {
        let (blocked, duration_s) = (blocked(index, blockers, &allowance_s), searched[index].1.duration_s);
        next_clear_start(&blocked, duration_s, margin_s, SEARCH_GUARD_S, 0.0, delay_s).is_some()
    };
    let exposures: Vec<&Exposure> = searched.iter().map(|(_, exposure)| *exposure).collect();
    let (blockers, left_out) = blockers(&exposures, blocking, max_delay_s, request, &options, has_start)?;
    report.left_out.extend(left_out);
    let earth = |start, end| request.sky.orientation_over(start, end);
    let watch = request.sky.watch();
    let last_starts = last_starts_s(&exposures, request.sky.viewpoint(), &earth, max_delay_s, watch)?;
    let mut searches = Vec::new();
    for (index, ((row, exposure), last_start_s)) in searched.iter().zip(last_starts).enumerate() {
        watch.check()?;
        let Some(flag) = flags[*row].as_mut() else { continue };
        let blocked = |allowance_s: &dyn Fn(&Pass) -> f64| blocked(index, &blockers[index], allowance_s);
        if flag.kind == VerdictKind::Clear {
            // Margins apply to nominal crossings, without the allowance for early and late satellites.
            let nominal = blocked(&|_| 0.0);
            let is_crossed = next_clear_start(&nominal, exposure.duration_s, margin_s, 0.0, 0.0, 0.0).is_none();
            if !is_crossed {
                continue;
            }
            flag.kind = VerdictKind::Streaked;
            let lit = if policy.include_dark { "" } else { "lit " };
            flag.reasons.push(format!("a {lit}satellite crosses within {margin_s} s of the exposure"));
        }
        if !seeks {
            continue;
        }
        let why_unknown =
            reason_for_unknown_starts(request.sky, request.field, policy, exposure.start, exposure.duration_s);
        if let Some(why) = why_unknown {
            flag.set_next_start(blocking, None);
            flag.reasons.push(format!("no {} start is known: {why}", start_name(blocking)));
            continue;
        }
        let is_in_orbit = request.sky.viewpoint().site().is_none();
        let search = StartSearch { row: *row, blocking, blocked: blocked(&allowance_s), last_start_s, is_in_orbit };
        search.find(exposure, policy, 0.0, flag);
        let is_possible_now = blocking == Blocking::Avoid && flag.kind == VerdictKind::Streaked;
        if !is_possible_now && flag.next_start(blocking).is_some_and(|(_, delay_s)| delay_s == 0.0) {
            // No satellite blocks this start: the exposure is excluded by the cost over all satellites.
            search.find(exposure, policy, least_step_s(policy), flag);
        }
        searches.push(search);
    }
    if policy.confirms_starts() {
        confirm(searches, above, blocking, rows, &options, request, flags)?;
    }
    Ok(())
}

/// Search for the next start of one exposure.
struct StartSearch {
    row: usize,
    blocking: Blocking,
    /// Intervals in which a blocking satellite is in the field, seconds after the scheduled opening.
    blocked: Vec<Interval>,
    /// Latest start before the pointing sets, seconds after the scheduled opening; see [`last_starts_s`].
    last_start_s: f64,
    /// True for a telescope in orbit, which may have limits and an ephemeris.
    is_in_orbit: bool,
}

impl StartSearch {
    /// Sets the earliest possible start that is at least `from_s` after the scheduled opening, or adds a reason if
    /// there is none.
    fn find(&self, exposure: &Exposure, policy: &Policy, from_s: f64, flag: &mut Verdict) {
        let (margin_s, max_delay_s) = (policy.margin_or_default_s(), policy.max_delay_or_default_s());
        let rest_s = max_delay_s - from_s;
        let found = next_clear_start(&self.blocked, exposure.duration_s, margin_s, SEARCH_GUARD_S, from_s, rest_s);
        let delay_s = found.map(|delay_s| (delay_s / TICK_S).ceil() * TICK_S);
        let sets = delay_s.is_some_and(|delay_s| delay_s > self.last_start_s);
        let start = delay_s.filter(|_| !sets).map(|delay_s| (seconds_after(exposure.start, delay_s), delay_s));
        flag.set_next_start(self.blocking, start);
        if start.is_none() {
            let state = start_name(self.blocking);
            flag.reasons.push(if sets {
                let ends = match self.is_in_orbit {
                    true => "the pointing sets, breaks a limit or the ephemeris ends",
                    false => "the pointing sets",
                };
                format!("no {state} start before {ends}, {:.0} s after the scheduled start", self.last_start_s)
            } else {
                format!("no {state} start within {max_delay_s} s")
            });
        }
    }
}

/// Returns the name, in reasons, of the starts that no satellite selected by `blocking` blocks.
fn start_name(blocking: Blocking) -> &'static str {
    match blocking {
        Blocking::Any => "clear",
        Blocking::Avoid => "acceptable",
    }
}

/// Returns the smallest step to the next start that is checked, seconds.
fn least_step_s(policy: &Policy) -> f64 {
    (policy.max_delay_or_default_s() / MOST_STEPS).max(TICK_S)
}

/// Computes passes and costs at the starts that were found, to check these starts. The check is necessary because the
/// blocked intervals do not determine the probabilities exactly.
///
/// A start at which a satellite still blocks, or at which the cost exceeds that of the policy, is replaced by the next
/// candidate within the longest delay. `band` returns the band of the exposure of a row.
fn confirm(
    mut searches: Vec<StartSearch>,
    judged: &[(usize, &Exposure)],
    blocking: Blocking,
    rows: &[&ScheduledExposure],
    options: &PassOptions,
    request: &FlagRequest<'_>,
    flags: &mut [Option<Verdict>],
) -> Result<(), Error> {
    let band = |row: usize| rows[row].band.as_deref();
    let policy = request.policy;
    let scheduled: HashMap<usize, &Exposure> = judged.iter().copied().collect();
    while !searches.is_empty() {
        let (open, later): (Vec<StartSearch>, Vec<Exposure>) = searches
            .into_iter()
            .filter_map(|search| {
                let (start, _) = flags[search.row].as_ref()?.next_start(search.blocking)?;
                let exposure = Exposure { start, ..(*scheduled.get(&search.row)?).clone() };
                Some((search, exposure))
            })
            .unzip();
        let crossings = request.sky.field_passes(&later, request.field, options)?;
        let is_too_costly: Vec<bool> = match policy.max_cost_s {
            Some(most_s) => request
                .sky
                .probabilities_with(&later, request.field, policy.include_dark, request.photometry.band)?
                .iter()
                .zip(open.iter().zip(&later).zip(&crossings.by_exposure))
                .map(|(satellites, ((search, exposure), passes))| {
                    let expected =
                        expected_of(satellites, (exposure, rows[search.row].open_s), band(search.row), passes, request);
                    expected.streak_cost_s.is_some_and(|cost_s| cost_s > most_s)
                })
                .collect(),
            None => vec![false; later.len()],
        };
        searches = Vec::new();
        for ((search, passes), is_too_costly) in open.into_iter().zip(&crossings.by_exposure).zip(is_too_costly) {
            request.sky.watch().check()?;
            let (Some(flag), Some(exposure)) = (flags[search.row].as_mut(), scheduled.get(&search.row)) else {
                continue;
            };
            let limits = request.limits(band(search.row), rows[search.row].open_time_s(exposure));
            let longest_sigma_s = passes
                .iter()
                .filter(|pass| blocks(pass, &limits, blocking, policy))
                .map(|pass| pass.along_track_sigma_s)
                .max_by(f64::total_cmp);
            if longest_sigma_s.is_none() && !is_too_costly {
                continue;
            }
            // A start that is later by half a sigma has a probability that is smaller by at least a tenth. The search
            // ends at the longest delay.
            if let Some((_, delay_s)) = flag.next_start(search.blocking) {
                let step_s = longest_sigma_s.map_or(0.0, |sigma_s| 0.5 * sigma_s).max(least_step_s(policy));
                search.find(exposure, policy, delay_s + step_s, flag);
                searches.push(search);
            }
        }
    }
    Ok(())
}

/// Returns the allowance for an early or late satellite, seconds; 0 if the policy has no `min_probability`.
pub(super) fn lateness_allowance_s(pass: &Pass, policy: &Policy) -> f64 {
    policy.min_probability.map_or(0.0, |_| (LATE_SIGMAS * pass.along_track_sigma_s).min(LONGEST_ALLOWANCE_S))
}

//! Satellites that may block the starts of exposures. The longest delay is searched in parts, because most exposures
//! have a start in the first one. A satellite that enters the Earth's shadow inside the field blocks the parts in which
//! it is lit.

use hifitime::Epoch;

use super::flag_request::FlagRequest;
use super::policy::Blocking;
use super::shift::{Interval, next_clear_start};
use crate::error::Error;
use crate::frames::{seconds_after, seconds_between};
use crate::orbit::LeftOut;
use crate::passes::{Exposure, FieldCrossing, Pass, PassOptions};

/// Delays up to which the satellites are searched first, seconds; the longest delay follows.
const FIRST_DELAYS_S: [f64; 2] = [30.0, 150.0];

/// Starts closer to the end of a part than this are judged with the next part, seconds; longer than the guard of
/// starts.
const SEAM_S: f64 = 0.01;

/// Satellites in the field of one exposure, for the delays that were searched.
#[derive(Default)]
pub(super) struct Blockers {
    parts: Vec<Part>,
}

/// Satellites in the field during one part of the time that was searched.
struct Part {
    /// Time from the start of the part to the scheduled opening, seconds; negative if the part starts later.
    lead_s: f64,
    satellites: PartSatellites,
}

enum PartSatellites {
    /// Passes with all that a policy needs to know of them.
    Passes(Vec<Pass>),
    /// Lit crossings with times only, which are ten times faster to compute.
    Crossings(Vec<FieldCrossing>),
}

impl Blockers {
    /// Returns the intervals in which a blocking satellite may be in the field, seconds after the scheduled opening.
    /// Those of a pass are extended by its allowance at both ends.
    pub fn intervals(
        &self,
        exposure: &Exposure,
        is_blocking: impl Fn(&Pass) -> bool,
        allowance_s: impl Fn(&Pass) -> f64,
    ) -> Vec<Interval> {
        let of_part = |Part { lead_s, satellites }: &Part| -> Vec<Interval> {
            match satellites {
                PartSatellites::Passes(passes) => passes
                    .iter()
                    .filter(|pass| is_blocking(pass))
                    .flat_map(|pass| intervals(pass, exposure, *lead_s, allowance_s(pass)))
                    .collect(),
                PartSatellites::Crossings(crossings) => in_field(crossings, *lead_s).collect(),
            }
        };
        self.parts.iter().flat_map(of_part).collect()
    }
}

/// Returns the intervals in which satellites are in the field, seconds after the scheduled opening.
fn in_field(crossings: &[FieldCrossing], lead_s: f64) -> impl Iterator<Item = Interval> {
    let chords = crossings.iter().flat_map(|crossing| &crossing.chords);
    chords.map(move |chord| Interval { start_s: chord.enter_s - lead_s, end_s: chord.exit_s - lead_s })
}

/// Returns the satellites that may block the starts of each exposure up to the longest delay, with the margins of the
/// policy, and the satellites without a position.
///
/// `has_start` is called with the index of an exposure, satellites, and a delay in seconds; it returns whether these
/// satellites leave a start up to this delay. If those of a part do, no later ones are searched; if some of them leave
/// none, the others of the part are not computed.
pub(super) fn blockers(
    exposures: &[&Exposure],
    blocking: Blocking,
    max_delay_s: f64,
    request: &FlagRequest<'_>,
    options: &PassOptions,
    has_start: impl Fn(usize, &Blockers, f64) -> bool + Sync,
) -> Result<(Vec<Blockers>, Vec<LeftOut>), Error> {
    let FlagRequest { sky, policy, .. } = request;
    let margin_s = policy.margin_or_default_s();
    let delayed =
        |exposure: &Exposure, delay_s| seconds_after(exposure.start, exposure.duration_s + margin_s + delay_s);
    let mut found: Vec<Blockers> = exposures.iter().map(|_| Blockers::default()).collect();
    let mut left_out = Vec::new();
    // Index, and the time of each exposure that has not been searched.
    let mut open: Vec<(usize, [Epoch; 2])> = exposures
        .iter()
        .map(|exposure| {
            let scheduled = [exposure.start, seconds_after(exposure.start, exposure.duration_s)];
            sky.viewpoint().known_part(scheduled, margin_s, max_delay_s + margin_s).unwrap_or(scheduled)
        })
        .enumerate()
        .collect();
    // A start that a second look does not confirm is replaced by a later one.
    let first_delays_s: &[f64] = if policy.confirms_starts() { &[] } else { &FIRST_DELAYS_S };
    let first_delays_s = first_delays_s.iter().copied().filter(|delay_s| *delay_s < max_delay_s);
    for delay_s in first_delays_s.chain([max_delay_s]) {
        let part = |(index, [start, end]): &(usize, [Epoch; 2])| {
            let end = delayed(exposures[*index], delay_s).min(*end);
            Exposure { start: *start, duration_s: seconds_between(*start, end), ..exposures[*index].clone() }
        };
        let parts: Vec<Exposure> = open.iter().map(part).collect();
        let is_last = delay_s >= max_delay_s;
        let excludes_all = |part: usize, crossings: &[FieldCrossing]| {
            let (index, exposure) = (open[part].0, exposures[open[part].0]);
            let mut blocked = found[index].intervals(exposure, |_| true, |_| 0.0);
            blocked.extend(in_field(crossings, seconds_between(parts[part].start, exposure.start)));
            // Satellites at the end of a part also block starts after it.
            let until_s = if is_last { max_delay_s } else { delay_s + exposure.duration_s + 2.0 * margin_s };
            next_clear_start(&blocked, exposure.duration_s, margin_s, 0.0, 0.0, until_s).is_none()
        };
        let leave_no_start = |part: usize, passes: &[Pass]| {
            let index = open[part].0;
            let lead_s = seconds_between(parts[part].start, exposures[index].start);
            let satellites = PartSatellites::Passes(passes.to_vec());
            !policy.confirms_starts()
                && !has_start(index, &Blockers { parts: vec![Part { lead_s, satellites }] }, delay_s)
        };
        let (satellites, without) = match request.every_crossing_blocks(blocking) {
            true => {
                let found = request.sky.field_crossings_until(&parts, request.field, excludes_all)?;
                (found.by_exposure.into_iter().map(PartSatellites::Crossings).collect::<Vec<_>>(), found.left_out)
            }
            false => {
                let found = request.sky.field_passes_until(&parts, request.field, options, leave_no_start)?;
                (found.by_exposure.into_iter().map(PartSatellites::Passes).collect(), found.left_out)
            }
        };
        left_out.extend(without);
        for (((index, [start, _]), part), satellites) in open.iter_mut().zip(&parts).zip(satellites) {
            let lead_s = seconds_between(part.start, exposures[*index].start);
            match satellites {
                PartSatellites::Crossings(_) => *start = seconds_after(part.start, part.duration_s),
                // Probability and peak of a pass depend on the whole time that is searched.
                PartSatellites::Passes(_) => found[*index].parts.clear(),
            }
            found[*index].parts.push(Part { lead_s, satellites });
        }
        open.retain(|(index, [start, end])| start < end && !has_start(*index, &found[*index], delay_s - SEAM_S));
    }
    Ok((found, left_out))
}

/// Returns the intervals in which a satellite may be in the field, seconds after the scheduled opening. `lead_s` is the
/// time by which the exposure used to compute the pass opens before the scheduled opening.
///
/// These are the chords of a crossing, or the time of closest approach of a near miss, extended at both ends by
/// `late_s`. If the delay has sigma σ, a satellite that left the field z σ before an exposure opens crosses it with a
/// probability below 1 - Φ(z).
pub(super) fn intervals(pass: &Pass, exposure: &Exposure, lead_s: f64, late_s: f64) -> Vec<Interval> {
    let widened = |start_s: f64, end_s: f64| Interval { start_s: start_s - late_s, end_s: end_s + late_s };
    if pass.is_crossing() {
        pass.chords.iter().map(|chord| widened(chord.enter_s - lead_s, chord.exit_s - lead_s)).collect()
    } else {
        let closest_s = seconds_between(exposure.start, pass.mid.epoch);
        vec![widened(closest_s, closest_s)]
    }
}

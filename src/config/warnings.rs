//! Warnings about files, element sets and tables.

use std::error::Error;

use hifitime::{Epoch, TimeScale, Unit};

use crate::elements::{ElementSet, Origin, Rejected, Satellites};
use crate::frames::{EopStatus, EopTable, seconds_between};
use crate::math::quantile::median;
use crate::message::Quoted;
use crate::orbit::{LeftOut, TooOld, elements_of_age};
use crate::output::{counted, format_utc};
use crate::passes::{OrbitingObserver, Sky};

/// Largest difference between the epoch of an element set and the time of a request without a warning, days.
pub const OLD_ELEMENTS_DAYS: f64 = 14.0;
/// Largest difference between the epoch of a telescope's elements and the time of a request without a warning, days.
const OLD_OBSERVER_DAYS: f64 = 3.0;

/// Largest number of items listed in a warning.
const NAMED: usize = 3;

/// Returns the warning about element sets that SGP4 cannot propagate to the time of the request, and about those that
/// are too old: the number of these is `unknown`.
pub(super) fn of_left_out(left_out: &[LeftOut], unknown: usize, satellites: usize) -> String {
    let failed = left_out.len() - unknown;
    let all = element_sets(satellites);
    let cannot = format!("{} of {all} cannot be propagated to this date", grouped(failed));
    if unknown == 0 {
        return cannot;
    }
    let too_old: Vec<&TooOld> =
        left_out.iter().filter_map(|satellite| satellite.reason.source()?.downcast_ref()).collect();
    let ages = too_old.iter().map(|satellite| satellite.age_days);
    let named: Vec<String> = too_old.iter().take(NAMED).map(|satellite| satellite.norad_id.to_string()).collect();
    let (are, more) = (if unknown == 1 { "is" } else { "are" }, if unknown > NAMED { ", ..." } else { "" });
    let old = format!(
        "{} of {all} {are} too old to predict positions (median: {}), and left out at these times: {}{more}",
        grouped(unknown),
        elements_of_age(median(ages.collect())),
        named.join(", ")
    );
    if failed == 0 { old } else { format!("{old}; {cannot}") }
}

/// Returns a warning if measured magnitudes are not used.
pub(super) fn of_measured(measured: usize, not_used: usize) -> Option<String> {
    (not_used > 0).then(|| {
        let of = counted(measured, "measured magnitude", "measured magnitudes");
        format!(
            "predicted magnitudes are not corrected by {not_used} of {of}: the satellite is simulated or has no element set, \
             or no magnitude is predicted at that time"
        )
    })
}

/// Returns the warning about satellites without a possible magnitude in the table of standard magnitudes.
pub(super) fn of_placeholders(placeholders: &[u32], elements: &[ElementSet]) -> Option<String> {
    if placeholders.is_empty() {
        return None;
    }
    let listed: Vec<String> = elements
        .iter()
        .filter(|set| set.origin == Origin::Published && placeholders.contains(&set.norad_id.0))
        .map(|set| set.norad_id.to_string())
        .collect();
    (!listed.is_empty()).then(|| {
        format!(
            "{} of {} in the table of standard magnitudes ignored, because it is 0 or outside -5 to 16: {}",
            counted(listed.len(), "magnitude", "magnitudes"),
            counted(placeholders.len(), "satellite", "satellites"),
            first_of(&listed)
        )
    })
}

/// Returns the warning about simulated constellations.
pub(super) fn of_simulated(names: &[&str], satellites: usize) -> String {
    let noun = if names.len() == 1 { "constellation" } else { "constellations" };
    format!(
        "simulated {noun} {}: positions do not correspond to real satellites ({} {})",
        names.join(", "),
        grouped(satellites),
        if satellites == 1 { "satellite" } else { "satellites" }
    )
}

/// Returns the warnings about satellites that are left out because they are the telescope in orbit by their orbits, and
/// about an ephemeris of the telescope with the number of another satellite.
pub(super) fn of_own_satellites(
    observer: &str,
    left_out: &[String],
    other_orbit: Option<(String, f64)>,
) -> Vec<String> {
    let left_out = (!left_out.is_empty()).then(|| {
        format!(
            "{} left out as part of the observer {observer}, always within 10 km of it: {}",
            counted(left_out.len(), "satellite is", "satellites are"),
            first_of(left_out)
        )
    });
    let wrong = other_orbit.map(|(name, km)| {
        format!(
            "the ephemeris of the observer {observer} is {km:.0} km from the element set of {name}: its OBJECT_ID may be wrong; this \
             satellite is searched like others"
        )
    });
    left_out.into_iter().chain(wrong).collect()
}

/// Returns the warning about constellations that grow, if none of their satellites is in orbit in the night of an
/// evening (MJD), and there are no other satellites.
pub(super) fn of_empty_period(evening: i64) -> String {
    let night = day(Epoch::from_mjd_utc(evening as f64));
    format!("there are no satellites: no simulated constellation has one in orbit in the night of {night}")
}

/// Returns a number of element sets with its noun.
pub(super) fn element_sets(count: usize) -> String {
    format!("{} {}", grouped(count), if count == 1 { "element set" } else { "element sets" })
}

/// Formats a count with commas between groups of three digits.
fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).unwrap_or_default()).collect();
    groups.join(",")
}

/// Returns the warnings about rejected records, truncated files, and records accepted despite a wrong checksum.
pub(super) fn of_catalogue(catalogue: &Satellites) -> Vec<String> {
    let mut warnings = Vec::new();
    let rejected = catalogue.rejected.len();
    if rejected > 0 {
        let records = rejected + catalogue.sources.iter().map(|source| source.records).sum::<usize>();
        let named: Vec<String> = catalogue.rejected.iter().take(NAMED).map(ToString::to_string).collect();
        let more = if rejected > NAMED { "; ..." } else { "" };
        let mut warning = format!("{rejected} of {} rejected", counted(records, "record", "records"));
        if 2 * rejected > records {
            warning += ", more than half: the result is incomplete without the satellites of these records";
        }
        let is_checksum = |record: &&Rejected| record.reason.what() == Some("checksum");
        let checksums = catalogue.rejected.iter().filter(is_checksum).count();
        if checksums > 0 {
            warning += &format!(" ({checksums} with a wrong checksum; --accept-bad-checksums accepts these)");
        }
        warnings.push(format!("{warning}: {}{more}", named.join("; ")));
    }
    for name in cut_short(catalogue) {
        warnings.push(format!("{name} ends with a broken record and may be truncated; fetch it again"));
    }
    let accepted: usize = catalogue.sources.iter().map(|source| source.bad_checksums_accepted).sum();
    if accepted > 0 {
        warnings.push(format!("{} accepted despite a wrong checksum", counted(accepted, "record", "records")));
    }
    warnings
}

/// Returns the warnings about element sets of other epochs that are not used, because they are of another object, and
/// about satellites with several element sets of one epoch that differ. Both lists are sorted by catalogue number.
pub(super) fn of_other_sets(elements: &[ElementSet], others: &[ElementSet]) -> Vec<String> {
    let (mut of_other_objects, mut contradictory) = (Vec::new(), Vec::new());
    for other in others {
        let Ok(index) = elements.binary_search_by_key(&other.norad_id, |set| set.norad_id) else { continue };
        let used = &elements[index];
        let satellite = format!("{} {}", used.norad_id, used.name);
        if used.is_of_other_object(other) {
            let [designator, used] = [other, used].map(|set| Quoted::new(&*set.international_designator));
            of_other_objects.push(format!("{} ({designator}, not {used})", satellite.trim()));
        } else if used.epoch == other.epoch
            && let Some((name, [used, other], unit)) = used.difference(other)
        {
            contradictory.push(format!("{} (used: {name} {used}{unit}, not {other}{unit})", satellite.trim()));
        }
    }
    let ignored = (!of_other_objects.is_empty()).then(|| {
        format!(
            "{} of another epoch ignored, because the COSPAR designator is that of another object than in the set that is \
             used: {}",
            element_sets(of_other_objects.len()),
            first_of(&of_other_objects)
        )
    });
    let contradictory = (!contradictory.is_empty()).then(|| {
        format!(
            "{} ignored, because another set of the same satellite and epoch with different elements is read after it: {}",
            element_sets(contradictory.len()),
            first_of(&contradictory)
        )
    });
    ignored.into_iter().chain(contradictory).collect()
}

/// Returns the warning about ephemerides whose satellites have no element set.
pub(super) fn of_ephemerides_without_elements(names: &[String]) -> Option<String> {
    (!names.is_empty()).then(|| {
        format!(
            "{} ignored, because the satellite has no element set: {}",
            counted(names.len(), "ephemeris", "ephemerides"),
            first_of(names)
        )
    })
}

/// Returns the warning about satellites whose ephemerides do not cover the time of the request. `all` is the number of
/// satellites with ephemerides.
pub(super) fn of_uncovered(names: &[String], all: usize) -> Option<String> {
    (!names.is_empty()).then(|| {
        format!(
            "the ephemerides of {} of {} do not cover the whole time of the request; element sets are used for exposures that \
             they do not cover: {}",
            grouped(names.len()),
            counted(all, "satellite", "satellites"),
            first_of(names)
        )
    })
}

/// Returns the warning about satellites with ephemerides of one message that contradict each other.
pub(super) fn of_contradictory(names: &[String]) -> Option<String> {
    (!names.is_empty()).then(|| {
        format!(
            "segments of one ephemeris message overlap and differ by more than 1 km, without USEABLE times that decide; the \
             one that begins later is used: {}",
            first_of(names)
        )
    })
}

/// Returns the first names of a list, separated by commas.
pub(super) fn first_of(names: &[String]) -> String {
    let more = if names.len() > NAMED { ", ..." } else { "" };
    names[..names.len().min(NAMED)].join(", ") + more
}

/// Returns the warning about element sets with epochs more than two weeks before or after the request.
pub(super) fn of_age(
    sky: &Sky,
    from_files: usize,
    first: Epoch,
    last: Epoch,
    is_selected: &dyn Fn(&ElementSet) -> bool,
) -> Option<String> {
    let elements = &sky.elements()[..from_files];
    let days = |from: Epoch, to: Epoch| seconds_between(from, to) / Unit::Day.in_seconds();
    // All epochs are UTC. Durations are compared because conversions with leap seconds are slow, and this function runs
    // for each server response.
    let days_after = |epoch: Epoch, days: f64| (epoch.to_time_scale(TimeScale::UTC) + days * Unit::Day).duration;
    let near = days_after(first, -OLD_ELEMENTS_DAYS)..=days_after(last, OLD_ELEMENTS_DAYS);
    let selected: Vec<usize> = (0..from_files).filter(|&index| is_selected(&elements[index])).collect();
    let is_old = |index: &usize| !near.contains(&elements[*index].epoch.duration);
    let old: Vec<usize> = selected.iter().copied().filter(is_old).collect();
    let age_days = |index: usize| days(elements[index].epoch, first).max(days(last, elements[index].epoch));
    let farthest = old.iter().map(|&index| age_days(index)).max_by(f64::total_cmp)?;
    let known: Vec<usize> = old.iter().copied().filter(|&index| sky.is_known(index, age_days(index))).collect();
    let late_s: Vec<f64> = known.iter().map(|&index| sky.uncertainty(index, age_days(index)).along_track_s).collect();
    let without = if !known.is_empty() && sky.mean_motions().keys().any(|motion| motion.is_improved()) {
        let of_one_set = |&index: &usize| sky.uncertainty_of_one_set(index, age_days(index)).along_track_s;
        format!(", without the sets of other epochs by {:.1} s", median(known.iter().map(of_one_set).collect()))
    } else {
        String::new()
    };
    let (are, they) = if old.len() == 1 { ("is", "it is") } else { ("are", "they are") };
    let lateness = match (known.len(), old.len() - known.len()) {
        (0, _) => "too old to predict positions".to_owned(),
        (_, 0) => format!("{they} early or late by {:.1} s{without} (68 %, median)", median(late_s)),
        (_, unknown) => format!(
            "{} too old to predict positions, the others early or late by {:.1} s{without} (68 %, median)",
            grouped(unknown),
            median(late_s)
        ),
    };
    Some(format!(
        "{} of {} {are} more than {OLD_ELEMENTS_DAYS} days from the exposures (the farthest by {farthest:.1} days): \
         {lateness}",
        grouped(old.len()),
        element_sets(selected.len()),
    ))
}

/// Returns the warning about simulated constellations generated for a day more than two weeks before or after the
/// request.
pub(super) fn of_shells(generated_for: Epoch, first: Epoch, last: Epoch) -> Option<String> {
    let days = |from: Epoch, to: Epoch| seconds_between(from, to) / Unit::Day.in_seconds();
    let age_days = days(generated_for, first).max(days(last, generated_for));
    (age_days > OLD_ELEMENTS_DAYS).then(|| {
        format!(
            "the shells were generated for {}, {age_days:.1} days from the exposures: their positions are arbitrary at that time",
            day(generated_for)
        )
    })
}

/// Returns the warning about constellations that grow: those of the evening `used` (MJD) are used, but between it and
/// the first or last evening of the request another period begins. `begins` are the first evenings of all periods.
pub(super) fn of_growth(used: i64, [first, last]: [i64; 2], begins: &[i64]) -> Option<String> {
    let (from, to) = (used.min(first), used.max(last));
    let other = begins.iter().filter(|begin| (from + 1..=to).contains(*begin)).min()?;
    Some(format!(
        "satellites are those of the night of {} for the whole request, although another period of the file \
         begins on {}",
        day(Epoch::from_mjd_utc(used as f64)),
        day(Epoch::from_mjd_utc(*other as f64))
    ))
}

/// Returns the warning about a telescope in orbit: its elements are old, or its ephemerides do not cover the time of
/// the request.
pub(super) fn of_observer(observer: &OrbitingObserver, first: Epoch, last: Epoch) -> Option<String> {
    let days = |from: Epoch, to: Epoch| seconds_between(from, to) / Unit::Day.in_seconds();
    let Some(epoch) = observer.elements_epoch() else {
        let intervals = || observer.ephemerides().iter().map(|ephemeris| ephemeris.interval());
        let begin = intervals().map(|(begin, _)| begin).min()?;
        let end = intervals().map(|(_, end)| end).max()?;
        let gap = observer.gap_in([first.max(begin), last.min(end)]);
        if gap.is_none() && first >= begin && last <= end {
            return None;
        }
        let name = observer.name();
        let (from, to) = (format_utc(begin, 0), format_utc(end, 0));
        return Some(match gap {
            None => {
                format!("the ephemeris of the observer {name} covers {from} to {to}: exposures outside are invalid")
            }
            Some(gap) => format!(
                "the ephemeris of the observer {name} has states from {from} to {to}, with gaps: exposures in gaps and \
                 outside are invalid (first {gap})"
            ),
        });
    };
    let farthest = if days(epoch, last) > days(first, epoch) { last } else { first };
    let (age_days, error_km) = (days(epoch, farthest).abs(), observer.position_error_km(farthest)?);
    (age_days > OLD_OBSERVER_DAYS).then(|| {
        format!(
            "the elements of the observer {} are {age_days:.1} days from the farthest exposure: 68 % of the positions are \
             within {error_km:.0} km, and all crossings have this error",
            observer.name()
        )
    })
}

/// Returns the warning about times outside the table of Earth orientation.
pub(super) fn of_orientation(eop: &EopTable, first: Epoch, last: Epoch) -> Option<String> {
    let uncovered = [first, last].map(|epoch| eop.status(epoch)).into_iter().find(|status| !status.is_covered())?;
    let why = match uncovered {
        EopStatus::Expired { last } => format!("the Earth orientation table ended {}", day(last)),
        EopStatus::TooEarly { first } => format!("the Earth orientation table begins {}", day(first)),
        _ => "there is no Earth orientation table".to_owned(),
    };
    Some(format!("{why}: UT1 = UTC is used (0.1 s of UT1 is 46 m at the equator); specify a newer one with --eop"))
}

/// Returns the names of files whose last record is incomplete.
pub(super) fn cut_short(catalogue: &Satellites) -> impl Iterator<Item = &str> {
    catalogue.sources.iter().filter(|source| source.cut_short).map(|source| source.name.as_ref())
}

fn day(epoch: Epoch) -> String {
    format_utc(epoch.to_time_scale(TimeScale::UTC), 0).chars().take(10).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::Constellation;
    use crate::frames::parse_instant;
    use crate::geometry::{Observer, Site};
    use crate::passes::ModelChoice;

    fn utc(text: &str) -> Epoch {
        parse_instant(text, None).unwrap()
    }

    #[test]
    fn ages_count_to_both_sides_and_only_outside_the_night() {
        let sets = Constellation::by_name("kuiper").unwrap().element_sets(utc("2024-08-14T00:00:00Z"));
        let site = Observer::new(Site::from_mpc("X05").unwrap());
        let sky = Sky::with_models(sets, site, EopTable::embedded(), &ModelChoice::default());
        let warning = |first: &str, last: &str| of_age(&sky, 10, utc(first), utc(last), &|_| true);
        assert_eq!(warning("2024-08-01T00:00:00Z", "2024-08-27T00:00:00Z"), None);
        assert_eq!(warning("2024-08-27T00:00:00Z", "2024-08-28T00:00:00Z"), None);
        let older = warning("2024-09-03T00:00:00Z", "2024-09-03T06:00:00Z").unwrap();
        assert!(
            older.starts_with("10 of 10 element sets are more than 14 days")
                && older.contains("(the farthest by 20.0 days): they are early or late by 0.1 s (68 %, median)"),
            "{older}"
        );
        let newer = warning("2024-07-01T00:00:00Z", "2024-07-15T00:00:00Z").unwrap();
        assert!(newer.contains("(the farthest by 30.0 days)"), "{newer}");
    }
}

//! Warnings about files, elements and tables, each with its count.

use hifitime::{Epoch, TimeScale, Unit};

use crate::elements::{ElementSet, RejectReason, Rejected, Satellites};
use crate::frames::{EopStatus, EopTable, seconds_between};
use crate::orbit::LeftOut;
use crate::output::{counted, format_utc};
use crate::passes::OrbitingObserver;

/// Beyond this age, either way, element sets draw a warning, days.
pub const OLD_ELEMENTS_DAYS: f64 = 14.0;
/// Beyond this age, either way, the elements of a telescope in orbit draw a warning, days.
const OLD_OBSERVER_DAYS: f64 = 3.0;

/// Number of objects named in a warning.
const NAMED: usize = 3;

/// Satellites without a position, of which there is a first.
pub(super) fn of_left_out(left_out: &[LeftOut], first: &LeftOut, satellites: usize) -> String {
    let named: Vec<String> = left_out.iter().take(NAMED).map(|one| one.norad_id.to_string()).collect();
    let more = if left_out.len() > NAMED { ", ..." } else { "" };
    format!(
        "{} of {} satellites left out ({}{more}); the first: {}",
        left_out.len(),
        satellites,
        named.join(", "),
        first.reason
    )
}

/// Records rejected, files cut short, and records accepted in spite of a wrong checksum.
pub(super) fn of_catalogue(catalogue: &Satellites) -> Vec<String> {
    let mut warnings = Vec::new();
    let rejected = catalogue.rejected.len();
    if rejected > 0 {
        let records = rejected + catalogue.sources.iter().map(|source| source.records).sum::<usize>();
        let named: Vec<String> = catalogue.rejected.iter().take(NAMED).map(ToString::to_string).collect();
        let more = if rejected > NAMED { "; ..." } else { "" };
        let mut warning = format!("{rejected} of {} rejected", counted(records, "record", "records"));
        if 2 * rejected > records {
            warning +=
                ", more than half: the answer is incomplete, the satellites of these records are missing from it";
        }
        let is_checksum = |one: &&Rejected| matches!(one.reason, RejectReason::BadChecksum { .. });
        let checksums = catalogue.rejected.iter().filter(is_checksum).count();
        if checksums > 0 {
            warning += &format!(" ({checksums} for a wrong checksum; --accept-bad-checksums takes those)");
        }
        warnings.push(format!("{warning}: {}{more}", named.join("; ")));
    }
    for name in cut_short(catalogue) {
        warnings.push(format!("{name} ends with a broken record: it may have been cut short; fetch it again"));
    }
    let accepted: usize = catalogue.sources.iter().map(|source| source.bad_checksums_accepted).sum();
    if accepted > 0 {
        warnings.push(format!("{} taken in spite of a wrong checksum", counted(accepted, "record", "records")));
    }
    warnings
}

/// Element sets more than two weeks from the time of the question, either way.
pub(super) fn of_age(elements: &[ElementSet], first: Epoch, last: Epoch) -> Option<String> {
    let days = |from: Epoch, to: Epoch| seconds_between(from, to) / Unit::Day.in_seconds();
    // All epochs are UTC: comparing their durations avoids leap seconds, and a server calls this with each answer.
    let days_after = |epoch: Epoch, days: f64| (epoch.to_time_scale(TimeScale::UTC) + days * Unit::Day).duration;
    let near = days_after(first, -OLD_ELEMENTS_DAYS)..=days_after(last, OLD_ELEMENTS_DAYS);
    let old: Vec<&ElementSet> = elements.iter().filter(|set| !near.contains(&set.epoch.duration)).collect();
    let farthest = old.iter().map(|set| days(set.epoch, first).max(days(last, set.epoch))).max_by(f64::total_cmp)?;
    Some(format!(
        "{} of {} element sets are more than {OLD_ELEMENTS_DAYS} days from the exposures (the farthest by {farthest:.1} days): \
         places and probabilities are uncertain to match",
        old.len(),
        elements.len(),
    ))
}

/// Synthetic satellites of a day more than two weeks from the time of the question, either way.
pub(super) fn of_shells(made_for: Epoch, first: Epoch, last: Epoch) -> Option<String> {
    let days = |from: Epoch, to: Epoch| seconds_between(from, to) / Unit::Day.in_seconds();
    let age_days = days(made_for, first).max(days(last, made_for));
    (age_days > OLD_ELEMENTS_DAYS).then(|| {
        format!(
            "the shells were made for {}, {age_days:.1} days from the exposures: nobody can say where they would stand then",
            day(made_for)
        )
    })
}

/// Position of the telescope in orbit from elements that are days old.
pub(super) fn of_observer(observer: &OrbitingObserver, first: Epoch, last: Epoch) -> Option<String> {
    let days = |from: Epoch, to: Epoch| seconds_between(from, to) / Unit::Day.in_seconds();
    let age_days = days(observer.elements_epoch(), last).max(days(first, observer.elements_epoch()));
    (age_days > OLD_OBSERVER_DAYS).then(|| {
        format!(
            "the elements of the observer {} are {age_days:.1} days from the farthest exposure: its own place errs by kilometres, \
             and with it every crossing",
            observer.name()
        )
    })
}

/// Times that the table of Earth orientation does not cover.
pub(super) fn of_orientation(eop: &EopTable, first: Epoch, last: Epoch) -> Option<String> {
    let uncovered = [first, last].map(|epoch| eop.status(epoch)).into_iter().find(|status| !status.is_covered())?;
    let why = match uncovered {
        EopStatus::Expired { last } => format!("the Earth orientation table ended {}", day(last)),
        EopStatus::TooEarly { first } => format!("the Earth orientation table begins {}", day(first)),
        _ => "there is no Earth orientation table".to_owned(),
    };
    Some(format!("{why}: UT1 = UTC was taken (0.1 s of UT1 is 46 m at the equator); give a newer one with --eop"))
}

/// Files that end with a broken record.
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

    fn utc(text: &str) -> Epoch {
        parse_instant(text, None).unwrap()
    }

    #[test]
    fn ages_count_to_both_sides_and_only_outside_the_night() {
        let sets = Constellation::by_name("kuiper").unwrap().element_sets(utc("2024-08-14T00:00:00Z"));
        let warning = |first: &str, last: &str| of_age(&sets[..10], utc(first), utc(last));
        assert_eq!(warning("2024-08-01T00:00:00Z", "2024-08-27T00:00:00Z"), None);
        assert_eq!(warning("2024-08-27T00:00:00Z", "2024-08-28T00:00:00Z"), None);
        let older = warning("2024-09-03T00:00:00Z", "2024-09-03T06:00:00Z").unwrap();
        assert!(
            older.starts_with("10 of 10 element sets are more than 14 days")
                && older.contains("(the farthest by 20.0 days)"),
            "{older}"
        );
        let newer = warning("2024-07-01T00:00:00Z", "2024-07-15T00:00:00Z").unwrap();
        assert!(newer.contains("(the farthest by 30.0 days)"), "{newer}");
    }
}

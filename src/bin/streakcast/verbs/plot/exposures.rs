//! Table of exposures with their verdicts, used by the plots of nights.

use std::path::Path;

use anyhow::{anyhow, bail};
use hifitime::Epoch;
use streakcast::config::Config;
use streakcast::frames::{EopTable, mjd_utc};
use streakcast::geometry::{Observer, Site};
use streakcast::output::{Column, Kind, Provenance, Table, Value};
use streakcast::schedule::{Schedule, ScheduledExposure, Verdict, VerdictKind, evening_mjd};

use crate::clock::{civil_date, date_of};
use crate::local_time::LocalTime;
use crate::verbs::schedule_verdicts::PreparedSchedule;

use super::clock::sun_altitude_deg;
use super::columns::Columns;

/// Table of exposures with their verdicts, and its provenance.
pub struct Exposures {
    pub table: Table,
    pub provenance: Provenance,
}

const COLUMNS: [Column; 9] = [
    Column::new("exposure_id", Kind::Text, "Identifier of the exposure in the schedule."),
    Column::time("start_utc", "Shutter opening."),
    Column::real("duration_s", "s", 3, "Length of the exposure."),
    Column::new("band", Kind::Text, "Band of the exposure in the schedule."),
    Column::new("verdict", Kind::Text, "Verdict: clear, streaked, avoid, or invalid."),
    Column::new("n_streaks", Kind::Integer, "Lit satellites with nominal tracks across the field."),
    Column::real(
        "n_bright",
        "",
        3,
        "Expected number of them brighter than the limit; empty without a limit for the band.",
    ),
    Column::real("brightest_mag", "mag", 3, "Brightest magnitude that any of these satellites reaches in the field."),
    Column::real("sun_altitude_deg", "deg", 4, "Altitude of the Sun's centre in the middle of the exposure."),
];

/// Judges a schedule.
pub fn compute(config: &Config, schedule: &Path, site: Option<&Site>, eop: &EopTable) -> anyhow::Result<Exposures> {
    let prepared = PreparedSchedule::read(config, schedule, None, None)?;
    let (flags, _) = prepared.judge()?;
    let observer = site.map(|site| Observer::new(site.clone()));
    let limit = config.policy()?.limit_mag;
    let rows = prepared.schedule.exposures.iter().zip(&flags);
    let row = |(row, flag): (&ScheduledExposure, &Verdict)| {
        let exposure = row.exposure.as_ref().ok();
        // The limits of a telescope depend on each streak, so there is no single number.
        let limit = limit.as_ref().and_then(|limit| limit.limit_in(row.band.as_deref()));
        let bright = limit.map(|limit| {
            let crossings = flag.passes.iter().filter(|pass| pass.lit && pass.is_crossing());
            crossings.fold(0.0, |sum, pass| sum + pass.probability_brighter_than(limit))
        });
        let is_judged = !matches!(flag.kind, VerdictKind::Unknown | VerdictKind::Invalid);
        let n_streaks = exposure.filter(|_| is_judged).map(|_| flag.n_streaks);
        let verdict =
            [flag.kind.name().into(), n_streaks.into(), exposure.and(bright).into(), flag.brightest_mag.into()];
        row_of(row, verdict, observer.as_ref(), eop)
    };
    Ok(Exposures {
        table: Table { columns: COLUMNS.to_vec(), rows: rows.map(row).collect() },
        provenance: prepared.provenance,
    })
}

/// Returns the table for an output of `flag`. The times are taken from the schedule.
pub fn of_flags(
    flags: &Columns,
    path: &Path,
    config: &Config,
    observer: Option<&Observer>,
    eop: &EopTable,
) -> anyhow::Result<Table> {
    let schedule = Schedule::read(path, &config.schedule_options()?)?;
    let ids = flags.texts("exposure_id")?;
    let same =
        schedule.exposures.len() == ids.len() && schedule.exposures.iter().zip(&ids).all(|(row, id)| row.id == *id);
    if !same {
        bail!(
            "the {1} exposures of the schedule {0} differ from the {2} of the flags; allowed: the schedule of the flags",
            path.display(),
            schedule.exposures.len(),
            ids.len()
        );
    }
    check_exposures(flags, &schedule, path)?;
    let (verdicts, streaks, brightest) =
        (flags.texts("verdict")?, flags.numbers("n_streaks")?, flags.numbers("brightest_mag")?);
    let rows = schedule.exposures.iter().enumerate().map(|(index, row)| {
        let is_valid = row.exposure.is_ok();
        let n_streaks = Some(streaks[index]).filter(|number| is_valid && number.is_finite());
        let n_streaks = n_streaks.map(|number| number as usize);
        let brightest_mag = Some(brightest[index]).filter(|mag| mag.is_finite());
        let verdict = [verdicts[index].into(), n_streaks.into(), Value::Null, brightest_mag.into()];
        row_of(row, verdict, observer, eop)
    });
    Ok(Table { columns: COLUMNS.to_vec(), rows: rows.collect() })
}

/// Largest difference between times in a table and in its schedule, seconds, and between angles, degrees: the rounding
/// of tables.
const ROUNDING_S: f64 = 0.01;
const ROUNDING_DEG: f64 = 1e-5;

/// Checks that starts, lengths and pointings of flags are those of the schedule, as far as the table has them.
/// Schedules of several nights may have the same identifiers.
///
/// # Errors
/// An exposure differs.
fn check_exposures(flags: &Columns, schedule: &Schedule, path: &Path) -> anyhow::Result<()> {
    let starts = if flags.has("start_utc") { flags.moments("start_utc")? } else { vec![f64::NAN; flags.len()] };
    let durations_s = flags.numbers_or_nan("duration_s")?;
    let (ras_deg, decs_deg) = (flags.numbers_or_nan("ra_deg")?, flags.numbers_or_nan("dec_deg")?);
    for (index, row) in schedule.exposures.iter().enumerate() {
        let Ok(exposure) = &row.exposure else { continue };
        let apart_deg = |degrees: f64, radians: f64| {
            let difference_deg = (degrees - radians.to_degrees()).rem_euclid(360.0);
            difference_deg.min(360.0 - difference_deg)
        };
        let apart_s = ((starts[index] - mjd_utc(exposure.start)) * 86_400.0).abs();
        let differences = [
            (apart_s, ROUNDING_S, "start", "s"),
            ((durations_s[index] - exposure.duration_s).abs(), ROUNDING_S, "length", "s"),
            (apart_deg(ras_deg[index], exposure.pointing.longitude_rad()), ROUNDING_DEG, "right ascension", "deg"),
            (apart_deg(decs_deg[index], exposure.pointing.latitude_rad()), ROUNDING_DEG, "declination", "deg"),
        ];
        // Columns that the table lacks are NaN.
        if let Some((apart, _, what, unit)) = differences.into_iter().find(|(apart, most, ..)| apart > most) {
            bail!(
                "the {what} of exposure {} in the flags differs by {apart:.3} {unit} from that in the schedule {}; allowed: the \
                 schedule of the flags, read with the same options",
                streakcast::message::Quoted::new(&row.id),
                path.display()
            );
        }
    }
    Ok(())
}

/// Returns a row of the table: `verdict` has the verdict, the numbers of streaks and of bright ones, and the magnitude.
fn row_of(
    row: &ScheduledExposure,
    [verdict, n_streaks, n_bright, brightest_mag]: [Value; 4],
    observer: Option<&Observer>,
    eop: &EopTable,
) -> Vec<Value> {
    let exposure = row.exposure.as_ref().ok();
    let middle = exposure.map(|exposure| mjd_utc(exposure.start) + exposure.duration_s / 2.0 / 86_400.0);
    vec![
        row.id.as_str().into(),
        exposure.map(|exposure| exposure.start).into(),
        exposure.map(|exposure| exposure.duration_s).into(),
        row.band.clone().into(),
        verdict,
        n_streaks,
        n_bright,
        brightest_mag,
        middle.zip(observer).map(|(middle, observer)| sun_altitude_deg(observer, eop, middle)).into(),
    ]
}

/// Nights of a table, named by the date of their evening, in a time zone if one is given. A night lasts from noon to
/// noon, in local mean time of the site, or in UTC if there is no site.
pub struct Nights {
    /// Night of each row; `None` if the row has no time.
    pub of_rows: Vec<Option<String>>,
}

impl Nights {
    pub fn from_columns(columns: &Columns, site: Option<&Site>, zone: Option<&LocalTime>) -> anyhow::Result<Self> {
        let longitude_rad = site.map_or(0.0, |site| site.longitude_rad);
        let date = |mjd: f64| {
            let mean_night = date_of(evening_mjd(Epoch::from_mjd_utc(mjd), longitude_rad));
            site.map_or_else(|| mean_night.clone(), |site| civil_date(&mean_night, site, zone))
        };
        let starts = columns.moments("start_utc")?;
        Ok(Self { of_rows: starts.iter().map(|start| start.is_finite().then(|| date(*start))).collect() })
    }

    pub fn all(&self) -> Vec<&str> {
        let mut all: Vec<&str> = self.of_rows.iter().flatten().map(String::as_str).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns the given night; the first night if none is given.
    pub fn choose(&self, night: Option<&str>) -> anyhow::Result<String> {
        let all = self.all();
        let allowed = || match all.as_slice() {
            [] => "none: no row has a time".to_owned(),
            [only] => (*only).to_owned(),
            [first, .., last] => format!("{first} to {last}, {} nights", all.len()),
        };
        match night {
            Some(night) if all.contains(&night) => Ok(night.to_owned()),
            Some(night) => Err(anyhow!("night {night} has no exposure of the schedule; allowed: {}", allowed())),
            None => all
                .first()
                .map(|night| (*night).to_owned())
                .ok_or_else(|| anyhow!("no row has a time; allowed: at least one valid exposure")),
        }
    }
}

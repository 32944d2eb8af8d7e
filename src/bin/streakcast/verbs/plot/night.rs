//! `plot night`: plots a timeline of a night with its streaked exposures.

use streakcast::config::{Config, FIELD, RequiredInput, SATELLITES, SITE};
use streakcast::geometry::Observer;
use streakcast::output::counted;
use streakcast::plot::{NightTimeline, Picture, night_timeline};

use super::arguments::PlotNightArguments;
use crate::failure::Outcome;
use crate::help::check;
use crate::start::begin;
use crate::verbs::map::site_of;

use super::clock::{Clock, sun_over};
use super::columns::{Columns, place_and_time};
use super::exposures::{Nights, compute, of_flags};
use super::target::{self, Target};

const SCHEDULE: RequiredInput = RequiredInput::new("schedule", &[&["--schedule FILE"], &["--from FILE"]]);

pub fn run(typed: PlotNightArguments) -> anyhow::Result<Outcome> {
    let flags = Config { rules: typed.rules.clone(), ..typed.config.clone() }.with_configuration_file()?;
    let config = flags.clone().with_home_file()?;
    if typed.from.is_none() {
        let answers = [target::picture(&typed.picture), (&SCHEDULE, typed.schedule.is_some())];
        check(&config, &[&SATELLITES, &SITE, &FIELD], &answers)?;
    }
    let notices = begin(&config)?;
    let target = match &typed.from {
        Some(_) if typed.schedule.is_none() => Target::of_table(&typed.picture)?,
        _ => Target::new(&typed.picture)?,
    };
    let (mut site, eop) = (site_of(&config)?, config.eop_table()?);
    let (columns, table) = match (&typed.from, &typed.schedule) {
        (Some(from), Some(schedule)) => {
            let flags = Columns::read(from, "flags")?;
            site = flags.site_with(&config, site);
            let observer = site.clone().map(Observer::new);
            let table = of_flags(&flags, schedule, &config, observer.as_ref(), &eop)?;
            (Columns::from_table(&table, &flags.provenance()), Some((table, flags.provenance())))
        }
        (Some(from), None) => {
            let columns = Columns::read(from, "exposures")?;
            site = columns.site_with(&config, site);
            (columns, None)
        }
        (None, Some(schedule)) => {
            let exposures = compute(&config, schedule, site.as_ref(), &eop)?;
            (
                Columns::from_table(&exposures.table, &exposures.provenance),
                Some((exposures.table, exposures.provenance)),
            )
        }
        (None, None) => return Err(SCHEDULE.missing().into()),
    };
    if site.is_none() {
        notices.warn(&["no site is given, and the table has none: twilight and local time are not drawn; specify --site, --mpc, or --lat and --lon"
            .to_owned()]);
    }
    let config = columns.time_zone_with(config);
    let zone = typed.zone.or_of(&config)?;
    let nights = Nights::from_columns(&columns, site.as_ref(), zone.as_ref())?;
    let clock = Clock::new(zone, site.as_ref());
    let night = nights.choose(typed.night.as_deref())?;
    let others = nights.all().len();
    if others > 1 && typed.night.is_none() {
        notices.info(&format!(
            "warning: the schedule has {others} nights; the first, {night}, is drawn; specify another with --night"
        ));
    }
    let keep: Vec<bool> = nights.of_rows.iter().map(|of| of.as_deref() == Some(&night)).collect();
    // The limit of a table has precedence over that of the home file.
    let given = if typed.from.is_some() { flags.policy()?.limit_mag } else { config.policy()?.limit_mag };
    let limit = match &given {
        Some(limit) => limit.limit_in(config.light.band.as_deref()),
        None => columns.limit_mag(),
    };
    let title = typed.title.title.clone().unwrap_or_else(|| format!("Night of {night}"));
    let timeline = Timeline {
        columns: &columns,
        keep: &keep,
        title: &title,
        limit,
        clock: clock.as_ref(),
        site: site.as_ref(),
        eop: &eop,
    };
    let picture = timeline.picture()?;
    match &table {
        Some((table, provenance)) => {
            let mut of_night = table.clone();
            let mut kept = keep.iter();
            of_night.rows.retain(|_| kept.next().copied().unwrap_or(false));
            target.write(&picture, "exposures", &of_night, provenance, &notices)?;
        }
        None => target.write_picture(&picture, &columns.provenance(), &notices)?,
    }
    Ok(Outcome::Done)
}

/// Data of a timeline.
struct Timeline<'a> {
    columns: &'a Columns,
    keep: &'a [bool],
    title: &'a str,
    limit: Option<f64>,
    clock: Option<&'a Clock>,
    site: Option<&'a streakcast::geometry::Site>,
    eop: &'a streakcast::frames::EopTable,
}

impl Timeline<'_> {
    fn picture(&self) -> anyhow::Result<Picture> {
        let (start_mjd, duration_s) = (self.columns.moments("start_utc")?, self.columns.numbers("duration_s")?);
        let (n_streaks, brightest_mag) = (self.columns.numbers("n_streaks")?, self.columns.numbers("brightest_mag")?);
        let verdicts = self.columns.texts("verdict")?;
        // An exposure that cannot be judged has no number of streaks.
        let is_judged = |verdict: &str| !matches!(verdict, "unknown" | "invalid");
        let is_drawn: Vec<bool> =
            verdicts.iter().zip(self.keep).map(|(verdict, keep)| *keep && is_judged(verdict)).collect();
        let kept = |column: Vec<f64>| -> Vec<f64> {
            column.into_iter().zip(&is_drawn).filter(|(_, keep)| **keep).map(|(value, _)| value).collect()
        };
        let (start_mjd, duration_s) = (kept(start_mjd), kept(duration_s));
        let (n_streaks, brightest_mag) = (kept(n_streaks), kept(brightest_mag));
        let first = start_mjd.iter().copied().fold(f64::INFINITY, f64::min);
        let last = start_mjd.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sun = self.site.map(|site| sun_over(site, self.eop, first, last)).unwrap_or_default();
        let invalid = match verdicts.iter().filter(|verdict| **verdict == "invalid").count() {
            0 => String::new(),
            1 => " 1 row of the schedule is invalid.".to_owned(),
            many => format!(" {many} rows of the schedule are invalid."),
        };
        let unknown = match verdicts.iter().filter(|verdict| **verdict == "unknown").count() {
            0 => String::new(),
            number => format!(" Unknown: {}.", counted(number, "exposure", "exposures")),
        };
        // The verdict also depends on the errors of magnitudes and positions.
        let avoid = verdicts.iter().zip(self.keep).filter(|(verdict, keep)| **keep && **verdict == "avoid").count();
        let avoid = match self.limit {
            Some(_) => format!("Verdict avoid: {}.", counted(avoid, "exposure", "exposures")),
            None => String::new(),
        };
        let caption = format!("{avoid}{unknown}{invalid}{}", self.columns.simulation_note());
        let ends = start_mjd.iter().zip(&duration_s).map(|(start, duration_s)| start + duration_s / 86_400.0);
        let observer = self.site.map(|site| site.name.clone()).or_else(|| self.columns.observer_name());
        let subtitle = place_and_time(observer, start_mjd.iter().copied().chain(ends));
        let drawn = night_timeline(&NightTimeline {
            title: self.title,
            caption: caption.trim_start(),
            start_mjd: &start_mjd,
            duration_s: &duration_s,
            n_streaks: &n_streaks,
            brightest_mag: &brightest_mag,
            limit_mag: self.limit,
            sun: &sun,
            local: self.clock.map(|clock| clock.at(first)),
        })?;
        Ok(drawn.with_subtitle(&subtitle))
    }
}

//! `plot sky-chart`: plots passes of a forecast over the sky of their site.

use serde_json::Value;
use streakcast::config::Config;
use streakcast::output::format_utc;
use streakcast::plot::{Picture, SkyChart, SkyTrack, sky_chart};

use super::arguments::PlotSkyChartArguments;
use crate::failure::Outcome;
use crate::verbs::judged::begin;

use super::clock::Clock;
use super::columns::Columns;
use super::curves::{Curve, SECTIONS, curves, shells_caption};
use super::target::Target;

pub fn run(typed: PlotSkyChartArguments) -> anyhow::Result<Outcome> {
    let notices = begin(&Config::default())?;
    let target = Target::of_table(&typed.picture)?;
    let columns = Columns::read_first(&typed.from, SECTIONS)?;
    let found = curves(&columns, &typed.norad)?;
    let clock = Clock::new(typed.utc_offset, None);
    target.write_picture(&picture(&columns, found, clock.as_ref(), typed.title.title.as_deref())?, &notices)?;
    Ok(Outcome::Done)
}

fn picture(
    columns: &Columns,
    found: Vec<Curve>,
    clock: Option<&Clock>,
    title: Option<&str>,
) -> anyhow::Result<Picture> {
    let tracks: Vec<SkyTrack> = found.into_iter().map(|curve| curve.track).collect();
    let site = columns.stated("site").and_then(|site| site.get("name")).and_then(Value::as_str);
    let over = site.filter(|name| *name != "site").map_or("a site".to_owned(), str::to_owned);
    let local = Clock::local(clock);
    let ahead_days = local.map_or(0.0, |clock| clock.ahead_of_utc_h / 24.0);
    let firsts = || tracks.iter().filter_map(|track| track.time_mjd.first()).map(|mjd| mjd + ahead_days);
    let begins = || firsts().filter(|mjd| mjd.is_finite());
    let day = |mjd: f64| format_utc(hifitime::Epoch::from_mjd_utc(mjd), 0).chars().take(10).collect::<String>();
    let date = match (begins().min_by(f64::total_cmp).map(day), begins().max_by(f64::total_cmp).map(day)) {
        (Some(first), Some(last)) if first != last => format!("{first} to {last}"),
        (first, _) => first.unwrap_or_default(),
    };
    let caption = columns.texts("name").map_or("", |names| shells_caption(&names));
    let one = tracks.first().filter(|_| tracks.len() == 1).map(|track| format!("{} over {over}, {date}", track.name));
    let default_title = one.unwrap_or_else(|| format!("Passes over {over}, {date}"));
    Ok(sky_chart(&SkyChart { title: title.unwrap_or(&default_title), caption, tracks: &tracks, local })?)
}

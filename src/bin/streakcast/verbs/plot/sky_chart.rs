//! `plot sky-chart`: passes of a forecast over the sky of their site.

use serde_json::Value;
use streakcast::plot::{Picture, SkyChart, SkyTrack, sky_chart};
use streakcast::setup::Setup;
use streakcast::table::format_utc;

use crate::failure::Outcome;
use crate::plot_arguments::PlotSkyChartArguments;
use crate::verbs::judged::begin;

use super::columns::Columns;
use super::curves::{Curve, SECTIONS, SYNTHETIC, curves};
use super::target::Target;

/// As many passes are drawn: the list beside has room for no more.
const MOST_PASSES: usize = 22;

pub fn run(typed: PlotSkyChartArguments) -> anyhow::Result<Outcome> {
    begin(&Setup::default())?;
    let target = Target::of_table(&typed.picture)?;
    let columns = Columns::read_first(&typed.from, SECTIONS)?;
    let found = curves(&columns, &typed.norad)?;
    target.write_picture(&picture(&columns, found, typed.title.title.as_deref())?)?;
    Ok(Outcome::Done)
}

fn picture(columns: &Columns, found: Vec<Curve>, title: Option<&str>) -> anyhow::Result<Picture> {
    let count = found.len();
    let tracks = brightest(found);
    let site = columns.stated("site").and_then(|site| site.get("name")).and_then(Value::as_str);
    let over = site.filter(|name| *name != "site").map_or("a site".to_owned(), str::to_owned);
    let begins = tracks.iter().filter_map(|track| track.time_mjd.first().copied()).fold(f64::INFINITY, f64::min);
    let date = if begins.is_finite() {
        format_utc(hifitime::Epoch::from_mjd_utc(begins), 0).chars().take(10).collect()
    } else {
        String::new()
    };
    let mut caption = "Zenith in the middle, horizon at the rim, north up, east left; grey where nothing is seen. Magnitudes in the list are the brightest of each pass.".to_owned();
    if tracks.len() < count {
        caption += &format!(" The {} brightest of {count} passes.", tracks.len());
    }
    if columns.texts("name").is_ok_and(|names| names.iter().any(|name| name.ends_with(SYNTHETIC))) {
        caption += " Satellites of shells are synthetic.";
    }
    let one = tracks.first().filter(|_| tracks.len() == 1).map(|track| format!("{} over {over}, {date}", track.name));
    let words = one.unwrap_or_else(|| format!("Passes over {over}, {date}"));
    Ok(sky_chart(&SkyChart { title: title.unwrap_or(&words), caption: &caption, tracks: &tracks })?)
}

/// The brightest passes in the order of the table.
fn brightest(found: Vec<Curve>) -> Vec<SkyTrack> {
    // Not a number sorts behind all numbers.
    let mut magnitudes: Vec<(usize, f64)> = found.iter().map(Curve::brightest).enumerate().collect();
    magnitudes.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut rows: Vec<usize> = magnitudes.into_iter().take(MOST_PASSES).map(|(row, _)| row).collect();
    rows.sort_unstable();
    let mut rows = rows.into_iter().peekable();
    let is_kept = |(row, curve): (usize, Curve)| rows.next_if_eq(&row).map(|_| curve.track);
    found.into_iter().enumerate().filter_map(is_kept).collect()
}

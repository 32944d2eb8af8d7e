//! `plot sky-chart`: plots passes of a forecast over the sky of their site, or one of them for printing.

use anyhow::anyhow;
use streakcast::plot::{FinderChart, Picture, SkyChart, SkyTrack, finder_chart, sky_chart};

use super::arguments::PlotSkyChartArguments;
use crate::failure::Outcome;
use crate::notices::Notices;

use super::clock::Clock;
use super::columns::Columns;
use super::curves::{Curve, SECTIONS, curves, shells_caption};
use super::target::Target;

pub fn run(typed: PlotSkyChartArguments) -> anyhow::Result<Outcome> {
    let notices = Notices::new(typed.quiet);
    let target = Target::of_table(&typed.picture)?;
    let columns = Columns::read_first(&typed.from, SECTIONS)?;
    let found = curves(&columns, &typed.norad)?;
    let clock = Clock::new(typed.zone.time_zone, None);
    let title = typed.title.title.as_deref();
    let drawn = match typed.finder {
        true => finder(&columns, found, clock.as_ref(), title)?,
        false => picture(&columns, found, clock.as_ref(), title)?,
    };
    target.write_picture(&drawn, &columns.provenance(), &notices)?;
    Ok(Outcome::Done)
}

fn picture(
    columns: &Columns,
    found: Vec<Curve>,
    clock: Option<&Clock>,
    title: Option<&str>,
) -> anyhow::Result<Picture> {
    let tracks: Vec<SkyTrack> = found.into_iter().map(|curve| curve.track).collect();
    let first_mjd = tracks.iter().filter_map(|track| track.time_mjd.first()).copied().reduce(f64::min);
    let local = clock.zip(first_mjd).map(|(clock, mjd)| clock.at(mjd));
    let subtitle = columns.place_and_time(tracks.iter().flat_map(|track| track.time_mjd.iter().copied()));
    let caption = columns.texts("name").map_or("", |names| shells_caption(&names));
    let title_of_one = tracks.first().filter(|_| tracks.len() == 1).map(|track| format!("Pass of {}", track.name));
    let default_title = title_of_one.unwrap_or_else(|| "Passes over the sky".to_owned());
    let site = columns.site();
    let title = title.unwrap_or(&default_title);
    let drawn = sky_chart(&SkyChart { title, caption, tracks: &tracks, local, site: site.as_ref() })?;
    Ok(drawn.with_subtitle(&subtitle))
}

/// Draws the brightest of the passes for printing.
fn finder(columns: &Columns, found: Vec<Curve>, clock: Option<&Clock>, title: Option<&str>) -> anyhow::Result<Picture> {
    // NaN is ordered after all numbers.
    let brightest = found.into_iter().min_by(|a, b| a.brightest().total_cmp(&b.brightest()));
    let Curve { is_synthetic, track, .. } =
        brightest.ok_or_else(|| anyhow!("table {} has no pass; allowed: one or more", columns.origin()))?;
    let local = clock.zip(track.time_mjd.first()).map(|(clock, mjd)| clock.at(*mjd));
    let subtitle = columns.place_and_time(track.time_mjd.iter().copied());
    let default_title = format!("Pass of {}", track.name);
    let drawn = finder_chart(&FinderChart {
        title: title.unwrap_or(&default_title),
        caption: if is_synthetic { "The satellite is simulated." } else { "" },
        track: &track,
        local,
        site: columns.site().as_ref(),
    })?;
    Ok(drawn.with_subtitle(&subtitle))
}

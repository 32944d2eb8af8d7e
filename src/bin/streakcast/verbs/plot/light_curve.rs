//! `plot light-curve`: plots the magnitude of one satellite along its track, in the field and before and after it.

use anyhow::{anyhow, bail};
use serde_json::json;
use streakcast::config::Config;
use streakcast::config::parse_duration_s;
use streakcast::elements::NoradId;
use streakcast::frames::{mjd_utc, parse_start, seconds_after};
use streakcast::output::{Column, Kind, Table, Value, format_utc};
use streakcast::passes::{Exposure, Field, Pass, PassOptions, TrackPoint};
use streakcast::plot::{LightCurve, Picture, light_curve};

use super::arguments::PlotLightCurveArguments;
use crate::failure::Outcome;
use crate::help::{VerbFlags, check};
use crate::start::begin;
use crate::verbs::map::site_of;
use crate::verbs::passes::{PassesArguments, Prediction, predict};

use super::clock::Clock;
use super::columns::Columns;
use super::curves::{Curve, SECTIONS, SYNTHETIC, curves, shells_caption};
use super::target::{self, Target};

/// Number of points along a track.
const POINTS: usize = 400;
/// Longest time before entry and after exit, seconds.
const MAX_AROUND_S: f64 = 600.0;
const DAY_S: f64 = 86_400.0;
/// Time by which --start may be before a pass or after it, seconds: tables for the terminal are rounded.
const START_TOLERANCE_S: f64 = 60.0;

const COLUMNS: [Column; 11] = [
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::time("utc", "Time at which the light reaches the observer."),
    Column::real("ra_deg", "deg", 7, "Right ascension, ICRS astrometric topocentric."),
    Column::real("dec_deg", "deg", 7, "Declination."),
    Column::real("altitude_deg", "deg", 4, "Altitude without refraction."),
    Column::real("azimuth_deg", "deg", 4, "Azimuth from north through east."),
    Column::real("range_km", "km", 3, "Distance from the observer."),
    Column::real("magnitude", "mag", 3, "Apparent magnitude; empty if the satellite is not visible."),
    Column::real("magnitude_sigma", "mag", 3, "One sigma of the magnitude."),
    Column::new(
        "in_fitted_range",
        Kind::Boolean,
        "False if the geometry is more than 10 deg from the geometries to which the model was fitted.",
    ),
    Column::new("in_field", Kind::Boolean, "True if the satellite is inside the field while the shutter is open."),
];

pub fn run(mut typed: PlotLightCurveArguments) -> anyhow::Result<Outcome> {
    let config = Config { exposure: typed.exposure.clone(), ..typed.config.clone() }.with_file()?;
    let site = site_of(&config)?;
    let title = typed.title.title.as_deref();
    if let Some(path) = &typed.from {
        let notices = begin(&config)?;
        let target = Target::of_table(&typed.picture)?;
        let columns = Columns::read_first(path, &[&["track"], SECTIONS].concat())?;
        let scale = config.time_scale()?;
        let site = columns.site_with(&config, site);
        let clock = Clock::new(typed.zone.or_of(&columns.time_zone_with(config))?, site.as_ref());
        let picture = if columns.has("in_field") {
            let given = typed.norad.map(|id| format!("--norad {id}"));
            let given = given.or(typed.exposure.start.as_ref().map(|start| format!("--start {}", start.as_str())));
            if let Some(given) = given {
                bail!(
                    "{given} is given for table {}, which has only one pass; allowed: the command without it",
                    path.display()
                );
            }
            picture(&columns, typed.limit_mag, clock.as_ref(), title)?
        } else {
            let start = typed.exposure.start.as_ref().map(|start| parse_start(start.as_str(), scale)).transpose()?;
            let (curve, remark) = curve_of_forecast(&columns, typed.norad, start.map(mjd_utc))?;
            remark.iter().for_each(|remark| notices.info(remark));
            of_forecast(&columns, curve, typed.limit_mag, clock.as_ref(), title)?
        };
        target.write_picture(&picture, &columns.provenance(), &notices)?;
        return Ok(Outcome::Done);
    }
    let clock = Clock::new(typed.zone.or_of(&config)?, site.as_ref());
    check(&config, PassesArguments::HELP.asks, &[target::picture(&typed.picture)])?;
    typed.limit_mag = typed.limit_mag.or(config.limit_mag()?);
    let target = Target::new(&typed.picture)?;
    let around_s = parse_duration_s("around", &typed.around)?;
    if around_s > MAX_AROUND_S {
        bail!("around is {}; allowed: at most 10min", typed.around);
    }
    let mut prediction = predict(&config)?;
    let pass = chosen(&prediction, typed.norad)?;
    let track = track(&prediction, &pass, around_s)?;
    let name = prediction.prepared.sky.elements()[pass.element_index].name.clone();
    let opening = mjd_utc(prediction.exposure.start);
    let is_in = |point: &TrackPoint| {
        let seconds = (mjd_utc(point.epoch) - opening) * DAY_S;
        pass.chords.iter().any(|chord| (chord.enter_s - 1e-3..=chord.exit_s + 1e-3).contains(&seconds))
    };
    let row = |point: &TrackPoint| -> Vec<Value> {
        let brightness = point.brightness.as_ref();
        vec![
            i64::from(pass.norad_id.0).into(),
            point.epoch.into(),
            point.direction.longitude_rad().to_degrees().into(),
            point.direction.latitude_rad().to_degrees().into(),
            point.altitude_rad.map(f64::to_degrees).into(),
            point.azimuth_rad.map(f64::to_degrees).into(),
            point.range_km.into(),
            brightness.map(|brightness| brightness.magnitude.0).into(),
            brightness.map(|brightness| brightness.sigma_mag).into(),
            brightness.map(|brightness| brightness.in_fitted_range).into(),
            is_in(point).into(),
        ]
    };
    let table = Table { columns: COLUMNS.to_vec(), rows: track.iter().map(row).collect() };
    let moments = |seconds: f64| format_utc(seconds_after(prediction.exposure.start, seconds), 6);
    let chords: Vec<[String; 2]> =
        pass.chords.iter().map(|chord| [moments(chord.enter_s), moments(chord.exit_s)]).collect();
    let shutter = [moments(0.0), moments(prediction.exposure.duration_s)];
    prediction.prepared.provenance.state(
        "track",
        json!({ "name": &*name, "in_field_utc": chords, "shutter_utc": shutter, "limit_mag": typed.limit_mag }),
    );
    let columns = Columns::from_table(&table, &prediction.prepared.provenance);
    let picture = picture(&columns, typed.limit_mag, clock.as_ref(), title)?;
    target.write(&picture, "track", &table, &prediction.prepared.provenance, &prediction.notices)?;
    Ok(Outcome::Done)
}

/// Returns the pass of the given satellite; the brightest pass if none is given.
fn chosen(prediction: &Prediction, norad: Option<u32>) -> anyhow::Result<Pass> {
    // Near misses are excluded, because they do not enter the field.
    let found: Vec<&Pass> = prediction.found().iter().filter(|pass| pass.is_crossing()).collect();
    if let Some(id) = norad {
        let pass = found.iter().find(|pass| pass.norad_id == NoradId(id));
        let ids: Vec<String> = found.iter().map(|pass| pass.norad_id.0.to_string()).collect();
        let allowed = if ids.is_empty() { "none, the field is clear".to_owned() } else { ids.join(", ") };
        return pass
            .copied()
            .cloned()
            .ok_or_else(|| anyhow!("norad {id} does not cross this exposure; allowed: {allowed}"));
    }
    let magnitude = |pass: &Pass| pass.peak.as_ref()?.brightness.as_ref().map(|brightness| brightness.magnitude.0);
    let bright = found.into_iter().filter_map(|pass| Some((magnitude(pass)?, pass)));
    let brightest = bright.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, pass)| pass.clone());
    brightest.ok_or_else(|| anyhow!("no visible satellite crosses this exposure; allowed: an exposure with a crossing"))
}

/// Returns points above the horizon from `around_s` before the first entry to `around_s` after the last exit.
fn track(prediction: &Prediction, pass: &Pass, around_s: f64) -> anyhow::Result<Vec<TrackPoint>> {
    let (first_s, last_s) = pass.chords.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), chord| {
        (low.min(chord.enter_s), high.max(chord.exit_s))
    });
    let start = seconds_after(prediction.exposure.start, first_s - around_s);
    let duration_s = last_s - first_s + 2.0 * around_s;
    // Circular field that contains the whole track. The angular rate may be higher at higher altitude, so the radius is
    // increased by half.
    let radius_rad = (1.5 * pass.angular_rate_rad_s * duration_s + 0.1).min(std::f64::consts::FRAC_PI_2);
    let exposure = Exposure { start, duration_s, pointing: pass.mid.direction, ..prediction.exposure.clone() };
    let options = PassOptions { include_dark: true, min_probability: None, samples: POINTS, ..prediction.options };
    let wide = Field::circle(2.0 * radius_rad)?;
    let crossings = prediction.prepared.sky.field_passes(&[exposure], &wide, &options)?;
    let tracks = crossings.by_exposure.into_iter().flatten();
    let found = tracks.filter(|found| found.element_index == pass.element_index && found.samples.len() > 1);
    let holds = |found: &Pass| {
        found.samples[0].epoch <= pass.mid.epoch && pass.mid.epoch <= found.samples[found.samples.len() - 1].epoch
    };
    found.into_iter().find(holds).map(|found| found.samples).ok_or_else(|| {
        anyhow!("the track of norad {} in the field is too short to draw; allowed: a longer --around", pass.norad_id.0)
    })
}

/// Returns the pass of a forecast of the given satellite at a time (MJD, UTC), or else the brightest one, and a remark
/// if there are others.
fn curve_of_forecast(
    columns: &Columns,
    norad: Option<u32>,
    start_mjd: Option<f64>,
) -> anyhow::Result<(Curve, Option<String>)> {
    let all = curves(columns, norad.as_slice())?;
    let of_satellites = all.len();
    let ends = |curve: &Curve| (curve.track.time_mjd.first().copied(), curve.track.time_mjd.last().copied());
    let is_at = |curve: &Curve, mjd: f64| match ends(curve) {
        (Some(first), Some(last)) => {
            (first - START_TOLERANCE_S / DAY_S..=last + START_TOLERANCE_S / DAY_S).contains(&mjd)
        }
        _ => false,
    };
    let text = |mjd: Option<f64>| {
        mjd.map(|mjd| format_utc(hifitime::Epoch::from_mjd_utc(mjd), 0)).unwrap_or_else(|| "an unknown time".to_owned())
    };
    let starts: Vec<String> = all.iter().take(10).map(|curve| text(ends(curve).0)).collect();
    let found = all.into_iter().filter(|curve| start_mjd.is_none_or(|mjd| is_at(curve, mjd)));
    // NaN is ordered after all numbers.
    let brightest = found.min_by(|a, b| a.brightest().total_cmp(&b.brightest()));
    let curve = brightest.ok_or_else(|| match start_mjd {
        Some(mjd) => anyhow!(
            "no pass of table {} at {}; allowed: a time in a pass, for example one of the starts {}",
            columns.origin(),
            text(Some(mjd)),
            starts.join(", ")
        ),
        None => anyhow!("table {} has no pass; allowed: one or more", columns.origin()),
    })?;
    let remark = (start_mjd.is_none() && of_satellites > 1).then(|| {
        format!(
            "the table has {of_satellites} such passes; the brightest is drawn, {} at {}; --norad ID and --start TIME \
             select another one",
            curve.track.name,
            text(ends(&curve).0)
        )
    });
    Ok((curve, remark))
}

/// Plots one pass of a forecast from rise to set.
fn of_forecast(
    columns: &Columns,
    curve: Curve,
    limit_mag: Option<f64>,
    clock: Option<&Clock>,
    title: Option<&str>,
) -> anyhow::Result<Picture> {
    let Curve { norad_id, is_synthetic, range_km: [from_km, to_km], in_fitted_range, track } = curve;
    let highest = track.altitude_deg.iter().copied().fold(f64::NAN, f64::max);
    let synthetic = if is_synthetic { SYNTHETIC } else { "" };
    let name = format!("{}{synthetic}", track.name);
    let caption = format!(
        "The whole pass, up to {highest:.0}° high: range {from_km:.0} km at the start, {to_km:.0} km at the end. {}",
        shells_caption(&[&name])
    );
    let number = format!("NORAD {norad_id}");
    let satellite = if track.name == number { number } else { format!("{name} ({number})") };
    let subtitle = columns.place_and_time(track.time_mjd.iter().copied());
    let drawn = light_curve(&LightCurve {
        title: title.unwrap_or(&format!("Light curve of {satellite}")),
        caption: caption.trim_end(),
        time_mjd: &track.time_mjd,
        magnitude: &track.magnitude,
        sigma_mag: &track.sigma_mag,
        in_fitted_range: &in_fitted_range,
        in_field: &[],
        shutter: None,
        limit_mag,
        local: clock.zip(track.time_mjd.first()).map(|(clock, mjd)| clock.at(*mjd)),
    })?;
    Ok(drawn.with_subtitle(&subtitle))
}

fn picture(
    columns: &Columns,
    limit_mag: Option<f64>,
    clock: Option<&Clock>,
    title: Option<&str>,
) -> anyhow::Result<Picture> {
    let time_mjd = columns.moments("utc")?;
    let (magnitude, sigma_mag) = (columns.numbers("magnitude")?, columns.numbers("magnitude_sigma")?);
    let stated = columns.stated("track").cloned().unwrap_or_default();
    let span = |value: &serde_json::Value| -> Option<[f64; 2]> {
        let moment = |index: usize| {
            let text = value.get(index)?.as_str()?;
            streakcast::frames::parse_moment(text, None).ok().map(mjd_utc)
        };
        Some([moment(0)?, moment(1)?])
    };
    let in_field: Vec<[f64; 2]> =
        stated.get("in_field_utc").and_then(|spans| spans.as_array()).into_iter().flatten().filter_map(span).collect();
    let ids = columns.texts("norad_id")?;
    let name = stated.get("name").and_then(|name| name.as_str()).unwrap_or_default().to_owned();
    let satellite = format!("{name} (NORAD {})", ids.first().copied().unwrap_or_default());
    let altitudes = columns.numbers("altitude_deg")?;
    let ranges = columns.numbers("range_km")?;
    let ends =
        |values: &[f64]| (values.first().copied().unwrap_or(f64::NAN), values.last().copied().unwrap_or(f64::NAN));
    let ((a0, a1), (r0, r1)) = (ends(&altitudes), ends(&ranges));
    let mut caption = format!("From left to right: range {r0:.0} to {r1:.0} km");
    if a0.is_finite() && a1.is_finite() {
        caption += &format!(", altitude {a0:.0}° to {a1:.0}°");
    }
    if let [[enter, exit], ..] = in_field.as_slice() {
        let seconds: f64 = in_field.iter().map(|[enter, exit]| (exit - enter) * DAY_S).sum();
        let at = |mjd: f64| {
            let text = format_utc(hifitime::Epoch::from_mjd_utc(mjd), 2);
            text.split('T').nth(1).unwrap_or_default().trim_end_matches('Z').to_owned()
        };
        let last = in_field.last().map_or(*exit, |[_, exit]| *exit);
        caption += &format!("; in the field from {} to {} UTC, {seconds:.2} s", at(*enter), at(last));
    }
    let subtitle = columns.place_and_time(time_mjd.iter().copied());
    let drawn = light_curve(&LightCurve {
        title: title.unwrap_or(&format!("Light curve of {}", satellite.trim_start())),
        caption: format!("{caption}. {}", shells_caption(&[&name])).trim_end(),
        time_mjd: &time_mjd,
        magnitude: &magnitude,
        sigma_mag: &sigma_mag,
        in_fitted_range: &columns.fitted()?,
        in_field: &in_field,
        shutter: stated.get("shutter_utc").and_then(span),
        limit_mag: limit_mag.or_else(|| stated.get("limit_mag")?.as_f64()),
        local: clock.zip(time_mjd.first()).map(|(clock, mjd)| clock.at(*mjd)),
    })?;
    Ok(drawn.with_subtitle(&subtitle))
}

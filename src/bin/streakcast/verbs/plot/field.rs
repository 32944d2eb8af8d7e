//! `plot field`: plots a field with the streaks that cross it.

use anyhow::{anyhow, bail};
use serde_json::Value;
use streakcast::config::{Config, NameOrTable, Quantity};
use streakcast::frames::{Direction, Gcrs, mjd_utc, parse_moment};
use streakcast::output::counted;
use streakcast::passes::Field;
use streakcast::plot::{FARTHEST_FIELD_DEG, FieldChart, FieldStreak, Picture, field_chart};

use super::arguments::PlotFieldArguments;
use crate::failure::Outcome;
use crate::help::{VerbFlags, check};
use crate::start::begin;
use crate::verbs::passes::{PassesArguments, predict};

use super::columns::Columns;
use super::curves::{SYNTHETIC, shells_caption};
use super::target::{self, Target};

/// Number of points of the outline of a circle.
const CIRCLE_POINTS: usize = 180;

pub fn run(typed: PlotFieldArguments) -> anyhow::Result<Outcome> {
    let include_dark = typed.include_dark;
    let mut flags = Config { exposure: typed.exposure, include_dark, ..typed.config };
    if typed.from.is_some() {
        // The field of the table has precedence over that of the home file.
        flags.home.file = None;
    }
    let config = flags.with_file()?;
    let title = typed.title.title.as_deref();
    let limit_mag = typed.limit_mag;
    if let Some(path) = &typed.from {
        let notices = begin(&config)?;
        let target = Target::of_table(&typed.picture)?;
        let columns = Columns::read(path, "passes")?;
        let exposure = Pointing::stated(&columns).ok_or_else(|| {
            anyhow!("table {} does not state its exposure; allowed: output of passes", path.display())
        })?;
        let field = stated_field(&config, &columns)?;
        field.as_ref().map_or(Ok(()), check_size)?;
        target.write_picture(
            &picture(&columns, &exposure, field.as_ref(), title, limit_mag)?,
            &columns.provenance(),
            &notices,
        )?;
        return Ok(outcome(&columns));
    }
    check(&config, PassesArguments::HELP.asks, &[target::picture(&typed.picture)])?;
    let target = Target::new(&typed.picture)?;
    let field = config.field_of_view()?;
    check_size(&field)?;
    let prediction = predict(&config)?;
    let table = prediction.table(false);
    let columns = Columns::from_table(&table, &prediction.prepared.provenance);
    // The exposure is read from the provenance of the table, so that a file of the table gives the same picture.
    let exposure = Pointing::stated(&columns).ok_or_else(|| anyhow!("the result does not state its exposure"))?;
    let picture = picture(&columns, &exposure, Some(&field), title, limit_mag)?;
    target.write(&picture, "passes", &table, &prediction.prepared.provenance, &prediction.notices)?;
    Ok(outcome(&columns))
}

/// Returns exit code 1 if there are no crossings, as `passes` does, although the picture is written.
fn outcome(columns: &Columns) -> Outcome {
    if columns.is_empty() { Outcome::No } else { Outcome::Done }
}

/// # Errors
/// The field extends beyond the projection of the chart.
fn check_size(field: &Field) -> anyhow::Result<()> {
    let radius_deg = field.bounding_radius_rad().to_degrees();
    // A rim at exactly this distance may be beyond it by rounding.
    if radius_deg > FARTHEST_FIELD_DEG - 1e-9 {
        bail!(
            "the field is too large for the chart, it extends to {radius_deg:.1} deg from its centre; allowed: below \
             {FARTHEST_FIELD_DEG} deg (a diameter below {} deg)",
            2.0 * FARTHEST_FIELD_DEG
        );
    }
    Ok(())
}

/// Pointing and time of an exposure.
struct Pointing {
    centre: Direction<Gcrs>,
    rotation_rad: f64,
    start_utc: String,
    exposure_s: f64,
}

impl Pointing {
    /// Reads pointing and time from the provenance of a table of passes.
    fn stated(columns: &Columns) -> Option<Self> {
        let options = columns.stated("options")?;
        let number = |name: &str| options.get(name).and_then(Value::as_f64);
        Some(Self {
            centre: Direction::from_lon_lat_rad(number("ra_deg")?.to_radians(), number("dec_deg")?.to_radians()),
            rotation_rad: number("rotation_deg").unwrap_or(0.0).to_radians(),
            start_utc: options.get("start_utc")?.as_str()?.to_owned(),
            exposure_s: number("exposure_s")?,
        })
    }
}

/// Returns the given field, or else that in the provenance of the table; `None` for the field of a telescope, which the
/// provenance does not contain.
fn stated_field(config: &Config, columns: &Columns) -> anyhow::Result<Option<Field>> {
    if config.fov.is_some() || config.field.is_some() || config.telescope.is_some() {
        return Ok(Some(config.field_of_view()?));
    }
    let field = columns.stated("options").and_then(|options| options.get("field"));
    let text = |name: &str| field.and_then(|field| field.get(name)).and_then(Value::as_str).map(str::to_owned);
    let config = match (text("circle").or(text("rectangle")), text("file")) {
        (Some(size), _) => Config { fov: Some(Quantity(size)), ..Config::default() },
        (None, Some(file)) => Config { field: Some(NameOrTable::Name(file.into())), ..Config::default() },
        (None, None) => return Ok(None),
    };
    Ok(Some(config.field_of_view()?))
}

fn picture(
    columns: &Columns,
    pointing: &Pointing,
    field: Option<&Field>,
    title: Option<&str>,
    limit_mag: Option<f64>,
) -> anyhow::Result<Picture> {
    let names = columns.texts("name")?;
    let ids = columns.texts("norad_id")?;
    let (enter, exit) = (columns.moments("enter_utc")?, columns.moments("exit_utc")?);
    let peak = columns.numbers("magnitude_peak")?;
    let sigma = columns.numbers("magnitude_peak_sigma")?;
    let ends = ["enter", "mid", "exit"].map(|end| {
        let of = |axis: &str| columns.numbers(&format!("{end}_{axis}_deg"));
        Ok::<_, anyhow::Error>((of("ra")?, of("dec")?))
    });
    let ends = ends.into_iter().collect::<anyhow::Result<Vec<_>>>()?;
    let streak = |k: usize| FieldStreak {
        name: if names[k].is_empty() {
            format!("NORAD {}", ids[k])
        } else {
            names[k].trim_end_matches(SYNTHETIC).to_owned()
        },
        track_deg: ends.iter().map(|(ra, dec)| [ra[k], dec[k]]).collect(),
        enter_mjd: enter[k],
        exit_mjd: exit[k],
        magnitude: peak[k],
        sigma_mag: sigma[k],
    };
    let is_shown = |k: &usize| limit_mag.is_none_or(|limit_mag| peak[*k] <= limit_mag);
    let streaks: Vec<FieldStreak> = (0..columns.len()).filter(is_shown).map(streak).collect();
    let omitted = columns.len() - streaks.len();
    let remark = limit_mag
        .filter(|_| omitted > 0)
        .map(|limit_mag| format!("{} fainter than mag {limit_mag} not drawn", counted(omitted, "streak", "streaks")));
    let degrees =
        |direction: &Direction<Gcrs>| [direction.longitude_rad().to_degrees(), direction.latitude_rad().to_degrees()];
    let outlines = field
        .map(|field| field.on_sky(&pointing.centre, pointing.rotation_rad).outlines(CIRCLE_POINTS))
        .unwrap_or_default();
    let outlines: Vec<Vec<[f64; 2]>> = outlines.iter().map(|outline| outline.iter().map(degrees).collect()).collect();
    let [ra_deg, dec_deg] = degrees(&pointing.centre);
    let start = parse_moment(&pointing.start_utc, None).map_or(f64::NAN, mjd_utc);
    let subtitle = columns.place_and_time([start, start + pointing.exposure_s / 86_400.0]);
    let drawn = field_chart(&FieldChart {
        title: title.unwrap_or(&format!("Streaks in the field, exposure of {} s", pointing.exposure_s)),
        caption: shells_caption(&names),
        ra_deg,
        dec_deg,
        outlines: &outlines,
        streaks: &streaks,
    })?;
    Ok(drawn.with_subtitle(&[Some(subtitle), remark].into_iter().flatten().collect::<Vec<_>>().join("; ")))
}

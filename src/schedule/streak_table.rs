//! Passes as a table: one row for each exposure and satellite.

use crate::elements::ElementSet;
use crate::images::{Telescope, effective_magnitude, surface_brightness_mag_arcsec2};
use crate::output::{Column, Kind, Table, Value};
use crate::passes::{Exposure, FieldPass, TrackPoint};
use crate::photometry::{Brightness, PhotometryOptions};

/// A pass with all that its row says.
#[derive(Copy, Clone)]
pub struct StreakRow<'a> {
    /// The exposure it crosses.
    pub exposure: &'a Exposure,
    /// The pass.
    pub pass: &'a FieldPass,
    /// Its element set: name and designator.
    pub elements: &'a ElementSet,
    /// Largest extent of the satellite, metres.
    pub satellite_size_m: f64,
    /// The telescope, where one is known; without it width, surface brightness and effective magnitude are empty.
    pub telescope: Option<&'a Telescope>,
    /// Band and system of the magnitudes.
    pub photometry: &'a PhotometryOptions,
}

/// One column and how its cell comes from a row.
struct Field {
    column: Column,
    value: fn(&StreakRow<'_>) -> Value,
}

const fn field(column: Column, value: fn(&StreakRow<'_>) -> Value) -> Field {
    Field { column, value }
}

const CHORDS: &[Column] = &[
    Column::time("enter_utc", "Entry into one stretch of the field."),
    Column::time("exit_utc", "Exit from it."),
    Column::real("enter_s", "s", 3, "Entry after shutter opening."),
    Column::real("exit_s", "s", 3, "Exit after shutter opening."),
];

const SAMPLES: &[Column] = &[
    Column::time("utc", "Moment of reception."),
    Column::real("ra_deg", "deg", 7, "Right ascension, ICRS astrometric topocentric."),
    Column::real("dec_deg", "deg", 7, "Declination."),
    Column::real("altitude_deg", "deg", 4, "Altitude without refraction."),
    Column::real("azimuth_deg", "deg", 4, "Azimuth from north through east."),
    Column::real("range_km", "km", 3, "Distance from the observer."),
    Column::real("magnitude", "mag", 3, "Apparent magnitude."),
    Column::real("magnitude_sigma", "mag", 3, "One sigma of it."),
];

static FIELDS: &[Field] = &[
    field(Column::new("exposure_id", Kind::Text, "The schedule's name of the exposure."), |row| {
        row.exposure.id.as_str().into()
    }),
    field(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |row| {
        i64::from(row.pass.norad_id.0).into()
    }),
    field(Column::new("name", Kind::Text, "Name in the element set."), |row| text(&row.elements.name)),
    field(Column::new("international_designator", Kind::Text, "COSPAR designator."), |row| {
        text(&row.elements.international_designator)
    }),
    field(Column::time("enter_utc", "Entry into the field, or shutter opening."), |row| row.pass.enter.epoch.into()),
    field(Column::time("mid_utc", "Half way in time between entry and exit."), |row| row.pass.mid.epoch.into()),
    field(Column::time("exit_utc", "Exit from the field, or shutter closing."), |row| row.pass.exit.epoch.into()),
    field(Column::real("enter_ra_deg", "deg", 7, "Right ascension at entry, ICRS astrometric topocentric."), |row| {
        ra_deg(&row.pass.enter)
    }),
    field(Column::real("enter_dec_deg", "deg", 7, "Declination at entry."), |row| dec_deg(&row.pass.enter)),
    field(Column::real("mid_ra_deg", "deg", 7, "Right ascension at mid."), |row| ra_deg(&row.pass.mid)),
    field(Column::real("mid_dec_deg", "deg", 7, "Declination at mid."), |row| dec_deg(&row.pass.mid)),
    field(Column::real("exit_ra_deg", "deg", 7, "Right ascension at exit."), |row| ra_deg(&row.pass.exit)),
    field(Column::real("exit_dec_deg", "deg", 7, "Declination at exit."), |row| dec_deg(&row.pass.exit)),
    field(Column::real("min_separation_deg", "deg", 6, "Least angle between track and field centre."), |row| {
        row.pass.min_separation_rad.to_degrees().into()
    }),
    field(Column::real("streak_length_deg", "deg", 6, "Length of the streak inside the field."), |row| {
        row.pass.streak_length_rad.to_degrees().into()
    }),
    field(
        Column::real("position_angle_deg", "deg", 4, "Direction of motion at mid, from north through east."),
        |row| row.pass.position_angle_rad.to_degrees().into(),
    ),
    field(Column::real("angular_rate_deg_s", "deg / s", 6, "Speed on the sky at mid."), |row| {
        row.pass.angular_rate_rad_s.to_degrees().into()
    }),
    field(Column::real("altitude_deg", "deg", 4, "Altitude at mid, without refraction."), |row| {
        degrees(row.pass.mid.altitude_rad)
    }),
    field(Column::real("azimuth_deg", "deg", 4, "Azimuth at mid, from north through east."), |row| {
        degrees(row.pass.mid.azimuth_rad)
    }),
    field(Column::real("range_km", "km", 3, "Distance from the observer at mid."), |row| row.pass.mid.range_km.into()),
    field(Column::real("height_km", "km", 3, "Distance from the Earth's centre at mid less 6378.137 km."), |row| {
        row.pass.mid.geometry.height_km.into()
    }),
    field(Column::real("phase_angle_deg", "deg", 4, "Sun-satellite-observer angle at mid."), |row| {
        row.pass.mid.geometry.phase_angle_rad().to_degrees().into()
    }),
    field(Column::new("illumination", Kind::Text, "sunlit, penumbra or umbra, at mid."), |row| {
        row.pass.mid.illumination.name().into()
    }),
    field(Column::real("lit_fraction", "", 4, "Share of the Sun's disk that the satellite sees at mid."), |row| {
        row.pass.mid.illumination.lit_fraction().into()
    }),
    field(
        Column::real("magnitude", "mag", 3, "Apparent magnitude at mid, steady; empty where nothing is seen."),
        |row| magnitude(&row.pass.mid),
    ),
    field(Column::real("magnitude_sigma", "mag", 3, "One sigma of the magnitude."), |row| sigma(&row.pass.mid)),
    field(Column::real("magnitude_peak", "mag", 3, "Brightest magnitude along the track."), |row| {
        row.pass.peak.as_ref().map_or(Value::Null, magnitude)
    }),
    field(Column::new("band", Kind::Text, "Passband of the magnitudes."), |row| row.photometry.band.name().into()),
    field(Column::new("mag_system", Kind::Text, "Zero point of the magnitudes."), |row| {
        row.photometry.system.to_string().into()
    }),
    field(Column::new("mag_source", Kind::Text, "What the magnitude rests on."), |row| {
        shown(row).map(|brightness| brightness.source.to_string()).into()
    }),
    field(
        Column::real(
            "effective_magnitude",
            "mag",
            3,
            "Magnitude of a star as bright per area as the streak, same exposure.",
        ),
        |row| streak(row).map(|streak| streak.effective_magnitude).into(),
    ),
    field(
        Column::real(
            "surface_brightness_mag_arcsec2",
            "mag / arcsec2",
            3,
            "Surface brightness of the streak, averaged over the exposure.",
        ),
        |row| streak(row).map(|streak| streak.surface_brightness).into(),
    ),
    field(Column::real("width_arcsec", "arcsec", 3, "Width of the streak: seeing, defocus and size."), |row| {
        row.telescope.map(|telescope| width_arcsec(row, telescope)).into()
    }),
    field(
        Column::real(
            "element_age_days",
            "d",
            4,
            "Exposure less epoch of the elements; positive where the exposure is later.",
        ),
        |row| row.pass.element_age_days.into(),
    ),
    field(Column::real("along_track_sigma_s", "s", 4, "One-sigma error along the track as time."), |row| {
        row.pass.along_track_sigma_s.into()
    }),
    field(
        Column::real("cross_track_sigma_deg", "deg", 6, "One-sigma error across the track as seen from the site."),
        |row| row.pass.cross_track_sigma_rad.to_degrees().into(),
    ),
    field(Column::real("probability", "", 4, "Probability that the satellite crosses, given those errors."), |row| {
        row.pass.probability.into()
    }),
];

/// Columns that only formats with tables inside tables carry by default: scripts count on the others' columns.
static NESTED: &[Field] = &[
    field(
        Column::new(
            "in_fitted_range",
            Kind::Boolean,
            "False where the model is asked beyond the geometry it rests on, and the sigma is wide; empty without a magnitude.",
        ),
        |row| shown(row).map(|brightness| Value::Boolean(brightness.in_fitted_range)).unwrap_or(Value::Null),
    ),
    field(Column::new("chords", Kind::Rows(CHORDS), "Stretches of the track inside the field."), |row| {
        let opening = row.exposure.start;
        let chord = |chord: &crate::passes::Chord| {
            let moment = |seconds| crate::frames::seconds_after(opening, seconds).into();
            vec![moment(chord.enter_s), moment(chord.exit_s), chord.enter_s.into(), chord.exit_s.into()]
        };
        Value::Rows(row.pass.chords.iter().map(chord).collect())
    }),
];

static SAMPLED: &[Field] = &[field(Column::new("samples", Kind::Rows(SAMPLES), "Points along the track."), |row| {
    let sample = |point: &TrackPoint| {
        vec![
            point.epoch.into(),
            ra_deg(point),
            dec_deg(point),
            degrees(point.altitude_rad),
            degrees(point.azimuth_rad),
            point.range_km.into(),
            magnitude(point),
            sigma(point),
        ]
    };
    Value::Rows(row.pass.samples.iter().map(sample).collect())
})];

/// The passes as a table, in their order.
///
/// `chords` adds the stretches inside the field, `samples` the points along the track where any were asked for.
pub fn streak_table<'a>(rows: impl IntoIterator<Item = StreakRow<'a>>, chords: bool, samples: bool) -> Table {
    let nested = if chords { NESTED } else { &[] };
    let sampled = if samples { SAMPLED } else { &[] };
    let fields: Vec<&Field> = FIELDS.iter().chain(nested).chain(sampled).collect();
    Table {
        columns: fields.iter().map(|field| field.column).collect(),
        rows: rows.into_iter().map(|row| fields.iter().map(|field| (field.value)(&row)).collect()).collect(),
    }
}

struct Streak {
    effective_magnitude: f64,
    surface_brightness: f64,
}

fn streak(row: &StreakRow<'_>) -> Option<Streak> {
    let telescope = row.telescope?;
    let magnitude = row.pass.mid.brightness.as_ref()?.magnitude.0;
    let width_arcsec = width_arcsec(row, telescope);
    let rate_arcsec_s = row.pass.angular_rate_rad_s.to_degrees() * 3600.0;
    let exposure_s = row.exposure.duration_s;
    Some(Streak {
        effective_magnitude: effective_magnitude(magnitude, width_arcsec, rate_arcsec_s, exposure_s),
        surface_brightness: surface_brightness_mag_arcsec2(magnitude, width_arcsec, rate_arcsec_s, exposure_s),
    })
}

fn width_arcsec(row: &StreakRow<'_>, telescope: &Telescope) -> f64 {
    telescope.width_arcsec(row.pass.mid.range_km, row.satellite_size_m)
}

/// The brightness that a row speaks of: at mid, else at the peak.
fn shown<'a>(row: &StreakRow<'a>) -> Option<&'a Brightness> {
    let at_peak = || row.pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
    row.pass.mid.brightness.as_ref().or_else(at_peak)
}

fn text(text: &str) -> Value {
    if text.is_empty() { Value::Null } else { text.into() }
}

fn degrees(radians: Option<f64>) -> Value {
    radians.map(f64::to_degrees).into()
}

fn ra_deg(point: &TrackPoint) -> Value {
    point.direction.longitude_rad().to_degrees().into()
}

fn dec_deg(point: &TrackPoint) -> Value {
    point.direction.latitude_rad().to_degrees().into()
}

fn magnitude(point: &TrackPoint) -> Value {
    point.brightness.as_ref().map(|brightness| brightness.magnitude.0).into()
}

fn sigma(point: &TrackPoint) -> Value {
    point.brightness.as_ref().map(|brightness| brightness.sigma_mag).into()
}

//! Tables of exposures, of verdicts (one row for each exposure) and of streaks (one row for each exposure and
//! satellite).

use crate::elements::ElementSet;
use crate::frames::seconds_after;
use crate::images::{Telescope, effective_magnitude, surface_brightness_mag_arcsec2};
use crate::output::{Column, Kind, Table, TableField, Value};
use crate::passes::{Chord, Exposure, Pass, TrackPoint};
use crate::photometry::{Brightness, PhotometryOptions};

use super::scheduled::ScheduledExposure;
use super::verdict::{Verdict, VerdictKind};

/// Returns exposures as a table, in their order: `id, start_utc, duration_s, ra_deg, dec_deg, rotation_deg`.
pub fn exposure_table<'a>(exposures: impl IntoIterator<Item = &'a Exposure>) -> Table {
    let row = |exposure: &Exposure| {
        vec![
            exposure.id.as_str().into(),
            exposure.start.into(),
            exposure.duration_s.into(),
            exposure.pointing.longitude_rad().to_degrees().into(),
            exposure.pointing.latitude_rad().to_degrees().into(),
            exposure.rotation_rad.to_degrees().into(),
        ]
    };
    Table {
        columns: vec![
            Column::new("id", Kind::Text, "The schedule's name of the exposure."),
            Column::time("start_utc", "Shutter opening."),
            Column::real("duration_s", "s", 3, "Length of the exposure."),
            Column::real("ra_deg", "deg", 7, "Right ascension of the field's centre, ICRS."),
            Column::real("dec_deg", "deg", 7, "Declination of the field's centre."),
            Column::real("rotation_deg", "deg", 4, "Position angle of the field's y axis."),
        ],
        rows: exposures.into_iter().map(row).collect(),
    }
}

/// Returns verdicts as a table, in their order.
pub fn flag_table(flags: &[Verdict]) -> Table {
    Table::from_records(&flag_fields(), flags)
}

/// Returns the columns of [`flag_table`] with those of the scheduled exposures before the last: `start_utc, duration_s,
/// ra_deg, dec_deg, band`. `rows` are the rows of the verdicts, in the same order.
pub fn flag_table_with_exposures(flags: &[Verdict], rows: &[ScheduledExposure]) -> Table {
    let mut table = flag_table(flags);
    let exposures = Table::from_records(&scheduled_fields(), rows);
    // The last column of the verdicts remains the last.
    let at = table.columns.len() - 1;
    table.columns.splice(at..at, exposures.columns);
    table.rows.iter_mut().zip(exposures.rows).for_each(|(flag, exposure)| drop(flag.splice(at..at, exposure)));
    table
}

fn scheduled_fields() -> Vec<TableField<ScheduledExposure>> {
    let field = TableField::<ScheduledExposure>::new;
    vec![
        field(Column::time("start_utc", "Scheduled shutter opening; empty in an invalid row."), |row| {
            of_exposure(row, |exposure| exposure.start.into())
        }),
        field(Column::real("duration_s", "s", 3, "Length of the exposure."), |row| {
            of_exposure(row, |exposure| exposure.duration_s.into())
        }),
        field(Column::real("ra_deg", "deg", 7, "Right ascension of the field's centre, ICRS."), |row| {
            of_exposure(row, |exposure| exposure.pointing.longitude_rad().to_degrees().into())
        }),
        field(Column::real("dec_deg", "deg", 7, "Declination of the field's centre."), |row| {
            of_exposure(row, |exposure| exposure.pointing.latitude_rad().to_degrees().into())
        }),
        field(Column::new("band", Kind::Text, "Band as written in the schedule; empty if it has none."), |row| {
            row.band.clone().into()
        }),
    ]
}

fn of_exposure(row: &ScheduledExposure, value: fn(&Exposure) -> Value) -> Value {
    row.exposure.as_ref().map_or(Value::Null, value)
}

fn flag_fields() -> Vec<TableField<Verdict>> {
    let field = TableField::<Verdict>::new;
    vec![
        field(Column::new("exposure_id", Kind::Text, "The schedule's name of the exposure."), |flag| {
            flag.exposure_id.as_str().into()
        }),
        field(
            Column::new(
                "verdict",
                Kind::Text,
                "clear, streaked, avoid, unknown if the elements are too old, or invalid if time or pointing are.",
            ),
            |flag| flag.kind.name().into(),
        ),
        field(
            Column::new(
                "n_streaks",
                Kind::Integer,
                "Number of lit satellites (with --include-dark of all) with nominal tracks that cross the field.",
            ),
            |flag| {
                let is_judged = !matches!(flag.kind, VerdictKind::Unknown | VerdictKind::Invalid);
                is_judged.then_some(flag.n_streaks).into()
            },
        ),
        field(
            Column::real("brightest_mag", "mag", 3, "Brightest magnitude of the lit crossings in the field."),
            |flag| flag.brightest_mag.into(),
        ),
        field(
            Column::real(
                "expected_lost_pixel_fraction",
                "",
                6,
                "Expected fraction of the field's pixels lost; empty without a telescope.",
            ),
            |flag| flag.expected_lost_pixel_fraction.into(),
        ),
        field(
            Column::real(
                "p_any",
                "",
                4,
                "Probability that at least one lit satellite crosses that is brighter than a limit of the policy, near misses included; without a limit, p_crossing.",
            ),
            |flag| flag.p_any.into(),
        ),
        field(
            Column::real(
                "streak_length_deg",
                "deg",
                4,
                "Length of the lit parts of all nominal tracks in the field; with --include-dark, of all parts.",
            ),
            |flag| flag.streak_length_deg.into(),
        ),
        field(Column::new("reasons", Kind::List { separator: "; " }, "Reasons for the verdict."), |flag| {
            Value::List(flag.reasons.clone())
        }),
        field(
            Column {
                kind: Kind::Time { decimals: 3 },
                ..Column::time(
                    "next_clear_start_utc",
                    "Earliest clear start, not before the scheduled one; empty if none exists within the allowed delay.",
                )
            },
            |flag| flag.next_clear_start.into(),
        ),
        field(Column::real("delay_s", "s", 3, "Delay of the next clear start after the scheduled start."), |flag| {
            flag.delay_s.into()
        }),
        field(
            Column::new(
                "norad_ids",
                Kind::List { separator: " " },
                "Catalogue numbers of the lit crossings (with --include-dark of all) in order of entry.",
            ),
            |flag| Value::Integers(flag.norad_ids.iter().map(|id| i64::from(id.0)).collect()),
        ),
        field(
            Column::real(
                "p_crossing",
                "",
                4,
                "Probability that at least one lit satellite (with --include-dark any) of any brightness crosses, near misses included.",
            ),
            |flag| flag.p_crossing.into(),
        ),
        field(
            Column {
                kind: Kind::Time { decimals: 3 },
                ..Column::time(
                    "next_acceptable_start_utc",
                    "Earliest start, not before the scheduled one, at which no limit of the policy is exceeded; equal to next_clear_start_utc if no limit applies.",
                )
            },
            |flag| flag.next_acceptable_start.into(),
        ),
        field(
            Column::real("acceptable_delay_s", "s", 3, "Delay of the next acceptable start after the scheduled start."),
            |flag| flag.acceptable_delay_s.into(),
        ),
        field(
            Column::real(
                "elements_age_days",
                "d",
                2,
                "Age of the elements of the satellites that decide the verdict (median); negative if their epochs are later.",
            ),
            |flag| flag.elements_age_days.into(),
        ),
        field(
            Column::real(
                "late_s",
                "s",
                2,
                "Lateness of these satellites (median): 68 % of the delays are at most this long; empty if it is unknown.",
            ),
            |flag| flag.late_s.into(),
        ),
        field(
            Column::real(
                "streak_cost_s",
                "s",
                3,
                "Expected cost of the streaks in seconds of open shutter; empty without a telescope.",
            ),
            |flag| flag.streak_cost_s.into(),
        ),
    ]
}

/// Row of a table of streaks: a pass with its exposure and satellite.
#[derive(Copy, Clone)]
pub struct StreakRow<'a> {
    /// Exposure that the pass crosses.
    pub exposure: &'a Exposure,
    /// The pass.
    pub pass: &'a Pass,
    /// Element set of the satellite.
    pub elements: &'a ElementSet,
    /// Largest extent of the satellite, metres.
    pub satellite_size_m: f64,
    /// Telescope; without one, streak width, surface brightness and effective magnitude are empty.
    pub telescope: Option<&'a Telescope>,
    /// Band and system of the magnitudes.
    pub photometry: &'a PhotometryOptions,
    /// Magnitude at which this satellite exceeds a limit of the exposure, used for the column `p_brighter`.
    pub limit_mag: Option<f64>,
    /// Expected cost of the pass ([`FlagRequest::pass_cost`](super::FlagRequest::pass_cost)); `None` without a
    /// telescope.
    pub cost: Option<PassCost>,
}

/// Expected cost of the streak of one pass.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PassCost {
    /// Expected cost, seconds of open shutter.
    pub streak_cost_s: f64,
    /// Probability that the streak, if there is one, is brighter per pixel than that of a satellite of the telescope's
    /// `bright_mag` at 550 km, [0, 1].
    pub p_bright: f64,
}

/// Optional columns of a table of streaks.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct StreakColumns {
    /// Probability that the satellite is brighter than the magnitude limit.
    pub p_brighter: bool,
    /// Intervals inside the field.
    pub chords: bool,
    /// Points along the track, if they were computed.
    pub samples: bool,
}

/// Returns passes as a table, in their order.
pub fn streak_table<'a>(rows: impl IntoIterator<Item = StreakRow<'a>>, columns: StreakColumns) -> Table {
    let mut fields = streak_fields();
    if columns.p_brighter {
        fields.push(p_brighter_field());
    }
    if columns.chords {
        fields.extend(nested_fields());
    }
    if columns.samples {
        fields.push(samples_field());
    }
    fields.extend(cost_fields());
    fields.push(fitted_range_field());
    Table::from_records(&fields, rows)
}

const CHORDS: &[Column] = &[
    Column::time("enter_utc", "Entry into the field."),
    Column::time("exit_utc", "Exit from the field."),
    Column::real("enter_s", "s", 3, "Entry after shutter opening."),
    Column::real("exit_s", "s", 3, "Exit after shutter opening."),
];

const SAMPLES: &[Column] = &[
    Column::time("utc", "Time of reception."),
    Column::real("ra_deg", "deg", 7, "Right ascension, ICRS astrometric topocentric."),
    Column::real("dec_deg", "deg", 7, "Declination."),
    Column::real("altitude_deg", "deg", 4, "Altitude without refraction."),
    Column::real("azimuth_deg", "deg", 4, "Azimuth from north through east."),
    Column::real("range_km", "km", 3, "Distance from the observer."),
    Column::real("magnitude", "mag", 3, "Apparent magnitude."),
    Column::real("magnitude_sigma", "mag", 3, "One-sigma uncertainty of the magnitude."),
];

fn streak_fields<'a>() -> Vec<TableField<StreakRow<'a>>> {
    let field = TableField::<StreakRow<'a>>::new;
    vec![
        field(Column::new("exposure_id", Kind::Text, "The schedule's name of the exposure."), |row| {
            row.exposure.id.as_str().into()
        }),
        field(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |row| {
            i64::from(row.pass.norad_id.0).into()
        }),
        field(Column::new("name", Kind::Text, "Name in the element set."), |row| Value::nonempty(&row.elements.name)),
        field(Column::new("international_designator", Kind::Text, "COSPAR designator."), |row| {
            Value::nonempty(&row.elements.international_designator)
        }),
        field(Column::time("enter_utc", "Entry into the field, or shutter opening."), |row| {
            row.pass.enter.epoch.into()
        }),
        field(Column::time("mid_utc", "Half way in time between entry and exit."), |row| row.pass.mid.epoch.into()),
        field(Column::time("exit_utc", "Exit from the field, or shutter closing."), |row| row.pass.exit.epoch.into()),
        field(
            Column::real("enter_ra_deg", "deg", 7, "Right ascension at entry, ICRS astrometric topocentric."),
            |row| ra_deg(&row.pass.enter),
        ),
        field(Column::real("enter_dec_deg", "deg", 7, "Declination at entry."), |row| dec_deg(&row.pass.enter)),
        field(Column::real("mid_ra_deg", "deg", 7, "Right ascension at mid."), |row| ra_deg(&row.pass.mid)),
        field(Column::real("mid_dec_deg", "deg", 7, "Declination at mid."), |row| dec_deg(&row.pass.mid)),
        field(Column::real("exit_ra_deg", "deg", 7, "Right ascension at exit."), |row| ra_deg(&row.pass.exit)),
        field(Column::real("exit_dec_deg", "deg", 7, "Declination at exit."), |row| dec_deg(&row.pass.exit)),
        field(Column::real("min_separation_deg", "deg", 6, "Least angle between track and field centre."), |row| {
            row.pass.min_separation_rad.to_degrees().into()
        }),
        field(
            Column::real(
                "streak_length_deg",
                "deg",
                6,
                "Length of the streak inside the field: the lit part of the track.",
            ),
            |row| row.pass.streak_length_rad.to_degrees().into(),
        ),
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
        field(Column::real("range_km", "km", 3, "Distance from the observer at mid."), |row| {
            row.pass.mid.range_km.into()
        }),
        field(Column::real("height_km", "km", 3, "Height above the WGS84 ellipsoid at mid."), |row| {
            row.pass.mid.height_km.into()
        }),
        field(Column::real("phase_angle_deg", "deg", 4, "Sun-satellite-observer angle at mid."), |row| {
            row.pass.mid.geometry.phase_angle_rad().to_degrees().into()
        }),
        field(Column::new("illumination", Kind::Text, "sunlit, penumbra or umbra, at mid."), |row| {
            row.pass.mid.illumination.name().into()
        }),
        field(
            Column::real("lit_fraction", "", 4, "Fraction of the Sun's light that reaches the satellite at mid."),
            |row| row.pass.mid.illumination.lit_fraction().into(),
        ),
        field(
            Column::real(
                "magnitude",
                "mag",
                3,
                "Apparent magnitude at mid without motion; empty if the satellite is not visible.",
            ),
            |row| magnitude(&row.pass.mid),
        ),
        field(Column::real("magnitude_sigma", "mag", 3, "One-sigma uncertainty of the magnitude at mid."), |row| {
            sigma(&row.pass.mid)
        }),
        field(
            Column::real(
                "magnitude_peak",
                "mag",
                3,
                "Brightest magnitude along the track; empty if all of it is in the umbra.",
            ),
            |row| row.pass.peak.as_ref().map_or(Value::Null, magnitude),
        ),
        field(Column::new("band", Kind::Text, "Passband of the magnitudes."), |row| row.photometry.band.name().into()),
        field(Column::new("mag_system", Kind::Text, "Zero point of the magnitudes."), |row| {
            row.photometry.system.to_string().into()
        }),
        field(Column::new("mag_source", Kind::Text, "Source of the magnitude."), |row| {
            shown(row).map(|brightness| brightness.source.to_string()).into()
        }),
        field(
            Column::real(
                "effective_magnitude",
                "mag",
                3,
                "Magnitude of a star with the surface brightness of the streak in the same exposure.",
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
                "Time of the exposure less epoch of the elements; positive if the exposure is later.",
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
        field(
            Column::real("probability", "", 4, "Probability that the satellite crosses, given those errors."),
            |row| row.pass.probability.into(),
        ),
        field(
            Column::new(
                "position_source",
                Kind::Text,
                "Source of the positions: `element set`, or `ephemeris` with the name of the file.",
            ),
            |row| row.pass.position_source.to_string().into(),
        ),
        field(
            Column::real("magnitude_peak_sigma", "mag", 3, "One-sigma uncertainty of the brightest magnitude."),
            |row| row.pass.peak.as_ref().map_or(Value::Null, sigma),
        ),
    ]
}

fn cost_fields<'a>() -> [TableField<StreakRow<'a>>; 2] {
    let field = TableField::<StreakRow<'a>>::new;
    [
        field(
            Column::real(
                "streak_cost_s",
                "s",
                3,
                "Expected cost of this streak in seconds of open shutter; empty without a telescope.",
            ),
            |row| row.cost.map(|cost| cost.streak_cost_s).into(),
        ),
        field(
            Column::real(
                "p_bright",
                "",
                4,
                "Probability that the streak is brighter per pixel than that of a satellite of `bright_mag` at 550 km; empty without a telescope.",
            ),
            |row| row.cost.map(|cost| cost.p_bright).into(),
        ),
    ]
}

fn fitted_range_field<'a>() -> TableField<StreakRow<'a>> {
    TableField::new(
        Column::new(
            "in_fitted_range",
            Kind::Boolean,
            "False if the geometry is more than 10 deg from those to which the model was fitted; empty without a magnitude.",
        ),
        |row| shown(row).map(|brightness| Value::Boolean(brightness.in_fitted_range)).unwrap_or(Value::Null),
    )
}

fn p_brighter_field<'a>() -> TableField<StreakRow<'a>> {
    TableField::new(
        Column::real(
            "p_brighter",
            "",
            4,
            "Probability of being brighter at the peak than a limit of magnitude or surface brightness; empty without one for the band.",
        ),
        |row| row.limit_mag.map(|limit_mag| row.pass.probability_brighter_than(limit_mag)).into(),
    )
}

/// Columns that are written by default only in formats with nested tables. In the other formats they are optional, so
/// that their default columns do not change.
fn nested_fields<'a>() -> Vec<TableField<StreakRow<'a>>> {
    let field = TableField::<StreakRow<'a>>::new;
    vec![
        field(Column::new("chords", Kind::Rows(CHORDS), "Intervals of the track inside the field."), |row| {
            intervals(row, &row.pass.chords)
        }),
        field(
            Column::new("lit_chords", Kind::Rows(CHORDS), "Parts of these intervals in which the satellite is lit."),
            |row| intervals(row, &row.pass.lit_chords),
        ),
    ]
}

fn intervals(row: &StreakRow<'_>, chords: &[Chord]) -> Value {
    let opening = row.exposure.start;
    let chord = |chord: &Chord| {
        let moment = |seconds| seconds_after(opening, seconds).into();
        vec![moment(chord.enter_s), moment(chord.exit_s), chord.enter_s.into(), chord.exit_s.into()]
    };
    Value::Rows(chords.iter().map(chord).collect())
}

fn samples_field<'a>() -> TableField<StreakRow<'a>> {
    TableField::new(Column::new("samples", Kind::Rows(SAMPLES), "Points along the track."), |row| {
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
    })
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

/// Returns the brightness at the middle of the pass, or at its peak if there is none at the middle.
fn shown<'a>(row: &StreakRow<'a>) -> Option<&'a Brightness> {
    let at_peak = || row.pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
    row.pass.mid.brightness.as_ref().or_else(at_peak)
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

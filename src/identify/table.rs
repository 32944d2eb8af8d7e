//! Tables of the measured streak and of its candidates.

use super::likelihood::Candidate;
use super::streak::MeasuredStreak;
use crate::elements::ElementSet;
use crate::frames::{Direction, Gcrs, seconds_after};
use crate::output::{Column, Kind, Table, TableField, Value};
use crate::photometry::{Brightness, PhotometryOptions};

/// Row of a table of candidates.
#[derive(Copy, Clone)]
pub struct CandidateRow<'a> {
    /// Candidate.
    pub candidate: &'a Candidate,
    /// Element set of the candidate.
    pub elements: &'a ElementSet,
    /// Band and system of the magnitudes.
    pub photometry: &'a PhotometryOptions,
}

const ARCSEC_PER_RAD: f64 = 3600.0 * 180.0 / std::f64::consts::PI;

fn candidate_fields<'a>() -> Vec<TableField<CandidateRow<'a>>> {
    let field = TableField::<CandidateRow<'a>>::new;
    vec![
        field(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |row| {
            i64::from(row.candidate.norad_id.0).into()
        }),
        field(Column::new("name", Kind::Text, "Name in the element set."), |row| Value::nonempty(&row.elements.name)),
        field(Column::new("international_designator", Kind::Text, "COSPAR designator."), |row| {
            Value::nonempty(&row.elements.international_designator)
        }),
        field(
            Column::real(
                "probability",
                "",
                6,
                "Probability that the streak is that of this satellite, among all candidates and satellites without elements.",
            ),
            |row| row.candidate.probability.into(),
        ),
        field(Column::real("chi_square", "", 3, "Sum of the squares of the offsets in sigmas."), |row| {
            row.candidate.chi_square.into()
        }),
        field(Column::new("chi_square_terms", Kind::Integer, "Number of offsets in the sum."), |row| {
            i64::from(row.candidate.terms).into()
        }),
        field(
            Column::real(
                "p_value",
                "",
                6,
                "Probability of a chi square at least as large if the streak is that of this satellite.",
            ),
            |row| row.candidate.p_value.into(),
        ),
        field(
            Column::real(
                "along_track_offset_s",
                "s",
                3,
                "Delay of the satellite relative to its prediction, negative if early; 0 if it is predicted to pass during the exposure.",
            ),
            |row| row.candidate.along_track_s.value.into(),
        ),
        field(Column::real("along_track_offset_deg", "deg", 5, "Delay as an angle on the sky."), |row| {
            (row.candidate.along_track_s.value * row.candidate.angular_rate_rad_s.to_degrees()).into()
        }),
        field(
            Column::real(
                "along_track_sigma_s",
                "s",
                3,
                "One sigma of the delay, from the age of the elements and the clock.",
            ),
            |row| row.candidate.along_track_s.sigma.into(),
        ),
        field(
            Column::real(
                "cross_track_offset_arcsec",
                "arcsec",
                2,
                "Distance of the streak from the predicted track, positive towards the position angle of motion plus 90 deg.",
            ),
            |row| (row.candidate.cross_track_rad.value * ARCSEC_PER_RAD).into(),
        ),
        field(Column::real("cross_track_sigma_arcsec", "arcsec", 2, "One sigma of the cross-track offset."), |row| {
            (row.candidate.cross_track_rad.sigma * ARCSEC_PER_RAD).into()
        }),
        field(
            Column::real("angle_difference_deg", "deg", 4, "Position angle of the streak minus that of the motion."),
            |row| row.candidate.angle_rad.value.to_degrees().into(),
        ),
        field(Column::real("angle_sigma_deg", "deg", 4, "One sigma of the angle difference."), |row| {
            row.candidate.angle_rad.sigma.to_degrees().into()
        }),
        field(
            Column::real(
                "length_difference_deg",
                "deg",
                5,
                "Measured minus predicted length; at least 0 if the streak may end at the edges of the frame.",
            ),
            |row| row.candidate.length_rad.map(|offset| offset.value.to_degrees()).into(),
        ),
        field(Column::real("length_sigma_deg", "deg", 5, "One sigma of the length difference."), |row| {
            row.candidate.length_rad.map(|offset| offset.sigma.to_degrees()).into()
        }),
        field(
            Column::real("predicted_length_deg", "deg", 5, "Predicted length of the track during the exposure."),
            |row| row.candidate.predicted_length_rad.to_degrees().into(),
        ),
        field(Column::real("angular_rate_deg_s", "deg / s", 6, "Angular rate on the sky."), |row| {
            row.candidate.angular_rate_rad_s.to_degrees().into()
        }),
        field(
            Column::real("position_angle_deg", "deg", 4, "Position angle of the motion, from north through east."),
            |row| row.candidate.position_angle_rad.to_degrees().into(),
        ),
        field(
            Column::time("passage_utc", "Time at which the delayed satellite passes the middle of the streak."),
            |row| row.candidate.passage.epoch.into(),
        ),
        field(Column::real("altitude_deg", "deg", 4, "Altitude at the passage, without refraction."), |row| {
            row.candidate.passage.altitude_rad.map(f64::to_degrees).into()
        }),
        field(Column::real("azimuth_deg", "deg", 4, "Azimuth at the passage, from north through east."), |row| {
            row.candidate.passage.azimuth_rad.map(f64::to_degrees).into()
        }),
        field(Column::real("range_km", "km", 3, "Distance from the observer at the passage."), |row| {
            row.candidate.passage.range_km.into()
        }),
        field(Column::real("phase_angle_deg", "deg", 4, "Sun-satellite-observer angle at the passage."), |row| {
            row.candidate.passage.geometry.phase_angle_rad().to_degrees().into()
        }),
        field(
            Column::new("illumination", Kind::Text, "Illumination at the passage: sunlit, penumbra or umbra."),
            |row| row.candidate.passage.illumination.name().into(),
        ),
        field(
            Column::real("magnitude", "mag", 3, "Predicted apparent magnitude at the passage, without flares."),
            |row| light(row).map(|light| light.magnitude.0).into(),
        ),
        field(Column::real("magnitude_sigma", "mag", 3, "One sigma of the magnitude."), |row| {
            light(row).map(|light| light.sigma_mag).into()
        }),
        field(Column::new("band", Kind::Text, "Passband of the magnitude."), |row| row.photometry.band.name().into()),
        field(Column::new("mag_system", Kind::Text, "Zero point of the magnitude."), |row| {
            row.photometry.system.to_string().into()
        }),
        field(Column::new("mag_source", Kind::Text, "Source of the magnitude."), |row| {
            light(row).map(|light| light.source.to_string()).into()
        }),
        field(
            Column::real(
                "element_age_days",
                "d",
                4,
                "Time of the passage minus epoch of the elements; negative for elements from after the passage.",
            ),
            |row| row.candidate.element_age_days.into(),
        ),
    ]
}

/// Returns candidates as a table, in their order.
pub fn candidate_table<'a>(rows: impl IntoIterator<Item = CandidateRow<'a>>) -> Table {
    Table::from_records(&candidate_fields(), rows)
}

const STREAK: [Column; 14] = [
    Column::time("start_utc", "Start of the exposure."),
    Column::time("end_utc", "End of the exposure."),
    Column::new("timing", Kind::Text, "Relation between the exposure and the ends of the streak."),
    Column::real("ra_deg", "deg", 7, "Right ascension of the middle of the streak, ICRS."),
    Column::real("dec_deg", "deg", 7, "Declination of the middle of the streak, ICRS."),
    Column::real("position_angle_deg", "deg", 4, "Position angle of the streak at its middle, towards the second end."),
    Column::real("length_deg", "deg", 6, "Length of the streak; empty if unknown."),
    Column::real("from_ra_deg", "deg", 7, "Right ascension of the first end, ICRS."),
    Column::real("from_dec_deg", "deg", 7, "Declination of the first end, ICRS."),
    Column::real("to_ra_deg", "deg", 7, "Right ascension of the second end, ICRS."),
    Column::real("to_dec_deg", "deg", 7, "Declination of the second end, ICRS."),
    Column::real("place_sigma_arcsec", "arcsec", 3, "One sigma of the position of an end."),
    Column::real("time_sigma_s", "s", 3, "One sigma of the clock."),
    Column::real("angle_sigma_deg", "deg", 4, "One sigma of the position angle."),
];

/// Returns measured streaks as a table, one row each.
pub fn streak_table<'a>(streaks: impl IntoIterator<Item = &'a MeasuredStreak>) -> Table {
    Table { columns: STREAK.to_vec(), rows: streaks.into_iter().map(streak_row).collect() }
}

fn streak_row(streak: &MeasuredStreak) -> Vec<Value> {
    let ends = streak.ends();
    let longitude = |end: usize| -> Value { ends.map(|ends| ends[end].longitude_rad().to_degrees()).into() };
    let latitude = |end: usize| -> Value { ends.map(|ends| ends[end].latitude_rad().to_degrees()).into() };
    let middle: Direction<Gcrs> = streak.middle();
    vec![
        streak.start().into(),
        seconds_after(streak.start(), streak.duration_s()).into(),
        streak.timing().name().into(),
        middle.longitude_rad().to_degrees().into(),
        middle.latitude_rad().to_degrees().into(),
        streak.position_angle_rad().to_degrees().into(),
        streak.length_rad().map(f64::to_degrees).into(),
        longitude(0),
        latitude(0),
        longitude(1),
        latitude(1),
        (streak.position_sigma_rad() * ARCSEC_PER_RAD).into(),
        streak.time_sigma_s().into(),
        streak.angle_sigma_rad().to_degrees().into(),
    ]
}

fn light<'a>(row: &CandidateRow<'a>) -> Option<&'a Brightness> {
    row.candidate.passage.brightness.as_ref()
}

//! Tables of measurements: all columns, and the upload format of IAU CPS SCORE.

use super::frame::MeasuredPass;
use super::given::ListedMeasurement;
use super::measurement::Flag;
use crate::frames::{Direction, Gcrs};
use crate::geometry::{Site, ViewingGeometry};
use crate::output::{Column, Kind, Table, TableField, Value};

const fn text(name: &'static str, description: &'static str) -> Column {
    Column::new(name, Kind::Text, description)
}

const FIELDS: &[TableField<MeasuredPass>] = &[
    TableField::new(text("image", "File of the frame."), |pass| pass.image.as_str().into()),
    TableField::new(Column::new("hdu", Kind::Integer, "HDU of the chip, from 0."), |pass| pass.hdu.into()),
    TableField::new(Column::new("norad_id", Kind::Integer, "NORAD catalogue number."), |pass| {
        pass.prediction.satellite.norad_id.map(|id| i64::from(id.0)).into()
    }),
    TableField::new(text("name", "Name of the satellite."), |pass| Value::nonempty(&pass.prediction.satellite.name)),
    TableField::new(Column::new("detected", Kind::Boolean, "True if the streak was found."), |pass| {
        pass.measured.is_detected.into()
    }),
    TableField::new(
        Column::time(
            "mid_utc",
            "Middle of the time in which the satellite is on the chip; by its prediction if it is not found.",
        ),
        |pass| pass.epoch.into(),
    ),
    TableField::new(
        Column::real(
            "duration_s",
            "s",
            4,
            "Time in which the satellite is on the chip; by its prediction if it is not found.",
        ),
        |pass| pass.duration_s.into(),
    ),
    TableField::new(Column::real("ra_deg", "deg", 6, "Right ascension at mid_utc (ICRS)."), |pass| {
        pass.direction.longitude_rad().to_degrees().into()
    }),
    TableField::new(Column::real("dec_deg", "deg", 6, "Declination at mid_utc (ICRS)."), |pass| {
        pass.direction.latitude_rad().to_degrees().into()
    }),
    TableField::new(
        Column::real(
            "magnitude",
            "mag",
            4,
            "Measured magnitude; a bright limit if flags contain saturated or clipped.",
        ),
        |pass| pass.magnitude.map(|magnitude| magnitude.value).into(),
    ),
    TableField::new(
        Column::small("magnitude_sigma", "mag", 4, "Error (one sigma), with zero_point_sigma_mag if it is known."),
        |pass| pass.magnitude.map(|magnitude| magnitude.sigma).into(),
    ),
    TableField::new(
        Column::small(
            "magnitude_size_sigma",
            "mag",
            4,
            "Part of magnitude_sigma by the unknown size of the satellite.",
        ),
        |pass| {
            let rate = pass.measured.rate.value;
            let sigma = 2.5 / std::f64::consts::LN_10 * pass.measured.size_sigma / rate;
            pass.magnitude.and(pass.prediction.size_m).map(|_| sigma).into()
        },
    ),
    TableField::new(
        Column::real("size_m", "m", 3, "Diameter of the satellite, given or assumed by its brightness model."),
        |pass| pass.prediction.size_m.into(),
    ),
    TableField::new(
        Column::real("limit_magnitude", "mag", 4, "For a streak not found: faintest magnitude that is excluded."),
        |pass| if pass.measured.is_detected { Value::Null } else { pass.limit_mag.into() },
    ),
    TableField::new(Column::new("calibrated", Kind::Boolean, "False if magnitudes are instrumental."), |pass| {
        pass.is_calibrated.into()
    }),
    TableField::new(
        Column::real("zero_point_mag", "mag", 4, "Magnitude of a star whose pixels sum to 1; empty if not calibrated."),
        |pass| Some(pass.zero_point_mag).filter(|_| pass.is_calibrated).into(),
    ),
    TableField::new(
        Column::small("zero_point_sigma_mag", "mag", 4, "Error (one sigma) of a zero point from stars."),
        |pass| pass.zero_point_sigma_mag.into(),
    ),
    TableField::new(text("filter", "Filter in the header."), |pass| pass.filter.clone().into()),
    TableField::new(
        Column::small("rate", "", 4, "Light per second in the unit of the frame, mean over the track."),
        |pass| pass.measured.rate.value.into(),
    ),
    TableField::new(Column::small("rate_sigma", "", 4, "Error (one sigma) of rate."), |pass| {
        pass.measured.rate.sigma.into()
    }),
    TableField::new(
        Column::small("flux", "", 4, "Light in the frame, in its unit: rate multiplied by duration_s."),
        |pass| (pass.measured.rate.value * pass.duration_s).into(),
    ),
    TableField::new(Column::small("flux_sigma", "", 4, "Error (one sigma) of flux."), |pass| {
        (pass.measured.rate.sigma * pass.duration_s).into()
    }),
    TableField::new(
        Column::real(
            "signal_to_noise",
            "",
            2,
            "Fitted light divided by rate_sigma; rate is less by the correction for the fitted position.",
        ),
        |pass| pass.measured.signal_to_noise.into(),
    ),
    TableField::new(Column::real("significance", "", 2, "Significance of the streak in the search."), |pass| {
        pass.measured.significance.into()
    }),
    TableField::new(Column::real("threshold", "", 2, "Significance required for a detection."), |pass| {
        pass.measured.threshold.into()
    }),
    TableField::new(
        Column::real("offset_pix", "pix", 3, "Distance from the predicted track, positive towards increasing y or x."),
        |pass| found(pass, pass.measured.offset_pix.value),
    ),
    TableField::new(Column::small("offset_sigma_pix", "pix", 3, "Error (one sigma) of offset_pix."), |pass| {
        found(pass, pass.measured.offset_pix.sigma)
    }),
    TableField::new(Column::real("offset_arcsec", "arcsec", 3, "Distance from the predicted track."), |pass| {
        found(pass, pass.measured.offset_pix.value * pass.pixel_scale_arcsec)
    }),
    TableField::new(Column::real("tilt_deg", "deg", 4, "Difference in angle from the predicted track."), |pass| {
        found(pass, pass.measured.tilt_rad.to_degrees())
    }),
    TableField::new(Column::real("late_s", "s", 4, "Delay, if an end of the streak is in the frame."), |pass| {
        pass.measured.late_s.map(|late| late.value).into()
    }),
    TableField::new(Column::small("late_sigma_s", "s", 4, "Error (one sigma) of late_s."), |pass| {
        pass.measured.late_s.map(|late| late.sigma).into()
    }),
    TableField::new(
        Column::small(
            "late_expected_sigma_s",
            "s",
            4,
            "Error (one sigma) of the prediction along the track, with that of the start of the exposure.",
        ),
        |pass| Some(pass.prediction.streak.lateness_sigma_s).filter(|_| pass.prediction.id.is_empty()).into(),
    ),
    TableField::new(Column::new("ends", Kind::Integer, "Number of ends of the streak in the frame."), |pass| {
        pass.measured.ends.into()
    }),
    TableField::new(Column::real("length_pix", "pix", 2, "Length in the frame."), |pass| {
        pass.measured.length_pix.into()
    }),
    TableField::new(
        Column::real(
            "x1_pix",
            "pix",
            3,
            "Column of the first end of the measured streak in the frame, from 1 as in FITS.",
        ),
        |pass| found(pass, pass.measured.ends_in_frame()[0].fits()[0]),
    ),
    TableField::new(
        Column::real(
            "y1_pix",
            "pix",
            3,
            "Row of the first end of the measured streak in the frame, from 1 as in FITS.",
        ),
        |pass| found(pass, pass.measured.ends_in_frame()[0].fits()[1]),
    ),
    TableField::new(
        Column::real(
            "x2_pix",
            "pix",
            3,
            "Column of the last end of the measured streak in the frame, from 1 as in FITS.",
        ),
        |pass| found(pass, pass.measured.ends_in_frame()[1].fits()[0]),
    ),
    TableField::new(
        Column::real("y2_pix", "pix", 3, "Row of the last end of the measured streak in the frame, from 1 as in FITS."),
        |pass| found(pass, pass.measured.ends_in_frame()[1].fits()[1]),
    ),
    TableField::new(
        Column::real(
            "ra1_deg",
            "deg",
            6,
            "Right ascension of the first end of the measured streak in the frame (ICRS).",
        ),
        |pass| end(pass, 0, Direction::longitude_rad),
    ),
    TableField::new(
        Column::real("dec1_deg", "deg", 6, "Declination of the first end of the measured streak in the frame (ICRS)."),
        |pass| end(pass, 0, Direction::latitude_rad),
    ),
    TableField::new(
        Column::real(
            "ra2_deg",
            "deg",
            6,
            "Right ascension of the last end of the measured streak in the frame (ICRS).",
        ),
        |pass| end(pass, 1, Direction::longitude_rad),
    ),
    TableField::new(
        Column::real("dec2_deg", "deg", 6, "Declination of the last end of the measured streak in the frame (ICRS)."),
        |pass| end(pass, 1, Direction::latitude_rad),
    ),
    TableField::new(
        Column::real("seeing_arcsec", "arcsec", 3, "Seeing that the width of the streak implies."),
        |pass| pass.measured.seeing_arcsec.into(),
    ),
    TableField::new(
        Column::real("corridor_pix", "pix", 1, "Largest distance from the predicted track searched."),
        |pass| pass.measured.corridor_pix.into(),
    ),
    TableField::new(Column::real("predicted_magnitude", "mag", 3, "Magnitude of the model."), |pass| {
        pass.prediction.satellite.brightness.as_ref().map(|brightness| brightness.magnitude.0).into()
    }),
    TableField::new(
        Column::real(
            "pass_magnitude",
            "mag",
            3,
            "Magnitude of the model, corrected by earlier streaks of the same pass in these frames; empty without them.",
        ),
        |pass| pass.of_pass.map(|light| light.value).into(),
    ),
    TableField::new(
        Column::real("pass_magnitude_sigma", "mag", 3, "One sigma of a measurement about pass_magnitude."),
        |pass| pass.of_pass.map(|light| light.sigma).into(),
    ),
    TableField::new(Column::real("range_km", "km", 3, "Predicted distance."), |pass| {
        pass.prediction.satellite.range_km.into()
    }),
    TableField::new(Column::real("phase_angle_deg", "deg", 3, "Predicted angle Sun-satellite-observer."), |pass| {
        pass.prediction.satellite.geometry.map(|geometry| geometry.phase_angle_rad().to_degrees()).into()
    }),
    TableField::new(
        Column::real("sun_angle_deg", "deg", 3, "Predicted angle of satellite and Sun at the observer."),
        |pass| known(pass, |geometry| geometry.sun_angle_rad().to_degrees()),
    ),
    TableField::new(
        Column::real(
            "sun_incidence_angle_deg",
            "deg",
            3,
            "Predicted angle of the Sun from the nadir at the satellite.",
        ),
        |pass| known(pass, |geometry| 90.0 + geometry.sun_latitude_rad.to_degrees()),
    ),
    TableField::new(
        Column::real(
            "observer_angle_deg",
            "deg",
            3,
            "Predicted angle of the observer from the nadir at the satellite.",
        ),
        |pass| known(pass, |geometry| 90.0 + geometry.observer_latitude_rad.to_degrees()),
    ),
    TableField::new(
        Column::real(
            "magnitude_550_km",
            "mag",
            4,
            "Measured magnitude scaled to a distance of 550 km, at the same angles.",
        ),
        |pass| scaled(pass, 550.0),
    ),
    TableField::new(
        Column::real(
            "magnitude_1000_km",
            "mag",
            4,
            "Measured magnitude scaled to a distance of 1000 km, at the same angles.",
        ),
        |pass| scaled(pass, 1000.0),
    ),
    TableField::new(Column::real("element_age_days", "d", 3, "Age of the elements."), |pass| {
        pass.prediction.satellite.element_age_days.into()
    }),
    TableField::new(
        Column::new(
            "flags",
            Kind::List { separator: " " },
            "Remarks: saturated, clipped, edge, masked, width, no_gain, pixel_noise, position; for streaks of a table also \
             blended and open, and masked, outside, short and no_ends for those that are not measured.",
        ),
        |pass| Value::List(pass.measured.flags.iter().map(|flag| flag.name().to_owned()).collect()),
    ),
];

/// Returns `value` if the streak was found, otherwise a missing value.
fn found(pass: &MeasuredPass, value: f64) -> Value {
    if pass.measured.is_detected { value.into() } else { Value::Null }
}

/// Returns an angle of an end of the measured streak, degrees; missing if the streak was not found.
fn end(pass: &MeasuredPass, number: usize, angle_rad: fn(&Direction<Gcrs>) -> f64) -> Value {
    let direction = pass.ends[number].as_ref().filter(|_| pass.measured.is_detected);
    direction.map(|direction| angle_rad(direction).to_degrees()).into()
}

/// Returns `value` if the position of the satellite is known, otherwise a missing value.
fn known(pass: &MeasuredPass, value: impl Fn(&ViewingGeometry) -> f64) -> Value {
    let geometry = pass.prediction.satellite.geometry.as_ref().filter(|_| pass.prediction.is_position_known);
    geometry.map(value).into()
}

/// Returns the measured magnitude at another distance; missing without a magnitude or a known position.
fn scaled(pass: &MeasuredPass, distance_km: f64) -> Value {
    // m - 5 log10(r / r0)
    let change_mag = |geometry: &ViewingGeometry| 5.0 * (geometry.range_km / distance_km).log10();
    pass.magnitude.map_or(Value::Null, |magnitude| known(pass, |geometry| magnitude.value - change_mag(geometry)))
}

/// Returns the table of all measurements.
pub fn measurement_table(passes: &[MeasuredPass]) -> Table {
    Table::from_records(FIELDS, passes)
}

/// Returns the table of the streaks of tables: the columns of [`measurement_table`] after the name of each streak and
/// the probability of its identification. Streaks that are not measured have a flag and empty cells.
pub fn listed_table(streaks: &[ListedMeasurement]) -> Table {
    let measured = measurement_table(&[]);
    let mut columns = vec![
        text("streak", "Name of the streak in its table."),
        Column::real("probability", "", 6, "Probability that the streak is of the satellite with this name."),
    ];
    let names: Vec<&str> = measured.columns.iter().map(|column| column.name).collect();
    columns.extend(measured.columns.iter().copied());
    let cells = |streak: &ListedMeasurement| -> Vec<Value> {
        let reason = match &streak.measured {
            Ok(pass) => return FIELDS.iter().map(|field| field.value_of(pass)).collect(),
            Err(reason) => reason.name().to_owned(),
        };
        let cell = |name: &&str| match *name {
            "image" => streak.image.as_str().into(),
            "hdu" => streak.hdu.into(),
            "norad_id" => streak.satellite.norad_id.map(|id| i64::from(id.0)).into(),
            "name" => Value::nonempty(&streak.satellite.name),
            "flags" => Value::List(vec![reason.clone()]),
            _ => Value::Null,
        };
        names.iter().map(cell).collect()
    };
    let rows = streaks.iter().map(|streak| {
        let named = [streak.id.as_str().into(), streak.probability.into()];
        named.into_iter().chain(cells(streak)).collect()
    });
    Table { columns, rows: rows.collect() }
}

/// Observer as stated in a SCORE upload.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScoreObserver {
    /// E-mail address of the observer.
    pub email: String,
    /// ORCID of the observer, or several separated by commas.
    pub orcid: String,
    /// Telescope and instrument.
    pub instrument: String,
}

/// Returns the measurements in the columns of the SCORE upload format, which `streakcast fit` also reads.
///
/// Streaks that were not found have no magnitude, the limit in `limiting_magnitude` and a comment, as the format
/// requires for non-detections. Saturated and clipped streaks, satellites of unknown position and instrumental
/// magnitudes are omitted, and so are streaks of tables that were not found, because their satellite may be elsewhere.
/// The range is that of the prediction.
pub fn score_table(passes: &[MeasuredPass], site: &Site, observer: &ScoreObserver) -> Table {
    let columns = [
        text("satellite_name", ""),
        text("norad_cat_id", ""),
        Column::new("observation_time_utc", Kind::Time { decimals: 3 }, ""),
        Column::real("observation_time_uncertainty_sec", "s", 4, ""),
        Column::real("apparent_magnitude", "mag", 4, ""),
        Column::real("apparent_magnitude_uncertainty", "mag", 4, ""),
        Column::real("observer_latitude_deg", "deg", 6, ""),
        Column::real("observer_longitude_deg", "deg", 6, ""),
        Column::real("observer_altitude_m", "m", 1, ""),
        Column::real("limiting_magnitude", "mag", 3, ""),
        text("instrument", ""),
        text("observing_mode", ""),
        text("observing_filter", ""),
        text("observer_email", ""),
        text("observer_orcid", ""),
        Column::real("satellite_right_ascension_deg", "deg", 7, ""),
        Column::real("satellite_declination_deg", "deg", 7, ""),
        Column::real("sigma_2_ra", "arcsec2", 5, ""),
        Column::real("sigma_ra_sigma_dec", "arcsec2", 5, ""),
        Column::real("sigma_2_dec", "arcsec2", 5, ""),
        Column::real("range_to_satellite_km", "km", 3, ""),
        Column::real("range_to_satellite_uncertainty_km", "km", 3, ""),
        Column::real("range_rate_of_satellite_km_per_sec", "km/s", 4, ""),
        Column::real("range_rate_of_satellite_uncertainty_km_per_sec", "km/s", 4, ""),
        text("comments", ""),
        text("data_archive_link", ""),
        text("mpc_code", ""),
    ];
    let is_usable = |pass: &&MeasuredPass| {
        pass.is_calibrated
            && pass.prediction.is_position_known
            && pass.prediction.satellite.norad_id.is_some()
            && if pass.measured.is_detected {
                let is_limit = |flag: &Flag| matches!(flag, Flag::Saturated | Flag::Clipped);
                pass.magnitude.is_some() && !pass.measured.flags.iter().any(is_limit)
            } else {
                pass.prediction.id.is_empty()
            }
    };
    let rows = passes.iter().filter(is_usable).map(|pass| {
        let longitude_deg = site.longitude_rad.to_degrees();
        let time_sigma_s = match pass.measured.late_s {
            Some(late) => late.sigma,
            // The satellite crossed during the exposure T: σ <= T / √12, that of an even distribution.
            None => pass.prediction.satellite.time_sigma_s.unwrap_or(f64::INFINITY).min(pass.exposure_s / 12f64.sqrt()),
        };
        let is_detected = pass.measured.is_detected;
        let comment = if is_detected {
            format!(
                "streak of {:.0} pixels, signal to noise {:.1}",
                pass.measured.length_pix, pass.measured.signal_to_noise
            )
        } else {
            "non-detection".to_owned()
        };
        let limit = if is_detected { pass.faintest_mag } else { pass.limit_mag };
        vec![
            Value::nonempty(&pass.prediction.satellite.name),
            pass.prediction.satellite.norad_id.map(|id| id.0.to_string()).into(),
            pass.epoch.into(),
            time_sigma_s.into(),
            pass.magnitude.map(|magnitude| magnitude.value).into(),
            pass.magnitude.map(|magnitude| magnitude.sigma).into(),
            site.latitude_rad.to_degrees().into(),
            (if longitude_deg > 180.0 { longitude_deg - 360.0 } else { longitude_deg }).into(),
            site.height_m.into(),
            limit.into(),
            Value::nonempty(&observer.instrument),
            "CCD".into(),
            pass.filter.as_deref().unwrap_or("CLEAR").into(),
            Value::nonempty(&observer.email),
            Value::nonempty(&observer.orcid),
            found(pass, pass.direction.longitude_rad().to_degrees().rem_euclid(360.0)),
            found(pass, pass.direction.latitude_rad().to_degrees()),
            Value::Null,
            Value::Null,
            Value::Null,
            pass.prediction.satellite.range_km.into(),
            Value::Null,
            Value::Null,
            Value::Null,
            comment.into(),
            Value::Null,
            site.mpc_code.clone().into(),
        ]
    });
    Table { columns: columns.to_vec(), rows: rows.collect() }
}

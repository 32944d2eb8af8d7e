//! Field, telescope, policy, photometry and exposure of a configuration.

use std::collections::BTreeSet;
use std::path::Path;

use hifitime::TimeScale;
use serde_json::{Value, json};

use super::document::{Config, ExposureConfig, RulesConfig};
use super::error;
use super::inputs::{parse_file, read_text};
use super::required::{EXPOSURE, FIELD, POINTING, START};
use super::response_file::read_response;
use super::values::{NameOrTable, in_range, parse_duration_s, parse_exposure_s, parse_size_deg, parse_time_scale};
use crate::error::Error;
use crate::frames::{Direction, Gcrs, deep_sky_object, is_covered, parse_direction, parse_start};
use crate::images::{FieldOfView, Telescope};
use crate::passes::{Exposure, Field, Sky};
use crate::photometry::{Band, Earthshine, MagSystem, PhotometryOptions};
use crate::schedule::{Blocking, FlagRequest, MagnitudeLimit, Policy, ScheduleOptions};

/// Largest number of points along one track.
pub const MOST_SAMPLES: usize = 100_000;

/// Field, telescope, policy and photometry for the verdicts of exposures.
#[derive(Clone, Debug)]
pub struct ObservationPlan {
    /// Field of view.
    pub field: Field,
    /// Telescope, if one is given.
    pub telescope: Option<Telescope>,
    /// Policy, with the limits of [`RulesConfig`](super::RulesConfig) set.
    pub policy: Policy,
    /// Band, magnitude system and light sources of the magnitudes.
    pub photometry: PhotometryOptions,
    /// Position angle of the field for exposures without one, radians.
    pub rotation_rad: f64,
}

impl ObservationPlan {
    /// Returns the request for verdicts on exposures of a sky.
    pub fn request<'a>(&'a self, sky: &'a Sky) -> FlagRequest<'a> {
        FlagRequest {
            sky,
            field: &self.field,
            policy: &self.policy,
            telescope: self.telescope.as_ref(),
            photometry: &self.photometry,
        }
    }
}

impl Config {
    /// Returns field, telescope, policy and photometry.
    ///
    /// # Errors
    /// Same as [`Config::field_of_view`], [`Config::telescope`], [`Config::policy`] and [`Config::photometry`]; or the
    /// rotation is out of range.
    pub fn observation(&self) -> Result<ObservationPlan, Error> {
        Ok(ObservationPlan {
            field: self.field_of_view()?,
            telescope: self.telescope()?,
            policy: self.policy()?,
            photometry: self.photometry()?,
            rotation_rad: self.rotation_rad()?,
        })
    }

    /// Returns the given field of view, or else that of the telescope.
    ///
    /// # Errors
    /// No field or more than one is given, or the field is invalid.
    pub fn field_of_view(&self) -> Result<Field, Error> {
        self.check_field()?;
        match (&self.fov, &self.field) {
            (Some(size), _) => Ok(match parse_size_deg("fov", size.as_str())? {
                (diameter_deg, None) => Field::circle(diameter_deg.to_radians())?,
                (width_deg, Some(height_deg)) => Field::rectangle_deg(width_deg, height_deg)?,
            }),
            (None, Some(NameOrTable::Name(path))) => parse_file("field", path, Field::from_json),
            (None, Some(NameOrTable::Table(table))) => field_of_table(table),
            (None, None) => match self.telescope()? {
                Some(telescope) => field_of_telescope(&telescope),
                None => Err(FIELD.missing()),
            },
        }
    }

    /// Returns the field of view as given, for the provenance.
    #[doc(hidden)]
    pub fn stated_field(&self) -> Value {
        match (&self.fov, &self.field) {
            (Some(size), _) if size.as_str().contains(['x', '×']) => json!({ "rectangle": size.as_str() }),
            (Some(diameter), _) => json!({ "circle": diameter.as_str() }),
            (None, Some(NameOrTable::Name(path))) => json!({ "file": path.display().to_string() }),
            (None, Some(NameOrTable::Table(table))) => json!(table),
            (None, None) => json!("of the telescope"),
        }
    }

    /// Returns the options of verdicts, for the provenance. `telescope` is its name.
    #[doc(hidden)]
    pub fn flag_options(&self, policy: &Policy, telescope: Option<&str>) -> Value {
        json!({
            "field": self.stated_field(),
            "default_rotation_deg": self.rotation.unwrap_or(0.0),
            "telescope": telescope,
            "policy": policy,
        })
    }

    pub(super) fn check_field(&self) -> Result<(), Error> {
        if self.fov.is_some() && self.field.is_some() {
            return Err(error::both("--fov", "--field"));
        }
        if let Some(size) = &self.fov {
            parse_size_deg("fov", size.as_str())?;
        }
        // A field file is checked when it is read.
        match &self.field {
            Some(NameOrTable::Table(table)) if !table.contains_key("file") => field_of_table(table).map(|_| ()),
            _ => Ok(()),
        }
    }

    /// Returns the telescope, with the given `bright_share`; `None` if none is given.
    ///
    /// # Errors
    /// The name is unknown, the file is invalid, or `bright_share` is out of range or given without a telescope.
    pub fn telescope(&self) -> Result<Option<Telescope>, Error> {
        let telescope = self.own_telescope()?;
        let Some(bright_share) = self.bright_share else { return Ok(telescope) };
        in_range("bright-share", bright_share, "", "0 to 100", |share| (0.0..=100.0).contains(&share))?;
        let what = "telescope for bright-share";
        let telescope = telescope.ok_or_else(|| Error::missing(what, "--telescope NAME"))?;
        Ok(Some(Telescope { bright_share, ..telescope }))
    }

    fn own_telescope(&self) -> Result<Option<Telescope>, Error> {
        Ok(match &self.telescope {
            None => None,
            Some(NameOrTable::Name(name)) if name.is_file() => {
                Some(Telescope::from_toml(&read_text("telescope", Path::new(&**name))?, name)?)
            }
            Some(NameOrTable::Name(name)) => Some(Telescope::by_name(name)?),
            Some(NameOrTable::Table(telescope)) => Some(telescope.as_ref().clone()),
        })
    }

    /// Returns the policy of the file or table. Limits given as flags or keys of the document override those in it.
    ///
    /// # Errors
    /// The file is invalid, a number is out of range, or the policy requires a telescope and none is given.
    pub fn policy(&self) -> Result<Policy, Error> {
        let mut policy = match &self.rules.policy {
            None => Policy::default(),
            Some(NameOrTable::Name(path)) => parse_file("policy", path, Policy::parse)?,
            Some(NameOrTable::Table(policy)) => policy.clone(),
        };
        self.check_limits()?;
        let RulesConfig { limit_mag, limit_surface_brightness, blocking, max_delay, .. } = &self.rules;
        policy.limit_mag = limit_mag.clone().or(policy.limit_mag);
        policy.limit_surface_brightness = limit_surface_brightness.clone().or(policy.limit_surface_brightness);
        policy.min_probability = self.min_probability.or(policy.min_probability);
        if let Some(blocking) = blocking {
            policy.blocking = blocking.parse()?;
        }
        if let Some(delay) = max_delay {
            policy.max_delay_s = Some(parse_duration_s("max-delay", delay.as_str())?);
        }
        policy.include_dark = self.is_in_orbit() && self.include_dark.unwrap_or(false);
        policy.validate()?;
        let needs_telescope = [
            (policy.max_cost_s.is_some(), "telescope for max_cost_s of the policy"),
            (policy.limit_surface_brightness.is_some(), "telescope for limit-surface-brightness"),
        ];
        for (_, what) in needs_telescope.into_iter().filter(|(is_given, _)| *is_given) {
            if self.telescope()?.is_none() {
                return Err(Error::missing(what, "--telescope NAME"));
            }
        }
        Ok(policy)
    }

    /// Returns the magnitude limit of the policy in the band of the magnitudes; `None` if there is no such limit.
    ///
    /// # Errors
    /// Same as [`Config::policy`] and [`Config::photometry`].
    pub fn limit_mag(&self) -> Result<Option<f64>, Error> {
        let band = self.photometry()?.band;
        Ok(self.policy()?.limit_mag.and_then(|limit| limit.limit_in(Some(band.name()))))
    }

    /// Returns a warning if the magnitude limits of the policy have no value for the band of the magnitudes.
    ///
    /// # Errors
    /// Same as [`Config::policy`] and [`Config::photometry`].
    pub fn limit_warnings(&self) -> Result<Vec<String>, Error> {
        let band = self.photometry()?.band;
        Ok(self.policy()?.band_warnings(&BTreeSet::from([Some(band.name())])))
    }

    /// Checks the limits that are given beside a policy.
    pub(super) fn check_limits(&self) -> Result<(), Error> {
        for limit in self.rules.limit_mag.iter().flat_map(MagnitudeLimit::numbers) {
            in_range("limit-mag", limit, "mag", "-30 to 40 mag", |limit| (-30.0..=40.0).contains(&limit))?;
        }
        for limit in self.rules.limit_surface_brightness.iter().flat_map(MagnitudeLimit::numbers) {
            let allowed = "-30 to 60 mag/arcsec2";
            in_range("limit-surface-brightness", limit, "mag/arcsec2", allowed, |limit| {
                (-30.0..=60.0).contains(&limit)
            })?;
        }
        if let Some(probability) = self.min_probability {
            in_range("min-probability", probability, "", "above 0, at most 1", |value| value > 0.0 && value <= 1.0)?;
        }
        Ok(())
    }

    /// Checks the values of a single exposure and of the search for later starts.
    pub(super) fn check_exposure(&self) -> Result<(), Error> {
        let ExposureConfig { start, duration, .. } = &self.exposure;
        if let Some(start) = start {
            // A flag may set another scale, which does not change the form.
            parse_start(start.as_str(), self.time_scale()?.or(Some(TimeScale::UTC)))?;
        }
        if let Some(duration) = duration {
            parse_exposure_s(duration.as_str())?;
        }
        if let Some(delay) = &self.rules.max_delay {
            parse_duration_s("max-delay", delay.as_str())?;
        }
        if let Some(blocking) = &self.rules.blocking {
            blocking.parse::<Blocking>()?;
        }
        self.pointing().map(|_| ())
    }

    /// Returns band (V if omitted), magnitude system and light sources of the magnitudes.
    ///
    /// # Errors
    /// The band or system is unknown, a response file is invalid or has no Vega magnitudes, or the extinction is out of
    /// range.
    pub fn photometry(&self) -> Result<PhotometryOptions, Error> {
        let band: Band = match &self.light.band {
            Some(path) if path.is_file() => Band::Response(read_response(Path::new(&**path))?),
            name => name.as_deref().unwrap_or("V").parse()?,
        };
        let system = self.light.mag_system.as_deref().map(str::parse).transpose()?.unwrap_or(band.usual_system());
        if matches!(band, Band::Response(_)) && system != MagSystem::Ab {
            return Err(Error::invalid("mag-system", "Vega with a response file as the band", "AB"));
        }
        let earthshine = if self.light.earthshine.unwrap_or(true) { Earthshine::Computed } else { Earthshine::Off };
        if let Some(extinction) = self.extinction {
            in_range("extinction", extinction, "mag", "0 to 5 mag", |extinction| (0.0..=5.0).contains(&extinction))?;
        }
        Ok(PhotometryOptions {
            earthshine,
            extinction_mag_per_airmass: self.extinction,
            sun_distance: self.sun_distance.unwrap_or(false),
            ..PhotometryOptions::in_band(band, system)
        })
    }

    /// Returns the number of points along each track, 0 if omitted.
    ///
    /// # Errors
    /// The number is larger than [`MOST_SAMPLES`].
    pub fn samples(&self) -> Result<usize, Error> {
        let samples = self.samples.unwrap_or(0);
        let too_many = || Error::invalid("samples", samples, "0 to 100000");
        if samples > MOST_SAMPLES { Err(too_many()) } else { Ok(samples) }
    }

    /// Returns the time scale of times without a scale.
    ///
    /// # Errors
    /// The scale is unknown.
    pub fn time_scale(&self) -> Result<Option<TimeScale>, Error> {
        self.given_time_scale().map(parse_time_scale).transpose()
    }

    /// Returns the name of the time scale from the flag, or else from the configuration file.
    pub fn given_time_scale(&self) -> Option<&str> {
        self.time_scale.as_deref().or(self.default_time_scale.as_deref())
    }

    pub(super) fn rotation_rad(&self) -> Result<f64, Error> {
        let degrees = self.rotation.unwrap_or(0.0);
        let degrees =
            in_range("rotation", degrees, "deg", "-360 to 360 deg", |angle| (-360.0..=360.0).contains(&angle))?;
        Ok(degrees.to_radians())
    }

    /// Returns the options for reading schedules.
    ///
    /// # Errors
    /// The scale is unknown, or the rotation is out of range.
    pub fn schedule_options(&self) -> Result<ScheduleOptions, Error> {
        Ok(ScheduleOptions {
            time_scale: self.time_scale.as_deref().map(parse_time_scale).transpose()?,
            default_time_scale: self.default_time_scale.as_deref().map(parse_time_scale).transpose()?,
            default_rotation_rad: self.rotation_rad()?,
        })
    }

    /// Returns the pointing: that of the named target, or right ascension and declination; `None` if neither is given.
    ///
    /// # Errors
    /// The name is unknown, an angle is invalid or out of range, one angle is missing, or both a target and angles are
    /// given.
    pub fn pointing(&self) -> Result<Option<Direction<Gcrs>>, Error> {
        let ExposureConfig { target, ra, dec, .. } = &self.exposure;
        Ok(match (target, ra, dec) {
            (None, None, None) => None,
            (Some(name), None, None) => Some(deep_sky_object(name)?),
            (None, Some(ra), Some(dec)) => Some(parse_direction(ra.as_str(), dec.as_str())?),
            (Some(_), ..) => return Err(error::both("--target", "--ra or --dec")),
            (None, Some(_), None) => {
                return Err(Error::missing("declination", "--dec ANGLE, for example -30.5 or -30d30m"));
            }
            (None, None, Some(_)) => {
                return Err(Error::missing("right ascension", "--ra ANGLE, for example 188.5 or 12h34m"));
            }
        })
    }

    /// Returns the single exposure of the configuration; its id is `1`.
    ///
    /// # Errors
    /// Start, exposure time, right ascension, declination or rotation is missing or out of range, or the start is
    /// outside the planetary ephemeris.
    pub fn one_exposure(&self) -> Result<Exposure, Error> {
        let start = self.exposure.start.as_ref().ok_or_else(|| START.missing())?;
        let duration = self.exposure.duration.as_ref().ok_or_else(|| EXPOSURE.missing())?;
        let start = parse_start(start.as_str(), self.time_scale()?)?;
        if !is_covered(start) {
            return Err(crate::passes::no_ephemeris(start.to_time_scale(TimeScale::UTC)));
        }
        Ok(Exposure {
            id: "1".to_owned(),
            start,
            duration_s: parse_exposure_s(duration.as_str())?,
            pointing: self.pointing()?.ok_or_else(|| POINTING.missing())?,
            rotation_rad: self.rotation_rad()?,
        })
    }
}

/// Returns the field of a table with the key of one shape, the key `file`, or the key `shapes` as in a field file.
fn field_of_table(table: &toml::Table) -> Result<Field, Error> {
    if let Some(path) = table.get("file").and_then(toml::Value::as_str).filter(|_| table.len() == 1) {
        return parse_file("field", Path::new(path), Field::from_json);
    }
    Field::from_keys(if table.contains_key("shapes") { json!(table) } else { json!({ "shapes": [table] }) })
}

fn field_of_telescope(telescope: &Telescope) -> Result<Field, Error> {
    Ok(match &telescope.field {
        FieldOfView::CircleDeg(diameter) => Field::circle(diameter.to_radians())?,
        FieldOfView::RectangleDeg([width, height]) => Field::rectangle_deg(*width, *height)?,
        FieldOfView::PolygonDeg(corners) => Field::polygon_deg(corners)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(text: &str) -> Config {
        Config::from_toml(text, "t.toml").unwrap()
    }

    fn message<T: std::fmt::Debug>(result: Result<T, Error>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn fields_of_a_circle_and_a_rectangle() {
        let size = |text: &str| config(&format!("fov = '{text}'")).field_of_view();
        let rectangle = Field::rectangle_deg(1.5, 1.0).unwrap();
        for text in ["1.5x1.0deg", "1.5degx1deg", "90 x 60 arcmin", "90arcmin×1deg"] {
            assert_eq!(size(text).unwrap(), rectangle, "{text}");
        }
        assert_eq!(size("3.5deg").unwrap(), Field::circle(3.5_f64.to_radians()).unwrap());
        // A sensor covers the angle arctan(d / 2f) on each side of the axis: 19.799 and 13.496 deg for 36 mm by 24 mm
        // at 50 mm, 45 deg for a circular sensor with a diameter of twice the focal length.
        let is_inside = |field: &Field, [x_deg, y_deg]: [f64; 2]| {
            let pointing = Direction::from_lon_lat_rad(1.0, 0.0);
            let direction = Direction::from_lon_lat_rad(1.0 + x_deg.to_radians(), y_deg.to_radians());
            field.on_sky(&pointing, 0.0).contains(&direction)
        };
        for text in ["36x24mm@50mm", "3.6cmx24mm @ 0.05m"] {
            let field = size(text).unwrap();
            let inside = [[19.79, 0.0], [-19.79, 0.0], [0.0, 13.49]].map(|place| is_inside(&field, place));
            let outside = [[19.81, 0.0], [-19.81, 0.0], [0.0, 13.51]].map(|place| is_inside(&field, place));
            assert_eq!((inside, outside), ([true; 3], [false; 3]), "{text}");
        }
        assert_eq!([44.99, 45.01].map(|x_deg| is_inside(&size("100mm@50mm").unwrap(), [x_deg, 0.0])), [true, false]);
        for text in
            ["1.5x1.0", "1.5x-1deg", "x1deg", "1x2x3deg", "36x24@400mm", "36x24mm@0mm", "36x24mm@400", "3deg@1m"]
        {
            assert!(message(size(text)).contains("fov"), "{text}");
        }
        let of_part = message(size("1deg@530"));
        assert!(of_part.starts_with("fov '1deg@530': fov is 530, without a unit; allowed"), "{of_part}");
    }

    #[test]
    fn limits_given_apart_override_the_policy() {
        let policy =
            config("limit_mag = 6\nmax_delay = '2min'\n[policy]\nlimit_mag = 7\nmargin_s = 3").policy().unwrap();
        assert_eq!(
            (policy.limit_mag.unwrap().limit_in(None), policy.margin_s, policy.max_delay_s),
            (Some(6.0), Some(3.0), Some(120.0))
        );
        assert!(message(config("min_probability = 2").policy()).contains("min-probability is 2; allowed: "));
        let cost = "[policy]\nmax_cost_s = 1";
        assert!(message(config(cost).policy()).contains("missing telescope for max_cost_s"));
        let surface = "limit_surface_brightness = 22";
        assert!(message(config(surface).policy()).contains("missing telescope for limit-surface-brightness"));
        let policy = config("limit_surface_brightness = { W1 = 20 }\ntelescope = 'small'").policy().unwrap();
        assert_eq!(policy.limit_surface_brightness.unwrap().limit_in(Some("W1")), Some(20.0));
        assert!(config(&format!("telescope = 'rubin'\n{cost}")).policy().is_ok());
    }

    #[test]
    fn a_bright_share_replaces_that_of_the_telescope() {
        let share = |text: &str| config(text).telescope().map(|telescope| telescope.unwrap().bright_share);
        assert_eq!(share("telescope = 'rubin'").unwrap(), 0.08);
        assert_eq!(share("telescope = 'rubin'\nbright_share = 0.3").unwrap(), 0.3);
        assert!(
            message(share("telescope = 'rubin'\nbright_share = -1")).contains("bright-share is -1; allowed: 0 to 100")
        );
        assert!(message(config("bright_share = 0.3").telescope()).contains("missing telescope for bright-share"));
    }

    #[test]
    fn an_exposure_needs_all_its_parts() {
        let all = ["start = '2024-08-14T00:30:00Z'", "exposure = '30s'", "ra = '12h34m'", "dec = -30.5"];
        let exposure = config(&all.join("\n")).one_exposure().unwrap();
        assert!((exposure.pointing.longitude_rad().to_degrees() - 188.5).abs() < 1e-9);
        assert!((exposure.pointing.latitude_rad().to_degrees() + 30.5).abs() < 1e-9);
        for missing in 0..4 {
            let rest: Vec<&str> = (0..4).filter(|&index| index != missing).map(|index| all[index]).collect();
            let message = message(config(&rest.join("\n")).one_exposure());
            assert!(message.starts_with("missing ") && message.contains("; specify --"), "{message}");
        }
        let early = all.join("\n").replace("2024", "1924");
        assert!(message(config(&early).one_exposure()).contains("1957 to 2099"));
    }

    #[test]
    fn bands_come_with_their_usual_system() {
        let system = |text: &str| config(text).photometry().unwrap().system.to_string();
        assert_eq!(
            (system("").as_str(), system("band = 'g'").as_str(), system("band = 'g'\nmag_system = 'vega'").as_str()),
            ("Vega", "AB", "Vega")
        );
        assert!(config("band = 'q'").photometry().is_err());
        let earthshine = |text: &str| config(text).photometry().unwrap().earthshine;
        assert_eq!(
            [earthshine(""), earthshine("earthshine = true"), earthshine("earthshine = false")],
            [Earthshine::Computed, Earthshine::Computed, Earthshine::Off]
        );
    }

    #[test]
    fn fields_by_diameter_table_and_telescope() {
        let area = |text: &str| config(text).field_of_view().unwrap().area_deg2();
        assert!((area("fov = '2deg'") - std::f64::consts::PI).abs() < 1e-3);
        assert!((area("[field]\nrectangle_deg = [2.0, 1.0]") - 2.0).abs() < 1e-9);
        assert!(
            (area("[field]\nshapes = [{circle_deg = 2.0}, {circle_deg = 2.0, center_deg = [3.0, 0.0]}]") - 6.282).abs()
                < 2e-3
        );
        assert!((area("telescope = 'rubin'") - 9.62).abs() < 0.01);
        assert!((area("telescope = 'rubin'\nfov = '2deg'") - std::f64::consts::PI).abs() < 1e-3);
        assert!(message(config("").field_of_view()).contains("missing field of view; specify --fov ANGLE"));
        assert!(message(config("fov = 3.5").field_of_view()).contains("without a unit"));
    }
}

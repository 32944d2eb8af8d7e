//! From what was said to what it means: site, field, telescope, policy, elements, times.

use std::path::Path;

use hifitime::{Epoch, TimeScale};

use crate::catalogue::{Catalogue, Constellation, ElementSet, Keep, ReadOptions};
use crate::frames::{Direction, EopTable, Orientation, parse_declination_deg, parse_right_ascension_deg};
use crate::geometry::{EarthLimb, GeometryError, Observer, ShadowModel, Site};
use crate::orbit::Propagator;
use crate::passes::{Exposure, Field, OrbitingObserver, SkyError, Viewpoint};
use crate::photometry::{Band, Earthshine, PhotometryOptions};
use crate::schedule::{Policy, PolicyError, ScheduleOptions, is_covered};
use crate::telescope::{FieldOfView, Telescope};

use super::choices::{
    FieldSetup, OneOrMany, PolicySetup, Quantity, SiteSetup, SiteTable, TelescopeSetup, is_file_name,
};
use super::document::Setup;
use super::error::SetupError;
use super::units::{in_range, parse_angle_deg, parse_duration_s, parse_moment, parse_time_scale};

/// Beyond this age, either way, element sets draw a warning, days.
pub const OLD_ELEMENTS_DAYS: f64 = 14.0;

/// The most points along one track.
pub const MOST_SAMPLES: usize = 100_000;

const SITES: &str = "--site NAME, --mpc CODE, or --lat, --lon and --height";
const FIELDS: &str = "--fov 3.5deg, --field FILE, or a telescope with --telescope";

/// The text of a file, with what it is for in the error.
pub(super) fn read_text(what: &'static str, path: &Path) -> Result<String, SetupError> {
    let error = |source| SetupError::Io { what, path: path.display().to_string(), source };
    if path.is_dir() {
        return Err(error(std::io::Error::new(std::io::ErrorKind::IsADirectory, "is a directory; a file is needed")));
    }
    std::fs::read_to_string(path).map_err(error)
}

impl Setup {
    /// The site.
    ///
    /// # Errors
    /// None was said, two were, it is not known, or a coordinate is out of range.
    pub fn site(&self) -> Result<Site, SetupError> {
        let flags = SiteTable {
            name: None,
            mpc: self.mpc.clone(),
            latitude_deg: self.lat,
            longitude_deg: self.lon,
            height_m: self.height,
        };
        for (what, value, unit, allowed, range) in [
            ("lat", self.lat, "deg", "-90 to 90 deg", -90.0..=90.0),
            ("lon", self.lon, "deg", "-180 to 360 deg", -180.0..=360.0),
            ("height", self.height, "m", "-11000 to 100000 m", -11_000.0..=100_000.0),
        ] {
            if let Some(value) = value {
                in_range(what, value, unit, allowed, |value| range.contains(&value))?;
            }
        }
        let has_flags = flags != SiteTable::default();
        match &self.site {
            Some(_) if has_flags => Err(SetupError::Both { first: "--site", second: "--mpc, --lat, --lon, --height" }),
            Some(SiteSetup::Name(name)) => site_of_name(name),
            Some(SiteSetup::Table(table)) => site_of(table),
            None => site_of(&flags),
        }
    }

    /// Where the telescope is for questions about `moment`: a site, or an orbit.
    ///
    /// # Errors
    /// As [`Setup::site`]; a site and an orbit were said; the telescope is below its limb height at `moment`; the file holds no element set, several objects, or not the one asked for.
    pub fn viewpoint(&self, moment: Epoch) -> Result<Viewpoint, SetupError> {
        let (orbit, limb) = (self.observer_elements.is_some() || self.observer_norad.is_some(), self.limb_height_km);
        let site = [&self.lat, &self.lon, &self.height].iter().any(|number| number.is_some());
        match (orbit, site || self.site.is_some() || self.mpc.is_some()) {
            (true, true) => Err(SetupError::Both {
                first: "--observer-elements, --observer-norad",
                second: "--site, --mpc, --lat, --lon, --height",
            }),
            (false, _) if limb.is_some() => Err(SetupError::Missing {
                what: "telescope in orbit for the limb-height-km",
                allowed: "--observer-elements FILE or --observer-norad ID",
            }),
            (false, _) => Ok(Observer::new(self.site()?).into()),
            (true, false) => {
                let height_km = limb.unwrap_or(0.0);
                in_range("limb-height-km", height_km, "km", "0 to 1000 km", |value| (0.0..=1000.0).contains(&value))?;
                let elements = self.observer_set(moment)?;
                let limb = EarthLimb { height_km };
                let observer = OrbitingObserver::new(&elements, limb).map_err(SetupError::Observer)?;
                let orientation = Orientation::at(moment, &self.eop_table()?);
                let place = Propagator::new(&elements).and_then(|orbit| orbit.state(moment, &orientation.teme_to_gcrs));
                // Where the orbit itself breaks down, each exposure says so.
                let at_km = place.map_or(f64::INFINITY, |state| limb.height_of_km(&state.position));
                if at_km < height_km {
                    return Err(SetupError::BelowLimb { name: observer.name(), at_km, height_km });
                }
                Ok(observer.into())
            }
        }
    }

    /// The element set of the telescope in orbit that is nearest to a moment.
    fn observer_set(&self, moment: Epoch) -> Result<ElementSet, SetupError> {
        let catalogue = match &self.observer_elements {
            Some(path) => Some(Catalogue::read(std::slice::from_ref(path), &self.read_options(moment))?),
            None => self.catalogue(moment)?,
        };
        let missing =
            SetupError::Missing { what: "elements of the telescope in orbit", allowed: "--observer-elements FILE" };
        let mut sets = catalogue.ok_or(missing)?.element_sets;
        if let Some(id) = self.observer_norad {
            let count = sets.len();
            sets.retain(|set| set.norad_id.0 == id);
            if sets.is_empty() {
                return Err(SetupError::NoObserver { id, count });
            }
        }
        let count = sets.len();
        let first = sets.swap_remove(0);
        if count > 1 { Err(SetupError::SeveralObservers { count, first: first.norad_id.0 }) } else { Ok(first) }
    }

    /// What casts the Earth's shadow; the solid Earth where nothing was said.
    ///
    /// # Errors
    /// A model that is not known.
    pub fn shadow(&self) -> Result<ShadowModel, SetupError> {
        let Some(name) = &self.shadow else { return Ok(ShadowModel::default()) };
        ShadowModel::by_name(name).ok_or_else(|| SetupError::Value {
            what: "shadow",
            given: name.clone(),
            allowed: "geometric, atmosphere",
        })
    }

    /// The field of view: as said, else that of the telescope.
    ///
    /// # Errors
    /// None was said, two were, or it is no field.
    pub fn field_of_view(&self) -> Result<Field, SetupError> {
        match (&self.fov, &self.field) {
            (Some(_), Some(_)) => Err(SetupError::Both { first: "--fov", second: "--field" }),
            (Some(diameter), None) => Ok(Field::circle(parse_angle_deg("fov", &diameter.text())?.to_radians())?),
            (None, Some(FieldSetup::File(path))) => Ok(Field::from_json(&read_text("field", path)?)?),
            (None, Some(FieldSetup::Table(table))) => field_of_table(table),
            (None, None) => match self.telescope()? {
                Some(telescope) => field_of_telescope(&telescope),
                None => Err(SetupError::Missing { what: "field of view", allowed: FIELDS }),
            },
        }
    }

    /// The telescope, where one was said.
    ///
    /// # Errors
    /// It is not known, or its file is none.
    pub fn telescope(&self) -> Result<Option<Telescope>, SetupError> {
        Ok(match &self.telescope {
            None => None,
            Some(TelescopeSetup::Name(name)) if is_file_name(name) => {
                Some(Telescope::from_toml(&read_text("telescope", Path::new(name))?, name)?)
            }
            Some(TelescopeSetup::Name(name)) => Some(Telescope::by_name(name)?),
            Some(TelescopeSetup::Table(telescope)) => Some(telescope.as_ref().clone()),
        })
    }

    /// The policy: a file or table, and over it the limits that were said by themselves.
    ///
    /// # Errors
    /// The file is no policy, or a number is out of range.
    pub fn policy(&self) -> Result<Policy, SetupError> {
        let mut policy = match &self.policy {
            None => Policy::default(),
            Some(PolicySetup::File(path)) => policy_of_file(path)?,
            Some(PolicySetup::Table(policy)) => policy.clone(),
        };
        if let Some(limit) = &self.limit_mag {
            for limit in limit.numbers() {
                in_range("limit-mag", limit, "mag", "-30 to 40 mag", |limit| (-30.0..=40.0).contains(&limit))?;
            }
            policy.limit_mag = Some(limit.clone());
        }
        if let Some(probability) = self.min_probability {
            in_range("min-probability", probability, "", "above 0, at most 1", |value| value > 0.0 && value <= 1.0)?;
        }
        policy.min_probability = self.min_probability.or(policy.min_probability);
        if let Some(delay) = &self.max_delay {
            policy.max_delay_s = Some(parse_duration_s("max-delay", &delay.text())?);
        }
        policy.validate()?;
        if policy.max_lost_fraction.is_some() && self.telescope()?.is_none() {
            let what = "telescope, without whose pixels nothing can be said of the policy's max_lost_fraction";
            return Err(SetupError::Missing { what, allowed: "--telescope NAME" });
        }
        if policy.limit_of_telescope().is_some() {
            let what = "telescope, whose limits the policy asks for (saturation_mag or crosstalk_mag = \"telescope\")";
            let telescope = self.telescope()?.ok_or(SetupError::Missing { what, allowed: "--telescope NAME" })?;
            let mut limits = policy.limits_of_telescope(&telescope).into_iter();
            if let Some((key, _)) = limits.find(|(_, limit)| limit.numbers().is_empty()) {
                return Err(SetupError::NoCameraLimit { key, telescope: telescope.name });
            }
        }
        Ok(policy)
    }

    /// Band and zero point of the magnitudes, and whether the Earth shines on satellites; V (Vega) and yes where nothing
    /// was said.
    ///
    /// # Errors
    /// A band or system that is not known.
    pub fn photometry(&self) -> Result<PhotometryOptions, SetupError> {
        let band: Band = self.band.as_deref().unwrap_or("V").parse()?;
        let system = self.mag_system.as_deref().map(str::parse).transpose()?.unwrap_or(band.usual_system());
        let earthshine = if self.earthshine.unwrap_or(true) { Earthshine::Computed } else { Earthshine::Off };
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

    /// Points along each track; 0 where nothing was said.
    ///
    /// # Errors
    /// More than [`MOST_SAMPLES`].
    pub fn samples(&self) -> Result<usize, SetupError> {
        let samples = self.samples.unwrap_or(0);
        let too_many =
            || SetupError::OutOfRange { what: "samples", given: samples.to_string(), allowed: "0 to 100000" };
        if samples > MOST_SAMPLES { Err(too_many()) } else { Ok(samples) }
    }

    /// The scale of times that name none.
    ///
    /// # Errors
    /// A scale that is not known.
    pub fn time_scale(&self) -> Result<Option<TimeScale>, SetupError> {
        self.said_time_scale().map(parse_time_scale).transpose()
    }

    /// The scale as it was said: by a flag, else by the configuration file.
    pub fn said_time_scale(&self) -> Option<&str> {
        self.time_scale.as_deref().or(self.default_time_scale.as_deref())
    }

    /// Position angle of the field where no exposure says its own, radians.
    fn rotation_rad(&self) -> Result<f64, SetupError> {
        let degrees = self.rotation.unwrap_or(0.0);
        let degrees =
            in_range("rotation", degrees, "deg", "-360 to 360 deg", |angle| (-360.0..=360.0).contains(&angle))?;
        Ok(degrees.to_radians())
    }

    /// How schedules are to be read.
    ///
    /// # Errors
    /// A scale that is not known, or a rotation out of range.
    pub fn schedule_options(&self) -> Result<ScheduleOptions, SetupError> {
        Ok(ScheduleOptions {
            time_scale: self.time_scale.as_deref().map(parse_time_scale).transpose()?,
            default_time_scale: self.default_time_scale.as_deref().map(parse_time_scale).transpose()?,
            default_rotation_rad: self.rotation_rad()?,
        })
    }

    /// The table of the Earth's orientation: the file said, else UT1 from the bundled one.
    ///
    /// Without a file the pole stays at its origin, as in Skyfield: places that people have from elsewhere are good to that, and it
    /// moves an observer by 18 m at most, where an element set errs by a kilometre. The provenance says so.
    ///
    /// # Errors
    /// The file cannot be read or is none.
    pub fn eop_table(&self) -> Result<EopTable, SetupError> {
        match &self.eop {
            Some(path) => Ok(EopTable::from_finals2000a(&read_text("Earth orientation", path)?)?),
            None => Ok(EopTable::embedded().without_polar_motion()),
        }
    }

    /// The one exposure that was said, called `1`.
    ///
    /// # Errors
    /// Start, length, right ascension or declination is missing or out of range, or the rotation is; the start lies where no ephemeris reaches.
    pub fn one_exposure(&self) -> Result<Exposure, SetupError> {
        let said = |value: &Option<Quantity>, what, allowed| {
            value.as_ref().map(Quantity::text).ok_or(SetupError::Missing { what, allowed })
        };
        let start = said(&self.start, "start of the exposure", "--start 2024-08-14T00:30:00.000Z")?;
        let duration = said(&self.exposure, "length of the exposure", "--exposure 30s")?;
        let right_ascension = said(&self.ra, "right ascension", "--ra 188.5 or --ra 12h34m")?;
        let declination = said(&self.dec, "declination", "--dec -30.5 or --dec -30d30m")?;
        let start = parse_moment(&start, self.time_scale()?)?;
        if !is_covered(start) {
            return Err(SkyError::NoEphemeris { epoch: start.to_time_scale(TimeScale::UTC) }.into());
        }
        Ok(Exposure {
            id: "1".to_owned(),
            start,
            duration_s: parse_duration_s("exposure", &duration)?,
            pointing: Direction::from_lon_lat_rad(
                parse_right_ascension_deg(&right_ascension)?.to_radians(),
                parse_declination_deg(&declination)?.to_radians(),
            ),
            rotation_rad: self.rotation_rad()?,
        })
    }

    /// The files of element sets, each object with the set nearest to `moment`; `None` where no file was said.
    ///
    /// # Errors
    /// A file that cannot be read or holds none.
    pub fn catalogue(&self, moment: Epoch) -> Result<Option<Catalogue>, SetupError> {
        let Some(paths) = self.elements.as_ref().map(OneOrMany::as_slice).filter(|paths| !paths.is_empty()) else {
            return Ok(None);
        };
        Ok(Some(Catalogue::read(paths, &self.read_options(moment))?))
    }

    fn read_options(&self, moment: Epoch) -> ReadOptions {
        ReadOptions { accept_bad_checksums: self.accept_bad_checksums.unwrap_or(false), keep: Keep::Nearest(moment) }
    }

    /// The synthetic constellations that were said.
    ///
    /// # Errors
    /// A name that is not known, or a file that is none.
    pub fn constellations(&self) -> Result<Vec<Constellation>, SetupError> {
        let mut all = Vec::new();
        for name in self.shells.as_ref().map_or(&[][..], OneOrMany::as_slice) {
            if is_file_name(name) {
                all.extend(Constellation::from_toml(&read_text("shells", Path::new(name))?)?);
            } else {
                all.push(Constellation::by_name(name)?);
            }
        }
        Ok(all)
    }
}

/// The element sets of several constellations for one epoch.
pub(super) fn synthetic(constellations: &[Constellation], epoch: Epoch) -> Vec<ElementSet> {
    constellations.iter().flat_map(|constellation| constellation.element_sets(epoch)).collect()
}

/// The policy of a file. What its syntax lacks is told as the parser tells it, which names the keys allowed once.
fn policy_of_file(path: &Path) -> Result<Policy, SetupError> {
    Policy::from_toml(&read_text("policy", path)?).map_err(|error| {
        let message = match error {
            PolicyError::Syntax(what) => what,
            PolicyError::Limit { .. } | PolicyError::Twice { .. } => error.to_string(),
            PolicyError::OutOfRange { field, value, allowed } => format!("{field} is {value}, allowed {allowed}"),
        };
        SetupError::PolicyFile { path: path.display().to_string(), message }
    })
}

/// By name; where nothing is near it, the error shows other ways.
fn site_of_name(name: &str) -> Result<Site, SetupError> {
    Site::by_name(name).map_err(|error| match error {
        GeometryError::UnknownSite { name, nearest } if nearest.is_empty() => SetupError::UnknownSite(name),
        error => error.into(),
    })
}

fn site_of(table: &SiteTable) -> Result<Site, SetupError> {
    match (&table.mpc, table.latitude_deg, table.longitude_deg) {
        (Some(_), Some(_), _) | (Some(_), _, Some(_)) => {
            Err(SetupError::Both { first: "an MPC code", second: "coordinates" })
        }
        (Some(code), None, None) => Ok(Site::by_mpc_code(code)?),
        (None, Some(latitude), Some(longitude)) => {
            let name = table.name.as_deref().unwrap_or("site");
            Ok(Site::new_deg(name, latitude, longitude, table.height_m.unwrap_or(0.0))?)
        }
        (None, None, None) => match &table.name {
            Some(name) => site_of_name(name),
            None => Err(SetupError::Missing { what: "site", allowed: SITES }),
        },
        (None, _, _) => Err(SetupError::Missing { what: "complete coordinates of the site", allowed: SITES }),
    }
}

/// A table of one shape by its own key, or of shapes as in a field file.
fn field_of_table(table: &toml::Table) -> Result<Field, SetupError> {
    let text = serde_json::to_string(table).unwrap_or_default();
    if table.contains_key("shapes") {
        return Ok(Field::from_json(&text)?);
    }
    if let Some(path) = table.get("file").and_then(toml::Value::as_str).filter(|_| table.len() == 1) {
        return Ok(Field::from_json(&read_text("field", Path::new(path))?)?);
    }
    Ok(Field::from_json(&format!("{{\"shapes\": [{text}]}}"))?)
}

fn field_of_telescope(telescope: &Telescope) -> Result<Field, SetupError> {
    Ok(match &telescope.field {
        FieldOfView::CircleDeg(diameter) => Field::circle(diameter.to_radians())?,
        FieldOfView::RectangleDeg([width, height]) => Field::rectangle_deg(*width, *height)?,
        FieldOfView::PolygonDeg(corners) => Field::polygon_deg(corners)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(text: &str) -> Setup {
        Setup::from_toml(text, "t.toml").unwrap()
    }

    fn message<T: std::fmt::Debug>(answer: Result<T, SetupError>) -> String {
        answer.unwrap_err().to_string()
    }

    #[test]
    fn sites_by_name_code_and_numbers() {
        assert_eq!(setup("site = 'Rubin Observatory'").site().unwrap().mpc_code.as_deref(), Some("X05"));
        assert_eq!(setup("[site]\nmpc = 'X05'").site().unwrap().mpc_code.as_deref(), Some("X05"));
        assert!((setup("lat = -30.5\nlon = -70\nheight = 2000").site().unwrap().height_m - 2000.0).abs() < 1e-9);
        assert!(message(setup("").site()).contains("say --site NAME, --mpc CODE"));
        assert!(message(setup("lat = 3").site()).contains("complete coordinates"));
        assert!(message(setup("mpc = 'X05'\nlat = 3").site()).contains("exclude each other"));
        assert!(
            message(setup("site = 'Nowhere at all'").site()).contains("streakcast sites lists them, --lat, --lon and")
        );
    }

    #[test]
    fn fields_by_diameter_table_and_telescope() {
        let area = |text: &str| setup(text).field_of_view().unwrap().area_deg2();
        assert!((area("fov = '2deg'") - std::f64::consts::PI).abs() < 1e-3);
        assert!((area("[field]\nrectangle_deg = [2.0, 1.0]") - 2.0).abs() < 1e-9);
        assert!(
            (area("[field]\nshapes = [{circle_deg = 2.0}, {circle_deg = 2.0, center_deg = [3.0, 0.0]}]") - 6.282).abs()
                < 2e-3
        );
        assert!((area("telescope = 'rubin'") - 9.62).abs() < 0.01);
        assert!((area("telescope = 'rubin'\nfov = '2deg'") - std::f64::consts::PI).abs() < 1e-3);
        assert!(message(setup("").field_of_view()).contains("no field of view; say --fov 3.5deg"));
        assert!(message(setup("fov = 3.5").field_of_view()).contains("has no unit"));
    }

    #[test]
    fn limits_said_by_themselves_lie_over_the_policy() {
        let policy =
            setup("limit_mag = 6\nmax_delay = '2min'\n[policy]\nlimit_mag = 7\nmargin_s = 3").policy().unwrap();
        assert_eq!(
            (policy.limit_mag.unwrap().of(None), policy.margin_s, policy.max_delay_s),
            (Some(6.0), Some(3.0), Some(120.0))
        );
        assert!(message(setup("min_probability = 2").policy()).contains("min-probability 2: allowed"));
        let camera = "[policy]\ncrosstalk_mag = 'telescope'";
        assert!(message(setup(camera).policy()).contains("no telescope, whose limits"));
        assert!(setup(&format!("telescope = 'rubin'\n{camera}")).policy().is_ok());
    }

    #[test]
    fn an_exposure_needs_all_its_parts() {
        let all = ["start = '2024-08-14T00:30:00Z'", "exposure = '30s'", "ra = '12h34m'", "dec = -30.5"];
        let exposure = setup(&all.join("\n")).one_exposure().unwrap();
        assert!((exposure.pointing.longitude_rad().to_degrees() - 188.5).abs() < 1e-9);
        assert!((exposure.pointing.latitude_rad().to_degrees() + 30.5).abs() < 1e-9);
        for missing in 0..4 {
            let rest: Vec<&str> = (0..4).filter(|&index| index != missing).map(|index| all[index]).collect();
            let message = message(setup(&rest.join("\n")).one_exposure());
            assert!(message.starts_with("no ") && message.contains("; say --"), "{message}");
        }
        let early = all.join("\n").replace("2024", "1924");
        assert!(message(setup(&early).one_exposure()).contains("1957 to 2099"));
    }

    #[test]
    fn bands_come_with_their_usual_system() {
        let system = |text: &str| setup(text).photometry().unwrap().system.to_string();
        assert_eq!(
            (system("").as_str(), system("band = 'g'").as_str(), system("band = 'g'\nmag_system = 'vega'").as_str()),
            ("Vega", "AB", "Vega")
        );
        assert!(setup("band = 'q'").photometry().is_err());
        let earthshine = |text: &str| setup(text).photometry().unwrap().earthshine;
        assert_eq!(
            [earthshine(""), earthshine("earthshine = true"), earthshine("earthshine = false")],
            [Earthshine::Computed, Earthshine::Computed, Earthshine::Off]
        );
    }
}

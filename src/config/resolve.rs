//! From what was said to what it means: shadow, policy, photometry, elements, times.

use std::path::Path;

use hifitime::{Epoch, TimeScale};

use crate::elements::{Catalogue, Constellation, ElementSet, Keep, ReadOptions};
use crate::frames::{Direction, EopTable, parse_declination_deg, parse_right_ascension_deg};
use crate::geometry::ShadowModel;
use crate::passes::{Exposure, SkyError};
use crate::photometry::{Band, Earthshine, PhotometryOptions};
use crate::schedule::{Policy, PolicyError, ScheduleOptions, is_covered};

use super::choices::{OneOrMany, PolicySetup, Quantity, is_file_name};
use super::document::Setup;
use super::error::SetupError;
use super::units::{in_range, parse_duration_s, parse_moment, parse_time_scale};

/// Beyond this age, either way, element sets draw a warning, days.
pub const OLD_ELEMENTS_DAYS: f64 = 14.0;

/// The most points along one track.
pub const MOST_SAMPLES: usize = 100_000;

/// The text of a file, with what it is for in the error.
pub(super) fn read_text(what: &'static str, path: &Path) -> Result<String, SetupError> {
    let error = |source| SetupError::Io { what, path: path.display().to_string(), source };
    if path.is_dir() {
        return Err(error(std::io::Error::new(std::io::ErrorKind::IsADirectory, "is a directory; a file is needed")));
    }
    std::fs::read_to_string(path).map_err(error)
}

impl Setup {
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
        self.read_elements(&self.read_options(moment))
    }

    /// The files of element sets with every set of every object; `None` where no file was said.
    pub(super) fn whole_catalogue(&self) -> Result<Option<Catalogue>, SetupError> {
        let accept_bad_checksums = self.accept_bad_checksums.unwrap_or(false);
        self.read_elements(&ReadOptions { accept_bad_checksums, keep: Keep::All })
    }

    fn read_elements(&self, options: &ReadOptions) -> Result<Option<Catalogue>, SetupError> {
        let Some(paths) = self.elements.as_ref().map(OneOrMany::as_slice).filter(|paths| !paths.is_empty()) else {
            return Ok(None);
        };
        Ok(Some(Catalogue::read(paths, options)?))
    }

    pub(super) fn read_options(&self, moment: Epoch) -> ReadOptions {
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

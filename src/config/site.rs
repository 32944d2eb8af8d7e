//! Observer of a configuration: a site by name, code or coordinates, or a telescope in orbit.

use std::sync::Arc;

use hifitime::Epoch;

use super::document::{Config, SiteConfig};
use super::error;
use super::required::{RequiredInput, SITE};
use super::values::{NameOrTable, SiteTable, in_range};
use crate::elements::{EphemerisObject, Keep, NoradId, Satellites};
use crate::error::{Error, ErrorKind};
use crate::frames::{EopTable, Orientation};
use crate::geometry::{EarthLimb, Observer, PointingLimits, Site};
#[cfg(all(feature = "fits", unix))]
use crate::images::{HeaderSite, SITE_KEYWORDS, UNNAMED_SITE};
use crate::passes::{OrbitingObserver, Viewpoint};

impl Config {
    /// Returns the site.
    ///
    /// # Errors
    /// No site or more than one is given, the site is unknown, or a coordinate is out of range.
    pub fn site(&self) -> Result<Site, Error> {
        self.check_viewpoint()?;
        let SiteConfig { named, mpc, lat, lon, height } = &self.site;
        match named {
            Some(NameOrTable::Name(name)) => site_of_name(name),
            Some(NameOrTable::Table(table)) => site_of(table),
            None => site_of(&SiteTable {
                name: None,
                mpc: mpc.clone(),
                latitude_deg: *lat,
                longitude_deg: *lon,
                height_m: *height,
            }),
        }
    }

    /// Checks that the keys of site and telescope in orbit do not exclude each other, and that numbers are in range.
    pub(super) fn check_viewpoint(&self) -> Result<(), Error> {
        let SiteConfig { named, mpc, lat, lon, height } = &self.site;
        for (what, value, unit, allowed, range) in [
            ("lat", lat, "deg", "-90 to 90 deg", -90.0..=90.0),
            ("lon", lon, "deg", "-180 to 360 deg", -180.0..=360.0),
            ("height", height, "m", "-11000 to 100000 m", -11_000.0..=100_000.0),
            ("limb-height-km", &self.limb_height_km, "km", "0 to 1000 km", 0.0..=1000.0),
            ("max-zenith-angle", &self.max_zenith_angle, "deg", "0 to 180 deg", 0.0..=180.0),
            ("min-sun-angle", &self.min_sun_angle, "deg", "0 to 180 deg", 0.0..=180.0),
            ("min-limb-angle", &self.min_limb_angle, "deg", "0 to 180 deg", 0.0..=180.0),
        ] {
            if let Some(value) = value {
                in_range(what, *value, unit, allowed, |value| range.contains(&value))?;
            }
        }
        let has_numbers = mpc.is_some() || lat.is_some() || lon.is_some() || height.is_some();
        if named.is_some() && has_numbers {
            return Err(error::both("--site", "--mpc, --lat, --lon, --height"));
        }
        match (self.is_in_orbit(), self.site.is_given()) {
            (true, true) => {
                Err(error::both("--observer-elements, --observer-norad", "--site, --mpc, --lat, --lon, --height"))
            }
            (false, _) if self.limb_height_km.is_some() => Err(Error::missing(
                "telescope in orbit for --limb-height-km",
                "--observer-elements FILE or --observer-norad ID",
            )),
            // A configuration file may have limits for a telescope that another file or a flag gives.
            (false, true) => {
                let (keys, uses) = match (self.max_zenith_angle, self.min_sun_angle, self.min_limb_angle) {
                    (Some(_), ..) => ("--max-zenith-angle", "--min-altitude of windows and statistics"),
                    (_, Some(_), _) => ("--min-sun-angle", "--max-sun-altitude-deg of windows"),
                    (.., Some(_)) => ("--min-limb-angle", "--min-altitude of windows and statistics"),
                    _ => return Ok(()),
                };
                Err(Error::new(
                    ErrorKind::Invalid,
                    format!(
                        "{keys} is a limit of a telescope in orbit (--observer-elements), not of a site; allowed for a site: {uses}"
                    ),
                ))
            }
            _ => Ok(()),
        }
    }

    /// Returns the limits on the pointings of a telescope in orbit.
    fn pointing_limits(&self) -> PointingLimits {
        PointingLimits {
            max_zenith_angle_rad: self.max_zenith_angle.map(f64::to_radians),
            min_sun_angle_rad: self.min_sun_angle.map(f64::to_radians),
            min_limb_angle_rad: self.min_limb_angle.map(f64::to_radians),
        }
    }

    /// Returns the observer: a site, or a telescope in orbit with its ephemerides, or else with the element set closest
    /// to `moment`.
    ///
    /// # Errors
    /// Same as [`Config::site`]; or both a site and an orbit are given; or the telescope is below its limb height at
    /// `moment`; or the file has neither element sets nor ephemerides, has several objects and no number is given, or
    /// lacks the given number.
    pub fn viewpoint(&self, moment: Epoch) -> Result<Viewpoint, Error> {
        self.check_viewpoint()?;
        match self.is_in_orbit() {
            false => Ok(Observer::new(self.site()?).into()),
            true => {
                let height_km = self.limb_height_km.unwrap_or(0.0);
                let limb = EarthLimb { height_km };
                let eop = self.eop_table()?;
                let observer = self.observer(moment, &eop, limb)?.with_limits(self.pointing_limits());
                let position = observer.position(moment, &Orientation::at(moment, &eop));
                // If there is no position at this time, the error is reported later for each exposure.
                let at_km = position.map_or(f64::INFINITY, |position| limb.height_of_km(&position));
                if at_km < height_km {
                    return Err(Error::new(
                        ErrorKind::Invalid,
                        format!("{} is at {at_km:.0} km, below the limb height of {height_km} km", observer.name()),
                    )
                    .allowing("--limb-height-km below the orbit"));
                }
                Ok(observer.into())
            }
        }
    }

    /// Returns the longitude at which local noon separates nights, radians, east positive: that of the site, or 0 for a
    /// telescope in orbit or if `moment` is `None`.
    ///
    /// # Errors
    /// Same as [`Config::viewpoint`].
    pub fn viewpoint_longitude_rad(&self, moment: Option<Epoch>) -> Result<f64, Error> {
        let Some(moment) = moment else { return Ok(0.0) };
        Ok(self.viewpoint(moment)?.site().map_or(0.0, |observer| observer.site().longitude_rad))
    }

    /// Returns the configuration with the site of the header of `frames` set, and a message that states it. Without
    /// such a site, that of the home file remains. `unused` states coordinates that do not give the site.
    ///
    /// # Errors
    /// There is no site.
    #[cfg(all(feature = "fits", unix))]
    pub(super) fn at_site_of_header(
        &self,
        found: Option<&HeaderSite>,
        unused: Option<String>,
        frames: &str,
    ) -> Result<(Self, Option<String>), Error> {
        let Some(HeaderSite { site, remark }) = found else {
            if !self.has_viewpoint() {
                let flags = SITE.flags();
                let unused = unused.map(|unused| format!("; {unused}")).unwrap_or_default();
                return Err(Error::missing(
                    "site",
                    format!("{flags} (the header of {frames} lacks it: {SITE_KEYWORDS}{unused})"),
                ));
            }
            let remark = format!("warning: the header of {frames} has no site; that of the home file is used");
            return Ok((self.clone(), Some(remark)));
        };
        let table = SiteTable {
            name: Some(site.name.clone()),
            latitude_deg: Some(site.latitude_rad.to_degrees()),
            longitude_deg: Some(site.longitude_rad.to_degrees()),
            height_m: Some(site.height_m),
            mpc: None,
        };
        let (named, what) = match &site.mpc_code {
            Some(code) => (NameOrTable::Name(site.name.clone()), code.clone()),
            None => {
                let (lat_deg, lon_deg) = (site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees());
                let what = format!("latitude {lat_deg:.5}, longitude {lon_deg:.5} deg, height {:.0} m", site.height_m);
                (NameOrTable::Table(table), what)
            }
        };
        let site_config = SiteConfig { named: Some(named), ..SiteConfig::default() };
        let config = Self {
            site: site_config,
            observer_elements: None,
            observer_norad: None,
            limb_height_km: None,
            ..self.clone().without_limits()
        };
        let sense = remark.as_ref().map(|remark| format!("; {remark}")).unwrap_or_default();
        let name = if site.name == UNNAMED_SITE { "" } else { &format!("{} ", site.name) };
        Ok((config, Some(format!("site {name}({what}) from the header{sense}"))))
    }

    /// Returns the designator of a wanted number in the element sets of the satellites, if it is among several objects
    /// known only by their designators.
    fn designator_in_elements(
        &self,
        wanted: Option<NoradId>,
        alone: &[&EphemerisObject],
        moment: Epoch,
    ) -> Result<Option<Arc<str>>, Error> {
        let is_designator = |object: &&&EphemerisObject| matches!(object, EphemerisObject::Designator(_));
        let (Some(wanted), 2..) = (wanted, alone.iter().filter(is_designator).count()) else { return Ok(None) };
        let sets = self.catalogue(moment)?.map(|catalogue| catalogue.element_sets).unwrap_or_default();
        let set = sets.into_iter().find(|set| set.norad_id == wanted);
        Ok(set.map(|set| set.international_designator))
    }

    /// Returns the telescope in orbit, with its ephemerides if there are any, or else with the element set that is
    /// closest to `moment`.
    fn observer(&self, moment: Epoch, eop: &EopTable, limb: EarthLimb) -> Result<OrbitingObserver, Error> {
        let catalogue = match &self.observer_elements {
            Some(path) => {
                Some(Satellites::read(std::slice::from_ref(path), &self.read_options(Keep::Nearest(moment)))?)
            }
            None => self.catalogue(moment)?,
        };
        let missing = || Error::missing("elements or ephemeris of the telescope in orbit", "--observer-elements FILE");
        let Satellites { element_sets, mut ephemerides, .. } = catalogue.ok_or_else(missing)?;
        // An ephemeris without element set is an object of its own.
        let mut alone: Vec<&EphemerisObject> = ephemerides
            .iter()
            .filter(|ephemeris| !element_sets.iter().any(|set| ephemeris.is_of(set)))
            .map(|ephemeris| &ephemeris.object)
            .collect();
        alone.sort_by_key(|object| object.to_string());
        alone.dedup();
        let count = element_sets.len() + alone.len();
        let wanted = self.observer_norad.map(NoradId);
        let designator = self.designator_in_elements(wanted, &alone, moment)?;
        let is_wanted = |norad_id: NoradId| wanted.is_none_or(|wanted| norad_id == wanted);
        if wanted.is_none() && count > 1 {
            let first = element_sets.first().map_or_else(|| alone[0].to_string(), |set| set.norad_id.to_string());
            return Err(Error::new(
                ErrorKind::Invalid,
                format!(
                    "the elements of the observer contain {count} objects; specify one with --observer-norad (the first is {first})"
                ),
            ));
        }
        let set = element_sets.into_iter().find(|set| is_wanted(set.norad_id));
        ephemerides.retain(|ephemeris| match &ephemeris.object {
            _ if set.as_ref().is_some_and(|set| ephemeris.is_of(set)) => true,
            EphemerisObject::Norad(norad_id) => is_wanted(*norad_id),
            // If the file has only this object, the given number is taken as that of the designator.
            EphemerisObject::Designator(own) => designator.as_ref().map_or(count == 1, |wanted| wanted == own),
        });
        if let Some(observer) = OrbitingObserver::from_ephemerides(&ephemerides, eop, limb) {
            return Ok(wanted.into_iter().fold(observer, OrbitingObserver::with_norad_id));
        }
        match (set, wanted) {
            (Some(set), _) => OrbitingObserver::new(&set, limb).map_err(|problem| Error::new(ErrorKind::NoPosition, format!("observer: {problem}"))),
            (None, Some(id)) => Err(Error::new(ErrorKind::Invalid, format!("--observer-norad {} is not among the {count} objects of the elements", id.0)).allowing("the NORAD number of one of them (for objects with only a COSPAR designator, one that has this designator in --elements)")),
            (None, None) => Err(missing()),
        }
    }
}

/// Returns the site with this name. If no known name is similar, the error lists other ways to specify a site.
fn site_of_name(name: &str) -> Result<Site, Error> {
    let allowed = "a name listed by streakcast sites, or --lat and --lon; streakcast setup --place TOWN writes those of a \
                   town into the home file";
    Site::by_name(name).map_err(|error| if error.allowed().is_some() { error.allowing(allowed) } else { error })
}

fn site_of(table: &SiteTable) -> Result<Site, Error> {
    let SiteTable { name, mpc, latitude_deg, longitude_deg, height_m } = table;
    match (mpc, name, (latitude_deg, longitude_deg, height_m)) {
        (Some(code), None, (None, None, None)) => Ok(Site::from_mpc(code)?),
        (Some(_), Some(_), _) => Err(error::both("an MPC code", "a name")),
        (Some(_), None, _) => Err(error::both("an MPC code", "coordinates")),
        (None, name, (Some(latitude), Some(longitude), height)) => {
            let name = name.as_deref().unwrap_or_default();
            Site::new_deg(name, *latitude, *longitude, height.unwrap_or(0.0))
        }
        (None, Some(name), (None, None, None)) => site_of_name(name),
        (None, None, (None, None, None)) => Err(SITE.missing()),
        (None, ..) => Err(RequiredInput { name: "complete coordinates of the site", ..SITE }.missing()),
    }
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
    fn a_table_with_contradictory_keys_is_rejected() {
        for (keys, part) in [
            ("name = 'La Silla'\nmpc = 'X05'", "an MPC code and a name exclude each other"),
            ("mpc = 'X05'\nheight_m = 10", "an MPC code and coordinates exclude each other"),
            ("name = 'La Silla'\nheight_m = 10", "missing complete coordinates of the site"),
            ("latitude_deg = 10", "missing complete coordinates of the site"),
        ] {
            let found = message(config(&format!("[site]\n{keys}")).site());
            assert!(found.contains(part), "{keys}: {found}");
        }
    }

    #[test]
    fn sites_by_name_code_and_numbers() {
        assert_eq!(config("site = 'Rubin Observatory'").site().unwrap().mpc_code.as_deref(), Some("X05"));
        assert_eq!(config("[site]\nmpc = 'X05'").site().unwrap().mpc_code.as_deref(), Some("X05"));
        assert!((config("lat = -30.5\nlon = -70\nheight = 2000").site().unwrap().height_m - 2000.0).abs() < 1e-9);
        assert!(message(config("").site()).contains("specify --site NAME, --mpc CODE"));
        assert!(message(config("lat = 3").site()).contains("complete coordinates"));
        assert!(message(config("mpc = 'X05'\nlat = 3").site()).contains("exclude each other"));
        assert!(message(config("site = 'Nowhere at all'").site()).contains("streakcast sites, or --lat and --lon"));
    }
}

//! Where the telescope is: a site by name, code or numbers, or an orbit.

use hifitime::Epoch;

use crate::elements::{Catalogue, ElementSet};
use crate::frames::Orientation;
use crate::geometry::{EarthLimb, GeometryError, Observer, Site};
use crate::orbit::Propagator;
use crate::passes::{OrbitingObserver, Viewpoint};

use super::choices::{SiteSetup, SiteTable};
use super::document::Setup;
use super::error::SetupError;
use super::units::in_range;

const SITES: &str = "--site NAME, --mpc CODE, or --lat, --lon and --height";

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

    /// The longitude whose noon parts the nights, radians, east positive: that of the site; Greenwich's for a telescope in orbit, and where
    /// no moment is given.
    ///
    /// # Errors
    /// As [`Setup::viewpoint`].
    pub fn viewpoint_longitude_rad(&self, moment: Option<Epoch>) -> Result<f64, SetupError> {
        let Some(moment) = moment else { return Ok(0.0) };
        Ok(self.viewpoint(moment)?.site().map_or(0.0, |observer| observer.site().longitude_rad))
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
}

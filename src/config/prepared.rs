//! Skies prepared for the times of a request, with their provenance and warnings.

use std::collections::BTreeSet;
use std::sync::Arc;

use hifitime::Epoch;
use serde_json::json;

use super::described::{
    LISTED, constellations_json, elements_json, ephemerides_json, mean_motion_json, names, observer_json, period_json,
    rejected_json, site_json,
};
use super::document::Config;
use super::doubtful_site::doubtful_site;
use super::error::request;
use super::inputs::LoadedInputs;
use super::warnings;
use crate::elements::{Constellation, ElementSet, Ephemeris, Keep};
use crate::error::{Error, ErrorKind};
use crate::frames::{EopTable, seconds_after, seconds_between};
use crate::geometry::Observer;
use crate::message::listed;
use crate::orbit::{EphemerisCoverage, LeftOut};
use crate::output::{Provenance, format_utc};
use crate::passes::{Exposure, Field, Sky, Viewpoint, read_measured};
use crate::photometry::{BrightObjects, PhotometryOptions};
use crate::schedule::{evening_mjd, lowest_altitude_rad};
use crate::watch::Watch;

/// Sky of a site or of a telescope in orbit, with provenance and warnings.
#[derive(Clone, Debug)]
pub struct PreparedSky {
    /// Satellites and observer.
    pub sky: Sky,
    /// Earth orientation of the sky.
    pub eop: EopTable,
    /// Provenance of the results. A request adds its own values.
    pub provenance: Provenance,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// Warnings about files and simulated constellations; they do not depend on the time of a request.
    of_files: Vec<String>,
    /// True if periods of constellations that grow have element sets of their own.
    has_own_elements: bool,
    /// Number of satellites read from files; these are the first satellites of the sky.
    from_files: usize,
    /// Epoch of the simulated satellites; `None` if there are none.
    shells_made_for: Option<Epoch>,
    /// Evening (MJD) of the night whose period of growing constellations is used, and the first evenings of all
    /// periods.
    growth_mjd: (i64, Vec<i64>),
}

impl Config {
    /// Reads all inputs and prepares the sky for requests from `first` to `last`.
    ///
    /// For each object, the element set closest to the middle of the interval is used. Simulated constellations are
    /// generated for the start of the UTC day of `first`; those that grow are as deployed in the night of `first`.
    ///
    /// # Errors
    /// Same as [`Config::load`] and [`LoadedInputs::prepare`].
    pub fn prepare(&self, first: Epoch, last: Epoch) -> Result<PreparedSky, Error> {
        self.load_with(Keep::Nearest(middle_of(first, last)), Some(first))?.prepare(first, last)
    }
}

impl LoadedInputs {
    /// Prepares the sky for requests from `first` to `last`, in the same way as [`Config::prepare`].
    ///
    /// # Errors
    /// No site is given, the site is invalid, or no satellite can be propagated to that time.
    pub fn prepare(&self, first: Epoch, last: Epoch) -> Result<PreparedSky, Error> {
        let middle = middle_of(first, last);
        let viewpoint = self.config.viewpoint(middle)?;
        let mut of_files = Vec::new();
        let mut provenance = Provenance::new();
        if let Some(home) = &self.config.home.file {
            provenance.state("home_file", home.display().to_string());
        }
        if !self.settings_files.is_empty() {
            provenance.state("settings_files", self.settings_files.clone());
        }
        let evening = evening_mjd(first, longitude_rad(&viewpoint));
        let constellations = self.deployment.at(evening)?;
        let (mut elements, mut others): (Vec<ElementSet>, Vec<ElementSet>) = Default::default();
        let catalogue = self.catalogue_at(evening);
        let has_own_elements = self.deployment.has_elements();
        if catalogue.is_some() || has_own_elements {
            provenance.state("elements", elements_json(catalogue));
        }
        if let Some(catalogue) = catalogue {
            of_files.extend(warnings::of_catalogue(catalogue));
            provenance.attach("rejected_count", catalogue.rejected.len());
            provenance
                .attach("rejected", catalogue.rejected.iter().take(LISTED).map(rejected_json).collect::<Vec<_>>());
            provenance.attach("cut_short", warnings::cut_short(catalogue).collect::<Vec<_>>());
            let chosen = catalogue.chosen_at(middle);
            (elements, others) = (chosen.sets, chosen.others);
            of_files.extend(warnings::of_other_sets(&elements, &others));
            let merged = merge_parts_of_stations(&mut elements);
            if !merged.is_empty() {
                provenance.attach("modules_merged", merged);
            }
        }
        let ephemerides = catalogue.map_or(&[][..], |catalogue| &catalogue.ephemerides);
        // The ephemerides of the telescope itself are used, although it may have no element set.
        let own = viewpoint.orbit().map_or(&[][..], |observer| observer.ephemerides());
        let is_own = |ephemeris: &&Arc<Ephemeris>| {
            own.iter().any(|other| (&ephemeris.file, &ephemeris.object) == (&other.file, &other.object))
        };
        let of_satellites: Vec<Arc<Ephemeris>> =
            ephemerides.iter().filter(|ephemeris| !is_own(ephemeris)).cloned().collect();
        let without_elements = without_elements(&of_satellites, &elements);
        if !without_elements.is_empty() && elements.is_empty() {
            let satellites: BTreeSet<&str> = without_elements.iter().map(String::as_str).collect();
            let satellites = listed(satellites);
            return Err(Error::missing(
                format!(
                    "element sets of {satellites}: an ephemeris has only positions, and the element set determines the \
                     search, the kind of satellite and its brightness model"
                ),
                "a file with its element set of about the same date in --elements too, such as that of streakcast fetch \
                 celestrak --group active",
            ));
        }
        of_files.extend(warnings::of_ephemerides_without_elements(&without_elements));
        let from_files = elements.len();
        let growth_mjd = (evening, self.deployment.periods().map(|period| period.from_mjd).collect());
        let shells_made_for = (!constellations.is_empty()).then(|| start_of_utc_day(first));
        if let Some(day) = shells_made_for {
            provenance.state("shells", constellations_json(&constellations));
            // All requests of a UTC day use one epoch, so that a schedule and a single exposure of it have the same
            // satellites.
            elements.extend(constellations.iter().flat_map(|constellation| constellation.element_sets(day)));
            let names: Vec<&str> = constellations.iter().map(|constellation| constellation.name.as_str()).collect();
            of_files.push(warnings::of_simulated(&names, elements.len() - from_files));
        }
        if elements.is_empty() {
            of_files.push(warnings::of_empty_period(evening));
        }
        provenance.state("satellites", elements.len());
        provenance.state("earth_orientation", self.eop.describe());
        match &viewpoint {
            Viewpoint::Site(observer) => {
                provenance.state("site", site_json(observer.site()));
                provenance.state("frame", "ICRS astrometric topocentric");
            }
            Viewpoint::Orbit(observer) => {
                provenance.state("observer", observer_json(&self.config, observer));
                provenance.state("frame", "ICRS astrometric, from the observer's orbit");
            }
        }
        provenance.state("drag", self.drag.name());
        provenance.state("shadow", self.shadow.name());

        let eop = self.eop.clone();
        let has_others = !others.is_empty();
        let sky =
            Sky::with_models_and_others(elements, (others, middle), self.drag, viewpoint, eop.clone(), &self.choice)
                .with_shadow(self.shadow)
                .with_ephemerides(ephemerides.to_vec());
        let (sky, own) = sky.recognising_observer(first, last);
        let own_names = names(own.by_orbit.iter().copied(), sky.elements());
        let other = own.other_orbit.map(|(index, km)| (names([index].into_iter(), sky.elements()).concat(), km));
        of_files.extend(warnings::of_own_satellites(&sky.viewpoint().name(), &own_names, other));
        if !own_names.is_empty() {
            provenance.state("observer_by_orbit", own_names);
        }
        if has_others {
            provenance.state("mean_motion", mean_motion_json(&sky, from_files, middle));
        }
        if !ephemerides.is_empty() {
            provenance.state("ephemerides", ephemerides_json(&sky, &without_elements, first, last));
        }
        // A period of growing constellations may have no satellites.
        if sky.left_out().len() == sky.elements().len() && !sky.elements().is_empty() {
            return Err(nothing_propagates(&sky, sky.left_out(), middle));
        }
        of_files.extend(warnings::of_placeholders(self.choice.magnitude_placeholders(), sky.elements()));
        let models: BTreeSet<String> =
            (0..sky.elements().len()).map(|index| sky.model(index).source().to_string()).collect();
        provenance.state("models", models.into_iter().collect::<Vec<_>>());
        if let (Some(learned), Some(path)) = (self.choice.learned(), &self.config.learned) {
            provenance.state("learned", learned.summary(&path.display().to_string()));
        }
        let mut sky = sky;
        if !self.config.measured.is_empty() {
            let tables = self.config.measured.iter().map(|path| read_measured(path));
            let measured = tables.collect::<Result<Vec<_>, _>>()?.concat();
            let not_used;
            (sky, not_used) = sky.with_measured(&measured, &self.config.photometry()?)?;
            let files: Vec<String> = self.config.measured.iter().map(|path| path.display().to_string()).collect();
            let stated = json!({ "files": files, "measurements": measured.len(), "not_used": not_used });
            provenance.state("measured", stated);
            of_files.extend(warnings::of_measured(measured.len(), not_used));
        }
        let warnings = Vec::new();
        let mut prepared = PreparedSky {
            sky,
            eop,
            provenance,
            warnings,
            of_files,
            has_own_elements,
            from_files,
            shells_made_for,
            growth_mjd,
        };
        prepared.warnings = prepared.warnings_at(first, last);
        Ok(prepared)
    }

    /// Returns the satellites of the period of the night at a time, for the provenance.
    ///
    /// # Errors
    /// The site is invalid, or the night is before the first period of a file.
    pub fn period_json(&self, first_start: Epoch) -> Result<serde_json::Value, Error> {
        let evening = evening_mjd(first_start, self.config.viewpoint_longitude_rad(Some(first_start))?);
        let constellations = self.deployment.at(evening)?;
        let catalogue = self.catalogue_at(evening);
        let mut elements = catalogue.map(|catalogue| catalogue.at(first_start)).unwrap_or_default();
        merge_parts_of_stations(&mut elements);
        let simulated: usize = constellations.iter().map(Constellation::satellites).sum();
        let elements_json = self.deployment.has_elements().then(|| elements_json(catalogue));
        Ok(period_json(first_start, elements.len() + simulated, constellations_json(&constellations), elements_json))
    }
}

impl PreparedSky {
    /// Returns the same sky, whose queries stop after [`Watch::stop`]; see [`Sky::watched`].
    pub fn watched(&self, watch: &Watch) -> Self {
        Self { sky: self.sky.watched(watch), ..self.clone() }
    }

    /// Adds the satellites to the periods of a provenance, like [`LoadedInputs::period_json`], unless the last period
    /// has the same.
    pub fn add_period(&self, first_start: Epoch, periods: &mut Vec<serde_json::Value>) {
        let stated = |name| self.provenance.get(name).cloned();
        let elements = stated("elements").filter(|_| self.has_own_elements);
        let shells = stated("shells").unwrap_or_else(|| json!([]));
        let period = period_json(first_start, self.sky.elements().len(), shells, elements);
        let differs = |last: &serde_json::Value| ["shells", "elements"].iter().any(|name| last[name] != period[name]);
        if periods.last().is_none_or(differs) {
            periods.push(period);
        }
    }

    /// Returns the warnings about the files, and those about inputs that are too old for a request from `first` to
    /// `last` or do not cover it.
    ///
    /// For the interval of [`LoadedInputs::prepare`] the field `warnings` has the same warnings. This method is for
    /// cached skies, which are also used at other times.
    pub fn warnings_at(&self, first: Epoch, last: Epoch) -> Vec<String> {
        self.warnings_of(first, last, &|_| true)
    }

    /// Returns the same warnings for a request that uses only some element sets; warnings about files are for all.
    pub fn warnings_of(&self, first: Epoch, last: Epoch, is_selected: &dyn Fn(&ElementSet) -> bool) -> Vec<String> {
        let mut warnings = self.of_files.clone();
        let uncovered = self.sky.ephemeris_coverage(first, last).filter(|(_, part)| *part != EphemerisCoverage::Whole);
        let uncovered = names(uncovered.map(|(index, _)| index), self.sky.elements());
        let all = self.sky.ephemeris_coverage(first, last).count();
        warnings.extend(warnings::of_uncovered(&uncovered, all));
        let contradictory = self.sky.contradictory_ephemerides().iter().copied();
        warnings.extend(warnings::of_contradictory(&names(contradictory, self.sky.elements())));
        warnings.extend(warnings::of_age(&self.sky, self.from_files, first, last, is_selected));
        warnings.extend(self.shells_made_for.and_then(|day| warnings::of_shells(day, first, last)));
        let (evening, begins) = &self.growth_mjd;
        let evenings = [first, seconds_after(last, -1.0).max(first)];
        let evenings = evenings.map(|epoch| evening_mjd(epoch, longitude_rad(self.sky.viewpoint())));
        warnings.extend(warnings::of_growth(*evening, evenings, begins));
        warnings.extend(warnings::of_orientation(&self.eop, first, last));
        let site = self.sky.viewpoint().site().map(Observer::site);
        warnings.extend(site.and_then(doubtful_site).map(|(finding, remedy)| format!("site: {finding}; {remedy}")));
        if let Viewpoint::Orbit(observer) = self.sky.viewpoint() {
            warnings.extend(warnings::of_observer(observer, first, last));
            let contradictory = observer.has_contradictory_ephemerides().then(|| observer.name());
            warnings.extend(warnings::of_contradictory(contradictory.as_slice()));
        }
        warnings
    }

    /// Rejects an exposure whose pointing is below the horizon or the Earth's limb while the shutter is open. `what` is
    /// its name in the error.
    ///
    /// # Errors
    /// The altitude is below 0°.
    pub fn check_altitude(&self, what: &str, exposure: &Exposure) -> Result<(), Error> {
        self.check_altitude_from(self.sky.viewpoint(), what, exposure)
    }

    /// As [`check_altitude`](Self::check_altitude), for another observer than that of the sky.
    pub fn check_altitude_from(&self, viewpoint: &Viewpoint, what: &str, exposure: &Exposure) -> Result<(), Error> {
        let altitude_rad = lowest_altitude_rad(exposure, viewpoint, &self.eop);
        if altitude_rad < 0.0 {
            return Err(request(format!(
                "the {what} is below {} of {} at {} (altitude {:.1} deg)",
                viewpoint.border_name(),
                viewpoint.name(),
                format_utc(exposure.start, 0),
                altitude_rad.to_degrees()
            ))
            .allowing("0 deg or more"));
        }
        Ok(())
    }

    /// Returns a warning with the number of satellites whose position cannot be computed or is unknown; `None` if there
    /// are none.
    ///
    /// # Errors
    /// No satellite can be propagated; an empty result would be misleading.
    pub fn left_out_warning(&self, left_out: &[LeftOut], moment: Epoch) -> Result<Option<String>, Error> {
        if left_out.is_empty() {
            return Ok(None);
        }
        let is_unknown = |satellite: &&LeftOut| satellite.reason.kind() == ErrorKind::UnknownPosition;
        let unknown = left_out.iter().filter(is_unknown).count();
        let satellites = self.sky.elements().len();
        if left_out.len() == satellites && unknown == 0 {
            return Err(nothing_propagates(&self.sky, left_out, moment));
        }
        Ok(Some(warnings::of_left_out(left_out, unknown, satellites)))
    }

    /// Returns the warning of [`left_out_warning`](Self::left_out_warning) for a request with several times or a night.
    /// If it has rows, satellites without a position in a part of it are no error.
    ///
    /// # Errors
    /// There are no rows, and no satellite can be propagated.
    pub fn left_out_warning_of_times(
        &self,
        left_out: &[LeftOut],
        moment: Epoch,
        has_rows: bool,
    ) -> Result<Option<String>, Error> {
        let satellites = self.sky.elements().len();
        let is_propagated = |satellite: &LeftOut| satellite.reason.kind() != ErrorKind::UnknownPosition;
        match left_out.first() {
            Some(first) if has_rows && left_out.len() == satellites && left_out.iter().all(is_propagated) => {
                Ok(Some(format!(
                    "{satellites} of {} cannot be propagated to a part of these times (first reason: {})",
                    warnings::element_sets(satellites),
                    first.reason
                )))
            }
            _ => self.left_out_warning(left_out, moment),
        }
    }

    /// Rejects a request for times from `first` to `last` if the positions of the satellites, or that of a telescope in
    /// orbit for the crossings of a field, are unknown at its start, middle and end.
    ///
    /// # Errors
    /// The elements are too old.
    pub fn check_known(&self, first: Epoch, last: Epoch, field: Option<&Field>) -> Result<(), Error> {
        let reasons = [first, middle_of(first, last), last].map(|epoch| self.sky.predictability(epoch, field).reason());
        match reasons {
            [Some(reason), Some(_), Some(_)] => Err(Error::new(
                ErrorKind::UnknownPosition,
                format!("{reason}; specify elements of about the date of the request"),
            )),
            _ => Ok(()),
        }
    }

    /// Returns a warning if the positions of the satellites are unknown in a part of the time from `first` to `last`,
    /// which is tested every six hours: the stated time begins and ends at known positions. `None` if they are always
    /// known.
    pub fn unknown_part_warning(&self, first: Epoch, last: Epoch) -> Option<String> {
        let steps = (seconds_between(first, last) / UNKNOWN_STEP_S).ceil() as usize;
        let epochs = (0..steps).map(|step| seconds_after(first, step as f64 * UNKNOWN_STEP_S)).chain([last]);
        let tested: Vec<(Epoch, Option<String>)> =
            epochs.map(|epoch| (epoch, self.sky.predictability(epoch, None).reason())).collect();
        let (begin, reason) = tested.iter().enumerate().find_map(|(i, (_, reason))| Some((i, reason.as_ref()?)))?;
        let end = tested.iter().rposition(|(_, reason)| reason.is_some())?;
        let time = |index: usize| format_utc(tested[index].0, 0);
        let (begin, end) = (time(begin.saturating_sub(1)), time((end + 1).min(tested.len() - 1)));
        Some(format!("{reason} in all or part of the time from {begin} to {end}: passes in it are missing"))
    }
}

/// Step of [`PreparedSky::unknown_part_warning`], seconds: that of [`Sky::predictability`].
const UNKNOWN_STEP_S: f64 = 6.0 * 3600.0;

/// Removes modules and docked spacecraft of space stations whose main object has an element set, because the magnitude
/// of a station includes them. Docked spacecraft have the same elements as their station. Returns the names of the
/// removed parts.
fn merge_parts_of_stations(elements: &mut Vec<ElementSet>) -> Vec<String> {
    let table = BrightObjects::embedded();
    let stations: Vec<ElementSet> = elements.iter().filter(|set| table.is_station(set.norad_id.0)).cloned().collect();
    let is_part = |set: &ElementSet| {
        stations.iter().any(|station| {
            let is_module = table.station_of(set.norad_id.0) == Some(station.norad_id.0);
            is_module || set.norad_id != station.norad_id && is_same_orbit(set, station)
        })
    };
    let parts = elements.iter().filter(|set| is_part(set));
    let parts = parts.map(|set| set.norad_id.or_name(&set.name)).collect();
    elements.retain(|set| !is_part(set));
    parts
}

/// Returns true if two element sets give the same positions.
fn is_same_orbit(first: &ElementSet, other: &ElementSet) -> bool {
    let numbers = |set: &ElementSet| {
        [
            set.mean_motion_rev_day,
            set.eccentricity,
            set.inclination_deg,
            set.right_ascension_of_node_deg,
            set.argument_of_perigee_deg,
            set.mean_anomaly_deg,
            set.bstar_per_earth_radius,
        ]
    };
    first.epoch == other.epoch && numbers(first) == numbers(other)
}

/// Adds the time scale and the photometry of a request to its provenance.
pub fn state_scales(provenance: &mut Provenance, time_scale: &str, photometry: &PhotometryOptions) {
    provenance.state("time_scale", time_scale);
    provenance.state_all(photometry.statements());
}

impl Config {
    /// Adds the time scale of times without a scale, UTC if none is given, and the options of the magnitudes.
    pub fn state_scales(&self, provenance: &mut Provenance, photometry: &PhotometryOptions) {
        let scale = self.given_time_scale().unwrap_or("utc").to_ascii_lowercase();
        state_scales(provenance, &scale, photometry);
    }
}

fn middle_of(first: Epoch, last: Epoch) -> Epoch {
    seconds_after(first, 0.5 * seconds_between(first, last))
}

fn nothing_propagates(sky: &Sky, left_out: &[LeftOut], moment: Epoch) -> Error {
    let none_can = match sky.elements().len() {
        1 => "the only element set cannot".to_owned(),
        satellites => format!("none of the {satellites} element sets can"),
    };
    let first = left_out.first().map(|satellite| satellite.reason.to_string()).unwrap_or_default();
    let moment = format_utc(moment, 0);
    Error::new(
        ErrorKind::NoPosition,
        format!("{none_can} be propagated to {moment}; specify elements of about that date (first error: {first})"),
    )
}

/// Returns descriptions of the ephemerides whose satellites have no element set.
pub(super) fn without_elements(ephemerides: &[Arc<Ephemeris>], elements: &[ElementSet]) -> Vec<String> {
    let without = ephemerides.iter().filter(|ephemeris| !elements.iter().any(|set| ephemeris.is_of(set)));
    without.map(|ephemeris| ephemeris.to_string()).collect()
}

/// Returns the longitude at which noon separates nights, radians: that of a site, or 0 for a telescope in orbit.
fn longitude_rad(viewpoint: &Viewpoint) -> f64 {
    viewpoint.site().map_or(0.0, |observer| observer.site().longitude_rad)
}

fn start_of_utc_day(epoch: Epoch) -> Epoch {
    let (year, month, day, ..) = epoch.to_gregorian_utc();
    Epoch::from_gregorian_utc_at_midnight(year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::parse_instant;

    fn utc(text: &str) -> Epoch {
        parse_instant(text, None).unwrap()
    }

    fn shells(more: &str) -> Config {
        Config::from_toml(&format!("shells = 'oneweb'\nmpc = 'X05'\n{more}"), "t.toml").unwrap()
    }

    #[test]
    fn simulated_satellites_are_named_as_such() {
        let start = utc("2024-08-14T00:30:00Z");
        let prepared = shells("").prepare(start, start).unwrap();
        assert_eq!(prepared.sky.elements().len(), 6372);
        assert!(
            prepared.warnings[0].starts_with("simulated constellation oneweb: ")
                && prepared.warnings[0].ends_with("(6,372 satellites)"),
            "{:?}",
            prepared.warnings
        );
        let shells = prepared.provenance.get("shells").unwrap();
        assert_eq!(shells[0]["synthetic"], true);
        assert_eq!(prepared.provenance.get("site").unwrap()["mpc_code"], "X05");
    }

    #[test]
    fn a_constellation_that_is_named_twice_counts_once() {
        let start = utc("2024-08-14T00:30:00Z");
        let config = Config { shells: ["oneweb", "OneWeb"].map(|name| name.to_owned().into()).to_vec(), ..shells("") };
        assert_eq!(config.prepare(start, start).unwrap().sky.elements().len(), 6372);
    }

    #[test]
    fn a_cached_sky_has_warnings_for_other_times() {
        let start = utc("2026-07-08T20:00:00Z");
        let (_folder, mut config) = with_bad_checksums(1);
        config.shells = shells("").shells;
        let prepared = config.prepare(start, start).unwrap();
        assert_eq!(prepared.warnings_at(start, start), prepared.warnings);
        let count = prepared.warnings.len();
        assert!(!prepared.warnings.iter().any(|warning| warning.contains("days")), "{:?}", prepared.warnings);
        let later = utc("2026-08-08T20:00:00Z");
        let warnings = prepared.warnings_at(later, later);
        assert_eq!(warnings[..count], prepared.warnings[..]);
        assert!(warnings[count].starts_with("1 of 1 element set is more than 14 days from"), "{warnings:?}");
        assert!(warnings[count + 1].starts_with("the shells were generated for 2026-07-08, 31.8 days"), "{warnings:?}");
    }

    #[test]
    fn ephemerides_alone_are_an_error_with_their_satellites() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/ephemerides/invented.oem");
        let config = Config::from_toml(&format!("elements = '{path}'\nmpc = 'X05'"), "t.toml").unwrap();
        let start = utc("2026-08-15T00:00:00Z");
        let message = config.prepare(start, start).unwrap_err().to_string();
        assert!(message.starts_with("missing element sets of INVENTED"), "{message}");
        assert!(
            message.contains("the search, the kind of satellite") && message.contains("--elements too"),
            "{message}"
        );
    }

    #[test]
    fn no_satellites_is_an_error_with_the_accepted_flags() {
        let start = utc("2024-08-14T00:30:00Z");
        let config = Config::from_toml("mpc = 'X05'", "t.toml").unwrap();
        let message = config.prepare(start, start).unwrap_err().to_string();
        assert!(
            message.contains("--elements") && message.contains("--shells NAME, for example starlink-gen1"),
            "{message}"
        );
    }

    const GOOD: &str = "1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9999\n\
                        2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097\n";

    /// Returns a configuration with one valid element set and `bad` ones with a wrong checksum, and its folder.
    fn with_bad_checksums(bad: usize) -> (tempfile::TempDir, Config) {
        let folder = tempfile::tempdir().unwrap();
        let text = GOOD.to_owned() + &GOOD.replace("575097", "575098").repeat(bad);
        std::fs::write(folder.path().join("a.tle"), text).unwrap();
        let path = folder.path().join("a.tle").display().to_string();
        (folder, Config::from_toml(&format!("elements = '{path}'\nmpc = 'X05'"), "t.toml").unwrap())
    }

    #[test]
    fn verif_parts_of_a_station_are_merged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.tle");
        let checked = |text: &str| text.lines().map(|line| format!("{}0\n", &line[..68])).collect::<String>();
        let docked = checked(&GOOD.replace("25544", "66664"));
        let released = checked(&GOOD.replace("25544", "66665").replace("87.8481", "87.9481"));
        let module = checked(&GOOD.replace("25544", "49044").replace("87.8481", "87.8482"));
        std::fs::write(&path, GOOD.to_owned() + &docked + &released + &module).unwrap();
        let text = format!("elements = '{}'\nmpc = 'X05'\naccept_bad_checksums = true", path.display());
        let start = utc("2026-07-08T20:00:00Z");
        let prepared = Config::from_toml(&text, "t.toml").unwrap().prepare(start, start).unwrap();
        let numbers: Vec<u32> = prepared.sky.elements().iter().map(|set| set.norad_id.0).collect();
        assert_eq!(numbers, [25_544, 66_665]);
        let (_, merged) = prepared.provenance.attached().find(|(name, _)| *name == "modules_merged").unwrap();
        assert_eq!(merged.as_array().unwrap().len(), 2);
    }

    #[test]
    fn rejected_records_are_counted_and_listed() {
        let start = utc("2026-07-08T20:00:00Z");
        let (_folder, config) = with_bad_checksums(1);
        let warning = config.prepare(start, start).unwrap().warnings.remove(0);
        assert!(warning.starts_with("1 of 2 records rejected (1 with a wrong checksum; --accept-bad-ch"), "{warning}");

        let (_folder, config) = with_bad_checksums(1200);
        let prepared = config.prepare(start, start).unwrap();
        let warning = &prepared.warnings[0];
        assert!(
            warning.starts_with("1200 of 1201 records rejected, more than half: the result is incomplete"),
            "{warning}"
        );
        assert!(warning.contains("(1200 with a wrong checksum; --accept-bad-checksums accepts these): "), "{warning}");
        let mut text = Vec::new();
        crate::output::write_json(&mut text, &[], &prepared.provenance).unwrap();
        let document: serde_json::Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(document["rejected_count"], 1200);
        let rejected = document["rejected"].as_array().unwrap();
        assert_eq!((rejected.len(), &rejected[1]["line"]), (LISTED, &json!(6)));
        assert!(rejected[1]["file"].as_str().unwrap().ends_with("a.tle"), "{}", rejected[1]);
        assert!(rejected[1]["reason"].as_str().unwrap().contains("checksum"), "{}", rejected[1]);
        let table = crate::output::Table { columns: Vec::new(), rows: Vec::new() };
        let mut text = Vec::new();
        crate::output::write_json_lines(&mut text, &table, &prepared.provenance).unwrap();
        let first: serde_json::Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(first["rejected"], document["rejected"]);
    }

    #[test]
    fn an_expired_table_is_a_warning() {
        let start = utc("2034-08-14T00:30:00Z");
        let prepared = shells("").prepare(start, start).unwrap();
        assert!(prepared.warnings.iter().any(|warning| warning.contains("table ended") && warning.contains("--eop")));
    }
}

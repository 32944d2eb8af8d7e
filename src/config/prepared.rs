//! A setup made ready: the sky of its elements over its site, what it rests on, and what the user should know.

use std::collections::BTreeSet;

use hifitime::Epoch;
use serde_json::json;

use crate::elements::{Catalogue, Constellation, ElementSet, Generation, Rejected, SourceFile};
use crate::frames::{EopTable, seconds_after, seconds_between};
use crate::geometry::{ShadowModel, Site};
use crate::orbit::LeftOut;
use crate::output::{Provenance, format_utc};
use crate::passes::{ModelChoice, OrbitingObserver, Sky, Viewpoint};
use crate::photometry::{ModelLibrary, StandardMagnitudes};

use super::document::Setup;
use super::error::SetupError;
use super::resolve::{read_text, synthetic};
use super::warnings;

/// How many rejected records are listed in JSON; the count beside them is of all.
const LISTED: usize = 1000;

/// Everything that a question needs besides the question.
#[derive(Debug)]
pub struct Prepared {
    /// Satellites over the site.
    pub sky: Sky,
    /// The Earth's orientation that the sky turns with.
    pub eop: EopTable,
    /// What the answers rest on; the question's own statements come behind.
    pub provenance: Provenance,
    /// What the user should know, each counted.
    pub warnings: Vec<String>,
    /// Of `warnings` those of files and shells, which hold whatever moment is asked about.
    of_files: Vec<String>,
    /// How many of the sky's satellites, the first of them, came from files.
    from_files: usize,
    /// The day that synthetic satellites were made for; `None` without any.
    shells_made_for: Option<Epoch>,
}

/// All that a setup names, read once: skies for any times come out of it, and no file is asked again (but that of a telescope in orbit).
#[derive(Clone, Debug)]
pub struct Stock {
    setup: Setup,
    shadow: ShadowModel,
    eop: EopTable,
    catalogue: Option<Catalogue>,
    constellations: Vec<Constellation>,
    choice: ModelChoice,
}

impl Setup {
    /// Reads all that was named and makes the sky ready for questions from `first` to `last`.
    ///
    /// Of several element sets of one object the one nearest to the middle is taken; shells are made for the beginning of the UTC day
    /// of `first`.
    ///
    /// # Errors
    /// Neither elements nor shells were said, or whatever is wrong with what was.
    pub fn prepare(&self, first: Epoch, last: Epoch) -> Result<Prepared, SetupError> {
        self.stock_with(self.catalogue(middle_of(first, last))?)?.prepare(first, last)
    }

    /// Reads all that was named, with every element set of every object, for skies of many nights.
    ///
    /// # Errors
    /// As [`Setup::prepare`].
    pub fn stock(&self) -> Result<Stock, SetupError> {
        self.stock_with(self.whole_catalogue()?)
    }

    fn stock_with(&self, catalogue: Option<Catalogue>) -> Result<Stock, SetupError> {
        let (shadow, eop) = (self.shadow()?, self.eop_table()?);
        let constellations = self.constellations()?;
        if catalogue.is_none() && constellations.is_empty() {
            let allowed = "--elements FILE..., or, without any download, --shells starlink-gen1 (synthetic; see streakcast shells)";
            return Err(SetupError::Missing { what: "satellites", allowed });
        }
        let choice = self.model_choice()?;
        Ok(Stock { setup: self.clone(), shadow, eop, catalogue, constellations, choice })
    }

    fn observer_json(&self, observer: &OrbitingObserver) -> serde_json::Value {
        json!({
            "norad_id": observer.norad_id().0,
            "name": observer.name(),
            "elements_epoch_utc": format_utc(observer.elements_epoch(), 3),
            "file": self.observer_elements.as_ref().map(|path| path.display().to_string()),
            "limb_height_km": observer.limb().height_km,
        })
    }

    /// The shipped models and those of the setup's own files, by name.
    ///
    /// # Errors
    /// A file that cannot be read or is no model.
    pub fn model_library(&self) -> Result<ModelLibrary, SetupError> {
        let mut library = ModelLibrary::embedded();
        for path in self.models.iter().flat_map(|models| &models.files) {
            library.add_json(&read_text("model", path)?, &path.display().to_string())?;
        }
        Ok(library)
    }

    /// Which model goes with which satellite.
    ///
    /// # Errors
    /// As [`Setup::model_library`]; a generation or model that is not known; a table of standard magnitudes that is none.
    pub fn model_choice(&self) -> Result<ModelChoice, SetupError> {
        let library = self.model_library()?;
        let mut choice = ModelChoice::new(&library)?;
        for (generation, model) in self.models.iter().flat_map(|models| &models.generations) {
            let generation = Generation::by_name(generation).ok_or_else(|| SetupError::UnknownGeneration {
                given: generation.clone(),
                known: Generation::ALL.map(Generation::name).join(", "),
            })?;
            choice = choice.with_model(generation, model, &library)?;
        }
        if let Some(path) = self.qs_mag.as_deref().or(self.models.as_ref().and_then(|models| models.qs_mag.as_deref()))
        {
            let magnitudes = StandardMagnitudes::from_qs_mag(&read_text("standard magnitudes", path)?)?;
            choice = choice.with_standard_magnitudes(magnitudes);
        }
        Ok(choice)
    }
}

impl Stock {
    /// The files of elements as they were read; none where all satellites are synthetic.
    pub fn sources(&self) -> &[SourceFile] {
        self.catalogue.as_ref().map_or(&[], |catalogue| &catalogue.sources)
    }

    /// The sky ready for questions from `first` to `last`, as of [`Setup::prepare`].
    ///
    /// # Errors
    /// No site or a bad one; none of the satellites has a place at that time.
    pub fn prepare(&self, first: Epoch, last: Epoch) -> Result<Prepared, SetupError> {
        let middle = middle_of(first, last);
        let viewpoint = self.setup.viewpoint(middle)?;
        let mut of_files = Vec::new();
        let mut provenance = Provenance::new();
        let mut elements: Vec<ElementSet> = Vec::new();
        if let Some(catalogue) = &self.catalogue {
            provenance.state("elements", catalogue.sources.iter().map(source_json).collect::<Vec<_>>());
            of_files.extend(warnings::of_catalogue(catalogue));
            provenance.attach("rejected_count", catalogue.rejected.len());
            provenance
                .attach("rejected", catalogue.rejected.iter().take(LISTED).map(rejected_json).collect::<Vec<_>>());
            provenance.attach("cut_short", warnings::cut_short(catalogue).collect::<Vec<_>>());
            elements = catalogue.at(middle);
        }
        let from_files = elements.len();
        let shells_made_for = (!self.constellations.is_empty()).then(|| start_of_utc_day(first));
        if let Some(day) = shells_made_for {
            let stated: Vec<_> = self.constellations.iter().map(constellation_json).collect();
            provenance.state("shells", stated);
            // One epoch for all questions of a day, so that a schedule and a single exposure of it see the same satellites.
            let satellites = synthetic(&self.constellations, day);
            let names: Vec<&str> =
                self.constellations.iter().map(|constellation| constellation.name.as_str()).collect();
            of_files.push(format!(
                "{} satellites are synthetic (shells {}): none of them is claimed to be there",
                satellites.len(),
                names.join(", ")
            ));
            elements.extend(satellites);
        }
        provenance.state("satellites", elements.len());
        provenance.state("earth_orientation", self.eop.describe());
        match &viewpoint {
            Viewpoint::Site(observer) => {
                provenance.state("site", site_json(observer.site()));
                provenance.state("frame", "ICRS astrometric topocentric");
            }
            Viewpoint::Orbit(observer) => {
                provenance.state("observer", self.setup.observer_json(observer));
                provenance.state("frame", "ICRS astrometric, from the observer's orbit");
            }
        }
        provenance.state("shadow", self.shadow.name());

        let eop = self.eop.clone();
        let sky = Sky::new(elements, viewpoint, eop.clone(), &self.choice).with_shadow(self.shadow);
        if sky.left_out().len() == sky.elements().len() {
            return Err(nothing_propagates(&sky, sky.left_out(), middle));
        }
        let models: BTreeSet<String> =
            (0..sky.elements().len()).map(|index| sky.model(index).source().to_string()).collect();
        provenance.state("models", models.into_iter().collect::<Vec<_>>());
        let warnings = Vec::new();
        let mut prepared = Prepared { sky, eop, provenance, warnings, of_files, from_files, shells_made_for };
        prepared.warnings = prepared.warnings_at(first, last);
        Ok(prepared)
    }
}

impl Prepared {
    /// What the user should know of a question from `first` to `last`, each counted: of the files, and how far the question is from the elements.
    ///
    /// For the times that all was prepared for they are `warnings`; a sky that is kept may be asked about others.
    pub fn warnings_at(&self, first: Epoch, last: Epoch) -> Vec<String> {
        let mut warnings = self.of_files.clone();
        warnings.extend(warnings::of_age(&self.sky.elements()[..self.from_files], first, last));
        warnings.extend(self.shells_made_for.and_then(|day| warnings::of_shells(day, first, last)));
        warnings.extend(warnings::of_orientation(&self.eop, first, last));
        if let Viewpoint::Orbit(observer) = self.sky.viewpoint() {
            warnings.extend(warnings::of_observer(observer, first, last));
        }
        warnings
    }

    /// A warning that names satellites left out, where there are any.
    ///
    /// # Errors
    /// All of them were: no answer is better than a sky called clear.
    pub fn left_out_warning(&self, left_out: &[LeftOut], moment: Epoch) -> Result<Option<String>, SetupError> {
        let Some(first) = left_out.first() else { return Ok(None) };
        if left_out.len() == self.sky.elements().len() {
            return Err(nothing_propagates(&self.sky, left_out, moment));
        }
        Ok(Some(warnings::of_left_out(left_out, first, self.sky.elements().len())))
    }
}

fn middle_of(first: Epoch, last: Epoch) -> Epoch {
    seconds_after(first, 0.5 * seconds_between(first, last))
}

fn nothing_propagates(sky: &Sky, left_out: &[LeftOut], moment: Epoch) -> SetupError {
    SetupError::NothingPropagates {
        satellites: sky.elements().len(),
        moment: format_utc(moment, 0),
        first: left_out.first().map(|one| one.reason.to_string()).unwrap_or_default(),
    }
}

fn source_json(source: &SourceFile) -> serde_json::Value {
    json!({
        "file": source.name.as_ref(),
        "sha256": source.sha256,
        "format": source.format.to_string(),
        "records": source.records,
        "rejected": source.rejected,
        "bad_checksums_accepted": source.bad_checksums_accepted,
        "first_epoch_utc": format_utc(source.first_epoch, 3),
        "last_epoch_utc": format_utc(source.last_epoch, 3),
    })
}

fn rejected_json(rejected: &Rejected) -> serde_json::Value {
    json!({
        "file": rejected.file.as_ref(),
        "line": rejected.line,
        "reason": rejected.reason.to_string(),
    })
}

fn constellation_json(constellation: &Constellation) -> serde_json::Value {
    json!({
        "name": constellation.name,
        "satellites": constellation.satellites(),
        "synthetic": true,
        "source": constellation.source,
    })
}

fn site_json(site: &Site) -> serde_json::Value {
    let round = |value: f64, digits: i32| (value * 10_f64.powi(digits)).round() / 10_f64.powi(digits);
    json!({
        "name": site.name,
        "mpc_code": site.mpc_code,
        "latitude_deg": round(site.latitude_rad.to_degrees(), 7),
        "longitude_deg": round(site.longitude_rad.to_degrees(), 7),
        "height_m": round(site.height_m, 3),
    })
}

fn start_of_utc_day(epoch: Epoch) -> Epoch {
    let (year, month, day, ..) = epoch.to_gregorian_utc();
    Epoch::from_gregorian_utc_at_midnight(year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schedule::parse_instant;

    fn utc(text: &str) -> Epoch {
        parse_instant(text, None).unwrap()
    }

    fn shells(more: &str) -> Setup {
        Setup::from_toml(&format!("shells = 'oneweb'\nmpc = 'X05'\n{more}"), "t.toml").unwrap()
    }

    #[test]
    fn synthetic_satellites_are_said_to_be_so() {
        let start = utc("2024-08-14T00:30:00Z");
        let prepared = shells("").prepare(start, start).unwrap();
        assert_eq!(prepared.sky.elements().len(), 6372);
        assert!(
            prepared.warnings[0].starts_with("6372 satellites are synthetic (shells oneweb)"),
            "{:?}",
            prepared.warnings
        );
        let shells = prepared.provenance.get("shells").unwrap();
        assert_eq!(shells[0]["synthetic"], true);
        assert_eq!(prepared.provenance.get("site").unwrap()["mpc_code"], "X05");
    }

    #[test]
    fn a_sky_that_is_kept_is_warned_of_at_other_times() {
        let start = utc("2026-07-08T20:00:00Z");
        let (_folder, mut setup) = with_bad_checksums(1);
        setup.shells = shells("").shells;
        let prepared = setup.prepare(start, start).unwrap();
        assert_eq!(prepared.warnings_at(start, start), prepared.warnings);
        let count = prepared.warnings.len();
        assert!(!prepared.warnings.iter().any(|warning| warning.contains("days")), "{:?}", prepared.warnings);
        let later = utc("2026-08-08T20:00:00Z");
        let warnings = prepared.warnings_at(later, later);
        assert_eq!(warnings[..count], prepared.warnings[..]);
        assert!(warnings[count].starts_with("1 of 1 element sets are more than 14 days"), "{warnings:?}");
        assert!(warnings[count + 1].starts_with("the shells were made for 2026-07-08, 31.8 days"), "{warnings:?}");
    }

    #[test]
    fn no_satellites_is_an_error_that_shows_the_way() {
        let start = utc("2024-08-14T00:30:00Z");
        let setup = Setup::from_toml("mpc = 'X05'", "t.toml").unwrap();
        let message = setup.prepare(start, start).unwrap_err().to_string();
        assert!(message.contains("--elements") && message.contains("--shells starlink-gen1"), "{message}");
    }

    const GOOD: &str = "1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9999\n\
                        2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097\n";

    /// The setup of a file with one good element set and some with a wrong checksum, with its folder.
    fn with_bad_checksums(bad: usize) -> (tempfile::TempDir, Setup) {
        let folder = tempfile::tempdir().unwrap();
        let text = GOOD.to_owned() + &GOOD.replace("575097", "575098").repeat(bad);
        std::fs::write(folder.path().join("a.tle"), text).unwrap();
        let path = folder.path().join("a.tle").display().to_string();
        (folder, Setup::from_toml(&format!("elements = '{path}'\nmpc = 'X05'"), "t.toml").unwrap())
    }

    #[test]
    fn rejected_records_are_counted_listed_and_told_how_to_be_taken() {
        let start = utc("2026-07-08T20:00:00Z");
        let (_folder, setup) = with_bad_checksums(1);
        let warning = setup.prepare(start, start).unwrap().warnings.remove(0);
        assert!(warning.starts_with("1 of 2 records rejected (1 for a wrong checksum; --accept-bad-ch"), "{warning}");

        let (_folder, setup) = with_bad_checksums(1200);
        let prepared = setup.prepare(start, start).unwrap();
        let warning = &prepared.warnings[0];
        assert!(
            warning.starts_with("1200 of 1201 records rejected, more than half: the answer is incomplete"),
            "{warning}"
        );
        assert!(warning.contains("(1200 for a wrong checksum; --accept-bad-checksums takes those): "), "{warning}");
        let mut text = Vec::new();
        crate::output::write_json(&mut text, &[], &prepared.provenance).unwrap();
        let answer: serde_json::Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(answer["rejected_count"], 1200);
        let rejected = answer["rejected"].as_array().unwrap();
        assert_eq!((rejected.len(), &rejected[1]["line"]), (LISTED, &json!(6)));
        assert!(rejected[1]["file"].as_str().unwrap().ends_with("a.tle"), "{}", rejected[1]);
        assert!(rejected[1]["reason"].as_str().unwrap().contains("checksum"), "{}", rejected[1]);
        let table = crate::output::Table { columns: Vec::new(), rows: Vec::new() };
        let mut text = Vec::new();
        crate::output::write_json_lines(&mut text, &table, &prepared.provenance).unwrap();
        let first: serde_json::Value = serde_json::from_slice(&text).unwrap();
        assert_eq!(first["rejected"], answer["rejected"]);
    }

    #[test]
    fn an_expired_table_says_so() {
        let start = utc("2034-08-14T00:30:00Z");
        let prepared = shells("").prepare(start, start).unwrap();
        assert!(prepared.warnings.iter().any(|warning| warning.contains("table ended") && warning.contains("--eop")));
    }
}

//! Constellations that change: from which night on which share of each simulated one is in orbit, and which element
//! sets are used.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use hifitime::Epoch;
use toml::value::Datetime;

use super::shell::{Constellation, PeriodEntry, ShellFile, in_constellations};
use crate::error::{Error, ErrorKind};
use crate::message::Quoted;

/// Largest number of periods in a file.
const MOST_PERIODS: usize = 1000;

/// Simulated constellations of a request, and the element sets that replace those of the request, by night.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deployment {
    /// Constellations that are complete in all nights.
    always: Vec<Constellation>,
    /// Constellations that grow: the periods of each file, in time order.
    growing: Vec<DeploymentFile>,
}

/// Constellations from one night until the next period begins.
#[derive(Clone, Debug, PartialEq)]
pub struct DeploymentPeriod {
    /// Date of the evening on which the first night of the period begins, such as `2027-01-01`.
    pub from: String,
    /// The same date as MJD.
    pub from_mjd: i64,
    /// Files of element sets in place of those of the request; if empty, those of the request are used.
    pub elements: Vec<PathBuf>,
    /// Constellations with their deployed fractions.
    pub constellations: Vec<Constellation>,
}

/// File of simulated constellations, with the periods in which they grow.
#[derive(Clone, Debug, PartialEq)]
pub struct DeploymentFile {
    /// Name of the file, for errors.
    name: String,
    constellations: Vec<Constellation>,
    periods: Vec<DeploymentPeriod>,
}

impl DeploymentFile {
    /// Parses a file of the user; `name` is its path. Paths in it are relative to its folder.
    ///
    /// # Errors
    /// Same as [`Constellation::from_toml`]; or a period is invalid.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, Error> {
        let ShellFile { constellations, periods, .. } = ShellFile::from_toml(text)?;
        let mut periods = checked_periods(periods, &constellations)?;
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        for path in periods.iter_mut().flat_map(|period| &mut period.elements) {
            *path = folder.join(&*path);
        }
        Ok(Self { name: name.to_owned(), periods, constellations })
    }

    /// Returns the period of the night that begins on an evening.
    fn period_at(&self, evening_mjd: i64) -> Option<&DeploymentPeriod> {
        self.periods.iter().take_while(|period| period.from_mjd <= evening_mjd).last()
    }
}

impl Deployment {
    /// Combines bundled constellations and those of files, with catalogue numbers that follow one another.
    ///
    /// # Errors
    /// There are too many satellites, or constellations of two files, or a bundled one and one of a file, have the same
    /// name.
    pub fn new(bundled: Vec<Constellation>, mut files: Vec<DeploymentFile>) -> Result<Self, Error> {
        // Where each constellation is specified: the number of the file, from 1, or 0.
        let by_name = bundled.iter().map(|constellation| (constellation.name.clone(), (0, "by name".to_owned())));
        let mut places: HashMap<String, (usize, String)> = by_name.collect();
        for (index, file) in files.iter().enumerate() {
            let within = if file.periods.is_empty() { "in" } else { "in periods of" };
            let here = (index + 1, format!("{within} {}", file.name));
            let growing = file.periods.iter().flat_map(|period| &period.constellations);
            for Constellation { name, .. } in file.constellations.iter().chain(growing) {
                let there = places.insert(name.clone(), here.clone()).filter(|there| *there != here);
                if let Some((_, there)) = there {
                    let message = format!("constellation {name} is specified {there} and {}; allowed: once", here.1);
                    return Err(in_constellations(message));
                }
            }
        }
        Constellation::number_own(files.iter_mut().flat_map(|file| &mut file.constellations))?;
        let mut deployment = Self { always: bundled, growing: Vec::new() };
        for mut file in files {
            if file.periods.is_empty() {
                deployment.always.append(&mut file.constellations);
                continue;
            }
            for constellation in file.periods.iter_mut().flat_map(|period| &mut period.constellations) {
                if let Some(own) = file.constellations.iter().find(|own| own.name == constellation.name) {
                    constellation.first_id = own.first_id;
                }
            }
            deployment.growing.push(file);
        }
        Ok(deployment)
    }

    /// Returns true if there are no simulated constellations in any night.
    pub fn is_empty(&self) -> bool {
        self.always.is_empty() && self.growing.is_empty()
    }

    /// Returns the constellations that are complete in all nights.
    pub fn always(&self) -> &[Constellation] {
        &self.always
    }

    /// Returns the constellations that are defined in files with periods, complete.
    pub fn own_growing(&self) -> impl Iterator<Item = &Constellation> {
        self.growing.iter().flat_map(|file| &file.constellations)
    }

    /// Returns the periods of all files.
    pub fn periods(&self) -> impl Iterator<Item = &DeploymentPeriod> {
        self.growing.iter().flat_map(|file| &file.periods)
    }

    /// Returns the constellations in the night that begins on the evening `evening_mjd` (MJD of the date).
    ///
    /// # Errors
    /// The night is before the first period of a file, so that its satellites are unknown.
    pub fn at(&self, evening_mjd: i64) -> Result<Vec<Constellation>, Error> {
        let mut all = self.always.clone();
        for file in &self.growing {
            let period = file.period_at(evening_mjd).ok_or_else(|| {
                let begin = file.periods.first().map(|period| period.from.clone()).unwrap_or_default();
                let (year, month, day, ..) = Epoch::from_mjd_utc(evening_mjd as f64).to_gregorian_utc();
                let message = format!(
                    "the periods begin with the night of {begin}, after the night of \
                     {year:04}-{month:02}-{day:02} of the request"
                );
                Error::new(ErrorKind::NoPosition, message)
                    .allowing("a [[period]] from an earlier date")
                    .in_file("", &file.name)
            })?;
            all.extend(period.constellations.iter().cloned());
        }
        Ok(all)
    }

    /// Returns the files of element sets that replace those of the request in the night that begins on an evening;
    /// empty if those of the request are used.
    pub fn elements_at(&self, evening_mjd: i64) -> Vec<PathBuf> {
        let periods = self.growing.iter().filter_map(|file| file.period_at(evening_mjd));
        periods.flat_map(|period| &period.elements).cloned().collect()
    }

    /// Returns true if periods have files of element sets.
    pub fn has_elements(&self) -> bool {
        self.periods().any(|period| !period.elements.is_empty())
    }

    /// Returns the results of [`elements_at`](Self::elements_at) in all nights, except for empty ones.
    pub fn all_elements(&self) -> BTreeSet<Vec<PathBuf>> {
        self.periods().map(|period| self.elements_at(period.from_mjd)).filter(|files| !files.is_empty()).collect()
    }

    /// Returns the number of periods that have begun on the evening `evening_mjd` (MJD of the date). Nights with the
    /// same number have the same constellations.
    pub fn periods_begun(&self, evening_mjd: i64) -> usize {
        self.periods().filter(|period| period.from_mjd <= evening_mjd).count()
    }
}

/// Checks the periods of a file and completes them with the shells of its own and of the bundled constellations.
fn checked_periods(entries: Vec<PeriodEntry>, own: &[Constellation]) -> Result<Vec<DeploymentPeriod>, Error> {
    if entries.len() > MOST_PERIODS {
        let message = format!("{} periods; allowed: at most {MOST_PERIODS}", entries.len());
        return Err(in_constellations(message));
    }
    let mut all: Vec<DeploymentPeriod> = Vec::with_capacity(entries.len());
    for entry in entries {
        let period = period(entry, own)?;
        if let Some(before) = all.last().filter(|before| before.from_mjd >= period.from_mjd) {
            let message = format!(
                "period from {} is listed after that from {}; allowed: periods in time order, each from another date",
                period.from, before.from
            );
            return Err(in_constellations(message));
        }
        all.push(period);
    }
    Ok(all)
}

fn period(entry: PeriodEntry, own: &[Constellation]) -> Result<DeploymentPeriod, Error> {
    let from = entry.from.to_string();
    let wrong = |what: String| in_constellations(format!("period from {from}: {what}"));
    let date = match entry.from {
        Datetime { date: Some(date), time: None, offset: None } if (1957..2100).contains(&date.year) => date,
        _ => return Err(wrong("allowed: from = 2027-01-01, a date without quotation marks, 1957 to 2099".to_owned())),
    };
    let evening = Epoch::from_gregorian_utc_at_midnight(i32::from(date.year), date.month, date.day);
    if entry.elements.is_none() && entry.shells.is_none() {
        return Err(wrong("it has neither shells nor elements; allowed: at least one of them".to_owned()));
    }
    let elements = match entry.elements {
        Some(given) => files(&given).ok_or_else(|| {
            let given = given.to_string();
            wrong(format!(
                "elements is {}; allowed: the path of a file of element sets, or a list of paths",
                Quoted::new(&given)
            ))
        })?,
        None => Vec::new(),
    };
    let mut constellations: Vec<Constellation> = Vec::new();
    for (name, fraction) in entry.shells.unwrap_or_default() {
        let number = match fraction {
            toml::Value::Float(number) => number,
            toml::Value::Integer(number) => number as f64,
            _ => f64::NAN,
        };
        if !(0.0..=1.0).contains(&number) {
            let (name, given) = (Quoted::new(&name), fraction.to_string());
            return Err(wrong(format!("the fraction of {name} is {}; allowed: 0 to 1", Quoted::new(&given))));
        }
        let found = match own.iter().find(|constellation| constellation.name == name) {
            Some(constellation) => vec![constellation.clone()],
            None => Constellation::by_name_or_set(&name).map_err(|error| wrong(error.to_string()))?,
        };
        for mut constellation in found {
            if constellations.iter().any(|other| other.name == constellation.name) {
                return Err(wrong(format!("constellation {} is in it twice; allowed: once", constellation.name)));
            }
            constellation.deployed_fraction = number;
            constellations.push(constellation);
        }
    }
    Ok(DeploymentPeriod { from, from_mjd: evening.to_mjd_utc_days().floor() as i64, elements, constellations })
}

/// Returns a path or a list of paths; `None` for other values, empty paths and empty lists.
fn files(given: &toml::Value) -> Option<Vec<PathBuf>> {
    let list = given.as_array().map_or(std::slice::from_ref(given), Vec::as_slice);
    let path = |value: &toml::Value| value.as_str().filter(|path| !path.is_empty()).map(PathBuf::from);
    list.iter().map(path).collect::<Option<Vec<_>>>().filter(|paths| !paths.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    const JANUARY_2027_MJD: i64 = 61_406;

    fn deployment(text: &str) -> Result<Deployment, Error> {
        Deployment::new(Vec::new(), vec![DeploymentFile::from_toml(text, "growth.toml")?])
    }

    fn message(text: &str) -> String {
        deployment(text).unwrap_err().to_string()
    }

    #[test]
    fn nights_have_the_planes_of_their_period() {
        let growing = deployment(
            "[[period]]\nfrom = 2026-10-01\nshells = { mine = 0.25 }\n\
             [[period]]\nfrom = 2027-01-01\nshells = { mine = 1, oneweb = 0.5 }\n\
             [[constellation]]\nname = 'mine'\nshell = [\
             { altitude_km = 600, inclination_deg = 53, planes = 8, satellites_per_plane = 3 },\
             { altitude_km = 700, inclination_deg = 60, planes = 4, satellites_per_plane = 5 }]",
        )
        .unwrap();
        assert!(growing.at(JANUARY_2027_MJD - 93).is_err() && growing.at(JANUARY_2027_MJD - 92).is_ok());
        let names =
            |mjd| growing.at(mjd).unwrap().iter().map(|constellation| constellation.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(JANUARY_2027_MJD - 1), ["mine"]);
        assert_eq!(names(JANUARY_2027_MJD), ["mine", "oneweb"]);
        let [before, after] = [JANUARY_2027_MJD - 1, JANUARY_2027_MJD].map(|mjd| growing.at(mjd).unwrap());
        // Two of eight planes and one of four; the evenly distributed ones, with the numbers of the complete shell.
        assert_eq!((before[0].satellites(), after[0].satellites()), (2 * 3 + 5, 8 * 3 + 4 * 5));
        // 18 + 16 + 16 of 36, 32 and 32 planes.
        assert_eq!(after[1].satellites(), 18 * 49 + 32 * 72);
        assert_eq!(after[1].element_sets(Epoch::from_gregorian_utc_at_midnight(2026, 12, 31)).len(), 18 * 49 + 32 * 72);
        let epoch = Epoch::from_gregorian_utc_at_midnight(2026, 12, 31);
        let (few, all) = (before[0].element_sets(epoch), after[0].element_sets(epoch));
        assert_eq!(few.len(), 11);
        let planes: Vec<f64> = few.iter().step_by(3).take(2).map(|set| set.right_ascension_of_node_deg).collect();
        assert!(((planes[1] - planes[0]).rem_euclid(360.0) - 180.0).abs() < 1e-9, "{planes:?}");
        for set in &few {
            let same = all.iter().find(|other| other.norad_id == set.norad_id).unwrap();
            assert_eq!((&same.name, same.mean_anomaly_deg), (&set.name, set.mean_anomaly_deg));
        }
    }

    #[test]
    fn periods_have_element_sets_of_their_own() {
        let file = |text, name| DeploymentFile::from_toml(text, name).unwrap();
        let one = file(
            "[[period]]\nfrom = 2026-10-01\nelements = 'a.csv'\n\
             [[period]]\nfrom = 2027-01-01\nelements = ['b.csv', '/data/c.csv']\nshells = { oneweb = 1 }\n\
             [[period]]\nfrom = 2028-01-01\nshells = { oneweb = 1 }",
            "years/one.toml",
        );
        let two = file("[[period]]\nfrom = 2026-12-31\nelements = 'd.csv'", "two.toml");
        let both = Deployment::new(Vec::new(), vec![one, two]).unwrap();
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        assert_eq!(both.elements_at(JANUARY_2027_MJD - 100), paths(&[]));
        assert_eq!(both.elements_at(JANUARY_2027_MJD - 2), paths(&["years/a.csv"]));
        assert_eq!(both.elements_at(JANUARY_2027_MJD - 1), paths(&["years/a.csv", "d.csv"]));
        assert_eq!(both.elements_at(JANUARY_2027_MJD), paths(&["years/b.csv", "/data/c.csv", "d.csv"]));
        assert_eq!(both.elements_at(JANUARY_2027_MJD + 365), paths(&["d.csv"]));
        assert_eq!(both.all_elements().len(), 4);
    }

    #[test]
    fn errors_contain_what_is_allowed() {
        for (text, expected) in [
            ("[[period]]\nfrom = 2027-01-01", "period from 2027-01-01: it has neither shells nor elements"),
            ("[[period]]\nfrom = 2027-01-01\nelements = []", "elements is []; allowed: the path of a file"),
            (
                "[[period]]\nfrom = 2027-01-01\nelements = ['a.csv', 3]",
                "allowed: the path of a file of element sets, or a",
            ),
            ("[[period]]\nfrom = 2027-01-01\nelements = ''", "allowed: the path of a file"),
            ("[[period]]\nfrom = '2027-01-01'\nshells = {}", "invalid value"),
            ("[[period]]\nfrom = 2027-01-01T12:00:00\nshells = {}", "allowed: from = 2027-01-01"),
            (
                "[[period]]\nfrom = 2027-01-01\nshells = { oneweb = 1.5 }",
                "the fraction of oneweb is 1.5; allowed: 0 to 1",
            ),
            (
                "[[period]]\nfrom = 2027-01-01\nshells = { oneweb = 'all' }",
                "period from 2027-01-01: the fraction of oneweb is \"all\"; allowed: 0 to 1",
            ),
            (
                "[[period]]\nfrom = 2027-01-01\nshells = { onewebb = 1 }",
                "period from 2027-01-01: unknown shells \"onewebb\"",
            ),
            ("[[period]]\nfrom = 2027-01-01\nshells = { planned-2026 = 1, guowang = 1 }", "guowang is in it twice"),
            (
                "[[period]]\nfrom = 2027-01-01\nshells = {}\n[[period]]\nfrom = 2026-01-01\nshells = {}",
                "allowed: periods in time order",
            ),
            ("", "neither [[constellation]] nor [[period]]"),
        ] {
            let message = message(text);
            assert!(message.contains(expected), "{text}: {message}");
        }
        let period = "[[period]]\nfrom = 2027-01-01\nshells = { oneweb = 1 }";
        let twice = Deployment::new(
            Constellation::by_name_or_set("oneweb").unwrap(),
            vec![DeploymentFile::from_toml(period, "growth.toml").unwrap()],
        );
        let message = twice.unwrap_err().to_string();
        assert!(
            message.contains("oneweb is specified by name and in periods of growth.toml; allowed: once"),
            "{message}"
        );
        let files = ["one.toml", "two.toml"].map(|name| DeploymentFile::from_toml(period, name).unwrap());
        let message = Deployment::new(Vec::new(), files.to_vec()).unwrap_err().to_string();
        assert!(message.contains("in periods of one.toml and in periods of two.toml"), "{message}");
        let own = "[[constellation]]\nname = 'oneweb'\n\
                   shell = [{ altitude_km = 600, inclination_deg = 53, planes = 4, satellites_per_plane = 5 }]";
        let own = DeploymentFile::from_toml(own, "own.toml").unwrap();
        for (bundled, files, expected) in [
            ("oneweb", vec![own.clone()], "oneweb is specified by name and in own.toml; allowed: once"),
            (
                "kuiper",
                vec![own.clone(), own.clone()],
                "oneweb is specified in own.toml and in own.toml; allowed: once",
            ),
            ("kuiper", vec![own, files[0].clone()], "oneweb is specified in own.toml and in periods of one.toml"),
        ] {
            let bundled = Constellation::by_name_or_set(bundled).unwrap();
            let message = Deployment::new(bundled, files).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    /// The totals that were reported for a rounding to whole planes of each shell, and others: 104 of 967 satellites of
    /// ctc-1, none of 3 of telesat.
    #[test]
    fn small_fractions_have_the_right_number_of_satellites() {
        let epoch = Epoch::from_gregorian_utc_at_midnight(2027, 1, 1);
        for (name, fraction) in [
            ("ctc-1", "0.01"),
            ("ctc-1", "0.02"),
            ("telesat", "0.01"),
            ("guowang", "0.005"),
            ("cmob", "0.01"),
            ("starlink-gen1", "0.005"),
            ("starlink-gen2", "0.337"),
            ("oneweb", "0.0001"),
            ("kuiper", "0"),
        ] {
            let text = format!("[[period]]\nfrom = 2027-01-01\nshells = {{ {name} = {fraction} }}");
            let one = deployment(&text).unwrap().at(JANUARY_2027_MJD).unwrap().remove(0);
            let all = Constellation::by_name(name).unwrap().satellites() as f64;
            assert_eq!(one.satellites() as f64, (all * fraction.parse::<f64>().unwrap()).round(), "{name} {fraction}");
            let sets = one.element_sets(epoch);
            let numbers: std::collections::BTreeSet<_> = sets.iter().map(|set| set.norad_id).collect();
            assert_eq!((sets.len(), numbers.len()), (one.satellites(), one.satellites()), "{name} {fraction}");
        }
        let period = "[[period]]\nfrom = 2027-01-01\nshells = { planned-2026 = 0.01 }";
        let constellations = deployment(period).unwrap().at(JANUARY_2027_MJD).unwrap();
        // 1 % of 1,822,393; each of 25 constellations is rounded.
        let total: usize = constellations.iter().map(Constellation::satellites).sum();
        assert!(total.abs_diff(18_224) <= 12, "{total}");
    }

    #[test]
    fn an_incomplete_plane_is_evenly_filled() {
        let text = "[[period]]\nfrom = 2027-01-01\nshells = { mine = 0.6 }\n\
                    [[constellation]]\nname = 'mine'\nshell = [\
                    { altitude_km = 600, inclination_deg = 53, planes = 4, satellites_per_plane = 4 }]";
        let one = deployment(text).unwrap().at(JANUARY_2027_MJD).unwrap().remove(0);
        let sets = one.element_sets(Epoch::from_gregorian_utc_at_midnight(2027, 1, 1));
        let places: Vec<String> =
            sets.iter().map(|set| set.name.split(' ').nth(1).unwrap_or_default().into()).collect();
        // 0.6 of 16 are 10: planes 2, 3 and 4 with 4, 4 and 2.
        let expected =
            ["P02-01", "P02-02", "P02-03", "P02-04", "P03-01", "P03-02", "P03-03", "P03-04", "P04-02", "P04-04"];
        assert_eq!(places, expected);
    }

    /// Planes that are not in orbit are not counted among those with assumed planes.
    #[test]
    fn assumed_planes_are_deployed_ones() {
        let period = "[[period]]\nfrom = 2027-01-01\nshells = { planned-2026 = 0.01 }";
        let constellations = deployment(period).unwrap().at(JANUARY_2027_MJD).unwrap();
        let sum = |of: fn(&Constellation) -> usize| constellations.iter().map(of).sum::<usize>();
        let [all, assumed] = [sum(Constellation::satellites), sum(Constellation::satellites_with_assumed_planes)];
        assert!(0 < assumed && assumed < all, "{assumed} of {all}");
    }
}

//! Check of all inputs of a configuration for a request at a given time.

use hifitime::Epoch;

use super::elements::ElementState;
use super::finding::{Finding, MomentSource, Severity};
use super::observation::{camera, clock, earth_orientation, policy, site};
use crate::config::document::Config;
use crate::elements::{Keep, SourceFile};
use crate::passes::ModelChoice;
use crate::photometry::ModelLibrary;
use crate::schedule::evening_mjd;

/// Results of a setup check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    /// Findings, at least one for each subject.
    pub findings: Vec<Finding>,
    /// State of the element sets; `None` if no files are given or they cannot be read.
    pub elements: Option<ElementState>,
    /// Files of element sets.
    pub sources: Vec<SourceFile>,
}

impl Health {
    /// Returns the worst severity.
    pub fn worst(&self) -> Severity {
        self.findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Fine)
    }
}

impl Config {
    /// Checks all inputs for a request at `now`. An input that cannot be read gives a finding, not an error.
    pub fn health(&self, now: Epoch, source: MomentSource) -> Health {
        let mut health = Health::default();
        self.check_elements(now, source, &mut health);
        health.findings.push(clock(now, source, health.elements.as_ref()));
        health.findings.extend(earth_orientation(self, now));
        health.findings.extend(site(self, now));
        health.findings.extend(camera(self));
        health.findings.push(policy(self));
        health
    }

    fn check_elements(&self, now: Epoch, source: MomentSource, health: &mut Health) {
        const SUBJECT: &str = "elements";
        const FILE_REMEDY: &str = "specify a file of element sets; streakcast fetch downloads one";
        // Without a valid site, which has its own finding, nights are those of Greenwich.
        let evening = evening_mjd(now, self.viewpoint_longitude_rad(Some(now)).unwrap_or_default());
        let deployment = self.deployment();
        let files = deployment.as_ref().map(|deployment| self.elements_in(deployment, evening));
        let files = files.unwrap_or_else(|_| self.elements.clone());
        match deployment.and_then(|deployment| deployment.at(evening)) {
            Err(error) => {
                health.findings.push(Finding::error(
                    SUBJECT,
                    error,
                    "names and periods are listed by streakcast shells",
                ));
            }
            Ok(simulated) if !simulated.is_empty() => {
                let finding = "simulated constellations (--shells): positions do not correspond to real satellites";
                health.findings.push(Finding::note(SUBJECT, finding, "specify --elements FILE for real satellites"));
            }
            Ok(_) => {}
        }
        let of_other_nights = self.element_files().unwrap_or_default();
        for path in of_other_nights.into_iter().filter(|path| !files.contains(path)) {
            if let Err(error) = self.read_elements(&[path], Keep::Newest) {
                health.findings.push(Finding::error(SUBJECT, error, FILE_REMEDY));
            }
        }
        let catalogue = match self.read_elements(&files, Keep::Nearest(now)) {
            Ok(Some(catalogue)) => catalogue,
            Ok(None) => {
                if self.shells.is_empty() {
                    let finding = "not given: element sets and the models of their satellites are not checked";
                    let remedy = "specify --elements FILE; streakcast fetch downloads one";
                    health.findings.push(Finding::new(Severity::Unchecked, SUBJECT, finding, remedy));
                }
                return;
            }
            Err(error) => {
                health.findings.push(Finding::error(SUBJECT, error, FILE_REMEDY));
                return;
            }
        };
        // If models cannot be read, the finding of `camera` reports it, and the finding about assigned models is
        // omitted.
        let given = self.model_choice();
        let is_readable = given.is_ok();
        let Some(choice) = given.ok().or_else(|| ModelChoice::new(&ModelLibrary::embedded()).ok()) else { return };
        let drag = self.drag();
        if let Err(error) = &drag {
            let remedy = "specify --drag station-keeping or --drag published";
            health.findings.push(Finding::error(SUBJECT, error, remedy));
        }
        let state = ElementState::new(&catalogue, &choice, drag.unwrap_or_default(), now);
        health.findings.extend(state.findings(&catalogue, now, source));
        if is_readable {
            health.findings.push(state.model_finding());
        }
        health.elements = Some(state);
        health.sources = catalogue.sources;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::parse_instant;

    fn health(text: &str, now: &str) -> Health {
        Config::from_toml(text, "t.toml").unwrap().health(parse_instant(now, None).unwrap(), MomentSource::Clock)
    }

    fn severity(health: &Health, subject: &str) -> Severity {
        health
            .findings
            .iter()
            .filter(|finding| finding.subject == subject)
            .map(|finding| finding.severity)
            .max()
            .unwrap()
    }

    #[test]
    fn a_fault_is_a_finding_and_the_check_goes_on() {
        let all = health(
            "elements = 'missing.tle'\nlat = 0.0\nlon = 0.0\ntelescope = 'no-such'\neop = 'missing'",
            "2026-11-25T00:00:00Z",
        );
        for subject in ["elements", "telescope", "Earth orientation"] {
            assert_eq!(severity(&all, subject), Severity::Error, "{subject}");
        }
        assert_eq!((severity(&all, "site"), severity(&all, "clock")), (Severity::Warning, Severity::Fine));
        assert!(all.elements.is_none() && all.worst() == Severity::Error);
    }

    #[test]
    fn tables_run_out() {
        let at = |now: &str| health("shells = 'oneweb'\nmpc = 'X05'", now);
        let now = at("2026-11-25T00:00:00Z");
        assert_eq!(
            (severity(&now, "Earth orientation"), severity(&now, "leap seconds")),
            (Severity::Fine, Severity::Fine)
        );
        assert_eq!(now.worst(), Severity::Note);
        let soon = at("2027-05-25T00:00:00Z");
        assert_eq!(
            (severity(&soon, "Earth orientation"), severity(&soon, "leap seconds")),
            (Severity::Fine, Severity::Note)
        );
        let late = at("2028-05-25T00:00:00Z");
        assert_eq!(
            (severity(&late, "Earth orientation"), severity(&late, "leap seconds")),
            (Severity::Warning, Severity::Warning)
        );
        assert_eq!(severity(&at("2020-05-25T00:00:00Z"), "clock"), Severity::Warning);
        assert_eq!(severity(&at("1970-01-01T00:00:00Z"), "clock"), Severity::Warning);
    }

    #[test]
    fn what_is_not_given_is_unchecked() {
        let all = health("models = { files = ['no-such.json'] }\nlimit_mag = 7", "2026-11-25T00:00:00Z");
        for subject in ["elements", "site"] {
            assert_eq!(severity(&all, subject), Severity::Unchecked, "{subject}");
        }
        let policy = all.findings.iter().find(|finding| finding.subject == "policy").unwrap();
        assert_eq!((policy.severity, policy.finding.as_str()), (Severity::Fine, "blocking avoid, limit_mag 7.0"));
        let all = health("policy = { max_cost_s = 1 }", "2026-11-25T00:00:00Z");
        assert_eq!(severity(&all, "policy"), Severity::Error, "{:?}", all.findings);
    }

    #[test]
    fn a_longitude_of_the_wrong_sign_is_found() {
        let site = |lon: f64| health(&format!("lat = -30.2446\nlon = {lon}\nheight = 2650"), "2026-11-25T00:00:00Z");
        let wrong = site(70.7494);
        let finding = wrong
            .findings
            .iter()
            .find(|finding| finding.subject == "site" && finding.severity == Severity::Warning)
            .unwrap();
        assert!(finding.remedy.contains("--lon=-70.7494"), "{finding:?}");
        assert_eq!(severity(&site(-70.7494), "site"), Severity::Fine);
    }

    #[test]
    fn swapped_coordinates_of_a_known_site_are_found() {
        let site =
            |lat: f64, lon: f64| health(&format!("lat = {lat}\nlon = {lon}\nheight = 100"), "2026-11-25T00:00:00Z");
        for (lat, lon, remedy) in [
            (-70.7494, -30.2446, "--lat=-30.2446 --lon=-70.7494"),
            (-70.7494, 329.7554, "--lat=-30.2446 --lon=-70.7494"),
            (0.0962, 51.7743, ""),
        ] {
            let found = site(lat, lon);
            let warning = found
                .findings
                .iter()
                .find(|finding| finding.severity == Severity::Warning && finding.subject == "site");
            match remedy {
                "" => assert!(warning.is_none(), "{warning:?}"),
                remedy => {
                    assert!(warning.is_some_and(|finding| finding.remedy.contains(remedy)), "{:?}", found.findings)
                }
            }
        }
        assert_eq!(severity(&site(-30.2446, -70.7494), "site"), Severity::Fine);
    }
}

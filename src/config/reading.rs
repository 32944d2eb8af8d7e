//! Configuration files: reading, checks, and the home file below them.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::document::Config;
use super::error;
use super::values::{ModelSource, NameOrTable};
use crate::elements::Constellation;
use crate::error::Error;
use crate::input;

/// Verbs of the command line that have a table in a configuration file.
#[rustfmt::skip]
const VERBS: [&str; 18] = [
    "passes", "flag", "annotate", "windows", "forecast", "ephemeris", "gate", "identify", "map", "plot", "inject",
    "measure", "mask", "learn", "serve", "statistics", "model", "doctor",
];

/// Smallest similarity of two names for a suggestion.
const SIMILAR: f64 = 0.85;

/// Largest size of a configuration file, bytes.
const LARGEST_BYTES: u64 = 1_000_000;

impl Config {
    /// Reads a configuration file. Relative paths in it are relative to the folder of the file.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or has an unknown key, an invalid value, or keys that exclude each other.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let shown = path.display().to_string();
        Self::check_size(path).map_err(|message| Error::format(message).in_file("configuration", path))?;
        let text = input::read_to_string(path).map_err(|source| error::unreadable("configuration", path, source))?;
        let mut config = Self::from_toml(&text, &shown)?;
        config.start_paths_from(path.parent().unwrap_or(Path::new("")));
        config.check().map_err(|error| {
            // The key without which the check succeeds, or has another error; of several the one that the error names.
            let message = error.to_string();
            let is_invalid =
                |key: &&str| config.without(key).check().map_or_else(|other| other.to_string() != message, |()| true);
            let keys: Vec<_> = config.given().into_iter().filter(is_invalid).collect();
            let named = keys.iter().find(|key| message.contains(&key.replace('_', "-")));
            let line = named.or(keys.first()).and_then(|key| input::toml_line(&text, &[key]));
            let place = line.map_or_else(String::new, |line| format!(": line {line}"));
            error.within(format_args!("configuration {shown}{place}"), path, line)
        })?;
        config.default_time_scale = config.time_scale.take();
        Ok(config)
    }

    /// Checks that a configuration file is not larger than 1,000,000 bytes. Parsing a much larger one takes seconds.
    ///
    /// # Errors
    /// The size, and what is allowed. A file without a size, such as a stream, is accepted.
    pub fn check_size(path: &Path) -> Result<(), String> {
        match path.metadata() {
            Ok(file) if file.len() > LARGEST_BYTES => {
                Err(format!("the file has {} bytes; allowed: at most {LARGEST_BYTES}", file.len()))
            }
            _ => Ok(()),
        }
    }

    /// Parses the text of a configuration file; `origin` is its name in errors.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown, or a value is invalid.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, Error> {
        let in_file = |error: Error| error.in_file("configuration", origin);
        let error = |message: String| in_file(Error::format(message));
        let of_toml = |error: &toml::de::Error| input::toml_error(error, text);
        let of_key = |error: Error, key: &str| {
            in_file(match input::toml_line(text, &[key]) {
                Some(line) => error.on_line(line),
                None => error,
            })
        };
        let keys: toml::Table = toml::from_str(text).map_err(|syntax| in_file(of_toml(&syntax)))?;
        // TOML keys may have hyphens or underscores; the fields have underscores.
        let mut renamed = toml::Table::new();
        for (key, value) in keys {
            let name = key.replace('-', "_");
            if renamed.insert(name.clone(), value).is_some() {
                return Err(error(format!("{name} is given twice, with hyphens and with underscores; allowed: once")));
            }
        }
        let mut keys = renamed;
        // The command line reads and checks the tables of verbs. It cannot read a stream twice.
        let is_table_of_verb = |key: &str, value: &toml::Value| value.is_table() && VERBS.contains(&key);
        if let Some((verb, _)) = keys.iter().find(|(key, value)| is_table_of_verb(key, value))
            && input::is_stream(Path::new(origin))
        {
            return Err(error(format!("[{verb}] is in a stream; allowed: tables of verbs in a regular file")));
        }
        keys.retain(|key, value| !is_table_of_verb(key, value));
        if let Some(unknown) = keys.keys().find(|key| Self::keys().all(|known| known != *key)) {
            let known = Self::keys().chain(VERBS);
            let similarity = |known: &&str| strsim::jaro_winkler(known, unknown);
            let nearest = known.max_by(|first, other| similarity(first).total_cmp(&similarity(other)));
            let hint = match nearest.filter(|known| similarity(known) > SIMILAR) {
                Some(known) => format!("did you mean {known}?"),
                None => format!("allowed: {}", Self::keys().collect::<Vec<_>>().join(", ")),
            };
            return Err(of_key(Error::format(format!("unknown key '{unknown}'; {hint}")), unknown));
        }
        Config::deserialize(keys.clone()).map_err(|value| {
            // The error of the TOML parser for an invalid value does not contain the key.
            let is_invalid = |(key, value): &(String, toml::Value)| {
                Config::deserialize(toml::Table::from_iter([(key.clone(), value.clone())])).is_err()
            };
            let key = keys.into_iter().find(is_invalid).map(|(key, _)| key).unwrap_or_default();
            of_key(of_toml(&value).at(&key), &key)
        })
    }

    /// Checks all values that need no other file, so that the error is that of this configuration alone.
    fn check(&self) -> Result<(), Error> {
        // A height of the limb without a telescope has no effect if flags give a site.
        let limb_height_km = self.limb_height_km.filter(|_| self.has_viewpoint());
        Config { limb_height_km, ..self.clone() }.check_viewpoint()?;
        self.check_field()?;
        self.check_limits()?;
        self.check_exposure()?;
        self.photometry()?;
        self.rotation_rad()?;
        self.samples()?;
        self.time_scale()?;
        self.drag()?;
        self.shadow()?;
        self.threads()?;
        self.check_names()
    }

    /// Checks the names of the bundled sites, telescopes, constellations and models.
    fn check_names(&self) -> Result<(), Error> {
        if self.site.is_given() {
            self.site()?;
        }
        if let Some(NameOrTable::Name(name)) = &self.telescope
            && !name.is_file()
        {
            self.telescope()?;
        }
        for name in self.shells.iter().filter(|name| !name.is_file()) {
            Constellation::by_name(name)?;
        }
        // Model files may have further names.
        if self.models.as_ref().is_none_or(|models| models.files.is_empty()) {
            let library = self.model_library()?;
            for assigned in &self.model {
                if let ModelSource::Name(name) = &assigned.model {
                    library.find(name)?;
                }
            }
        }
        Ok(())
    }

    /// Fills omitted keys from the configuration file, and then from the home file, if they are given.
    ///
    /// # Errors
    /// Same as [`Config::read`].
    pub fn with_file(self) -> Result<Self, Error> {
        self.with_configuration_file()?.with_home_file()
    }

    /// Fills omitted keys from the configuration file, if one is given, and not from the home file.
    ///
    /// # Errors
    /// Same as [`Config::read`].
    pub fn with_configuration_file(self) -> Result<Self, Error> {
        match &self.run.file {
            Some(path) => {
                let base = Config::read(path)?;
                Ok(self.over(base))
            }
            None => Ok(self),
        }
    }

    /// Fills omitted keys from the home file, if one is given. Its time zone is that of its site: it does not apply to
    /// another site.
    ///
    /// # Errors
    /// Same as [`Config::read`].
    pub fn with_home_file(mut self) -> Result<Self, Error> {
        let Some(path) = &self.home.file else { return Ok(self) };
        let mut base = Config::read(path)?;
        if self.has_viewpoint() {
            base.time_zone = None;
        }
        self.home.gives_site = !self.has_viewpoint() && base.has_viewpoint();
        self.home.gives_time_zone = self.time_zone.is_none() && base.time_zone.is_some();
        Ok(self.over(base))
    }

    /// Returns the text of a value of `key`, with the path in it relative to `folder`.
    pub fn in_folder(key: &str, text: &str, folder: &Path) -> String {
        let config = Config::deserialize(toml::Table::from_iter([(key.to_owned(), text.into())]));
        let files = config.map_or_else(|_| Vec::new(), |config| config.files());
        let of_path = |path: &PathBuf| {
            let before = text.strip_suffix(path.to_str()?)?;
            Some(format!("{before}{}", folder.join(path).display()))
        };
        files.first().and_then(of_path).unwrap_or_else(|| text.to_owned())
    }

    fn start_paths_from(&mut self, folder: &Path) {
        self.visit_paths(&mut |path| *path = folder.join(&*path));
    }
}

#[cfg(test)]
mod tests {
    use super::super::document::{HomeConfig, RunConfig, SiteConfig};
    use super::super::values::{PolicyChoice, SiteChoice};
    use super::*;
    use crate::schedule::MagnitudeLimit;

    #[test]
    fn tables_and_names_hyphens_and_underscores() {
        let config = Config::from_toml(
            "shells = 'starlink-gen1'\nlimit-mag = 7\nexposure = '30s'\nra = 188.5\n[site]\nmpc = 'X05'\n\
             [telescope]\npreset = 'rubin'\n[policy]\nmargin_s = 3\n[field]\ncircle_deg = 3.5\n",
            "t.toml",
        )
        .unwrap();
        assert_eq!(config.shells, ["starlink-gen1".to_owned().into()]);
        assert_eq!(config.rules.limit_mag, Some(MagnitudeLimit::All(7.0)));
        assert_eq!(config.exposure.ra.as_ref().unwrap().as_str(), "188.5");
        assert_eq!(config.telescope, Some("rubin".to_owned().into()));
        let mpc =
            |table: &SiteChoice| matches!(table, NameOrTable::Table(table) if table.mpc.as_deref() == Some("X05"));
        assert!(config.site.named.as_ref().is_some_and(mpc));
        let margin =
            |policy: &PolicyChoice| matches!(policy, NameOrTable::Table(policy) if policy.margin_s == Some(3.0));
        assert!(config.rules.policy.as_ref().is_some_and(margin));
        let names = "site = 'Rubin'\ntelescope = 'rubin'\nelements = ['a.tle', 'b.tle']\n";
        let names = Config::from_toml(names, "t.toml").unwrap();
        assert_eq!(names.site.named, Some(NameOrTable::Name("Rubin".into())));
        assert_eq!(names.elements.len(), 2);
    }

    #[test]
    fn unknown_keys_and_invalid_values_are_rejected() {
        for text in ["limitmag = 7\n", "[site]\nlatitude = 3\n", "samples = -1\n", "x", "[policy]\nlimit = 3\n"] {
            let message = Config::from_toml(text, "t.toml").unwrap_err().to_string();
            assert!(message.starts_with("configuration t.toml: ") && !message.contains('\n'), "{text}: {message}");
        }
        // Plugins pass JSON.
        assert!(serde_json::from_str::<Config>(r#"{"limitmag": 7}"#).is_err());
    }

    /// The home file lies below the configuration file. Its site is not that of a frame with another one.
    #[test]
    fn the_home_file_fills_what_is_omitted() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
            Some(folder.path().join(name))
        };
        let file = write("home.toml", "mpc = 'X05'\nfov = '1deg'\ntime_scale = 'tai'\n");
        let home = HomeConfig { file, ..HomeConfig::default() };
        let with = |file: Option<PathBuf>, site: SiteConfig| {
            let run = RunConfig { file, ..RunConfig::default() };
            Config { run, home: home.clone(), site, ..Config::default() }.with_file().unwrap()
        };
        let config = with(None, SiteConfig::default());
        assert_eq!((config.site.mpc.as_deref(), config.given_time_scale()), (Some("X05"), Some("tai")));
        assert!(config.takes_site_of_frame() && config.fov.is_some());
        let config = with(write("obs.toml", "lat = 1.0\nlon = 2.0\ntime_scale = 'tt'\n"), SiteConfig::default());
        assert_eq!((config.site.mpc.as_deref(), config.given_time_scale()), (None, Some("tt")));
        assert!(!config.takes_site_of_frame() && config.fov.is_some());
        let flag = SiteConfig { mpc: Some("W84".into()), ..SiteConfig::default() };
        assert!(!with(None, flag).takes_site_of_frame());
    }

    #[test]
    fn paths_start_from_the_folder_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("streakcast.toml");
        std::fs::write(&path, "elements = 'a.tle'\ntelescope = 'mine.toml'\nshells = ['oneweb']\n").unwrap();
        let config = Config::read(&path).unwrap();
        assert_eq!(config.elements, [folder.path().join("a.tle")]);
        let mine = folder.path().join("mine.toml").display().to_string();
        assert_eq!(config.telescope, Some(mine.into()));
        assert_eq!(config.shells, ["oneweb".to_owned().into()]);
        assert_eq!(config.files().len(), 2);
    }
}

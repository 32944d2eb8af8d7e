//! The document: what can be said, and how one saying lies over another.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::choices::{
    FieldSetup, ModelsSetup, OneOrMany, PolicySetup, Quantity, SiteSetup, TelescopeSetup, is_file_name,
};
use super::error::SetupError;
use crate::schedule::MagnitudeLimit;

/// Everything that the shared flags say, by their names. What is `None` was not said.
///
/// As TOML, hyphens in keys are as good as underscores, and `site`, `telescope`, `field` and `policy` are either the one
/// word that the flag takes or a table.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Setup {
    /// Files of element sets.
    pub elements: Option<OneOrMany<PathBuf>>,
    /// Names of synthetic constellations, or TOML files of one's own.
    pub shells: Option<OneOrMany<String>>,
    /// Take element sets with wrong checksums.
    pub accept_bad_checksums: Option<bool>,
    /// Site by name, or a table.
    pub site: Option<SiteSetup>,
    /// Site by its MPC code.
    pub mpc: Option<String>,
    /// Geodetic latitude (WGS84), degrees, north positive.
    pub lat: Option<f64>,
    /// Longitude, degrees, east positive.
    pub lon: Option<f64>,
    /// Height above the ellipsoid, metres; 0 where latitude and longitude are said without it.
    pub height: Option<f64>,
    /// A file with the element set of a telescope in orbit, instead of a site.
    pub observer_elements: Option<PathBuf>,
    /// Its NORAD catalogue number, where the file (or that of the satellites) holds several objects.
    pub observer_norad: Option<u32>,
    /// Height above the ground, km, below which the Earth's air hides what a telescope in orbit would see.
    pub limb_height_km: Option<f64>,
    /// What casts the Earth's shadow: `geometric`, `atmosphere`.
    pub shadow: Option<String>,
    /// An IERS finals2000A file.
    pub eop: Option<PathBuf>,
    /// Scale of times that name none: `utc`, `tai`, `tt`.
    pub time_scale: Option<String>,
    /// The same as a configuration file says it: for times of which nothing else tells, never against a column's name.
    #[serde(skip)]
    pub default_time_scale: Option<String>,
    /// Shutter opening.
    pub start: Option<Quantity>,
    /// Length of the exposure with its unit.
    pub exposure: Option<Quantity>,
    /// Right ascension of the field's centre.
    pub ra: Option<Quantity>,
    /// Declination of the field's centre.
    pub dec: Option<Quantity>,
    /// Full diameter of a circular field with its unit.
    pub fov: Option<Quantity>,
    /// A field file, or a table of shapes.
    pub field: Option<FieldSetup>,
    /// Position angle of the field's y axis, degrees from north through east.
    pub rotation: Option<f64>,
    /// A telescope by name or file, or a table.
    pub telescope: Option<TelescopeSetup>,
    /// Passband of the magnitudes.
    pub band: Option<String>,
    /// Zero point of the magnitudes, `Vega` or `AB`.
    pub mag_system: Option<String>,
    /// Light from the Earth on two-panel models; true where nothing is said.
    pub earthshine: Option<bool>,
    /// Extinction of the site in the band, mag per airmass; magnitudes above the air where nothing is said.
    pub extinction: Option<f64>,
    /// The Sun's distance of the day in magnitudes; at 1 au where nothing is said.
    pub sun_distance: Option<bool>,
    /// Crossings brighter than this make an exposure one to avoid: one number, or a table by band.
    pub limit_mag: Option<MagnitudeLimit>,
    /// Near misses at least this probable count too.
    pub min_probability: Option<f64>,
    /// The longest wait for a clear field, with its unit.
    pub max_delay: Option<Quantity>,
    /// A policy file, or a table.
    pub policy: Option<PolicySetup>,
    /// Dark crossings too.
    pub include_dark: Option<bool>,
    /// Points along each track.
    pub samples: Option<usize>,
    /// A table of standard magnitudes in the form of McCants' `qs.mag`.
    pub qs_mag: Option<PathBuf>,
    /// Brightness models.
    pub models: Option<ModelsSetup>,
    /// Output format.
    pub format: Option<String>,
    /// Threads.
    pub threads: Option<usize>,
    /// No progress, no warnings.
    pub quiet: Option<bool>,
}

impl Setup {
    /// Reads a configuration file. Relative paths in it start from the folder of the file.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or says something that is not known.
    pub fn read(path: &Path) -> Result<Self, SetupError> {
        let shown = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| SetupError::Io {
            what: "configuration",
            path: shown.clone(),
            source,
        })?;
        let mut setup = Self::from_toml(&text, &shown)?;
        setup.start_paths_from(path.parent().unwrap_or(Path::new("")));
        setup.default_time_scale = setup.time_scale.take();
        Ok(setup)
    }

    /// From the text of a configuration file; `origin` (its name) is what errors call it.
    ///
    /// # Errors
    /// Text that is not TOML, or says something that is not known.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, SetupError> {
        let error = |error: toml::de::Error| SetupError::Toml {
            path: origin.to_owned(),
            message: crate::schedule::toml_error_on_one_line(&error, text),
        };
        let keys: toml::Table = toml::from_str(text).map_err(error)?;
        // Flags are spelled with hyphens, TOML keys mostly with underscores.
        let keys: toml::Table = keys.into_iter().map(|(key, value)| (key.replace('-', "_"), value)).collect();
        Setup::deserialize(keys).map_err(error)
    }

    /// All files that it names: what an answer depends on besides the question.
    pub fn files(&self) -> Vec<&Path> {
        let mut files: Vec<&Path> = self.elements.iter().flat_map(OneOrMany::as_slice).map(PathBuf::as_path).collect();
        files.extend([&self.eop, &self.observer_elements, &self.qs_mag].into_iter().flatten().map(PathBuf::as_path));
        if let Some(FieldSetup::File(path)) = &self.field {
            files.push(path);
        }
        if let Some(PolicySetup::File(path)) = &self.policy {
            files.push(path);
        }
        if let Some(models) = &self.models {
            files.extend(models.files.iter().chain(&models.qs_mag).map(PathBuf::as_path));
        }
        let telescope = match &self.telescope {
            Some(TelescopeSetup::Name(name)) => Some(name),
            _ => None,
        };
        let names = self.shells.iter().flat_map(OneOrMany::as_slice).chain(telescope);
        files.extend(names.filter(|name| is_file_name(name)).map(Path::new));
        files
    }

    fn start_paths_from(&mut self, folder: &Path) {
        let place = |path: &mut PathBuf| *path = folder.join(&*path);
        match &mut self.elements {
            Some(OneOrMany::One(path)) => place(path),
            Some(OneOrMany::Many(paths)) => paths.iter_mut().for_each(place),
            None => {}
        }
        self.eop.iter_mut().for_each(place);
        self.observer_elements.iter_mut().for_each(place);
        self.qs_mag.iter_mut().for_each(place);
        if let Some(FieldSetup::File(path)) = &mut self.field {
            place(path);
        }
        if let Some(PolicySetup::File(path)) = &mut self.policy {
            place(path);
        }
        if let Some(models) = &mut self.models {
            models.files.iter_mut().for_each(place);
            models.qs_mag.iter_mut().for_each(place);
        }
        let names = match &mut self.shells {
            Some(OneOrMany::One(name)) => std::slice::from_mut(name),
            Some(OneOrMany::Many(names)) => names.as_mut_slice(),
            None => &mut [],
        };
        for name in names.iter_mut().chain(self.telescope.iter_mut().filter_map(TelescopeSetup::name_mut)) {
            if is_file_name(name) {
                *name = folder.join(&*name).display().to_string();
            }
        }
    }

    /// This setup, and where it says nothing, `base`.
    ///
    /// What is said together is taken together: a site, a field or elements said here are not mixed with those of `base`.
    pub fn over(self, base: Setup) -> Setup {
        let has_site = |setup: &Setup| {
            setup.site.is_some()
                || setup.mpc.is_some()
                || setup.lat.is_some()
                || setup.lon.is_some()
                || setup.height.is_some()
                || setup.observer_elements.is_some()
                || setup.observer_norad.is_some()
        };
        let own_site = has_site(&self);
        let own_field = self.fov.is_some() || self.field.is_some();
        let own_elements = self.elements.is_some() || self.shells.is_some();
        Setup {
            elements: self.elements.or(base.elements.filter(|_| !own_elements)),
            shells: self.shells.or(base.shells.filter(|_| !own_elements)),
            accept_bad_checksums: self.accept_bad_checksums.or(base.accept_bad_checksums),
            site: self.site.or(base.site.filter(|_| !own_site)),
            mpc: self.mpc.or(base.mpc.filter(|_| !own_site)),
            lat: self.lat.or(base.lat.filter(|_| !own_site)),
            lon: self.lon.or(base.lon.filter(|_| !own_site)),
            height: self.height.or(base.height.filter(|_| !own_site)),
            observer_elements: self.observer_elements.or(base.observer_elements.filter(|_| !own_site)),
            observer_norad: self.observer_norad.or(base.observer_norad.filter(|_| !own_site)),
            limb_height_km: self.limb_height_km.or(base.limb_height_km),
            shadow: self.shadow.or(base.shadow),
            eop: self.eop.or(base.eop),
            time_scale: self.time_scale.or(base.time_scale),
            default_time_scale: self.default_time_scale.or(base.default_time_scale),
            start: self.start.or(base.start),
            exposure: self.exposure.or(base.exposure),
            ra: self.ra.or(base.ra),
            dec: self.dec.or(base.dec),
            fov: self.fov.or(base.fov.filter(|_| !own_field)),
            field: self.field.or(base.field.filter(|_| !own_field)),
            rotation: self.rotation.or(base.rotation),
            telescope: self.telescope.or(base.telescope),
            band: self.band.or(base.band),
            mag_system: self.mag_system.or(base.mag_system),
            earthshine: self.earthshine.or(base.earthshine),
            extinction: self.extinction.or(base.extinction),
            sun_distance: self.sun_distance.or(base.sun_distance),
            limit_mag: self.limit_mag.or(base.limit_mag),
            min_probability: self.min_probability.or(base.min_probability),
            max_delay: self.max_delay.or(base.max_delay),
            policy: self.policy.or(base.policy),
            include_dark: self.include_dark.or(base.include_dark),
            samples: self.samples.or(base.samples),
            qs_mag: self.qs_mag.or(base.qs_mag),
            models: self.models.or(base.models),
            format: self.format.or(base.format),
            threads: self.threads.or(base.threads),
            quiet: self.quiet.or(base.quiet),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_and_words_hyphens_and_underscores() {
        let setup = Setup::from_toml(
            "shells = 'starlink-gen1'\nlimit-mag = 7\nexposure = '30s'\nra = 188.5\n[site]\nmpc = 'X05'\n\
             [telescope]\npreset = 'rubin'\n[policy]\nmargin_s = 3\n[field]\ncircle_deg = 3.5\n",
            "t.toml",
        )
        .unwrap();
        assert_eq!(setup.shells.as_ref().unwrap().as_slice(), ["starlink-gen1"]);
        assert_eq!(setup.limit_mag, Some(MagnitudeLimit::All(7.0)));
        assert_eq!(setup.ra.as_ref().unwrap().text(), "188.5");
        assert!(matches!(&setup.site, Some(SiteSetup::Table(table)) if table.mpc.as_deref() == Some("X05")));
        assert!(matches!(&setup.policy, Some(PolicySetup::Table(policy)) if policy.margin_s == Some(3.0)));
        let words =
            Setup::from_toml("site = 'Rubin'\ntelescope = 'rubin'\nelements = ['a.tle', 'b.tle']\n", "t.toml").unwrap();
        assert_eq!(words.site, Some(SiteSetup::Name("Rubin".into())));
        assert_eq!(words.elements.unwrap().as_slice().len(), 2);
    }

    #[test]
    fn what_is_not_known_is_refused() {
        for text in ["limitmag = 7\n", "[site]\nlatitude = 3\n", "samples = -1\n", "x", "[policy]\nlimit = 3\n"] {
            let message = Setup::from_toml(text, "t.toml").unwrap_err().to_string();
            assert!(message.starts_with("configuration t.toml: ") && !message.contains('\n'), "{text}: {message}");
        }
    }

    #[test]
    fn what_is_said_together_is_taken_together() {
        let base = Setup {
            lat: Some(1.0),
            lon: Some(2.0),
            height: Some(3.0),
            fov: Some(Quantity::Text("1deg".into())),
            ..Setup::default()
        };
        let flags = Setup { mpc: Some("X05".into()), limit_mag: Some(MagnitudeLimit::All(6.0)), ..Setup::default() };
        let both = flags.over(base);
        assert_eq!((both.lat, both.height, both.mpc.as_deref()), (None, None, Some("X05")));
        assert_eq!(both.limit_mag, Some(MagnitudeLimit::All(6.0)));
        assert!(both.fov.is_some());
    }

    #[test]
    fn paths_start_from_the_folder_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("streakcast.toml");
        std::fs::write(&path, "elements = 'a.tle'\ntelescope = 'mine.toml'\nshells = ['oneweb']\n").unwrap();
        let setup = Setup::read(&path).unwrap();
        assert_eq!(setup.elements.unwrap().as_slice(), [folder.path().join("a.tle")]);
        let mine = folder.path().join("mine.toml").display().to_string();
        assert_eq!(setup.telescope, Some(TelescopeSetup::Name(mine)));
        assert_eq!(setup.shells.unwrap().as_slice(), ["oneweb"]);
    }
}

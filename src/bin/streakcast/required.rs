//! Check of required inputs, with one error that lists all missing ones.

use anyhow::anyhow;
use streakcast::config::Config;

/// Inputs that a home file can have.
const SATELLITES: &str = "satellites";
const SITE: &str = "site";

/// List of required inputs that are neither on the command line nor in the configuration file.
pub struct Required<'a> {
    config: &'a Config,
    /// Description of each missing input, and the flags that set it.
    missing: Vec<(&'static str, &'static str)>,
}

impl<'a> Required<'a> {
    /// Creates an empty list for flags that were completed by their configuration file.
    pub fn new(config: &'a Config) -> Self {
        Self { config, missing: Vec::new() }
    }

    /// Adds an input to the list if it is missing.
    pub fn input(mut self, is_given: bool, what: &'static str, flags: &'static str) -> Self {
        if !is_given {
            self.missing.push((what, flags));
        }
        self
    }

    /// Requires element sets or a simulated constellation.
    pub fn satellites(self) -> Self {
        let is_given = self.config.has_satellites();
        self.input(is_given, SATELLITES, "--elements FILE or --shells NAME, for example starlink-gen1")
    }

    /// Requires a site, or a telescope in orbit.
    pub fn site(self) -> Self {
        let is_given = self.config.has_viewpoint();
        self.input(is_given, SITE, "--site NAME, --mpc CODE, or --lat and --lon")
    }

    /// Requires a field of view.
    pub fn field(self) -> Self {
        let Config { fov, field, telescope, .. } = self.config;
        let is_given = fov.is_some() || field.is_some() || telescope.is_some();
        self.input(is_given, "field of view", "--fov ANGLE, --field FILE or --telescope NAME")
    }

    /// Requires start and duration of an exposure.
    pub fn times(self) -> Self {
        let exposure = &self.config.exposure;
        self.input(exposure.start.is_some(), "start of the exposure", "--start TIME, for example 2024-08-14T00:30:00Z")
            .input(exposure.duration.is_some(), "exposure time", "--exposure TIME, for example 30s")
    }

    /// Requires the pointing of an exposure.
    pub fn pointing(self) -> Self {
        let exposure = &self.config.exposure;
        let has_target = exposure.target.is_some();
        self.input(
            exposure.ra.is_some() || has_target,
            "right ascension",
            "--ra ANGLE, for example 188.5 or 12h34m; or --target M31",
        )
        .input(
            exposure.dec.is_some() || has_target,
            "declination",
            "--dec ANGLE, for example -30.5 or -30d30m; or --target M31",
        )
    }

    /// # Errors
    /// One error that lists all missing inputs.
    pub fn check(self) -> anyhow::Result<()> {
        let is_of_home = self.missing.iter().any(|(what, _)| [SATELLITES, SITE].contains(what));
        let setup = if is_of_home { "; streakcast setup writes them once into a home file" } else { "" };
        match self.missing.as_slice() {
            [] => Ok(()),
            [(what, flags)] => Err(anyhow!("missing {what}; specify {flags}{setup}")),
            several => {
                let listed: Vec<String> = several.iter().map(|(what, flags)| format!("{what} ({flags})")).collect();
                Err(anyhow!("missing: {}{setup}", listed.join(", ")))
            }
        }
    }
}

//! Required inputs. Each is declared once: usage lines, notes in the help, and errors for missing inputs follow from
//! it.

use super::document::Config;
use crate::error::Error;

/// Input that a request requires, from flags or from a configuration file.
#[derive(Copy, Clone, Debug)]
pub struct RequiredInput {
    /// Name in errors.
    pub name: &'static str,
    /// Alternatives: each is a list of flags that are given together, with the names of their values (`--lat DEG`).
    pub ways: &'static [&'static [&'static str]],
    /// Alternatives in words, for errors; empty if the list of flags is sufficient.
    pub words: &'static str,
    /// Example, for errors; empty if there is none.
    pub example: &'static str,
    /// Part of the help that states that the input is required.
    pub mark: Mark,
    /// Returns true if the configuration has the input.
    pub is_given: fn(&Config) -> bool,
}

/// Part of the help of a verb that states that an input is required, in addition to the usage line.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Help of each flag.
    Flags,
    /// Heading of the flags, and a text after the alternatives.
    Heading(&'static str, &'static str),
    /// Only the usage line.
    Usage,
}

impl RequiredInput {
    /// Creates an input of one verb, which checks whether it is given.
    pub const fn new(name: &'static str, ways: &'static [&'static [&'static str]]) -> Self {
        Self { name, ways, words: "", example: "", mark: Mark::Flags, is_given: |_| false }
    }

    /// Returns the error for a request without this input.
    pub fn missing(&self) -> Error {
        Error::missing(self.name, self.flags())
    }

    /// Returns the flags that give this input, with values and an example, for errors.
    pub fn flags(&self) -> String {
        let example = if self.example.is_empty() { String::new() } else { format!(", for example {}", self.example) };
        if !self.words.is_empty() {
            return self.words.to_owned() + &example;
        }
        // A value in lower case is the only one.
        let has_value = |way: &[&str], flag: &str| {
            way.len() == 1 || self.ways.len() == 1 || flag.contains(' ') && !flag.contains(char::is_uppercase)
        };
        self.alternatives(|way, flag| match flag.strip_suffix("...").filter(|_| flag.starts_with('-')) {
            _ if !has_value(way, flag) => name_of(flag),
            Some(several) => several,
            None => flag,
        }) + &example
    }

    /// Returns the names of the flags that give this input.
    pub fn names(&self) -> String {
        self.alternatives(|_, flag| name_of(flag))
    }

    fn alternatives(&self, text_of: impl Fn(&[&str], &'static str) -> &'static str) -> String {
        let of_way = |way: &&'static [&'static str]| {
            let flags: Vec<String> = way.iter().map(|flag| text_of(way, flag).to_owned()).collect();
            joined(&flags, " and ")
        };
        let ways: Vec<String> = self.ways.iter().map(of_way).collect();
        joined(&ways, if ways.len() > 1 && ways.iter().any(|way| way.contains(" and ")) { ", or " } else { " or " })
    }

    /// Returns true if this input is one flag.
    pub fn is_one_flag(&self) -> bool {
        matches!(self.ways, [[_]])
    }

    /// Returns the alternatives for a usage line.
    pub fn usage(&self) -> String {
        /// Longest line, without its indentation, and the indentation of the next one.
        const LINE: usize = 100;
        const NEXT: &str = "\n        ";
        let value = |word: &str| match word.strip_suffix("...").unwrap_or(word) {
            name if name.starts_with(|c: char| c.is_ascii_uppercase()) => word.replacen(name, &format!("<{name}>"), 1),
            _ => word.to_owned(),
        };
        let of_way = |way: &&[&str]| way.join(" ").split(' ').map(value).collect::<Vec<_>>().join(" ");
        let (mut text, mut length) = (String::new(), 0);
        for way in self.ways.iter().map(of_way) {
            let is_first = text.is_empty();
            text += if is_first { "" } else { " |" };
            length = if length + way.len() > LINE { way.len() } else { length + way.len() + 3 };
            text += if is_first {
                ""
            } else if length == way.len() {
                NEXT
            } else {
                " "
            };
            text += &way;
        }
        if self.ways.len() == 1 { text } else { format!("({text})") }
    }
}

fn name_of(flag: &str) -> &str {
    flag.split(' ').next().unwrap_or(flag)
}

/// Returns the texts as a list with `last` before the last one.
fn joined(texts: &[String], last: &str) -> String {
    match texts {
        [others @ .., end] if !others.is_empty() => others.join(", ") + last + end,
        texts => texts.concat(),
    }
}

/// Element sets or a simulated constellation.
pub const SATELLITES: RequiredInput = RequiredInput {
    example: "starlink-gen1",
    mark: Mark::Heading("Satellites", ""),
    is_given: Config::has_satellites,
    ..RequiredInput::new("satellites", &[&["--elements FILE..."], &["--shells NAME..."]])
};

/// Site, or a telescope in orbit.
pub const SITE: RequiredInput = RequiredInput {
    mark: Mark::Heading("Site", ""),
    is_given: Config::has_viewpoint,
    ..RequiredInput::new("site", &[&["--site NAME"], &["--mpc CODE"], &["--lat DEG", "--lon DEG"]])
};

/// Field of view.
pub const FIELD: RequiredInput = RequiredInput {
    mark: Mark::Heading("Camera", ""),
    is_given: |config| config.fov.is_some() || config.field.is_some() || config.telescope.is_some(),
    ..RequiredInput::new("field of view", &[&["--fov ANGLE"], &["--field FILE"], &["--telescope NAME"]])
};

/// Shutter opening.
pub const START: RequiredInput = RequiredInput {
    example: "2024-08-14T00:30:00Z",
    is_given: |config| config.exposure.start.is_some(),
    ..RequiredInput::new("start of the exposure", &[&["--start TIME"]])
};

/// Exposure time.
pub const EXPOSURE: RequiredInput = RequiredInput {
    example: "30s",
    is_given: |config| config.exposure.duration.is_some(),
    ..RequiredInput::new("exposure time", &[&["--exposure TIME"]])
};

/// Centre of the field. One angle without the other is another error.
pub const POINTING: RequiredInput = RequiredInput {
    example: "--target M31",
    is_given: |Config { exposure, .. }| exposure.target.is_some() || exposure.ra.is_some() || exposure.dec.is_some(),
    ..RequiredInput::new("pointing", &[&["--target NAME"], &["--ra ANGLE", "--dec ANGLE"]])
};

/// Satellites of an ephemeris.
pub const SELECTION: RequiredInput = RequiredInput::new(
    "selection of satellites",
    &[&["--norad ID..."], &["--name TEXT..."], &["--generation KIND..."]],
);

/// Times of an ephemeris.
pub const TIMES: RequiredInput = RequiredInput::new(
    "times",
    &[&["--times TIME..."], &["--times-file FILE"], &["--start TIME", "--end TIME", "--step TIME"]],
);

/// Position of a measured streak.
pub const STREAK: RequiredInput = RequiredInput {
    words: "--end RA,DEC twice; --ra, --dec and --position-angle; --image with --from-pix and --to-pix; or --region FILE",
    mark: Mark::Heading("Streak", "position and times"),
    ..RequiredInput::new(
        "streak",
        &[
            &["--end RA,DEC", "--end RA,DEC"],
            &["--ra ANGLE", "--dec ANGLE", "--position-angle DEG"],
            &["--image FILE", "--from-pix X,Y", "--to-pix X,Y"],
            &["--region FILE"],
        ],
    )
};

/// Frames that are measured or masked.
pub const FRAMES: RequiredInput = RequiredInput {
    words: "FRAME..., FITS files",
    mark: Mark::Usage,
    ..RequiredInput::new("frames", &[&["FRAME..."]])
};

/// Light of the streaks that are injected.
pub const INJECTED_STREAKS: RequiredInput = RequiredInput::new(
    "streaks",
    &[&["--elements FILE"], &["--shells NAME"], &["--streaks TABLE"], &["--random-streaks N", "--magnitude MAG"]],
);

/// Width of the streaks that are injected.
pub const SEEING: RequiredInput = RequiredInput {
    example: "--seeing 1.2arcsec",
    ..RequiredInput::new("seeing", &[&["--seeing ANGLE"], &["--telescope NAME"], &["--psf FILE"]])
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_alternatives() {
        let site = (SITE.names(), SITE.flags(), SITE.usage());
        assert_eq!(site.0, "--site, --mpc, or --lat and --lon");
        assert_eq!(site.1, "--site NAME, --mpc CODE, or --lat and --lon");
        assert_eq!(site.2, "(--site <NAME> | --mpc <CODE> | --lat <DEG> --lon <DEG>)");
        let gate = RequiredInput::new("pointing", &[&["--target NAME"], &["--targets FILE", "--stdin ekos"]]);
        assert_eq!(gate.flags(), "--target NAME, or --targets and --stdin ekos");
        assert_eq!(SATELLITES.flags(), "--elements FILE or --shells NAME, for example starlink-gen1");
        assert_eq!(SATELLITES.usage(), "(--elements <FILE>... | --shells <NAME>...)");
        assert_eq!((START.usage(), FRAMES.usage()), ("--start <TIME>".to_owned(), "<FRAME>...".to_owned()));
        assert_eq!(TIMES.names(), "--times, --times-file, or --start, --end and --step");
        assert!(STREAK.usage().contains("--position-angle <DEG> |\n        --image <FILE>"), "{}", STREAK.usage());
        let error = START.missing().to_string();
        assert_eq!(error, "missing start of the exposure; specify --start TIME, for example 2024-08-14T00:30:00Z");
    }
}

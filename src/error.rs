//! The error type of the crate, its constructors and its places.

use std::borrow::Cow;
use std::error::Error as StdError;
use std::fmt::{self, Display};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::message::{Quoted, bounded, printable};

/// What a program can do about an error.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A value is out of range, unknown, of the wrong form, or contradicts another one.
    Invalid,
    /// A required value is missing.
    Missing,
    /// A time has no time scale: UTC, TAI and TT differ by up to 69 s.
    NoTimeScale,
    /// The operating system or a library of a file format reported an error for a file.
    File,
    /// The content of a file is invalid.
    Format,
    /// The position of a satellite or of a telescope in orbit cannot be computed.
    NoPosition,
    /// The positions of the satellites are unknown, because their elements are too old.
    UnknownPosition,
    /// A frame has no celestial coordinates.
    NoCoordinates,
    /// There are too few data for the computation.
    TooFewData,
    /// The computation was stopped by [`Watch::stop`](crate::Watch::stop).
    Cancelled,
}

/// Error of any function of the crate.
///
/// The message states what is wrong, where, and what is accepted, in at most 1,000 characters. Values of inputs in it
/// are shortened, and their control characters escaped.
///
/// ```
/// use streakcast::{ErrorKind, Site};
///
/// let error = Site::new("Vienna", 95.0, 16.4, 0.0).unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Invalid);
/// assert!(error.to_string().ends_with("; allowed: -90 to 90 deg"));
/// ```
#[derive(Clone)]
pub struct Error(Arc<Inner>);

#[derive(Clone)]
struct Inner {
    kind: ErrorKind,
    place: Place,
    problem: Problem,
    allowed: Option<Cow<'static, str>>,
    source: Option<Arc<dyn StdError + Send + Sync>>,
}

/// Where an error is: file, line and the like as text, and as numbers if they are known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Place {
    text: String,
    file: Option<PathBuf>,
    line: Option<usize>,
    hdu: Option<usize>,
}

/// Sentence of an error without its place and the accepted values.
#[derive(Clone)]
enum Problem {
    Is { what: Cow<'static, str>, given: Quoted },
    Unknown { what: Cow<'static, str>, given: Quoted },
    Missing { what: Cow<'static, str> },
    /// Sentence whose subject is the file of the place.
    OfFile(String),
    Text(String),
}

impl Error {
    fn from_parts(kind: ErrorKind, problem: Problem) -> Self {
        Self(Arc::new(Inner { kind, place: Place::default(), problem, allowed: None, source: None }))
    }

    /// Creates an error from a sentence.
    pub(crate) fn new(kind: ErrorKind, problem: impl Into<String>) -> Self {
        Self::from_parts(kind, Problem::Text(problem.into()))
    }

    /// Creates the error `WHAT is GIVEN; allowed: ALLOWED`.
    pub(crate) fn invalid(
        what: impl Into<Cow<'static, str>>,
        given: impl Display,
        allowed: impl Into<Cow<'static, str>>,
    ) -> Self {
        let given = Quoted::statement(&given.to_string());
        Self::from_parts(ErrorKind::Invalid, Problem::Is { what: what.into(), given }).allowing(allowed)
    }

    /// Creates the error `unknown WHAT "GIVEN"; allowed: ALLOWED`.
    pub(crate) fn unknown(
        what: impl Into<Cow<'static, str>>,
        given: &str,
        allowed: impl Into<Cow<'static, str>>,
    ) -> Self {
        let given = Quoted::new(given);
        Self::from_parts(ErrorKind::Invalid, Problem::Unknown { what: what.into(), given }).allowing(allowed)
    }

    /// Creates the error `missing WHAT; specify ALLOWED`.
    pub(crate) fn missing(what: impl Into<Cow<'static, str>>, allowed: impl Into<Cow<'static, str>>) -> Self {
        Self::from_parts(ErrorKind::Missing, Problem::Missing { what: what.into() }).allowing(allowed)
    }

    /// Creates the error of a file whose content is invalid.
    pub(crate) fn format(problem: impl Into<String>) -> Self {
        Self::new(ErrorKind::Format, problem)
    }

    /// Creates the error `PURPOSE PATH PROBLEM`, of a file whose content is invalid, such as `schedule x.csv is empty`.
    pub(crate) fn about_file(purpose: &str, path: impl Into<PathBuf>, problem: impl Into<String>) -> Self {
        Self::from_parts(ErrorKind::Format, Problem::OfFile(problem.into())).in_file(purpose, path)
    }

    /// Creates the error `cannot ACTION PATH: SOURCE`.
    pub(crate) fn cannot(action: &str, path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::caused(ErrorKind::File, source).in_file(&format!("cannot {action}"), path)
    }

    /// Creates the error of another library, which remains its source.
    pub(crate) fn caused(kind: ErrorKind, source: impl StdError + Send + Sync + 'static) -> Self {
        let mut error = Self::new(kind, source.to_string());
        error.inner().source = Some(Arc::new(source));
        error
    }

    /// Returns a function that converts an error of the operating system to the error `PATH: SOURCE`.
    pub(crate) fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        move |source| Self::caused(ErrorKind::File, source).in_file("", path)
    }

    /// Rejects a number that is outside a range or not finite.
    pub(crate) fn check_range(
        what: impl Into<Cow<'static, str>>,
        given: f64,
        least: f64,
        greatest: f64,
    ) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::invalid(what, given, format!("{least} to {greatest}")))
    }

    fn inner(&mut self) -> &mut Inner {
        Arc::make_mut(&mut self.0)
    }

    /// Adds the accepted values.
    pub(crate) fn allowing(mut self, allowed: impl Into<Cow<'static, str>>) -> Self {
        self.inner().allowed = Some(allowed.into());
        self
    }

    /// Puts a place before the message. Places that are added later enclose it.
    pub(crate) fn at(mut self, place: impl Display) -> Self {
        let inner = &mut self.inner().place.text;
        *inner = if inner.is_empty() { place.to_string() } else { format!("{place}: {inner}") };
        self
    }

    /// Puts the file before the message, after a word for its purpose such as `schedule`, which may be empty.
    pub(crate) fn in_file(self, purpose: &str, path: impl Into<PathBuf>) -> Self {
        let path = path.into();
        let blank = if purpose.is_empty() { "" } else { " " };
        let mut error = self.at(format_args!("{purpose}{blank}{}", path.display()));
        error.inner().place.file = Some(path);
        error
    }

    /// Puts the file and the number of the line, from 1, before the message.
    pub(crate) fn in_line(self, path: impl Into<PathBuf>, line: usize) -> Self {
        let mut error = self.at(format_args!("line {line}"));
        error.inner().place.line = Some(line);
        error.in_file("", path)
    }

    /// Puts the file and the number of the HDU, from 0, before the message.
    #[cfg(all(feature = "fits", unix))]
    pub(crate) fn in_hdu(self, path: &Path, hdu: usize) -> Self {
        let mut error = self.at(format_args!("HDU {hdu}"));
        error.inner().place.hdu = Some(hdu);
        error.in_file("", path)
    }

    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// Returns the name of the value that is wrong or missing, if the error is about one value.
    pub fn what(&self) -> Option<&str> {
        match &self.0.problem {
            Problem::Is { what, .. } | Problem::Unknown { what, .. } | Problem::Missing { what } => Some(what),
            Problem::OfFile(_) | Problem::Text(_) => None,
        }
    }

    /// Returns the given value, shortened and escaped.
    pub fn given(&self) -> Option<&str> {
        match &self.0.problem {
            Problem::Is { given, .. } | Problem::Unknown { given, .. } => Some(given.as_str()),
            Problem::Missing { .. } | Problem::OfFile(_) | Problem::Text(_) => None,
        }
    }

    /// Returns the accepted values.
    pub fn allowed(&self) -> Option<&str> {
        self.0.allowed.as_deref()
    }

    /// Returns the place as in the message: file, line, HDU, key, or the name of an exposure. Empty without one.
    pub fn place(&self) -> &str {
        &self.0.place.text
    }

    /// Returns the file in which the error is.
    pub fn file(&self) -> Option<&Path> {
        self.0.place.file.as_deref()
    }

    /// Returns the number of the line in the file, from 1.
    pub fn line(&self) -> Option<usize> {
        self.0.place.line
    }

    /// Returns the number of the HDU in the file, from 0.
    pub fn hdu(&self) -> Option<usize> {
        self.0.place.hdu
    }
}

impl Display for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Inner { place, problem, allowed, .. } = &*self.0;
        let joint = match problem {
            _ if place.text.is_empty() => "",
            Problem::OfFile(_) => " ",
            _ => ": ",
        };
        let (problem, allowed_follows) = match problem {
            Problem::Is { what, given } => (format!("{what} is {given}"), "allowed:"),
            Problem::Unknown { what, given } => (format!("unknown {what} {given:?}"), "allowed:"),
            Problem::Missing { what } => (format!("missing {what}"), "specify"),
            Problem::OfFile(text) | Problem::Text(text) => (text.clone(), "allowed:"),
        };
        let allowed = allowed.as_ref().map_or_else(String::new, |allowed| format!("; {allowed_follows} {allowed}"));
        formatter.write_str(&bounded(&printable(&format!("{}{joint}{problem}{allowed}", place.text))))
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?}: {self}", self.kind())
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        self.0.source.as_deref().map(|source| source as _)
    }
}

/// Converts the errors of modules that have their own type.
macro_rules! from_module {
    ($($(#[$cfg:meta])* $error:path,)*) => {
        $($(#[$cfg])* impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::caused(ErrorKind::Invalid, error)
            }
        })*
    };
}

from_module! {
    crate::config::ConfigError,
    crate::elements::ElementsError,
    #[cfg(feature = "fit")]
    crate::fit::FitError,
    crate::forecast::ForecastError,
    crate::frames::FramesError,
    crate::geometry::GeometryError,
    crate::identify::IdentifyError,
    crate::images::ImagesError,
    crate::learn::LearnError,
    crate::maps::MapError,
    crate::measure::MeasureError,
    crate::orbit::OrbitError,
    crate::passes::LearnedError,
    crate::passes::SkyError,
    crate::photometry::PhotometryError,
    #[cfg(feature = "plot")]
    crate::plot::PlotError,
    crate::schedule::ScheduleError,
    crate::streaks::StreaksError,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_place_value_and_accepted_values() {
        let error = Error::invalid("ra_deg", 400.0, "0 to 360 deg").in_line("a.csv", 3);
        assert_eq!(error.to_string(), "a.csv: line 3: ra_deg is 400; allowed: 0 to 360 deg");
        assert_eq!((error.kind(), error.what(), error.given()), (ErrorKind::Invalid, Some("ra_deg"), Some("400")));
        assert_eq!((error.allowed(), error.file(), error.line()), (Some("0 to 360 deg"), Some("a.csv".as_ref()), Some(3)));
        let inner = Error::invalid("PSF", "x", "a FITS image").at("extension PSF").at("psf.fits");
        assert_eq!((inner.place(), inner.file()), ("psf.fits: extension PSF", None));
        assert_eq!(Error::missing("site", "--mpc").to_string(), "missing site; specify --mpc");
        let unknown = Error::unknown("band", "Q\n", "B or V");
        assert_eq!((unknown.to_string().as_str(), unknown.given()), ("unknown band \"Q\\n\"; allowed: B or V", Some("Q\\n")));
        let empty = Error::about_file("schedule", "a.csv", "is empty").allowing("one row");
        assert_eq!(empty.to_string(), "schedule a.csv is empty; allowed: one row");
        assert_eq!((empty.kind(), empty.what(), empty.given()), (ErrorKind::Format, None, None));
    }

    #[test]
    fn errors_of_the_system_keep_file_and_source() {
        let missing = || std::io::Error::new(std::io::ErrorKind::NotFound, "no such file");
        for (error, text) in [
            (Error::io("a.fits".as_ref())(missing()), "a.fits: no such file"),
            (Error::cannot("write", "a.fits", missing()), "cannot write a.fits: no such file"),
        ] {
            assert_eq!((error.to_string().as_str(), error.kind()), (text, ErrorKind::File));
            assert_eq!(error.file(), Some("a.fits".as_ref()));
            let source = error.source().and_then(|source| source.downcast_ref::<std::io::Error>());
            assert_eq!(source.map(std::io::Error::kind), Some(std::io::ErrorKind::NotFound));
        }
    }

    /// Inputs of any length and content, in each part of a message.
    #[test]
    fn messages_are_bounded() {
        let long = "\u{1b}é".repeat(100_000);
        for error in [
            Error::invalid("value", &long, "1"),
            Error::invalid(long.clone(), 1, "1"),
            Error::invalid("value", 1, long.clone()),
            Error::unknown("name", &long, "1"),
            Error::new(ErrorKind::Invalid, long.clone()),
            Error::missing("value", "1").at(&long),
            Error::about_file("schedule", &long, "is empty"),
            Error::caused(ErrorKind::File, std::io::Error::other(long.clone())),
        ] {
            let text = error.to_string();
            assert!(text.chars().count() <= 1000 && !text.contains('\u{1b}'), "{text:?}");
            assert!(error.given().is_none_or(|given| given.chars().count() < 1000), "{text}");
        }
    }

    #[test]
    fn errors_are_small_and_shared_between_threads() {
        fn assert_shared<T: Send + Sync + 'static>(_: &T) {}
        assert_shared(&Error::missing("site", "--mpc"));
        assert_eq!(size_of::<Result<(), Error>>(), size_of::<usize>());
    }
}

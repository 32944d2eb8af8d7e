//! The error type of the crate, its constructors and its places.

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
/// let error = Site::new_deg("Vienna", 95.0, 16.4, 0.0).unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Invalid);
/// assert!(error.to_string().ends_with("; allowed: -90 to 90 deg"));
/// ```
#[derive(Clone)]
pub struct Error(Arc<Inner>);

#[derive(Clone)]
struct Inner {
    kind: ErrorKind,
    place: Place,
    sentence: Sentence,
    what: Option<String>,
    given: Option<Quoted>,
    remark: Option<String>,
    allowed: Option<String>,
    source: Option<Arc<dyn StdError + Send + Sync>>,
}

/// Where an error is: file, line and the like as text, and as numbers if they are known.
#[derive(Clone, Default)]
struct Place {
    text: String,
    file: Option<PathBuf>,
    line: Option<usize>,
    hdu: Option<usize>,
}

/// Sentence of an error, between its place and the accepted values.
#[derive(Clone)]
enum Sentence {
    /// `WHAT is GIVEN`
    Is,
    /// `unknown WHAT "GIVEN"`
    Unknown,
    /// `invalid WHAT 'GIVEN'`
    Malformed,
    /// `missing WHAT`
    Missing,
    /// Sentence whose subject is the file of the place.
    OfFile(String),
    Text(String),
}

/// Constructors. Each adds `; allowed: ALLOWED` to its message, or `; specify ALLOWED` if a value is missing.
impl Error {
    fn of_value(kind: ErrorKind, sentence: Sentence, what: impl Into<String>) -> Self {
        let mut error = Self::of_sentence(kind, sentence);
        error.inner().what = Some(what.into());
        error
    }

    fn of_sentence(kind: ErrorKind, sentence: Sentence) -> Self {
        let place = Place::default();
        Self(Arc::new(Inner {
            kind,
            place,
            sentence,
            what: None,
            given: None,
            remark: None,
            allowed: None,
            source: None,
        }))
    }

    /// Creates an error from a sentence.
    pub(crate) fn new(kind: ErrorKind, sentence: impl Into<String>) -> Self {
        Self::of_sentence(kind, Sentence::Text(sentence.into()))
    }

    /// Creates the error `WHAT is GIVEN`.
    pub(crate) fn invalid(what: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        let given = Quoted::statement(&given.to_string());
        Self::of_value(ErrorKind::Invalid, Sentence::Is, what).with_given(given).allowing(allowed)
    }

    /// Creates the error `unknown WHAT "GIVEN"`.
    pub(crate) fn unknown(what: impl Into<String>, given: &str, allowed: impl Into<String>) -> Self {
        let error = Self::of_value(ErrorKind::Invalid, Sentence::Unknown, what);
        error.with_given(Quoted::new(given)).allowing(allowed)
    }

    /// Creates the error `invalid WHAT 'GIVEN'`, of a text in an invalid form.
    pub(crate) fn malformed(what: impl Into<String>, given: &str, allowed: impl Into<String>) -> Self {
        let error = Self::of_value(ErrorKind::Invalid, Sentence::Malformed, what);
        error.with_given(Quoted::new(given)).allowing(allowed)
    }

    /// Creates the error `missing WHAT`.
    pub(crate) fn missing(what: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self::of_value(ErrorKind::Missing, Sentence::Missing, what).allowing(allowed)
    }

    /// Creates the error of invalid content of a file.
    pub(crate) fn format(sentence: impl Into<String>) -> Self {
        Self::new(ErrorKind::Format, sentence)
    }

    /// Creates the error `PURPOSE PATH PREDICATE`, of a file whose content is invalid, such as `schedule x.csv is
    /// empty`.
    pub(crate) fn about_file(purpose: &str, path: impl Into<PathBuf>, predicate: impl Into<String>) -> Self {
        Self::of_sentence(ErrorKind::Format, Sentence::OfFile(predicate.into())).in_file(purpose, path)
    }

    /// Creates an error with the message of another one, which is its source.
    pub(crate) fn caused(kind: ErrorKind, source: impl StdError + Send + Sync + 'static) -> Self {
        let mut error = Self::new(kind, source.to_string());
        error.inner().source = Some(Arc::new(source));
        error
    }

    /// Creates an error with the message of the operating system or of a reader of tables, which is its source.
    pub(crate) fn system(source: std::io::Error) -> Self {
        let is_content = source.kind() == std::io::ErrorKind::InvalidData;
        Self::caused(if is_content { ErrorKind::Format } else { ErrorKind::File }, source)
    }

    /// Creates the error `cannot ACTION PATH: SOURCE`.
    pub(crate) fn cannot(action: &str, path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::system(source).in_file(&format!("cannot {action}"), path)
    }

    /// Returns a function that converts an error of the operating system to the error `PATH: SOURCE`.
    pub(crate) fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        move |source| Self::system(source).in_file("", path)
    }

    /// Rejects a number that is outside a range or not finite.
    pub(crate) fn check_range(what: impl Into<String>, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::invalid(what, given, format!("{least} to {greatest}")))
    }

    fn inner(&mut self) -> &mut Inner {
        Arc::make_mut(&mut self.0)
    }

    /// Adds the accepted values.
    pub(crate) fn allowing(mut self, allowed: impl Into<String>) -> Self {
        self.inner().allowed = Some(allowed.into());
        self
    }

    /// Adds a remark after the sentence, before the accepted values.
    pub(crate) fn with_remark(mut self, remark: impl Into<String>) -> Self {
        self.inner().remark = Some(remark.into());
        self
    }

    /// Adds the name of the value that is wrong, which the sentence contains.
    pub(crate) fn about(mut self, what: &str) -> Self {
        self.inner().what = Some(what.to_owned());
        self
    }

    /// Adds the given value, which the sentence contains in another form.
    pub(crate) fn with_given(mut self, given: Quoted) -> Self {
        self.inner().given = Some(given);
        self
    }

    /// Puts a place before the message. Places that are added later enclose it. An error that names a file is returned
    /// unchanged.
    pub(crate) fn at(mut self, place: impl Display) -> Self {
        if self.file().is_none() {
            let own = &mut self.inner().place.text;
            *own = if own.is_empty() { place.to_string() } else { format!("{place}: {own}") };
        }
        self
    }

    /// Puts a file before the message, after a word for its purpose such as `schedule`, which may be empty. An error
    /// that names a file is returned unchanged.
    pub(crate) fn in_file(self, purpose: &str, path: impl Into<PathBuf>) -> Self {
        let path = path.into();
        self.located(named(purpose, &path), path, None)
    }

    /// Puts a file, with its purpose, and the number of a line, from 1, before the message.
    pub(crate) fn in_line(self, purpose: &str, path: impl Into<PathBuf>, line: usize) -> Self {
        let path = path.into();
        let joint = if purpose.is_empty() { ": " } else { ", " };
        self.located(format_args!("{}{joint}line {line}", named(purpose, &path)), path, Some(line))
    }

    /// Puts the number of a line, from 1, before the message, to which the file is added later.
    pub(crate) fn on_line(self, line: usize) -> Self {
        let mut error = self.at(format_args!("line {line}"));
        if error.file().is_none() {
            error.inner().place.line = Some(line);
        }
        error
    }

    /// Puts a file and the number of an HDU, from 0, before the message.
    #[cfg(all(feature = "fits", unix))]
    pub(crate) fn in_hdu(self, path: &Path, hdu: usize) -> Self {
        if self.file().is_some() {
            return self;
        }
        let mut error = self.located(format_args!("{}: HDU {hdu}", path.display()), path, None);
        error.inner().place.hdu = Some(hdu);
        error
    }

    /// Puts a place before the message, and states its file and line. An error that names a file is returned unchanged.
    pub(crate) fn located(self, place: impl Display, path: impl Into<PathBuf>, line: Option<usize>) -> Self {
        if self.file().is_some() { self } else { self.within(place, path, line) }
    }

    /// Puts the place in a configuration before the message, which may name another file that is mentioned there.
    pub(crate) fn within(mut self, place: impl Display, path: impl Into<PathBuf>, line: Option<usize>) -> Self {
        let own = &mut self.inner().place;
        own.text = if own.text.is_empty() { place.to_string() } else { format!("{place}: {}", own.text) };
        if own.file.is_none() {
            (own.file, own.line) = (Some(path.into()), line.or(own.line));
        }
        self
    }

    /// Replaces the word for the purpose of the file, with which the place begins.
    pub(crate) fn with_purpose(mut self, from: &str, to: &str) -> Self {
        let text = &mut self.inner().place.text;
        if let Some(rest) = text.strip_prefix(from).filter(|rest| rest.starts_with(' ')) {
            *text = format!("{to}{rest}");
        }
        self
    }

    /// Replaces the file that the message names, for example a temporary one by that of the user.
    #[cfg(all(feature = "fits", unix))]
    pub(crate) fn of_file(mut self, path: &Path) -> Self {
        let hdu = self.hdu();
        self.inner().place = Place::default();
        match hdu {
            Some(hdu) => self.in_hdu(path, hdu),
            None => self.in_file("", path),
        }
    }
}

/// Returns a file and the word for its purpose as text.
fn named(purpose: &str, path: &Path) -> String {
    if purpose.is_empty() { path.display().to_string() } else { format!("{purpose} {}", path.display()) }
}

impl Error {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// Returns the name of the value that is wrong or missing, if the error is about one value.
    pub fn what(&self) -> Option<&str> {
        self.0.what.as_deref()
    }

    /// Returns the given value, shortened and escaped.
    pub fn given(&self) -> Option<&str> {
        self.0.given.as_ref().map(Quoted::as_str)
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
        let (what, given) = (self.what().unwrap_or_default(), self.given().unwrap_or_default());
        let sentence = match &self.0.sentence {
            Sentence::Is => format!("{what} is {given}"),
            Sentence::Unknown => format!("unknown {what} \"{given}\""),
            Sentence::Malformed => format!("invalid {what} '{given}'"),
            Sentence::Missing => format!("missing {what}"),
            Sentence::OfFile(text) | Sentence::Text(text) => text.clone(),
        };
        let joint = match self.0.sentence {
            _ if self.place().is_empty() => "",
            Sentence::OfFile(_) => " ",
            _ => ": ",
        };
        let verb = if matches!(self.0.sentence, Sentence::Missing) { "specify" } else { "allowed:" };
        let allowed = self.allowed().map_or_else(String::new, |allowed| format!("; {verb} {allowed}"));
        let remark = self.0.remark.as_ref().map_or_else(String::new, |remark| format!("; {remark}"));
        formatter.write_str(&bounded(&printable(&format!("{}{joint}{sentence}{remark}{allowed}", self.place()))))
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?}: {self}", self.kind())
    }
}

/// Errors are equal if their kinds and messages are.
impl PartialEq for Error {
    fn eq(&self, other: &Self) -> bool {
        self.kind() == other.kind() && self.to_string() == other.to_string()
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        self.0.source.as_deref().map(|source| source as _)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(all(feature = "fits", unix))]
    #[test]
    fn remarks_precede_accepted_values() {
        let error = Error::invalid("seeing", 0, "0.1 to 10").with_remark("1 of 2 frames are written").in_file("", "a");
        assert_eq!(error.to_string(), "a: seeing is 0; 1 of 2 frames are written; allowed: 0.1 to 10");
    }

    #[test]
    fn messages_have_place_value_and_accepted_values() {
        let error = Error::invalid("ra_deg", 400.0, "0 to 360 deg").in_line("", "a.csv", 3);
        assert_eq!(error.to_string(), "a.csv: line 3: ra_deg is 400; allowed: 0 to 360 deg");
        assert_eq!((error.kind(), error.what(), error.given()), (ErrorKind::Invalid, Some("ra_deg"), Some("400")));
        assert_eq!(
            (error.allowed(), error.file(), error.line()),
            (Some("0 to 360 deg"), Some("a.csv".as_ref()), Some(3))
        );
        let error = Error::format("unknown key 'a'").on_line(3).in_file("policy", "p.toml");
        assert_eq!(error.to_string(), "policy p.toml: line 3: unknown key 'a'");
        assert_eq!((error.file(), error.line()), (Some("p.toml".as_ref()), Some(3)));
        let error = Error::format("is x").in_file("schedule", "schedule.csv").with_purpose("schedule", "target list");
        assert_eq!(error.place(), "target list schedule.csv");
        let inner = Error::invalid("PSF", "x", "a FITS image").at("extension PSF").at("psf.fits");
        assert_eq!((inner.place(), inner.file()), ("psf.fits: extension PSF", None));
        assert_eq!(Error::missing("site", "--mpc").to_string(), "missing site; specify --mpc");
        let unknown = Error::unknown("band", "Q\n", "B or V");
        assert_eq!(
            (unknown.to_string().as_str(), unknown.given()),
            ("unknown band \"Q\\n\"; allowed: B or V", Some("Q\\n"))
        );
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

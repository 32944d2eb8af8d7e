//! Comments of header cards: what they state about the instant, the unit or the number of parts of a value.
//!
//! `part` reads the part of the exposure to which an instant refers, `clock` local times and time scales, `doubt`
//! uncertainties and remarks about clocks, and `unit` units of time.

mod clock;
mod doubt;
mod part;
mod unit;

pub use part::{AFTER_EXPOSURE, Role};
pub use unit::seconds_in;

const EXPOSURE: &str = "exposure exposures exposed exp expo exposition exposicion exposicao esposizione exptime pose posa \
     belichtung belichtungs aufnahme integration integrations int observation observations observing obs frame frames image images \
     img shutter scan capture stack interval visit coadd coadds dce";
const CLOCK: &str = "time times date dates datetime timestamp timestamps stamp t ut utc ut1 tu tai tt tdb gmt epoch jd \
     mjd julian instant moment point points pt way yyyy ccyy dd hh hms ymd";
/// Phrases in which a word of a part or of a zone qualifies something else.
const OTHER_MEANINGS: &[&str] = &[
    "front end",
    "back end",
    "f stop",
    "closed loop",
    "open loop",
    "open source",
    "data center",
    "data centre",
    "half second",
    "half a second",
    "half day",
    "half a day",
    "greenwich mean",
    "universal mean",
    "mean equinox",
    "modified julian",
    "modified jd",
    "mid night",
    "not local",
    "not in local",
    "non local",
    "not the local",
];

/// Returns true if a list of words contains a word, in upper or lower case.
fn lists(list: &str, word: &str) -> bool {
    list.split_ascii_whitespace().any(|other| other.eq_ignore_ascii_case(word))
}

/// Splits words such as "MidExposure", "UTstart" and "expend" into a word of a part and one of the exposure or a clock.
fn parts_of_word(word: &str) -> Vec<&str> {
    let is_part = |word: &str| part::PARTS.iter().any(|(_, list)| lists(list, word));
    let is_other = |word: &str| lists(EXPOSURE, word) || lists(CLOCK, word);
    let ends = (1..word.len()).map(|at| word.split_at(at));
    let found = ends.filter(|(first, last)| (is_part(first) && is_other(last)) || (is_other(first) && is_part(last)));
    // "exposureMidTime" has three.
    let capital = || {
        let is_end = |at: &usize| {
            let (first, last) = word.split_at(*at);
            first.ends_with(|c: char| c.is_ascii_lowercase()) && last.starts_with(|c: char| c.is_ascii_uppercase())
        };
        let at = (3..word.len().saturating_sub(2)).find(is_end)?;
        Some(word.split_at(at))
    };
    if is_part(word) || is_other(word) {
        return vec![word];
    }
    match found.last() {
        Some((first, last)) => vec![first, last],
        None => capital().map_or_else(|| vec![word], |(first, rest)| [vec![first], parts_of_word(rest)].concat()),
    }
}

/// Comment of a card with its words.
#[derive(Clone, Debug)]
pub struct Comment {
    text: String,
    /// Clauses between commas, brackets, ... with their words as written: runs of letters and digits, without the
    /// phrases of [`OTHER_MEANINGS`].
    clauses: Vec<Vec<String>>,
}

impl Comment {
    pub fn new(text: &str) -> Self {
        let clauses = text.split([',', ';', ':', '.', '(', ')', '[', ']']).map(|clause| {
            let words = clause.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
            let mut words: Vec<String> = words.flat_map(parts_of_word).map(str::to_owned).collect();
            for phrase in OTHER_MEANINGS {
                let phrase: Vec<&str> = phrase.split(' ').collect();
                let is_phrase = |part: &[String]| part.iter().zip(&phrase).all(|(a, b)| a.eq_ignore_ascii_case(b));
                while let Some(at) = words.windows(phrase.len()).position(is_phrase) {
                    words.drain(at..at + phrase.len());
                }
            }
            words
        });
        Self { text: text.to_owned(), clauses: clauses.filter(|words| !words.is_empty()).collect() }
    }

    /// Returns the text without surrounding blanks.
    pub fn text(&self) -> &str {
        &self.text
    }

    fn words(&self) -> impl Iterator<Item = &str> {
        self.clauses.iter().flatten().map(String::as_str)
    }

    /// Returns true if the comment contains a word of a list.
    pub fn has(&self, list: &str) -> bool {
        self.words().any(|word| lists(list, word))
    }

    /// Returns true if a word of the first list is followed by a word of the second list in the same clause.
    pub fn has_pair(&self, first: &str, second: &str) -> bool {
        let is_pair = |pair: &[String]| lists(first, &pair[0]) && lists(second, &pair[1]);
        self.clauses.iter().any(|words| words.windows(2).any(is_pair))
    }
}

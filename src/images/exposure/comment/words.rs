//! Words of comments.

/// Part of an exposure to which an instant refers.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Role {
    Start,
    Middle,
    End,
}

/// Words of the parts of an exposure. They count only where they qualify a word of [`EXPOSURE`] or [`CLOCK`].
pub(super) const PARTS: &[(Role, &str)] = &[
    (
        Role::Start,
        "start starts started starting begin begins beginning began beg open opens opened opening debut beginn anfang \
         inicio inizio",
    ),
    (
        Role::Middle,
        "mid middle midway half halfway effective weighted center centre central average averaged avg mean median mitte milieu mitad \
         medio centro meio",
    ),
    (
        Role::End,
        "end ends ended ending finish finished stop stops stopped close closes closed closing closure shut off complete \
         completion completed terminated fin fim ende eoe",
    ),
];
/// Words of exposures, and of clocks and dates.
pub(super) const EXPOSURE: &str = "exposure exposures exposed exp expo exposition exposicion exposicao esposizione exptime pose posa \
     belichtung belichtungs aufnahme integration integrations int observation observations observing obs frame frames image images \
     img shutter scan capture stack interval visit coadd coadds dce";
/// Words of the frames of a stack.
pub const FRAMES: &str = "image images frame frames exposure exposures subframe subframes sub subs subexposures inputs \
     files lights";
pub(super) const CLOCK: &str = "time times date dates datetime timestamp timestamps stamp t ut utc ut1 tu tai tt tdb gmt epoch jd \
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
    "frame transfer mode",
    "frame transfer ccd",
    "frame transfer camera",
    "frame transfer exposure",
    "mean julian",
    "mean solar day",
    "mean solar days",
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

/// Words of a part that are written together with a word of the exposure or a clock, as in "tmid" and "expend", and
/// words that only seem to be such a pair.
const JOINED_PARTS: &str = "start begin beginn beg mid middle mitte end ende stop";
const NO_PAIRS: &str = "intend endpoint";

/// Returns true if a list of words contains a word, in upper or lower case.
pub(super) fn lists(list: &str, word: &str) -> bool {
    list.split_ascii_whitespace().any(|other| other.eq_ignore_ascii_case(word))
}

/// Splits words such as "UTstart" and "expend" into a word of a part and one of the exposure or a clock, and other
/// words, such as "EndOfExposure", at their capitals.
fn parts_of_word(word: &str) -> Vec<&str> {
    let is_other = |word: &str| lists(EXPOSURE, word) || lists(CLOCK, word);
    let pair = JOINED_PARTS.split_ascii_whitespace().filter(|part| part.len() < word.len()).find_map(|part| {
        let [after, before] = [part.len(), word.len() - part.len()].map(|at| word.split_at(at));
        let is_first = after.0.eq_ignore_ascii_case(part) && is_other(after.1);
        let is_last = || before.1.eq_ignore_ascii_case(part) && is_other(before.0);
        if is_first { Some(after) } else { is_last().then_some(before) }
    });
    let letters = word.as_bytes();
    let capital = || {
        let is_end = |at: &usize| letters[at - 1].is_ascii_lowercase() && letters[*at].is_ascii_uppercase();
        (2..letters.len().saturating_sub(2)).find(is_end).map(|at| word.split_at(at))
    };
    match pair.filter(|_| !lists(NO_PAIRS, word)) {
        Some((first, last)) => vec![first, last],
        None => capital().map_or_else(|| vec![word], |(first, rest)| [vec![first], parts_of_word(rest)].concat()),
    }
}

/// Comment of a card with its words.
#[derive(Clone, Debug)]
pub struct Comment {
    pub(super) text: String,
    /// Clauses between commas, brackets, ... with their words as written: runs of letters and digits, without the
    /// phrases of [`OTHER_MEANINGS`].
    pub(super) clauses: Vec<Vec<String>>,
}

/// Returns a text with abbreviations such as "L.T." as one word.
fn without_dots(text: &str) -> String {
    let is_abbreviation = |word: &str| {
        word.trim_matches('.').contains('.')
            && word.split('.').all(|letter| letter.len() <= 1 && letter.chars().all(|c| c.is_ascii_alphabetic()))
    };
    let words = text.split_inclusive([' ', ',', ';', ':', '(', ')', '[', ']']);
    let joined = |word: &str| {
        let bare = word.trim_end_matches(|c: char| c != '.' && !c.is_ascii_alphanumeric());
        if is_abbreviation(bare) { word.replace('.', "") } else { word.to_owned() }
    };
    words.map(joined).collect()
}

impl Comment {
    pub fn new(text: &str) -> Self {
        let joined = without_dots(text);
        let clauses = joined.split([',', ';', ':', '.', '(', ')', '[', ']']).map(|clause| {
            let words = clause.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
            let mut words: Vec<String> = words.flat_map(parts_of_word).map(str::to_owned).collect();
            for phrase in OTHER_MEANINGS {
                let is_word =
                    |at: usize, word: &str| words.get(at).is_some_and(|other| other.eq_ignore_ascii_case(word));
                let is_phrase = |at: &usize| phrase.split(' ').enumerate().all(|(next, word)| is_word(at + next, word));
                if let Some(at) = (0..words.len()).find(is_phrase) {
                    words.drain(at..at + phrase.split(' ').count());
                }
            }
            words
        });
        Self { text: text.to_owned(), clauses: clauses.filter(|words| !words.is_empty()).collect() }
    }

    /// Returns the text as written.
    pub fn text(&self) -> &str {
        &self.text
    }

    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
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

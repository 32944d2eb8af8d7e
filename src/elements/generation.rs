//! Satellite generations, which determine the brightness model.
//!
//! The generation of a Starlink satellite is determined from its launch if that is in the table
//! ([`STARLINK_TABLE_DATE`]), else from its name, else from its launch date or catalogue number. For other
//! constellations the name determines the generation, or for an object without a name, its launch or catalogue number.
//! [`Certainty`] states which of these was used. Names are those of CelesTrak and Space-Track.

use std::collections::HashMap;
use std::fmt;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::element_set::{ElementSet, NoradId, Origin};

/// Table of launches with the generations of their satellites.
const LAUNCHES: &str = include_str!("launches.txt");

/// Last day of the table of Starlink launches.
pub const STARLINK_TABLE_DATE: &str = "14 April 2025";

/// Launches shared by satellites of several kinds: for an object without a name, the launch does not determine the
/// generation. 2021-006 and 2021-059 carried only a few Starlink satellites. 2018-047, a launch of Iridium NEXT, also
/// carried GRACE-FO, and 2023-068 also carried OneWeb satellites.
const SHARED_LAUNCHES: [Launch; 4] = [Launch(2018, 47), Launch(2021, 6), Launch(2021, 59), Launch(2023, 68)];

/// Lowest number in the names of Iridium NEXT; the first generation has numbers below 100.
const FIRST_IRIDIUM_NEXT: u32 = 100;

/// Ranges of catalogue numbers (first and last) of Iridium NEXT, from the launches of 2017 to 2019 and 2023; from
/// CelesTrak's catalogue of 14 August 2024.
const IRIDIUM_NEXT_NORAD_IDS: [[u32; 2]; 9] = [
    [41_917, 41_926],
    [42_803, 42_812],
    [42_955, 42_964],
    [43_070, 43_079],
    [43_249, 43_258],
    [43_478, 43_482],
    [43_569, 43_578],
    [43_922, 43_931],
    [56_726, 56_730],
];

/// Generation of satellites: a type with its own brightness model.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Generation {
    /// V0.9: the 60 satellites launched in May 2019.
    #[serde(rename = "starlink-v0.9")]
    StarlinkV09,
    /// V1.0, launched from November 2019 to July 2020: no visor, no dielectric mirror.
    #[serde(rename = "starlink-v1.0")]
    StarlinkV10,
    /// V1.0 with a visor: STARLINK-1436, and all launched from August 2020 to June 2021.
    #[serde(rename = "starlink-visorsat")]
    StarlinkVisorSat,
    /// V1.5, launched from June 2021: laser links, dielectric mirror film, no visor.
    #[serde(rename = "starlink-v1.5")]
    StarlinkV15,
    /// V2 Mini, launched from February 2023.
    #[serde(rename = "starlink-v2mini")]
    StarlinkV2Mini,
    /// V2 Mini with an antenna for mobile telephones, launched from January 2024, in lower orbits.
    #[serde(rename = "starlink-direct-to-cell")]
    StarlinkDirectToCell,
    /// Second generation of Iridium, launched from January 2017.
    #[serde(rename = "iridium-next")]
    IridiumNext,
    /// OneWeb.
    #[serde(rename = "oneweb")]
    OneWeb,
    /// Amazon Leo, formerly Kuiper.
    #[serde(rename = "kuiper")]
    Kuiper,
    /// Qianfan (G60, Spacesail).
    #[serde(rename = "qianfan")]
    Qianfan,
    /// Guowang satellites in low orbit (HULIANWANG DIGUI).
    #[serde(rename = "guowang")]
    Guowang,
    /// AST SpaceMobile: BlueWalker 3 and the BlueBirds.
    #[serde(rename = "bluebird")]
    BlueBird,
    /// All other objects.
    #[serde(rename = "other")]
    Other,
}

impl Generation {
    /// All generations.
    pub const ALL: [Self; 13] = [
        Self::StarlinkV09,
        Self::StarlinkV10,
        Self::StarlinkVisorSat,
        Self::StarlinkV15,
        Self::StarlinkV2Mini,
        Self::StarlinkDirectToCell,
        Self::IridiumNext,
        Self::OneWeb,
        Self::Kuiper,
        Self::Qianfan,
        Self::Guowang,
        Self::BlueBird,
        Self::Other,
    ];

    /// Returns the name in files and messages, such as `starlink-v1.5`.
    pub fn name(self) -> &'static str {
        match self {
            Self::StarlinkV09 => "starlink-v0.9",
            Self::StarlinkV10 => "starlink-v1.0",
            Self::StarlinkVisorSat => "starlink-visorsat",
            Self::StarlinkV15 => "starlink-v1.5",
            Self::StarlinkV2Mini => "starlink-v2mini",
            Self::StarlinkDirectToCell => "starlink-direct-to-cell",
            Self::IridiumNext => "iridium-next",
            Self::OneWeb => "oneweb",
            Self::Kuiper => "kuiper",
            Self::Qianfan => "qianfan",
            Self::Guowang => "guowang",
            Self::BlueBird => "bluebird",
            Self::Other => "other",
        }
    }

    /// Returns true for the generations of Starlink.
    pub fn is_starlink(self) -> bool {
        self.name().starts_with("starlink-")
    }

    /// Returns the generation with this [`name`](Self::name).
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|generation| generation.name() == name)
    }
}

impl fmt::Display for Generation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// Evidence from which a generation was determined.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Certainty {
    /// The launch or the catalogue number is in a bundled table.
    Table,
    /// The name of the object, or the number in the name, determines the generation.
    Name,
    /// Only the launch date or the catalogue number makes the generation likely, or the satellite is simulated.
    Guess,
}

/// Year and number of a launch, ordered by time.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Launch(u16, u16);

impl Launch {
    /// Parses `2020-055` or `2020-055AB`.
    fn parse(designator: &str) -> Option<Self> {
        let (year, rest) = designator.split_once('-')?;
        let number = rest.get(..3)?;
        Some(Self(year.parse().ok()?, number.parse().ok()?))
    }
}

/// Table of launches and the generations of their satellites.
///
/// ```
/// use streakcast::elements::{Satellites, Generation, GenerationTable, ReadOptions};
///
/// let text = "\
/// STARLINK-3042
/// 1 49131U 21082A   22336.47699629  .00001505  00000+0  11993-3 0  999
/// 2 49131  70.0000 143.1715 0001798  75.7035 284.4154 14.99000000    1
/// ";
/// let catalogue = Satellites::from_bytes("v15.tle", text.as_bytes(), &ReadOptions::default())?;
/// assert_eq!(GenerationTable::embedded().generation(&catalogue.element_sets[0]), Generation::StarlinkV15);
/// # Ok::<(), streakcast::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct GenerationTable {
    launches: HashMap<Launch, Generation>,
    /// Last Starlink launch in the table.
    last_starlink: Launch,
}

static EMBEDDED: LazyLock<GenerationTable> = LazyLock::new(|| GenerationTable::parse(LAUNCHES));

impl GenerationTable {
    /// Returns the bundled table: Starlink launches to [`STARLINK_TABLE_DATE`], other constellations to April 2026.
    pub fn embedded() -> &'static Self {
        &EMBEDDED
    }

    /// Returns the generation of a satellite.
    pub fn generation(&self, set: &ElementSet) -> Generation {
        self.classify(set).0
    }

    /// Returns true for a real satellite whose generation is assumed: a Starlink satellite launched after the end of
    /// the table, which may be of a new generation, or an object whose generation follows only from its launch, launch
    /// date or catalogue number.
    pub fn is_assumed(&self, set: &ElementSet) -> bool {
        let (generation, certainty) = self.classify(set);
        let is_later =
            || Launch::parse(&set.international_designator).is_some_and(|launch| launch > self.last_starlink);
        set.origin != Origin::Synthetic
            && generation != Generation::Other
            && (certainty == Certainty::Guess || (generation.is_starlink() && is_later()))
    }

    /// Returns the generation of a satellite, and the evidence for it.
    pub fn classify(&self, set: &ElementSet) -> (Generation, Certainty) {
        if set.origin == Origin::Synthetic {
            return (synthetic(set.name.trim()), Certainty::Guess);
        }
        self.classify_object(&set.name, &set.international_designator, set.norad_id)
    }

    /// Returns the generation of a catalogued object by its name, international designator and catalogue number, and
    /// the evidence for it.
    pub fn classify_object(&self, name: &str, designator: &str, norad_id: NoradId) -> (Generation, Certainty) {
        let name = name.trim();
        let launch = Launch::parse(designator);
        // The names of debris and rocket bodies contain the name of their parent object.
        if name.ends_with(" DEB") || name.contains(" DEB ") || name.contains("R/B") {
            return (Generation::Other, Certainty::Name);
        }
        if let Some(rest) = strip_prefix_ignoring_case(name, "STARLINK") {
            return self.starlink(rest, launch, norad_id.0);
        }
        if name.is_empty() || strip_prefix_ignoring_case(name, "OBJECT ").is_some() {
            let id = norad_id.0;
            if IRIDIUM_NEXT_NORAD_IDS.iter().any(|[first, last]| (*first..=*last).contains(&id)) {
                return (Generation::IridiumNext, Certainty::Table);
            }
            // Without a name: most objects of a launch in the table are satellites of its generation.
            return match launch.and_then(|launch| Some((launch, *self.launches.get(&launch)?))) {
                Some((launch, generation)) if !SHARED_LAUNCHES.contains(&launch) => (generation, Certainty::Guess),
                _ => (Generation::Other, Certainty::Guess),
            };
        }
        let named = [
            ("ONEWEB", Generation::OneWeb),
            ("KUIPER", Generation::Kuiper),
            ("AMAZON LEO", Generation::Kuiper),
            ("AMAZON-LEO", Generation::Kuiper),
            ("QIANFAN", Generation::Qianfan),
            ("HULIANWANG DIGUI", Generation::Guowang),
            ("HULIANWANG-DIGUI", Generation::Guowang),
            ("GUOWANG", Generation::Guowang),
            ("BLUEWALKER", Generation::BlueBird),
            ("BLUEBIRD", Generation::BlueBird),
            ("SPACEMOBILE", Generation::BlueBird),
        ];
        if let Some(rest) = strip_prefix_ignoring_case(name, "IRIDIUM") {
            let is_next = number_at_start(rest).is_some_and(|number| number >= FIRST_IRIDIUM_NEXT);
            return (if is_next { Generation::IridiumNext } else { Generation::Other }, Certainty::Name);
        }
        let found = named.iter().find(|(prefix, _)| strip_prefix_ignoring_case(name, prefix).is_some());
        (found.map_or(Generation::Other, |(_, generation)| *generation), Certainty::Name)
    }

    /// Determines the generation of a satellite whose name starts with STARLINK; `rest` is the text after it.
    fn starlink(&self, rest: &str, launch: Option<Launch>, norad_id: u32) -> (Generation, Certainty) {
        let number = number_at_start(rest);
        // Direct-to-Cell satellites are launched together with V2 Mini satellites, so their launch does not determine
        // the generation.
        if rest.contains("[DTC]") || matches!(number, Some(11_000..=11_999)) {
            return (Generation::StarlinkDirectToCell, Certainty::Name);
        }
        // STARLINK-1436 was the first with a visor, on a launch of V1.0 satellites without visors.
        if number == Some(1436) {
            return (Generation::StarlinkVisorSat, Certainty::Name);
        }
        let listed = launch.and_then(|launch| self.launches.get(&launch)).copied().filter(|kind| kind.is_starlink());
        match (listed, number) {
            // Satellites with these numbers have visors, also on a launch of V1.0: STARLINK-1521 of 2020-038 is on the
            // VisorSat list of MMT-9.
            (Some(Generation::StarlinkV10), Some(1518..=2999)) => {
                return (Generation::StarlinkVisorSat, Certainty::Name);
            }
            (Some(generation), _) => return (generation, Certainty::Table),
            (None, _) => {}
        }
        match number {
            Some(21..=99) => (Generation::StarlinkV09, Certainty::Name),
            Some(1000..=1517) => (Generation::StarlinkV10, Certainty::Name),
            Some(1518..=2999) => (Generation::StarlinkVisorSat, Certainty::Name),
            Some(3000..=9999) => (Generation::StarlinkV15, Certainty::Name),
            Some(30_000..) => (Generation::StarlinkV2Mini, Certainty::Name),
            _ => (launch.map_or_else(|| by_norad_id(norad_id), by_date), Certainty::Guess),
        }
    }

    /// Parses lines of the form `generation: launch launch ...`; lines with `#` at the start are comments.
    fn parse(text: &str) -> Self {
        let mut launches = HashMap::new();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let Some((generation, list)) = line.split_once(':') else { continue };
            let Some(generation) = Generation::by_name(generation) else { continue };
            launches.extend(list.split_whitespace().filter_map(Launch::parse).map(|launch| (launch, generation)));
        }
        let starlinks = launches.iter().filter(|(_, generation)| generation.is_starlink());
        let last_starlink = starlinks.map(|(launch, _)| *launch).max().unwrap_or(Launch(0, 0));
        Self { launches, last_starlink }
    }
}

/// Returns the number after the name of a constellation, as in `STARLINK-1436` and `IRIDIUM 102`.
fn number_at_start(rest: &str) -> Option<u32> {
    let digits = rest.trim_start_matches(['-', ' ']);
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

/// Returns the generation of the Starlink satellites of that time, for a launch that is not in the table.
fn by_date(launch: Launch) -> Generation {
    match launch {
        _ if launch < Launch(2019, 74) => Generation::StarlinkV09,
        _ if launch < Launch(2020, 55) => Generation::StarlinkV10,
        _ if launch < Launch(2021, 59) => Generation::StarlinkVisorSat,
        _ if launch < Launch(2023, 26) => Generation::StarlinkV15,
        _ => Generation::StarlinkV2Mini,
    }
}

/// Returns the generation of Starlink that was launched when a catalogue number was assigned. Numbers beyond the last
/// limit give the latest generation.
fn by_norad_id(norad_id: u32) -> Generation {
    match norad_id {
        ..=44_700 => Generation::StarlinkV09,
        44_701..=46_026 => Generation::StarlinkV10,
        46_027..=48_879 => Generation::StarlinkVisorSat,
        48_880..=55_690 => Generation::StarlinkV15,
        _ => Generation::StarlinkV2Mini,
    }
}

/// Returns the generation assumed for a simulated constellation: the latest one built for its shells.
fn synthetic(name: &str) -> Generation {
    let assumed = [
        ("STARLINK-GEN1", Generation::StarlinkV15),
        ("STARLINK-GEN2", Generation::StarlinkV2Mini),
        ("ONEWEB", Generation::OneWeb),
        ("KUIPER", Generation::Kuiper),
        ("QIANFAN", Generation::Qianfan),
        ("GUOWANG", Generation::Guowang),
    ];
    assumed.iter().find(|(prefix, _)| name.starts_with(prefix)).map_or(Generation::Other, |(_, generation)| *generation)
}

fn strip_prefix_ignoring_case<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let head = text.get(..prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then(|| &text[prefix.len()..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_every_line_of_the_table_is_read() {
        let expected: usize = LAUNCHES
            .lines()
            .filter(|line| !line.starts_with('#') && !line.is_empty())
            .map(|line| line.split_whitespace().count() - 1)
            .sum();
        assert_eq!(GenerationTable::embedded().launches.len(), expected);
        assert_eq!(expected, 298);
        assert_eq!(GenerationTable::embedded().last_starlink, Launch(2025, 71));
    }

    #[test]
    fn verif_names_of_kinds_agree_everywhere() {
        for generation in Generation::ALL {
            assert_eq!(Generation::by_name(generation.name()), Some(generation));
            assert_eq!(serde_json::to_string(&generation).unwrap(), format!("\"{generation}\""));
        }
    }
}

//! Selection of satellites by generation, name or catalogue number.

use std::collections::HashSet;

use crate::elements::{ElementSet, Generation, GenerationTable, NoradId};
use crate::error::{Error, ErrorKind};

/// Names of well-known objects that no catalogue uses, in lower case, with the NORAD number. A station is selected by
/// its main module.
const WELL_KNOWN: [(&str, u32); 6] = [
    ("iss", 25544),
    ("tiangong", 48274),
    ("css", 48274),
    ("hubble", 20580),
    ("hubble space telescope", 20580),
    ("hst", 20580),
];

/// Selection of satellites by three lists. A satellite is selected if it matches at least one item of every list that
/// is not empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Generations of satellites.
    pub generations: Vec<Generation>,
    /// Names of satellites, in upper or lower case. A text selects the object that is well known by it (`ISS`, `HST`,
    /// `hubble`, `tiangong`), or else the satellites with exactly this name, or else those with it as words of their
    /// names, or else those with it anywhere in their names.
    pub names: Vec<String>,
    /// NORAD catalogue numbers.
    pub norad_ids: Vec<u32>,
}

/// Selected satellites of a catalogue.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selected(HashSet<NoradId>);

impl Selected {
    /// Returns true if a satellite is selected.
    pub fn contains(&self, elements: &ElementSet) -> bool {
        self.0.contains(&elements.norad_id)
    }

    /// Returns true if no satellite is selected.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// No satellite matches the selection.
pub(super) fn empty_selection(satellites: usize, selection: &str) -> Error {
    let sentence = format!("none of the {satellites} satellites has {selection}");
    Error::new(ErrorKind::Invalid, sentence).allowing(
        "a selection of at least one satellite (modules and docked spacecraft belong to their station: 25544 ISS, 48274 CSS)",
    )
}

/// Returns the satellites that a text selects by the first rule of [`Selection::names`] that selects any.
fn named(text: &str, elements: &[ElementSet]) -> HashSet<NoradId> {
    let text = text.trim().to_lowercase();
    let well_known = WELL_KNOWN.iter().find(|(name, _)| *name == text).map(|(_, id)| NoradId(*id));
    let rank = |set: &ElementSet| {
        let name = set.name.trim().to_lowercase();
        let rules = [well_known == Some(set.norad_id), name == text, has_words(&name, &text), name.contains(&text)];
        rules.iter().position(|applies| *applies)
    };
    let ranks: Vec<Option<usize>> = elements.iter().map(rank).collect();
    let best = ranks.iter().flatten().min();
    let selected = elements.iter().zip(&ranks).filter(|(_, rank)| rank.is_some() && rank.as_ref() == best);
    selected.map(|(set, _)| set.norad_id).collect()
}

/// Returns true if a name contains a text that neither begins nor ends within a word.
fn has_words(name: &str, text: &str) -> bool {
    let is_inside = |before: Option<char>, after: Option<char>| {
        before.is_some_and(char::is_alphanumeric) && after.is_some_and(char::is_alphanumeric)
    };
    name.match_indices(text).any(|(at, _)| {
        let end = at + text.len();
        !is_inside(name[..at].chars().next_back(), text.chars().next())
            && !is_inside(text.chars().next_back(), name[end..].chars().next())
    })
}

/// Returns a text of a selection by name, with a hint if it is a catalogue number.
fn shown_name(text: &str) -> String {
    let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if is_number { format!("{text} (--norad {text} selects a catalogue number)") } else { text.to_owned() }
}

impl Selection {
    /// Returns true if every satellite is selected.
    pub fn is_all(&self) -> bool {
        self.generations.is_empty() && self.names.is_empty() && self.norad_ids.is_empty()
    }

    /// Returns the selected satellites of a catalogue.
    #[doc(hidden)]
    pub fn among(&self, elements: &[ElementSet]) -> Selected {
        let named: HashSet<NoradId> = self.names.iter().flat_map(|text| named(text, elements)).collect();
        let is_selected = |set: &&ElementSet| {
            (self.norad_ids.is_empty() || self.norad_ids.contains(&set.norad_id.0))
                && (self.names.is_empty() || named.contains(&set.norad_id))
                && (self.generations.is_empty()
                    || self.generations.contains(&GenerationTable::embedded().generation(set)))
        };
        Selected(elements.iter().filter(is_selected).map(|set| set.norad_id).collect())
    }

    /// Returns a warning with the selected names and catalogue numbers that no element set has; `None` if there are
    /// none.
    pub fn unknown_warning(&self, elements: &[ElementSet]) -> Option<String> {
        let is_unknown = |id: &&u32| !elements.iter().any(|set| set.norad_id.0 == **id);
        let unknown: Vec<String> = self.norad_ids.iter().filter(is_unknown).map(ToString::to_string).collect();
        let unnamed: Vec<String> =
            self.names.iter().filter(|text| named(text, elements).is_empty()).map(|text| shown_name(text)).collect();
        let numbers = if unknown.len() == 1 { "number" } else { "numbers" };
        let parts = [
            (!unknown.is_empty()).then(|| format!("NORAD {numbers} {}", unknown.join(" or "))),
            (!unnamed.is_empty()).then(|| format!("a name with {}", unnamed.join(" or "))),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| format!("none of the {} satellites has {}", elements.len(), parts.join(", or ")))
    }

    /// Returns a description of the selection.
    pub fn description(&self) -> String {
        let list =
            |what: &str, items: Vec<String>| (!items.is_empty()).then(|| format!("{what} {}", items.join(" or ")));
        let parts = [
            list("generation", self.generations.iter().map(ToString::to_string).collect()),
            list("a name with", self.names.iter().map(|text| shown_name(text)).collect()),
            list("NORAD number", self.norad_ids.iter().map(ToString::to_string).collect()),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(" and ")
    }
}

#[cfg(test)]
mod tests {
    use hifitime::Epoch;

    use super::*;
    use crate::elements::Constellation;

    fn selected(text: &str) -> Vec<u32> {
        let any = Constellation::by_name("oneweb").unwrap().element_sets(Epoch::from_tai_seconds(0.0)).remove(0);
        let named = |name: &str, id: u32| ElementSet { name: name.into(), norad_id: NoradId(id), ..any.clone() };
        let catalogue = [
            named("ISS (ZARYA)", 25544),
            named("ISS (NAUKA)", 49044),
            named("ISS OBJECT XT", 60001),
            named("SWISSCUBE", 35932),
            named("HST", 20580),
            named("HUBBLE 6", 60002),
            named("CSS (TIANHE)", 48274),
            named("STARLINK-12", 1),
            named("STARLINK-123", 2),
            named("AISSAT 1", 36797),
        ];
        let selection = Selection { names: vec![text.to_owned()], ..Selection::default() };
        let chosen = selection.among(&catalogue);
        catalogue.iter().filter(|set| chosen.contains(set)).map(|set| set.norad_id.0).collect()
    }

    #[test]
    fn verif_well_known_names_come_before_exact_names_words_and_parts() {
        assert_eq!(selected("iss"), [25544]);
        assert_eq!(selected("Hubble"), [20580]);
        assert_eq!(selected("tiangong"), [48274]);
        assert_eq!(selected("HUBBLE 6"), [60002]);
        assert_eq!(selected("starlink-12"), [1]);
        assert_eq!(selected("STARLINK"), [1, 2]);
        assert_eq!(selected("nauka"), [49044]);
        assert_eq!(selected("STARLINK-1"), [1, 2]);
        assert_eq!(selected("iss object"), [60001]);
        assert_eq!(selected("cube"), [35932]);
        assert!(selected("no such").is_empty());
    }
}

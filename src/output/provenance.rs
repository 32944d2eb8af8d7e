//! Provenance of an output: named values that describe the program, elements, models, time scale and options used.

use std::sync::Arc;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use serde_json::Value;

/// Named values that describe the origin of a result, in the order in which they were added, and attached lists. Clones
/// share them until one is changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    entries: Arc<Vec<(String, Value)>>,
    attached: Arc<Vec<(String, Value)>>,
}

impl Provenance {
    /// Creates a provenance that contains the program's name and version.
    pub fn new() -> Self {
        let mut provenance = Self::default();
        provenance.state("software", "streakcast");
        provenance.state("version", env!("CARGO_PKG_VERSION"));
        provenance
    }

    /// Adds an entry, or replaces the value of the existing entry with this name.
    pub fn state(&mut self, name: &str, value: impl Into<Value>) {
        let (entries, value) = (Arc::make_mut(&mut self.entries), value.into());
        match entries.iter_mut().find(|(known, _)| known == name) {
            Some(entry) => entry.1 = value,
            None => entries.push((name.to_owned(), value)),
        }
    }

    /// Removes the entry with this name.
    pub fn remove(&mut self, name: &str) {
        Arc::make_mut(&mut self.entries).retain(|(known, _)| known != name);
    }

    /// Adds or replaces several entries.
    pub fn state_all(&mut self, statements: impl IntoIterator<Item = (&'static str, Value)>) {
        statements.into_iter().for_each(|(name, value)| self.state(name, value));
    }

    /// Attaches a list that is too long for the header of a text table. JSON and JSON lines contain the list next to
    /// the provenance; the other formats omit it.
    pub fn attach(&mut self, name: &str, value: impl Into<Value>) {
        Arc::make_mut(&mut self.attached).push((name.to_owned(), value.into()));
    }

    /// Returns the attached lists in the order in which they were added.
    pub fn attached(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.attached.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// Returns the entries in the order in which they were added.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.entries.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// Returns the value of the entry with this name.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.entries.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }
}

impl Serialize for Provenance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.entries.len()))?;
        for (name, value) in self.entries.iter() {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_keep_their_order_and_a_second_one_replaces_the_first() {
        let mut provenance = Provenance::default();
        provenance.state("z", 1);
        provenance.state("a", "x");
        provenance.state("z", 2);
        assert_eq!(serde_json::to_string(&provenance).unwrap(), r#"{"z":2,"a":"x"}"#);
    }
}

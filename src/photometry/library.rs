//! Brightness models by name: the models that are part of the program, and those of the user.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::model::BrightnessModel;
use crate::error::Error;
use crate::message::Quoted;

macro_rules! shipped {
    ($($file:literal),* $(,)?) => {
        /// Name and text of every shipped model file.
        const SHIPPED: &[(&str, &str)] = &[$(($file, include_str!(concat!("models/", $file)))),*];
    };
}
shipped!(
    "bluebird.json",
    "direct-to-cell.json",
    "guowang.json",
    "high-orbit.json",
    "iridium-next.json",
    "kuiper.json",
    "oneweb-panels.json",
    "oneweb.json",
    "qianfan.json",
    "rocket-body.json",
    "starlink-v1.0.json",
    "starlink-v1.5-facets.json",
    "starlink-v1.5-phase.json",
    "starlink-v1.5.json",
    "unknown.json",
    "v2mini-panels.json",
    "v2mini.json",
    "visorsat-panels.json",
    "visorsat.json",
);

/// Set of models that can be found by their names and aliases.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelLibrary {
    models: BTreeMap<String, Arc<BrightnessModel>>,
    aliases: BTreeMap<String, String>,
}

impl ModelLibrary {
    /// Returns a library of the models that are part of the program.
    pub fn embedded() -> Self {
        let mut library = Self::default();
        for (origin, text) in SHIPPED {
            // A test validates every shipped file.
            if let Ok(model) = BrightnessModel::from_json(text, origin) {
                library.add(model);
            }
        }
        library
    }

    /// Adds a model from the text of a file and returns its name. A model of the same name is replaced.
    ///
    /// # Errors
    /// The errors of [`BrightnessModel::from_json`]; the library is then unchanged.
    pub fn add_json(&mut self, text: &str, origin: &str) -> Result<String, Error> {
        let model = BrightnessModel::from_json(text, origin)?;
        Ok(self.add(model))
    }

    /// Returns the model with this name or alias; upper and lower case are equivalent.
    pub fn get(&self, name: &str) -> Option<Arc<BrightnessModel>> {
        let name = name.trim().to_ascii_lowercase();
        let name = self.aliases.get(&name).filter(|_| !self.models.contains_key(&name)).unwrap_or(&name);
        self.models.get(name).cloned()
    }

    /// Returns the model with this name or alias; case is ignored.
    ///
    /// # Errors
    /// An unknown name; the error lists the known ones.
    pub fn find(&self, name: &str) -> Result<Arc<BrightnessModel>, Error> {
        self.get(name).ok_or_else(|| {
            Error::format(format!("unknown model '{}'", Quoted::new(name)))
                .allowing(self.names().collect::<Vec<_>>().join(", "))
        })
    }

    /// Returns the model of unknown satellites; always present in the embedded library.
    pub fn unknown(&self) -> Option<Arc<BrightnessModel>> {
        self.get("unknown")
    }

    /// Returns the names in alphabetical order, without aliases.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.models.keys().map(String::as_str)
    }

    /// Returns the name and the text of every model file that is part of the program.
    pub fn shipped_files() -> &'static [(&'static str, &'static str)] {
        SHIPPED
    }

    fn add(&mut self, model: BrightnessModel) -> String {
        let (name, aliases) = model.file().map(|file| (file.name.clone(), file.aliases.clone())).unwrap_or_default();
        self.aliases.retain(|_, target| *target != name);
        self.aliases.extend(aliases.into_iter().map(|alias| (alias, name.clone())));
        self.models.insert(name.clone(), Arc::new(model));
        name
    }
}

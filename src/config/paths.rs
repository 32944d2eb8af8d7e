//! Paths of files in settings. Each type of a setting states whether its values have any, so that a setting of a new
//! type does not compile without this statement.

use std::path::PathBuf;

use super::values::{ModelAssignment, ModelSource, ModelsTable, NameOrFile, NameOrTable, Quantity, SiteTable};
use crate::images::Telescope;
use crate::schedule::{MagnitudeLimit, Policy};

/// Type of a setting.
pub(super) trait Paths {
    /// Calls a function for the path of each file in the value.
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf));
}

/// Types whose values have no paths. A text that may be a file has the type [`NameOrFile`].
macro_rules! without_paths {
    ($($type:ty),+) => {
        $(impl Paths for $type {
            fn visit_paths(&mut self, _: &mut dyn FnMut(&mut PathBuf)) {}
        })+
    };
}

without_paths!(bool, f64, u32, usize, String, Quantity, MagnitudeLimit, SiteTable, Box<Telescope>, Policy);

impl Paths for PathBuf {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        visit(self);
    }
}

impl Paths for NameOrFile {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        if self.is_file() {
            let mut path = PathBuf::from(&**self);
            visit(&mut path);
            *self = path.display().to_string().into();
        }
    }
}

impl<T: Paths> Paths for Option<T> {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        self.iter_mut().for_each(|value| value.visit_paths(visit));
    }
}

impl<T: Paths> Paths for Vec<T> {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        self.iter_mut().for_each(|value| value.visit_paths(visit));
    }
}

impl<N: Paths, T: Paths> Paths for NameOrTable<N, T> {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        match self {
            Self::Name(name) => name.visit_paths(visit),
            Self::Table(table) => table.visit_paths(visit),
        }
    }
}

/// Table `[field]`, which may have the key `file`.
impl Paths for toml::Table {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        if let Some(toml::Value::String(file)) = self.get_mut("file") {
            let mut path = PathBuf::from(&*file);
            visit(&mut path);
            *file = path.display().to_string();
        }
    }
}

impl Paths for ModelAssignment {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        if let ModelSource::File(path) = &mut self.model {
            visit(path);
        }
    }
}

impl Paths for ModelsTable {
    fn visit_paths(&mut self, visit: &mut dyn FnMut(&mut PathBuf)) {
        let Self { files, qs_mag, generations: _ } = self;
        files.visit_paths(visit);
        qs_mag.visit_paths(visit);
    }
}

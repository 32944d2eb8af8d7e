//! Catalogue of satellites: element sets and ephemerides from files of any formats, with their provenance.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hifitime::Epoch;
use rayon::prelude::*;

use super::element_set::ElementSet;
use super::ephemeris::Ephemeris;
use super::history::{Chosen, History, chosen_of_each, nearest_of_each};
use super::record::Rejected;
use super::shell::Constellation;
use super::source::{FileReading, SourceFile, files_of, read_bytes, read_file};
use super::tle::Checksums;
use crate::error::{Error, ErrorKind};

/// Options for reading element sets.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// If true, records with a wrong checksum are accepted and counted in [`SourceFile::bad_checksums_accepted`]. A
    /// missing checksum is always accepted.
    pub accept_bad_checksums: bool,
    /// Selection among several element sets of one object.
    pub keep: Keep,
}

/// Selection among several element sets of one object.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Keep {
    /// The element set with the latest epoch.
    #[default]
    Newest,
    /// The element set with the epoch nearest to this time, before or after it.
    Nearest(Epoch),
    /// All element sets, for a [`History`].
    All,
}

/// Element sets and ephemerides with their provenance.
///
/// ```
/// use streakcast::elements::{Satellites, NoradId, ReadOptions};
///
/// let text = "\
/// ISS (ZARYA)
/// 1 25544U 98067A   26189.73419088  .00005258  00000+0  10370-3 0  9999
/// 2 25544  51.6304 193.4497 0006669 272.1743  87.8481 15.48947664575097
/// 1 25545U 98067B   26189.734
/// ";
/// let catalogue = Satellites::from_bytes("iss.txt", text.as_bytes(), &ReadOptions::default())?;
/// assert_eq!(catalogue.element_sets[0].norad_id, NoradId(25544));
/// assert_eq!(catalogue.rejected[0].line, 4);
/// # Ok::<(), streakcast::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Satellites {
    /// Element sets sorted by catalogue number, then by epoch if several of one object are kept.
    pub element_sets: Vec<ElementSet>,
    /// Element sets of the same objects with other epochs, at most 18 days from the selected ones, sorted by catalogue
    /// number, then by epoch; empty with [`Keep::All`]. They improve the mean motion (`orbit::OrbitModel`).
    pub other_epochs: Vec<ElementSet>,
    /// Operator ephemerides, in file order.
    pub ephemerides: Vec<Arc<Ephemeris>>,
    /// Rejected records, sorted by file and line.
    pub rejected: Vec<Rejected>,
    /// Files, in the given order.
    #[doc(hidden)]
    pub sources: Vec<SourceFile>,
    /// Number of records removed as exact duplicates of others.
    pub duplicates: usize,
    /// Number of records that are not selected because another epoch of the same object is, including
    /// [`other_epochs`](Self::other_epochs).
    pub superseded: usize,
    /// Time for which the element sets were selected: that of [`Keep::Nearest`], or else the latest epoch.
    pub(crate) selected_for: Option<Epoch>,
}

impl Satellites {
    /// Reads files, and all files in folders. The format of each is detected from its content.
    ///
    /// Invalid records are listed in [`rejected`](Self::rejected), and the others are kept. An invalid ephemeris is an
    /// error.
    ///
    /// # Errors
    /// * no file is given;
    /// * a file cannot be read, is empty, or is an invalid gzip file; a folder has no files;
    /// * a file is in none of the formats, or has no valid record;
    /// * an ephemeris is invalid.
    pub fn read<P: AsRef<Path> + Sync>(paths: &[P], options: &ReadOptions) -> Result<Self, Error> {
        if paths.is_empty() {
            return Err(Error::new(ErrorKind::Missing, "no file of element sets is given"));
        }
        let checksums = options.checksums();
        let files = files_of(paths)?;
        let readings: Result<Vec<_>, _> = files.par_iter().map(|path| read_file(path, checksums)).collect();
        Ok(Self::assemble(readings?, options.keep))
    }

    /// Reads several lists of files, like [`read`](Self::read); a file of several lists is read once.
    pub(crate) fn read_lists(
        lists: BTreeSet<Vec<PathBuf>>,
        options: &ReadOptions,
    ) -> Result<BTreeMap<Vec<PathBuf>, Self>, Error> {
        if lists.len() < 2 {
            return lists.into_iter().map(|list| Self::read(&list, options).map(|read| (list, read))).collect();
        }
        let files = lists.iter().map(|list| files_of(list)).collect::<Result<Vec<_>, _>>()?;
        let distinct: BTreeSet<&PathBuf> = files.iter().flatten().collect();
        let readings = distinct.into_par_iter().map(|path| Ok((path, read_file(path, options.checksums())?)));
        let readings = readings.collect::<Result<BTreeMap<&PathBuf, _>, Error>>()?;
        let assemble = |files: &Vec<PathBuf>| {
            Self::assemble(files.iter().map(|path| readings[path].clone()).collect(), options.keep)
        };
        Ok(lists.into_iter().zip(files.iter().map(assemble)).collect())
    }

    /// Reads files with the default options: the newest of several element sets of one object is kept, and records with
    /// a wrong checksum are rejected.
    ///
    /// # Errors
    /// Same as [`read`](Self::read).
    pub fn from_files<P: AsRef<Path> + Sync>(paths: impl AsRef<[P]>) -> Result<Self, Error> {
        Self::read(paths.as_ref(), &ReadOptions::default())
    }

    /// Returns a simulated constellation with the orbits of its licence filing, for example `starlink-gen1`, or a set
    /// of them, for example `planned-2026`, at an epoch.
    ///
    /// The positions do not correspond to real satellites.
    ///
    /// # Errors
    /// The name is unknown. The error lists the known names.
    pub fn synthetic(constellation: &str, epoch: Epoch) -> Result<Self, Error> {
        let constellations = Constellation::by_name_or_set(constellation)?;
        let element_sets = constellations.iter().flat_map(|constellation| constellation.element_sets(epoch)).collect();
        Ok(Self::from_element_sets(element_sets, Keep::All))
    }

    /// Reads the content of one file; `name` is used in messages and provenance.
    ///
    /// # Errors
    /// Same as [`read`](Self::read).
    pub fn from_bytes(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Self, Error> {
        Ok(Self::assemble(vec![read_bytes(name, bytes, options.checksums())?], options.keep))
    }

    /// Creates a catalogue from element sets that were not read from a file.
    pub fn from_element_sets(element_sets: Vec<ElementSet>, keep: Keep) -> Self {
        let mut catalogue = Self::default();
        catalogue.put(element_sets, keep);
        catalogue
    }

    /// Returns the element set of every object nearest to a time. This requires [`Keep::All`]; otherwise only one
    /// element set of each object is stored.
    pub fn at(&self, epoch: Epoch) -> Vec<ElementSet> {
        nearest_of_each(&self.element_sets, epoch)
    }

    /// Returns the same element sets as [`at`](Self::at), and those of other epochs.
    pub fn chosen_at(&self, epoch: Epoch) -> Chosen {
        if self.other_epochs.is_empty() {
            return chosen_of_each(&self.element_sets, epoch);
        }
        Chosen { sets: self.element_sets.clone(), others: self.other_epochs.clone() }
    }

    /// Returns all records as a history. This requires [`Keep::All`]; otherwise there is only one record of each
    /// object.
    pub fn into_history(self) -> History {
        History::new(self.element_sets)
    }

    /// Returns the earliest and latest epoch; `None` for an empty catalogue.
    pub fn epochs(&self) -> Option<(Epoch, Epoch)> {
        let epochs = || self.element_sets.iter().map(|set| set.epoch);
        epochs().min().zip(epochs().max())
    }

    fn assemble(readings: Vec<FileReading>, keep: Keep) -> Self {
        let mut catalogue = Self::default();
        let mut sets = Vec::new();
        for reading in readings {
            catalogue.sources.push(reading.source);
            catalogue.rejected.extend(reading.rejected);
            catalogue.ephemerides.extend(reading.ephemerides);
            if sets.is_empty() {
                sets = reading.sets;
            } else {
                sets.extend(reading.sets);
            }
        }
        catalogue.put(sets, keep);
        catalogue
    }

    fn put(&mut self, sets: Vec<ElementSet>, keep: Keep) {
        let given = sets.len();
        let history = History::new(sets);
        self.duplicates = given - history.len();
        let distinct = history.len();
        let Chosen { sets, others } = match keep {
            Keep::Newest => history.into_newest(),
            Keep::Nearest(epoch) => history.into_nearest(epoch),
            Keep::All => Chosen { sets: history.into_element_sets(), others: Vec::new() },
        };
        (self.element_sets, self.other_epochs) = (sets, others);
        self.selected_for = match keep {
            Keep::Nearest(epoch) => Some(epoch),
            _ => self.epochs().map(|(_, latest)| latest),
        };
        self.superseded = distinct - self.element_sets.len();
    }
}

impl ReadOptions {
    fn checksums(&self) -> Checksums {
        if self.accept_bad_checksums { Checksums::Ignore } else { Checksums::Require }
    }
}

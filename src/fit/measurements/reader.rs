//! Reader of files of photometry, which reads and parses blocks in parallel and in bounded memory.

use std::collections::{HashMap, HashSet, VecDeque};
use std::hash::{BuildHasherDefault, Hasher};
use std::io::Read;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::super::error;
use super::super::error::FORMATS;
use super::blocks::{Blocks, Head};
use super::column_map::ColumnMap;
use super::dropped::{DropCounts, DropExample, DropReason};
use super::format::{FilterCounts, Format};
use super::record::{Record, RecordSource};
use super::rows::{Layout, Parsed, UNKNOWN_PASS};
use super::untimed::passes_without_times;
use crate::error::{Error, ErrorKind};
use crate::geometry::Site;
use crate::message::Quoted;

/// Options for reading photometry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PhotometryOptions {
    /// Format of the files; if `None`, it is recognised by the header.
    pub format: Option<Format>,
    /// Column map for a custom table; the format may then be omitted.
    pub columns: Option<ColumnMap>,
    /// Site of all rows; if `None`, the site in the columns or that of the format is used.
    pub site: Option<Site>,
    /// Selected filters; upper and lower case are equivalent. If empty, `Clear` for MMT-9, otherwise the only filter of
    /// a file.
    pub filters: Vec<String>,
    /// If true, rows with the same values as an earlier row are kept.
    pub keep_duplicates: bool,
}

/// Number of blocks that are parsed together: some 8 MB of text or 100,000 rows.
const BLOCKS_AT_A_TIME: usize = 8;

/// Hasher for values that are hashes already.
#[derive(Default)]
struct IdentityHasher(u64);

impl Hasher for IdentityHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = self.0.rotate_left(8) ^ u64::from(*byte);
        }
    }

    fn write_u64(&mut self, hash: u64) {
        self.0 = hash;
    }
}

/// State of the file that is being read.
struct OpenFile {
    blocks: Blocks,
    layout: Layout,
    /// Blocks that have been read but not parsed.
    read: Vec<Vec<u8>>,
    rows: u64,
    /// First filter in the file, if no filter is selected.
    filter: Option<String>,
}

/// Reader of the records of several files, in the order of the files.
///
/// It needs some 30 MB for text and records, 10 to 25 bytes per row for the detection of duplicates (none if they are
/// kept), and memory for the names of tracks and sites. Text is parsed on all threads of rayon's pool while more is
/// read.
pub struct RecordReader {
    queue: VecDeque<PathBuf>,
    open: Option<OpenFile>,
    options: PhotometryOptions,
    files: Vec<String>,
    groups: Vec<String>,
    group_of: HashMap<String, u32>,
    sites: Vec<Site>,
    seen: HashSet<u64, BuildHasherDefault<IdentityHasher>>,
    dropped: DropCounts,
    filters: FilterCounts,
}

impl RecordReader {
    /// Creates a reader of files, which are opened one after another.
    ///
    /// # Errors
    /// The list is empty.
    pub fn open<P: AsRef<Path>>(paths: &[P], options: &PhotometryOptions) -> Result<Self, Error> {
        if paths.is_empty() {
            return Err(Error::new(ErrorKind::Missing, "no file of photometry is given").allowing("one or more"));
        }
        let queue = paths.iter().map(|path| path.as_ref().to_owned()).collect();
        Ok(Self::empty(queue, options))
    }

    /// Creates a reader of a stream; `name` identifies it in messages.
    ///
    /// # Errors
    /// Errors of the head: it is unreadable, empty or of unknown format, or a required column is missing.
    pub fn from_reader(name: &str, source: Box<dyn Read + Send>, options: &PhotometryOptions) -> Result<Self, Error> {
        let mut reader = Self::empty(VecDeque::new(), options);
        let (head, blocks) = Blocks::from_source(source, name)?;
        reader.begin(name.to_owned(), &head, blocks)?;
        Ok(reader)
    }

    fn empty(queue: VecDeque<PathBuf>, options: &PhotometryOptions) -> Self {
        Self {
            queue,
            open: None,
            options: options.clone(),
            files: Vec::new(),
            groups: Vec::new(),
            group_of: HashMap::new(),
            sites: Vec::new(),
            seen: HashSet::default(),
            dropped: DropCounts::default(),
            filters: FilterCounts::default(),
        }
    }

    /// Returns the filters of the rows read so far, including duplicates.
    pub fn filters(&self) -> &FilterCounts {
        &self.filters
    }

    fn begin(&mut self, name: String, head: &Head, blocks: Blocks) -> Result<(), Error> {
        let sniffed = || {
            Format::sniff(&head.header).ok_or_else(|| {
                Error::new(
                    ErrorKind::Invalid,
                    format!("the format with the header '{}' is unknown", Quoted::new(head.header.join(","))),
                )
                .allowing(format!("{FORMATS}, or any table with a column map"))
                .in_file("", &name)
            })
        };
        let (format, map) = match (&self.options.columns, self.options.format) {
            (Some(map), None | Some(Format::Csv)) => (Format::Csv, map.clone()),
            (Some(_), Some(format)) => {
                let problem = format!("format {} has fixed columns; a column map requires csv", format.name());
                return Err(Error::new(ErrorKind::Invalid, format!("column map: {problem}")));
            }
            (None, Some(Format::Csv)) => {
                return Err(Error::new(ErrorKind::Missing, "csv requires a column map").at("column map"));
            }
            (None, Some(format)) => (format, format.columns()),
            (None, None) => sniffed().map(|format| (format, format.columns()))?,
        };
        let site = match &self.options.site {
            Some(site) => Some(site.clone()),
            None => format.site()?,
        };
        let mut filters = self.options.filters.clone();
        if filters.is_empty() {
            filters.extend(format.usual_filter().map(str::to_owned));
        }
        let layout = Layout::new(map, head, site, &filters, &name)?;
        self.files.push(name);
        self.open = Some(OpenFile { blocks, layout, read: Vec::new(), rows: 0, filter: None });
        Ok(())
    }

    /// Returns the name of the current file.
    fn name(&self) -> String {
        self.files.last().cloned().unwrap_or_default()
    }

    /// Appends the contents of a parsed block.
    fn take(&mut self, open: &mut OpenFile, parsed: Parsed, records: &mut Vec<Record>) -> Result<(), Error> {
        let name = self.name();
        for (row, filter) in parsed.first_filter.into_iter().chain(parsed.other_filter) {
            let first = open.filter.get_or_insert_with(|| filter.clone());
            if *first != filter {
                let (first, row) = (first.clone(), open.rows + row);
                return Err(Error::about_file(
                    "",
                    name,
                    format!(
                        "data row {row}: filter is '{}' after rows of filter '{}'",
                        Quoted::new(filter),
                        Quoted::new(first)
                    ),
                )
                .allowing("one filter, unless the filters are specified"));
            }
        }
        let groups: Vec<u32> = parsed
            .groups
            .into_iter()
            .map(|group| {
                let next = self.groups.len() as u32;
                match self.group_of.get(&group) {
                    Some(known) => *known,
                    None => {
                        self.groups.push(group.clone());
                        self.group_of.insert(group, next);
                        next
                    }
                }
            })
            .collect();
        let sites: Vec<u32> = parsed
            .sites
            .into_iter()
            .map(|site| match self.sites.iter().position(|known| *known == site) {
                Some(known) => known as u32,
                None => {
                    self.sites.push(site);
                    self.sites.len() as u32 - 1
                }
            })
            .collect();
        self.filters.append(&parsed.filters);
        let mut dropped = parsed.dropped;
        dropped.shift_rows(&name, open.rows);
        for (mut record, hash) in parsed.records.into_iter().zip(parsed.hashes) {
            let row = open.rows + u64::from(record.row);
            if !self.options.keep_duplicates && !self.seen.insert(hash) {
                dropped.add(DropReason::Duplicate, || DropExample { file: name.clone(), row, problem: String::new() });
                continue;
            }
            record.row = u32::try_from(row).unwrap_or(u32::MAX);
            record.group = groups.get(record.group as usize).copied().unwrap_or(UNKNOWN_PASS);
            record.site = record.site.map(|site| sites[site as usize]);
            records.push(record);
        }
        self.dropped.append(dropped);
        open.rows += parsed.rows;
        Ok(())
    }
}

impl RecordReader {
    /// Numbers the passes of rows without times, within the rows that are read at a time (8 MB).
    fn name_passes(&mut self, records: &mut [Record]) {
        for pass in passes_without_times(records) {
            let number = self.groups.len() as u32;
            self.groups.push(format!("{} pass from row {}", self.name(), records[pass[0]].row));
            pass.into_iter().for_each(|index| records[index].group = number);
        }
    }
}

fn read_some(blocks: &mut Blocks) -> std::io::Result<Vec<Vec<u8>>> {
    let mut read = Vec::with_capacity(BLOCKS_AT_A_TIME);
    while read.len() < BLOCKS_AT_A_TIME {
        match blocks.next()? {
            Some(block) => read.push(block),
            None => break,
        }
    }
    Ok(read)
}

impl RecordSource for RecordReader {
    fn next_chunk(&mut self) -> Result<Option<Vec<Record>>, Error> {
        let Some(mut open) = self.open.take() else {
            let Some(path) = self.queue.pop_front() else { return Ok(None) };
            let name = path.display().to_string();
            let (head, blocks) = Blocks::open(&path, &name)?;
            self.begin(name, &head, blocks)?;
            return Ok(Some(Vec::new()));
        };
        let name = self.name();
        let unreadable = |error: std::io::Error| Error::cannot("read", &name, error);
        if open.read.is_empty() {
            open.read = read_some(&mut open.blocks).map_err(unreadable)?;
        }
        if open.read.is_empty() {
            if open.rows == 0 {
                return Err(error::empty_file(&name));
            }
            return Ok(Some(Vec::new()));
        }
        let file = self.files.len() as u32 - 1;
        let now = std::mem::take(&mut open.read);
        let (layout, blocks) = (&open.layout, &mut open.blocks);
        let (parsed, next) = rayon::join(
            || now.par_iter().map(|block| layout.parse(block, file)).collect::<Vec<_>>(),
            || read_some(blocks),
        );
        open.read = next.map_err(unreadable)?;
        let mut records = Vec::with_capacity(parsed.iter().map(|block| block.records.len()).sum());
        for block in parsed {
            self.take(&mut open, block, &mut records)?;
        }
        self.name_passes(&mut records);
        self.open = Some(open);
        Ok(Some(records))
    }

    fn groups(&self) -> &[String] {
        &self.groups
    }

    fn sites(&self) -> &[Site] {
        &self.sites
    }

    fn files(&self) -> &[String] {
        &self.files
    }

    fn dropped(&self) -> &DropCounts {
        &self.dropped
    }
}

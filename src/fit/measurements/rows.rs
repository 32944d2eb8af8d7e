//! From the cells of one row to a record, or to the reason why there is none.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::hash::{DefaultHasher, Hash, Hasher};

use hifitime::{Epoch, TimeScale};

use crate::elements::NoradId;
use crate::frames::{epoch_from_mjd, mjd_utc};
use crate::geometry::Site;
use crate::photometry::Magnitude;

use super::blocks::{Delimiter, Head};
use super::cells::{Cell, Refused, refused};
use super::column_map::{ColumnMap, FIELDS, Field};
use super::dropped::{DropCounts, DropExample, DropReason};
use super::error::MeasuredError;
use super::filters::FilterCounts;
use super::record::Record;

/// Columns of one file by their places.
pub(super) struct Layout {
    pub(super) map: ColumnMap,
    pub(super) places: [Option<usize>; FIELDS],
    /// Numbers that stand for a column.
    constants: [Option<f64>; FIELDS],
    delimiter: Delimiter,
    norad_id: Option<NoradId>,
    /// Of every row; else the columns tell.
    pub site: Option<Site>,
    /// In lower case; empty for any, as long as it is one.
    filters: Vec<String>,
    file: String,
}

/// Rows of a block, counted from its own beginning; groups and sites by its own lists.
#[derive(Default)]
pub(super) struct Parsed {
    pub records: Vec<Record>,
    /// Of the cells of each record.
    pub hashes: Vec<u64>,
    pub groups: Vec<String>,
    pub sites: Vec<Site>,
    pub dropped: DropCounts,
    /// Of the records.
    pub filters: FilterCounts,
    pub rows: u64,
    /// Where no filter is named: the first one, and the first that differs from it, each with its row.
    pub first_filter: Option<(u64, String)>,
    pub other_filter: Option<(u64, String)>,
}

impl Layout {
    pub(super) fn new(
        map: ColumnMap,
        head: &Head,
        site: Option<Site>,
        filters: &[String],
        file: &str,
    ) -> Result<Self, MeasuredError> {
        let (mut places, mut constants) = ([None; FIELDS], [None; FIELDS]);
        for (field, _) in Field::ALL {
            let Some(column) = map.column(field) else { continue };
            let place = head.header.iter().position(|header| header == column);
            let can_be_number = matches!(field, Field::Latitude | Field::Longitude | Field::SiteHeight);
            let number = column.parse::<f64>().ok().filter(|_| can_be_number);
            if place.is_none() && number.is_none() && !map.optional.contains(&field) {
                return Err(MeasuredError::Column { file: file.to_owned(), column: column.to_owned() });
            }
            places[field as usize] = place;
            constants[field as usize] = number.filter(|_| place.is_none());
        }
        if !filters.is_empty() && places[Field::Filter as usize].is_none() && !map.optional.contains(&Field::Filter) {
            return Err(MeasuredError::ColumnMap {
                problem: format!("filters are named, but {file} has no column of filters"),
            });
        }
        let filters = filters.iter().map(|filter| filter.to_ascii_lowercase()).collect();
        let (delimiter, norad_id) = (head.delimiter, head.norad_id);
        Ok(Self { map, places, constants, delimiter, norad_id, site, filters, file: file.to_owned() })
    }

    /// All rows of a block; `file` is the file's number.
    pub(super) fn parse(&self, block: &[u8], file: u32) -> Parsed {
        let mut rows = Rows::new(self, file);
        match self.delimiter {
            Delimiter::Byte(delimiter) => {
                let mut reader = csv::ReaderBuilder::new()
                    .has_headers(false)
                    .flexible(true)
                    .delimiter(delimiter)
                    .comment(Some(b'#'))
                    .from_reader(block);
                let mut record = csv::ByteRecord::new();
                // Reading from memory, and any bytes are cells.
                while reader.read_byte_record(&mut record).unwrap_or(false) {
                    rows.push(&|place| record.get(place), record.iter());
                }
            }
            Delimiter::Blanks => {
                let mut ends: Vec<(usize, usize)> = Vec::new();
                for line in block.split(|byte| *byte == b'\n') {
                    ends.clear();
                    let start = line.as_ptr() as usize;
                    let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
                    ends.extend(words.map(|word| (word.as_ptr() as usize - start, word.len())));
                    if !ends.is_empty() && line[ends[0].0] != b'#' {
                        let cell = |&(at, length): &(usize, usize)| &line[at..at + length];
                        rows.push(&|place| ends.get(place).map(cell), ends.iter().map(cell));
                    }
                }
            }
        }
        rows.parsed
    }
}

/// A block on its way.
struct Rows<'l> {
    layout: &'l Layout,
    file: u32,
    parsed: Parsed,
    group_of: HashMap<String, u32>,
    site_of: HashMap<[u64; 3], u32>,
    /// The night that the last row belonged to.
    last_night: Option<(i64, u32)>,
}

impl<'l> Rows<'l> {
    fn new(layout: &'l Layout, file: u32) -> Self {
        let mut parsed = Parsed::default();
        parsed.sites.extend(layout.site.clone());
        Self { layout, file, parsed, group_of: HashMap::new(), site_of: HashMap::new(), last_night: None }
    }

    fn push<'a>(&mut self, cell: Cell<'a>, cells: impl Iterator<Item = &'a [u8]>) {
        self.parsed.rows += 1;
        let row = self.parsed.rows;
        match self.record(cell) {
            Ok(record) => {
                self.parsed.records.push(record);
                self.parsed.filters.add(self.layout.text(cell, Field::Filter), 1);
                let mut hasher = DefaultHasher::new();
                cells.for_each(|cell| cell.hash(&mut hasher));
                self.parsed.hashes.push(hasher.finish());
            }
            Err(Refused { reason, field, expected }) => {
                let layout = self.layout;
                self.parsed.dropped.add(reason, || {
                    let given = layout.text(cell, field).unwrap_or_default();
                    let column = layout.map.column(field).unwrap_or_default();
                    let problem = format!("{column} '{given}', expected {expected}");
                    DropExample { file: String::new(), row, problem }
                });
            }
        }
    }

    fn record(&mut self, cell: Cell) -> Result<Record, Refused> {
        let layout = self.layout;
        if let Some(filter) = layout.text(cell, Field::Filter) {
            self.judge_filter(filter)?;
        }
        // No [-30, 40]: 99 and -99 stand for "none".
        let magnitude = layout.number(cell, Field::Magnitude, [-30.0, 40.0], "a magnitude of -30 to 40");
        let Ok(Some(magnitude)) = magnitude else {
            return Err(Refused {
                reason: DropReason::NoMagnitude,
                field: Field::Magnitude,
                expected: "a magnitude of -30 to 40",
            });
        };
        let epoch = layout.time(cell)?;
        let norad_id = match layout.text(cell, Field::Norad) {
            None => layout.norad_id,
            Some(text) => {
                let number: u32 =
                    text.parse().map_err(|_| refused(Field::Norad, "a catalogue number of up to nine digits"))?;
                (number != 0).then_some(NoradId(number)).or(layout.norad_id)
            }
        };
        let site = self.site(cell)?;
        let in_penumbra = match layout.text(cell, Field::Penumbra) {
            None | Some("0") => false,
            Some("1") => true,
            Some(_) => return Err(refused(Field::Penumbra, "0 or 1")),
        };
        Ok(Record {
            epoch,
            magnitude: Magnitude(magnitude),
            sigma_mag: layout.number(cell, Field::Sigma, [0.0, 10.0], "a sigma of 0 to 10 mag")?,
            sighting: layout.sighting(cell)?,
            norad_id,
            group: self.group(cell, norad_id, epoch, site),
            site,
            in_penumbra,
            file: self.file,
            row: u32::try_from(self.parsed.rows).unwrap_or(u32::MAX),
        })
    }

    fn judge_filter(&mut self, filter: &str) -> Result<(), Refused> {
        let layout = self.layout;
        if !layout.filters.is_empty() {
            let is_wanted = layout.filters.iter().any(|wanted| wanted.eq_ignore_ascii_case(filter));
            return if is_wanted {
                Ok(())
            } else {
                Err(Refused {
                    reason: DropReason::WrongFilter,
                    field: Field::Filter,
                    expected: "a filter that is wanted",
                })
            };
        }
        let here = || (self.parsed.rows, filter.to_owned());
        match &self.parsed.first_filter {
            None => self.parsed.first_filter = Some(here()),
            Some((_, first)) if first != filter && self.parsed.other_filter.is_none() => {
                self.parsed.other_filter = Some(here());
            }
            Some(_) => {}
        }
        Ok(())
    }

    /// The block's number of the site.
    fn site(&mut self, cell: Cell) -> Result<Option<u32>, Refused> {
        let layout = self.layout;
        if layout.site.is_some() {
            return Ok(Some(0));
        }
        if layout.map.column(Field::Latitude).is_none() {
            return Ok(None);
        }
        let of = |field: Field, bounds: [f64; 2], expected: &'static str| match layout.constants[field as usize] {
            Some(number) => Ok(number),
            None => layout.number(cell, field, bounds, expected)?.ok_or_else(|| refused(field, expected)),
        };
        let latitude = of(Field::Latitude, [-90.0, 90.0], "a latitude of -90 to 90 deg")?;
        let longitude = of(Field::Longitude, [-180.0, 360.0], "a longitude of -180 to 360 deg")?;
        let height = of(Field::SiteHeight, [-500.0, 9000.0], "a height of -500 to 9000 m")?;
        let key = [latitude, longitude, height].map(f64::to_bits);
        if let Some(number) = self.site_of.get(&key) {
            return Ok(Some(*number));
        }
        let name = format!("{latitude} {longitude}");
        let site = Site::new_deg(&name, latitude, longitude, height)
            .map_err(|_| refused(Field::Latitude, "a place on the Earth"))?;
        let number = self.parsed.sites.len() as u32;
        self.parsed.sites.push(site);
        self.site_of.insert(key, number);
        Ok(Some(number))
    }

    /// The block's number of the track, else the satellite, else the night, else the degree of the Sun's altitude, else the file.
    fn group(&mut self, cell: Cell, norad_id: Option<NoradId>, epoch: Option<Epoch>, site: Option<u32>) -> u32 {
        if let Some(track) = self.layout.text(cell, Field::Track) {
            // Rows of a track mostly stand together.
            if self.parsed.records.last().is_some_and(|last| self.parsed.groups[last.group as usize] == track) {
                return self.parsed.records[self.parsed.records.len() - 1].group;
            }
            return self.numbered(track.to_owned());
        }
        if let Some(norad_id) = norad_id {
            return self.numbered(format!("satellite {norad_id}"));
        }
        let Some(epoch) = epoch else {
            // Without times the Sun's altitude is the clock: what was seen within a degree of it was seen within some minutes.
            let sun = self.layout.text(cell, Field::SunAltitude).and_then(|text| text.parse::<f64>().ok());
            let name = sun.map_or_else(|| self.layout.file.clone(), |sun| format!("Sun at {} deg", sun.floor()));
            return self.numbered(name);
        };
        // A night is named by its evening's date: days that begin at local noon.
        let longitude = site.map_or(0.0, |site| self.parsed.sites[site as usize].longitude_rad);
        let day = (mjd_utc(epoch) + longitude / TAU - 0.5).floor() as i64;
        if let Some((_, number)) = self.last_night.filter(|(last, _)| *last == day) {
            return number;
        }
        let (year, month, date, ..) =
            epoch_from_mjd(day as f64, TimeScale::UTC).map_or((0, 0, 0, 0, 0, 0, 0), |noon| noon.to_gregorian_utc());
        let number = self.numbered(format!("night {year:04}-{month:02}-{date:02}"));
        self.last_night = Some((day, number));
        number
    }

    fn numbered(&mut self, name: String) -> u32 {
        if let Some(number) = self.group_of.get(&name) {
            return *number;
        }
        let number = self.parsed.groups.len() as u32;
        self.parsed.groups.push(name.clone());
        self.group_of.insert(name, number);
        number
    }
}

//! Parser of rows: converts the values of a row to a record, or to the reason for dropping the row.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::hash::{DefaultHasher, Hash, Hasher};

use hifitime::{Epoch, TimeScale};

use super::blocks::{Delimiter, Head};
use super::column_map::{ColumnMap, FIELDS, Field};
use super::dropped::{DropCounts, DropExample, DropReason};
use super::format::FilterCounts;
use super::record::{Record, Sighting};
use crate::elements::{NoradId, parse_iso};
use crate::error::{Error, ErrorKind};
use crate::frames::{epoch_from_jd, epoch_from_mjd, has_zone, mjd_utc, parse_instant};
use crate::geometry::Site;
use crate::input::blank_record;
use crate::message::Quoted;
use crate::photometry::Magnitude;
use crate::units::{DEGREES, KILOMETRES, MAGNITUDES, Unit};

/// Layout of the columns of one file.
pub(super) struct Layout {
    map: ColumnMap,
    /// Index of the column of each quantity.
    columns: [Option<usize>; FIELDS],
    /// Numbers that are given instead of a column.
    constants: [Option<f64>; FIELDS],
    delimiter: Delimiter,
    norad_id: Option<NoradId>,
    /// Site of all rows, if the columns do not contain it.
    site: Option<Site>,
    /// Selected filters in lower case. If empty, any filter is accepted, but all rows of the file must have the same.
    filters: Vec<String>,
    file: String,
}

/// Result of parsing a block. Rows, groups and sites are numbered from the beginning of the block.
#[derive(Default)]
pub(super) struct Parsed {
    pub records: Vec<Record>,
    /// Hash of the values of each record.
    pub hashes: Vec<u64>,
    pub groups: Vec<String>,
    pub sites: Vec<Site>,
    pub dropped: DropCounts,
    /// Filters of the records, with numbers of rows.
    pub filters: FilterCounts,
    pub rows: u64,
    /// First filter and the first filter that differs from it, each with its row, if no filter is selected.
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
    ) -> Result<Self, Error> {
        let (mut columns, mut constants) = ([None; FIELDS], [None; FIELDS]);
        for (field, _) in Field::ALL {
            let Some(column) = map.column(field) else { continue };
            let index = head.header.iter().position(|header| header == column);
            let can_be_number = matches!(field, Field::Latitude | Field::Longitude | Field::SiteHeight);
            let number = column.parse::<f64>().ok().filter(|_| can_be_number);
            if index.is_none() && number.is_none() && !map.optional.contains(&field) {
                return Err(
                    Error::new(ErrorKind::Invalid, format!("no column '{}'", Quoted::new(column))).in_file("", file)
                );
            }
            if index.is_some() {
                check_unit(&map, field, column, head, file)?;
            }
            columns[field as usize] = index;
            constants[field as usize] = number.filter(|_| index.is_none());
        }
        if !filters.is_empty() && columns[Field::Filter as usize].is_none() && !map.optional.contains(&Field::Filter) {
            let sentence = format!("filters are selected, but {file} has no column of filters");
            return Err(Error::new(ErrorKind::Invalid, sentence).at("column map"));
        }
        let filters = filters.iter().map(|filter| filter.to_ascii_lowercase()).collect();
        let (delimiter, norad_id) = (head.delimiter, head.norad_id);
        Ok(Self { map, columns, constants, delimiter, norad_id, site, filters, file: file.to_owned() })
    }

    /// Parses all rows of a block; `file` is the number of the file.
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
                // Reading from memory cannot fail.
                while reader.read_byte_record(&mut record).unwrap_or(false) {
                    rows.push(&|index| record.get(index), record.iter());
                }
            }
            Delimiter::QuotedBlanks => {
                for line in block.split(|byte| *byte == b'\n') {
                    let line = String::from_utf8_lossy(line);
                    let cells = if line.starts_with('#') { Vec::new() } else { blank_record(line.trim_end()) };
                    if !cells.is_empty() {
                        let cell = |index: usize| cells.get(index).map(String::as_bytes);
                        rows.push(&cell, cells.iter().map(String::as_bytes));
                    }
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
                        rows.push(&|index| ends.get(index).map(cell), ends.iter().map(cell));
                    }
                }
            }
        }
        rows.parsed
    }
}

/// Checks that a column has the unit and the time scale of the column map, if the file states them.
fn check_unit(map: &ColumnMap, field: Field, column: &str, head: &Head, file: &str) -> Result<(), Error> {
    let error = |stated: &str, allowed: &str| {
        Error::new(ErrorKind::Invalid, format!("column {} is in '{}'", Quoted::new(column), Quoted::new(stated)))
            .allowing(allowed)
            .in_file("", file)
    };
    if let (Field::Time, Some(stated), Some(scale)) = (field, head.time_scales.get(column), map.time_scale) {
        let allowed = scale.to_string().to_ascii_lowercase();
        return if *stated == allowed { Ok(()) } else { Err(error(stated, &format!("{allowed} (time_scale)"))) };
    }
    let angle_deg = map.angle_rad.to_degrees();
    let (unit, size, key): (&Unit, f64, &str) = match field {
        Field::Magnitude | Field::Sigma => (&MAGNITUDES, 1.0, "mag"),
        Field::Altitude
        | Field::Azimuth
        | Field::Phase
        | Field::RightAscension
        | Field::Declination
        | Field::SunAltitude
        | Field::AzimuthFromSun => (&DEGREES, angle_deg, "that of the column map (angle_unit: deg or rad)"),
        Field::Height => (&KILOMETRES, map.height_km, "that of the column map (height_unit: km or m)"),
        Field::Distance => (&KILOMETRES, map.distance_km, "that of the column map (distance_unit: km or m)"),
        Field::Latitude | Field::Longitude => (&DEGREES, 1.0, "deg"),
        Field::SiteHeight => (&KILOMETRES, 1e-3, "m"),
        Field::Time | Field::TimeOfDay | Field::Filter | Field::Penumbra | Field::Norad | Field::Track => return Ok(()),
    };
    let Some(stated) = head.units.get(column) else { return Ok(()) };
    let is_same = unit.size(stated).is_some_and(|found| (found / size - 1.0).abs() < 1e-9);
    if is_same { Ok(()) } else { Err(error(stated, key)) }
}

/// Group of rows whose pass is not yet known.
pub(super) const UNKNOWN_PASS: u32 = u32::MAX;

/// State of the parser within a block.
struct Rows<'l> {
    layout: &'l Layout,
    file: u32,
    parsed: Parsed,
    group_of: HashMap<String, u32>,
    site_of: HashMap<[u64; 3], u32>,
    /// Night of the last row, and its group.
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
            Err(RejectedCell { reason, field, expected }) => {
                let layout = self.layout;
                self.parsed.dropped.add(reason, || {
                    let given = layout.text(cell, field).unwrap_or_default();
                    let column = layout.map.column(field).unwrap_or_default();
                    let problem = format!("{column} is '{given}'; allowed: {expected}");
                    DropExample { file: String::new(), row, problem }
                });
            }
        }
    }

    fn record(&mut self, cell: Cell) -> Result<Record, RejectedCell> {
        let layout = self.layout;
        if let Some(filter) = layout.text(cell, Field::Filter) {
            self.check_filter(filter)?;
        }
        // 99 and -99 stand for missing magnitudes.
        let magnitude = layout.number(cell, Field::Magnitude, [-30.0, 40.0], "a magnitude of -30 to 40");
        let Ok(Some(magnitude)) = magnitude else {
            return Err(RejectedCell {
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
                    text.parse().map_err(|_| rejected(Field::Norad, "a catalogue number of up to nine digits"))?;
                (number != 0).then_some(NoradId(number)).or(layout.norad_id)
            }
        };
        let site = self.site(cell)?;
        let in_penumbra = match layout.text(cell, Field::Penumbra) {
            None | Some("0") => false,
            Some("1") => true,
            Some(_) => return Err(rejected(Field::Penumbra, "0 or 1")),
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

    fn check_filter(&mut self, filter: &str) -> Result<(), RejectedCell> {
        let layout = self.layout;
        if !layout.filters.is_empty() {
            let is_selected = layout.filters.iter().any(|selected| selected.eq_ignore_ascii_case(filter));
            return if is_selected {
                Ok(())
            } else {
                Err(RejectedCell {
                    reason: DropReason::WrongFilter,
                    field: Field::Filter,
                    expected: "one of the selected filters",
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

    /// Returns the number of the site within the block.
    fn site(&mut self, cell: Cell) -> Result<Option<u32>, RejectedCell> {
        let layout = self.layout;
        if layout.site.is_some() {
            return Ok(Some(0));
        }
        if layout.map.column(Field::Latitude).is_none() {
            return Ok(None);
        }
        let of = |field: Field, bounds: [f64; 2], expected: &'static str| match layout.constants[field as usize] {
            Some(number) => Ok(number),
            None => layout.number(cell, field, bounds, expected)?.ok_or_else(|| rejected(field, expected)),
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
            .map_err(|_| rejected(Field::Latitude, "a position on the Earth"))?;
        let number = self.parsed.sites.len() as u32;
        self.parsed.sites.push(site);
        self.site_of.insert(key, number);
        Ok(Some(number))
    }

    /// Returns the number of a row's group within the block. The group is the track if it is recorded, otherwise the
    /// satellite, the night, or the file. [`UNKNOWN_PASS`] if the passes follow from the geometries of all rows.
    fn group(&mut self, cell: Cell, norad_id: Option<NoradId>, epoch: Option<Epoch>, site: Option<u32>) -> u32 {
        if let Some(track) = self.layout.text(cell, Field::Track) {
            // Rows of the same track are usually consecutive.
            let is_of = |last: &Record| self.parsed.groups.get(last.group as usize).is_some_and(|group| group == track);
            if self.parsed.records.last().is_some_and(is_of) {
                return self.parsed.records[self.parsed.records.len() - 1].group;
            }
            return self.numbered(track.to_owned());
        }
        if let Some(norad_id) = norad_id {
            return self.numbered(format!("satellite {norad_id}"));
        }
        let Some(epoch) = epoch else {
            let has_angles = self.layout.map.column(Field::SunAltitude).is_some();
            return if has_angles { UNKNOWN_PASS } else { self.numbered(self.layout.file.clone()) };
        };
        // A night is named by the date of its evening, so days begin at local noon.
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

/// A value because of which a row is dropped.
struct RejectedCell {
    reason: DropReason,
    field: Field,
    expected: &'static str,
}

/// Function that returns the value at a column index.
type Cell<'a> = &'a dyn Fn(usize) -> Option<&'a [u8]>;

fn rejected(field: Field, expected: &'static str) -> RejectedCell {
    RejectedCell { reason: DropReason::Unparsable, field, expected }
}

impl Layout {
    /// Returns the text in a column; `None` for a missing column or an empty value.
    fn text<'a>(&self, cell: Cell<'a>, field: Field) -> Option<&'a str> {
        let bytes = cell(self.columns[field as usize]?)?.trim_ascii();
        // Text that is not valid Unicode is neither a number nor a time nor a known name.
        (!bytes.is_empty()).then(|| std::str::from_utf8(bytes).unwrap_or("?"))
    }

    /// Returns a finite number within bounds; `None` for a missing column or an empty value.
    fn number(
        &self,
        cell: Cell,
        field: Field,
        [least, greatest]: [f64; 2],
        expected: &'static str,
    ) -> Result<Option<f64>, RejectedCell> {
        let Some(text) = self.text(cell, field) else { return Ok(None) };
        let number = text.parse::<f64>().ok().filter(|number| (least..=greatest).contains(number));
        number.map(Some).ok_or_else(|| rejected(field, expected))
    }

    /// Returns the same as `number`, converted to kilometres.
    fn length(
        &self,
        cell: Cell,
        field: Field,
        unit_km: f64,
        [least, greatest]: [f64; 2],
        expected: &'static str,
    ) -> Result<Option<f64>, RejectedCell> {
        let length = self.number(cell, field, [least / unit_km, greatest / unit_km], expected)?;
        Ok(length.map(|length| length * unit_km))
    }

    /// Returns the same as `number`, converted to radians; the bounds are in degrees.
    fn angle(
        &self,
        cell: Cell,
        field: Field,
        bounds_deg: [f64; 2],
        expected: &'static str,
    ) -> Result<Option<f64>, RejectedCell> {
        let bounds = bounds_deg.map(|bound| bound.to_radians() / self.map.angle_rad);
        Ok(self.number(cell, field, bounds, expected)?.map(|angle| angle * self.map.angle_rad))
    }

    fn time(&self, cell: Cell) -> Result<Option<Epoch>, RejectedCell> {
        let (Some(_), Some(scale)) = (self.columns[Field::Time as usize], self.map.time_scale) else { return Ok(None) };
        let wrong = || rejected(Field::Time, "a time from 1957 to 2100 as ISO 8601, MJD or JD");
        let date = self.text(cell, Field::Time).ok_or_else(wrong)?;
        let epoch = match self.columns[Field::TimeOfDay as usize] {
            Some(_) => {
                let time = self.text(cell, Field::TimeOfDay).ok_or_else(wrong)?;
                moment(&format!("{date} {time}"), scale)
            }
            None => match date.parse::<f64>() {
                Ok(days) => epoch_from_mjd(days, scale).or_else(|_| epoch_from_jd(days, scale)).ok(),
                Err(_) => moment(date, scale),
            },
        };
        // MJD of the launch of Sputnik and of the end of the Sun's ephemeris.
        let (first, last) = (36_116.0, 88_069.0);
        epoch.filter(|epoch| (first..last).contains(&mjd_utc(*epoch))).map(Some).ok_or_else(wrong)
    }

    fn sighting(&self, cell: Cell) -> Result<Sighting, RejectedCell> {
        let altitude = self.angle(cell, Field::Altitude, [-90.0, 90.0], "an altitude of -90 to 90 deg")?;
        let height_unit = self.map.height_km;
        let height = self.length(cell, Field::Height, height_unit, [100.0, 50_000.0], "a height of 100 to 50000 km")?;
        if self.map.column(Field::SunAltitude).is_some() {
            let sun = self.angle(cell, Field::SunAltitude, [-90.0, 90.0], "an altitude of -90 to 90 deg")?;
            let azimuth = self.angle(cell, Field::AzimuthFromSun, [-360.0, 360.0], "an azimuth in deg")?;
            return Ok(Sighting::SunRelative {
                sun_altitude_rad: sun.ok_or_else(|| rejected(Field::SunAltitude, "an altitude"))?,
                altitude_rad: altitude.ok_or_else(|| rejected(Field::Altitude, "an altitude"))?,
                azimuth_from_sun_rad: azimuth.ok_or_else(|| rejected(Field::AzimuthFromSun, "an azimuth"))?,
                height_km: height.ok_or_else(|| rejected(Field::Height, "a height"))?,
            });
        }
        let azimuth = self.angle(cell, Field::Azimuth, [-360.0, 360.0], "an azimuth in deg")?;
        if let (Some(altitude_rad), Some(azimuth_rad), Some(height_km)) = (altitude, azimuth, height) {
            return Ok(Sighting::Horizontal { altitude_rad, azimuth_rad, height_km });
        }
        let distance_unit = self.map.distance_km;
        let range =
            self.length(cell, Field::Distance, distance_unit, [100.0, 100_000.0], "a distance of 100 to 100000 km")?;
        let ascension = self.angle(cell, Field::RightAscension, [0.0, 360.0], "a right ascension of 0 to 360 deg")?;
        let declination = self.angle(cell, Field::Declination, [-90.0, 90.0], "a declination of -90 to 90 deg")?;
        let phase_rad = self.angle(cell, Field::Phase, [0.0, 180.0], "an angle of 0 to 180 deg")?;
        Ok(match (range, ascension, declination) {
            (Some(range_km), Some(right_ascension_rad), Some(declination_rad)) => {
                Sighting::Equatorial { right_ascension_rad, declination_rad, range_km }
            }
            (Some(range_km), ..) => Sighting::Distance { range_km, phase_rad },
            _ => Sighting::Nothing,
        })
    }
}

/// Parses date and time in a time scale, also with `Z` or an offset from UTC, which contradict other scales than UTC.
fn moment(text: &str, scale: TimeScale) -> Option<Epoch> {
    match has_zone(text) {
        true if scale != TimeScale::UTC => None,
        true => parse_instant(text, None).ok().or_else(|| date_and_time(text)),
        false => date_and_time(text).map(|epoch| Epoch::from_duration(epoch.to_utc_duration(), scale)),
    }
}

/// Parses date and time. Hours of one digit (`2024-01-01 5:03:02`) are accepted because they occur in tables of
/// photometry.
fn date_and_time(text: &str) -> Option<Epoch> {
    parse_iso(text).or_else(|| {
        let (date, time) = text.split_once(['T', ' '])?;
        let time = time.trim_start();
        (time.find(':') == Some(1)).then(|| parse_iso(&format!("{date}T0{time}"))).flatten()
    })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::super::blocks::Blocks;
    use super::*;

    /// Returns the records of ECSV with these units and this row, or the error.
    fn read(units: [&str; 4], scale: &str, row: &str) -> Result<Vec<Record>, Error> {
        let names = ["mag", "alt", "az", "height"];
        let columns: String = names
            .iter()
            .zip(units)
            .map(|(name, unit)| format!("# - {{name: {name}, unit: {unit}, datatype: float64}}\n"))
            .collect();
        let text = format!(
            "# %ECSV 1.0\n# ---\n# datatype:\n# - {{name: time, datatype: string}}\n{columns}# meta: !!omap\n\
             # - __serialized_columns__:\n#     time: {{__class__: astropy.time.core.Time, format: isot, scale: {scale}}}\n\
             time mag alt az height\n{row}\n"
        );
        let map = "time=time,time_scale=utc,magnitude=mag,altitude=alt,azimuth=az,height=height";
        let (head, mut blocks) = Blocks::from_source(Box::new(Cursor::new(text.into_bytes())), "p.ecsv")?;
        let site = Site::from_mpc("X05").ok();
        let layout = Layout::new(ColumnMap::from_text(map)?, &head, site, &[], "p.ecsv")?;
        Ok(layout.parse(&blocks.next().unwrap().unwrap(), 0).records)
    }

    #[test]
    fn units_and_scale_of_ecsv_must_be_those_of_the_map() {
        // Cells may be aligned by several blanks.
        let row = "2026-08-14T23:36:25  5.5   45.0  120.0 550.0";
        let stated = ["mag", "deg", "deg", "km"];
        let epoch = |time: &str| {
            let records = read(stated, "utc", &row.replacen("2026-08-14T23:36:25", time, 1)).unwrap();
            records.first().and_then(|record| record.epoch)
        };
        let utc = epoch("2026-08-14T23:36:25");
        assert!(utc.is_some());
        for time in ["2026-08-14T23:36:25.000+00:00", "2026-08-15T01:36:25+02:00", "2026-08-14T18:06:25-0530"] {
            assert_eq!(epoch(time), utc, "{time}");
        }
        assert_eq!(epoch("2026-08-14T23:36:25+25:00"), None);
        assert_eq!(read(stated, "utc", row).unwrap()[0].magnitude, Magnitude(5.5));
        for (units, scale, expected) in [
            (["s", "deg", "deg", "km"], "utc", "column mag is in 's'; allowed: mag"),
            (["mag", "rad", "deg", "km"], "utc", "column alt is in 'rad'; allowed: that of the column map (angle_unit"),
            (["mag", "deg", "hourangle", "km"], "utc", "column az is in 'hourangle'"),
            (
                ["mag", "deg", "deg", "m"],
                "utc",
                "column height is in 'm'; allowed: that of the column map (height_unit",
            ),
            (stated, "tai", "column time is in 'tai'; allowed: utc (time_scale)"),
        ] {
            let error = read(units, scale, row).err().unwrap().to_string();
            assert!(error.starts_with("p.ecsv: ") && error.contains(expected), "{error}");
        }
    }
}

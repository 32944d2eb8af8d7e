//! Rows of photometry as recorded, before their viewing geometry is computed.

use hifitime::Epoch;

use super::dropped::DropCounts;
use crate::elements::NoradId;
use crate::error::Error;
use crate::geometry::Site;
use crate::photometry::Magnitude;

/// Position of the satellite as recorded. Angles are in radians.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Sighting {
    /// Distance and phase angle.
    Distance {
        /// Distance from observer to satellite, km.
        range_km: f64,
        /// Phase angle Sun-satellite-observer, [0, π], if it is recorded.
        phase_rad: Option<f64>,
    },
    /// Horizontal coordinates and height.
    Horizontal {
        /// Altitude above the horizon, without refraction.
        altitude_rad: f64,
        /// Azimuth from north through east.
        azimuth_rad: f64,
        /// Height above the WGS84 ellipsoid, km.
        height_km: f64,
    },
    /// Altitudes of satellite and Sun and the azimuth difference, without time and site.
    SunRelative {
        /// Altitude of the Sun.
        sun_altitude_rad: f64,
        /// Altitude of the satellite.
        altitude_rad: f64,
        /// Azimuth of the satellite minus that of the Sun.
        azimuth_from_sun_rad: f64,
        /// Height above a sphere of radius 6371 km, in km.
        height_km: f64,
    },
    /// Equatorial coordinates and distance.
    Equatorial {
        /// Right ascension, ICRS, astrometric topocentric.
        right_ascension_rad: f64,
        /// Declination, ICRS, astrometric topocentric.
        declination_rad: f64,
        /// Distance from observer to satellite, km.
        range_km: f64,
    },
    /// No position is recorded, so that element sets are required.
    Nothing,
}

impl Sighting {
    /// Returns the recorded range, km, and the recorded phase angle, radians.
    pub fn distance_and_phase(&self) -> (Option<f64>, Option<f64>) {
        match *self {
            Self::Distance { range_km, phase_rad } => (Some(range_km), phase_rad),
            Self::Equatorial { range_km, .. } => (Some(range_km), None),
            _ => (None, None),
        }
    }
}

/// A row of photometry as recorded.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Record {
    /// Time; `None` in tables without times.
    pub epoch: Option<Epoch>,
    /// Apparent magnitude.
    pub magnitude: Magnitude,
    /// Uncertainty (one sigma) as stated, mag.
    pub sigma_mag: Option<f64>,
    /// Recorded position of the satellite.
    pub sighting: Sighting,
    /// NORAD catalogue number from the row or the head of its file.
    pub norad_id: Option<NoradId>,
    /// Index into [`RecordSource::groups`].
    pub group: u32,
    /// Index into [`RecordSource::sites`]; `None` if the site is unknown.
    pub site: Option<u32>,
    /// True if the survey flags the satellite as being in the penumbra.
    pub in_penumbra: bool,
    /// Index into [`RecordSource::files`].
    pub file: u32,
    /// Data row of that file, from 1.
    pub row: u32,
}

/// Source of records in chunks, such as files or memory.
pub trait RecordSource {
    /// Returns the next chunk of rows, in order. A chunk may be empty; `None` means that all rows have been read.
    ///
    /// # Errors
    /// Errors after which the rest of a file cannot be used.
    fn next_chunk(&mut self) -> Result<Option<Vec<Record>>, Error>;

    /// Returns the names of the groups (tracks, satellites, nights or files) that have occurred so far.
    fn groups(&self) -> &[String];

    /// Returns the sites that have occurred so far.
    fn sites(&self) -> &[Site];

    /// Returns the names of the files that have been opened so far.
    fn files(&self) -> &[String];

    /// Returns the numbers of rows dropped so far.
    fn dropped(&self) -> &DropCounts;
}

/// Records in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    /// Records in order.
    pub records: Vec<Record>,
    /// Names of the groups; `Record::group` is an index into them.
    pub groups: Vec<String>,
    /// Sites; `Record::site` is an index into them.
    pub sites: Vec<Site>,
    /// Names of the files; `Record::file` is an index into them.
    pub files: Vec<String>,
    /// Numbers of dropped rows by reason.
    pub dropped: DropCounts,
}

impl Records {
    /// Reads a source to its end.
    ///
    /// # Errors
    /// The errors of the source.
    pub fn collect(source: &mut impl RecordSource) -> Result<Self, Error> {
        let mut records = Vec::new();
        while let Some(chunk) = source.next_chunk()? {
            records.extend(chunk);
        }
        Ok(Self {
            records,
            groups: source.groups().to_vec(),
            sites: source.sites().to_vec(),
            files: source.files().to_vec(),
            dropped: source.dropped().clone(),
        })
    }

    /// Returns the records of each group, in the order of [`groups`](Self::groups).
    pub fn by_group(&self) -> Vec<Vec<Record>> {
        let mut groups = vec![Vec::new(); self.groups.len()];
        for record in &self.records {
            if let Some(group) = groups.get_mut(record.group as usize) {
                group.push(*record);
            }
        }
        groups
    }

    /// Returns a source that gives these records.
    pub fn source(&self) -> RecordsSource<'_> {
        RecordsSource { of: self, at: 0 }
    }
}

/// Source of records in memory.
#[derive(Clone, Debug)]
pub struct RecordsSource<'a> {
    of: &'a Records,
    at: usize,
}

/// Number of rows per chunk.
const CHUNK: usize = 1 << 16;

impl RecordSource for RecordsSource<'_> {
    fn next_chunk(&mut self) -> Result<Option<Vec<Record>>, Error> {
        let rest = &self.of.records[self.at..];
        let chunk = &rest[..rest.len().min(CHUNK)];
        self.at += chunk.len();
        Ok((!chunk.is_empty()).then(|| chunk.to_vec()))
    }

    fn groups(&self) -> &[String] {
        &self.of.groups
    }

    fn sites(&self) -> &[Site] {
        &self.of.sites
    }

    fn files(&self) -> &[String] {
        &self.of.files
    }

    fn dropped(&self) -> &DropCounts {
        &self.of.dropped
    }
}

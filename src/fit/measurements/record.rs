//! A row of photometry as it was recorded, before anything is known of its geometry.

use hifitime::Epoch;

use crate::elements::NoradId;
use crate::geometry::Site;
use crate::photometry::Magnitude;

use super::dropped::DropCounts;
use super::error::MeasuredError;

/// What a row says of where the satellite stood. Angles in radians.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Sighting {
    /// How far it was, and the angle Sun-satellite-observer.
    Distance {
        /// Observer to satellite, km.
        range_km: f64,
        /// [0, π]; `None` where the row does not tell.
        phase_rad: Option<f64>,
    },
    /// Above which horizon, and how high.
    Horizontal {
        /// Above the horizon, without refraction.
        altitude_rad: f64,
        /// From north through east.
        azimuth_rad: f64,
        /// Above a sphere about the geocentre through the site, km.
        height_km: f64,
    },
    /// Altitudes of satellite and Sun, and the azimuth between them: neither time nor site.
    SunRelative {
        /// Of the Sun.
        sun_altitude_rad: f64,
        /// Of the satellite.
        altitude_rad: f64,
        /// From the Sun to the satellite.
        azimuth_from_sun_rad: f64,
        /// Above a sphere of 6371 km, km.
        height_km: f64,
    },
    /// A place among the stars, and how far.
    Equatorial {
        /// ICRS, astrometric topocentric.
        right_ascension_rad: f64,
        /// ICRS, astrometric topocentric.
        declination_rad: f64,
        /// Observer to satellite, km.
        range_km: f64,
    },
    /// Nothing: element sets have to tell.
    Nothing,
}

impl Sighting {
    /// Observer to satellite, km, and the phase, radians, as recorded.
    pub fn distance_and_phase(&self) -> (Option<f64>, Option<f64>) {
        match *self {
            Self::Distance { range_km, phase_rad } => (Some(range_km), phase_rad),
            Self::Equatorial { range_km, .. } => (Some(range_km), None),
            _ => (None, None),
        }
    }
}

/// One row.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Record {
    /// When; `None` in tables without times.
    pub epoch: Option<Epoch>,
    /// At the observer.
    pub magnitude: Magnitude,
    /// One sigma as stated, mag.
    pub sigma_mag: Option<f64>,
    /// Where.
    pub sighting: Sighting,
    /// Which satellite, where the row or the head of its file says so.
    pub norad_id: Option<NoradId>,
    /// Index into [`RecordSource::groups`].
    pub group: u32,
    /// Index into [`RecordSource::sites`]; `None` where no site is known.
    pub site: Option<u32>,
    /// Flagged by the survey as in the penumbra.
    pub in_penumbra: bool,
    /// Index into [`RecordSource::files`].
    pub file: u32,
    /// Data row of that file, from 1.
    pub row: u32,
}

/// Where records come from, chunk by chunk: files, or a simulation.
pub trait RecordSource {
    /// The next rows in order; `None` after the last. A chunk may be empty.
    ///
    /// # Errors
    /// What makes the rest of a file useless.
    fn next_chunk(&mut self) -> Result<Option<Vec<Record>>, MeasuredError>;

    /// Names of tracks, satellites, nights or files, as far as they have occurred.
    fn groups(&self) -> &[String];

    /// Observers, as far as they have occurred.
    fn sites(&self) -> &[Site];

    /// Names of the files.
    fn files(&self) -> &[String];

    /// Rows dropped so far.
    fn dropped(&self) -> &DropCounts;
}

/// Records in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    /// In order.
    pub records: Vec<Record>,
    /// Names that [`Record::group`] points at.
    pub groups: Vec<String>,
    /// Sites that [`Record::site`] points at.
    pub sites: Vec<Site>,
    /// Files that [`Record::file`] points at.
    pub files: Vec<String>,
    /// Rows that were not taken.
    pub dropped: DropCounts,
}

impl Records {
    /// Everything that a source has.
    ///
    /// # Errors
    /// Those of the source.
    pub fn collect(source: &mut impl RecordSource) -> Result<Self, MeasuredError> {
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

    /// The records of each group, in the order of [`groups`](Self::groups).
    pub fn by_group(&self) -> Vec<Vec<Record>> {
        let mut groups = vec![Vec::new(); self.groups.len()];
        for record in &self.records {
            if let Some(group) = groups.get_mut(record.group as usize) {
                group.push(*record);
            }
        }
        groups
    }

    /// The same records as a source.
    pub fn source(&self) -> RecordsSource<'_> {
        RecordsSource { of: self, at: 0 }
    }
}

/// Records in memory, given out in chunks.
#[derive(Clone, Debug)]
pub struct RecordsSource<'a> {
    of: &'a Records,
    at: usize,
}

/// Rows given out at a time.
const CHUNK: usize = 1 << 16;

impl RecordSource for RecordsSource<'_> {
    fn next_chunk(&mut self) -> Result<Option<Vec<Record>>, MeasuredError> {
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

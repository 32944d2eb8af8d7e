//! Recorded rows of photometry, before their geometry is computed.

use hifitime::Epoch;

use super::super::error::FitError;
use super::dropped::DropCounts;
use crate::elements::NoradId;
use crate::geometry::Site;
use crate::photometry::Magnitude;

/// Recorded position of the satellite. Angles in radians.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Sighting {
    /// Distance and phase angle.
    Distance {
        /// Distance from observer to satellite, km.
        range_km: f64,
        /// Angle Sun-satellite-observer, [0, π], if recorded.
        phase_rad: Option<f64>,
    },
    /// Horizontal coordinates and height.
    Horizontal {
        /// Altitude above the horizon, without refraction.
        altitude_rad: f64,
        /// Azimuth from north through east.
        azimuth_rad: f64,
        /// Height above the geocentric sphere through the site, km.
        height_km: f64,
    },
    /// Altitudes of satellite and Sun and the azimuth between them, without time and site.
    SunRelative {
        /// Altitude of the Sun.
        sun_altitude_rad: f64,
        /// Altitude of the satellite.
        altitude_rad: f64,
        /// Azimuth of the satellite from the Sun.
        azimuth_from_sun_rad: f64,
        /// Height above a sphere of 6371 km, km.
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
    /// No position; element sets are required.
    Nothing,
}

impl Sighting {
    /// Recorded range, km, and phase, radians.
    pub fn distance_and_phase(&self) -> (Option<f64>, Option<f64>) {
        match *self {
            Self::Distance { range_km, phase_rad } => (Some(range_km), phase_rad),
            Self::Equatorial { range_km, .. } => (Some(range_km), None),
            _ => (None, None),
        }
    }
}

/// Recorded row of photometry.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Record {
    /// Time; `None` in tables without times.
    pub epoch: Option<Epoch>,
    /// Apparent magnitude.
    pub magnitude: Magnitude,
    /// Stated one sigma, mag.
    pub sigma_mag: Option<f64>,
    /// Position of the satellite.
    pub sighting: Sighting,
    /// NORAD catalogue number from the row or the head of its file.
    pub norad_id: Option<NoradId>,
    /// Index into [`RecordSource::groups`].
    pub group: u32,
    /// Index into [`RecordSource::sites`]; `None` if the site is unknown.
    pub site: Option<u32>,
    /// Penumbra flag of the survey.
    pub in_penumbra: bool,
    /// Index into [`RecordSource::files`].
    pub file: u32,
    /// Data row of that file, from 1.
    pub row: u32,
}

/// Source of records in chunks: files or memory.
pub trait RecordSource {
    /// Next rows in order, possibly none; `None` after the last.
    ///
    /// # Errors
    /// Errors that make the rest of a file unusable.
    fn next_chunk(&mut self) -> Result<Option<Vec<Record>>, FitError>;

    /// Names of the groups (tracks, satellites, nights or files) so far.
    fn groups(&self) -> &[String];

    /// Sites so far.
    fn sites(&self) -> &[Site];

    /// Names of the files so far.
    fn files(&self) -> &[String];

    /// Rows dropped so far.
    fn dropped(&self) -> &DropCounts;
}

/// Records in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Records {
    /// Records in order.
    pub records: Vec<Record>,
    /// Names of the groups, for [`Record::group`].
    pub groups: Vec<String>,
    /// Sites, for [`Record::site`].
    pub sites: Vec<Site>,
    /// Names of the files, for [`Record::file`].
    pub files: Vec<String>,
    /// Dropped rows.
    pub dropped: DropCounts,
}

impl Records {
    /// Reads a source to its end.
    ///
    /// # Errors
    /// Those of the source.
    pub fn collect(source: &mut impl RecordSource) -> Result<Self, FitError> {
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

    /// Records of each group, in the order of [`groups`](Self::groups).
    pub fn by_group(&self) -> Vec<Vec<Record>> {
        let mut groups = vec![Vec::new(); self.groups.len()];
        for record in &self.records {
            if let Some(group) = groups.get_mut(record.group as usize) {
                group.push(*record);
            }
        }
        groups
    }

    /// Source with these records.
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

/// Rows per chunk.
const CHUNK: usize = 1 << 16;

impl RecordSource for RecordsSource<'_> {
    fn next_chunk(&mut self) -> Result<Option<Vec<Record>>, FitError> {
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

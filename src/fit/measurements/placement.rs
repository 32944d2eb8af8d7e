//! Viewing geometry of records, computed from element sets or from the recorded quantities.

use std::collections::HashMap;

use hifitime::{Epoch, Unit};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::constants::{AU_KM, EARTH_EQUATORIAL_RADIUS_KM};
use crate::elements::{ElementSet, History, NoradId};
use crate::frames::{Direction, EopTable, Gcrs, Horizontal, Itrs, Position};
use crate::geometry::{Illumination, ShadowModel, ViewingGeometry, ellipsoidal_height_km, grazing_height_km};
use crate::orbit::Propagator;

use super::dropped::DropReason;
use super::ephemeris::{Ephemeris, Moment, SiteAxes};
use super::offset::{Ranged, fitted_offset_s};
use super::record::{Record, RecordSource, Sighting};
use super::triangle;

/// Mean radius of the Earth, km; used as the observer's distance from the Earth's centre for tables without a site.
const MEAN_RADIUS_KM: f64 = 6371.0;

/// Data from which a satellite's position is computed.
#[derive(Clone, Debug, PartialEq)]
pub enum PositionSource {
    /// SGP4 with the element set that is nearest in time.
    Elements {
        /// Largest delay along the track, early or late, that is fitted to the recorded ranges of each track, s (10 is
        /// usual). `None`: no fit. Tracks without ranges are not shifted.
        fit_offset_s: Option<f64>,
    },
    /// Quantities recorded in the row. Records with only distance and phase angle also require the radius of the orbit.
    Recorded {
        /// Radius of the orbit. If it is `None`, rows with only distance and phase angle have no geometry.
        radius: Option<OrbitRadius>,
    },
}

/// Distance from the Earth's centre to a satellite whose distance and phase angle are recorded.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum OrbitRadius {
    /// Circular orbit at this height above 6378.137 km. In low orbits the short-period term of J2 changes the radius by
    /// ±10 km, which causes an error of 13° in α at the 90th percentile.
    HeightKm(f64),
    /// Radius computed by SGP4 for the time of the row, including short-period terms. It is nearly right even if the
    /// satellite is a minute late.
    Elements,
}

/// Options for the computation of viewing geometry.
#[derive(Clone, Debug)]
pub struct Placement<'a> {
    /// Data from which the satellites' positions are computed.
    pub source: PositionSource,
    /// History of the element sets of all satellites.
    pub history: Option<&'a History>,
    /// Satellites of groups whose rows contain no catalogue number, as found by
    /// [`identify_tracks`](super::identify_tracks).
    pub identified: HashMap<String, NoradId>,
    /// Largest difference between the time of a record and the epoch of an element set, days.
    pub max_element_age_days: f64,
    /// Table of Earth orientation parameters.
    pub eop: EopTable,
}

impl Placement<'_> {
    /// Creates options for recorded quantities. Satellites with only distance and phase angle are on circular orbits at
    /// this height above 6378.137 km.
    pub fn recorded(height_km: Option<f64>) -> Placement<'static> {
        let source = PositionSource::Recorded { radius: height_km.map(OrbitRadius::HeightKm) };
        Placement {
            source,
            history: None,
            identified: HashMap::new(),
            max_element_age_days: 14.0,
            eop: EopTable::embedded(),
        }
    }

    /// Creates options for element sets within two weeks of the record, without a fit of delays.
    pub fn elements(history: &History) -> Placement<'_> {
        Placement {
            source: PositionSource::Elements { fit_offset_s: None },
            history: Some(history),
            identified: HashMap::new(),
            max_element_age_days: 14.0,
            eop: EopTable::embedded(),
        }
    }

    /// Returns the catalogue number of the satellite of a record.
    pub(super) fn norad_of(&self, record: &Record, groups: &[String]) -> Option<NoradId> {
        record.norad_id.or_else(|| {
            // A look-up by name is slow, and it is unnecessary for most tables.
            if self.identified.is_empty() {
                None
            } else {
                self.identified.get(groups.get(record.group as usize)?).copied()
            }
        })
    }
}

/// Viewing geometry of a record and the positions from which it was computed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Placed {
    /// Viewing geometry.
    pub geometry: ViewingGeometry,
    /// Geocentric positions of satellite and Sun; `None` if unknown.
    pub satellite_and_sun: Option<(Position<Gcrs>, Position<Gcrs>)>,
    /// Altitude above the horizon, radians; `None` if unknown.
    pub altitude_rad: Option<f64>,
    /// NORAD catalogue number.
    pub norad_id: Option<NoradId>,
}

impl Placed {
    /// Returns the lowest height above the ground of the line from satellite to Sun, km; `None` if the satellite is the
    /// lowest point. Without positions, the ground is a sphere of 6378.137 km.
    pub fn grazing_height_km(&self) -> Option<f64> {
        match &self.satellite_and_sun {
            Some((satellite, sun)) => grazing_height_km(satellite, sun),
            // Distance between the Earth's centre and the line to the Sun: R cos δ_sun for a Sun below the satellite's
            // horizontal plane.
            None => (self.geometry.sun_latitude_rad < 0.0).then(|| {
                let radius_km = EARTH_EQUATORIAL_RADIUS_KM + self.geometry.height_km;
                radius_km * self.geometry.sun_latitude_rad.cos() - EARTH_EQUATORIAL_RADIUS_KM
            }),
        }
    }

    /// Returns the illumination, with the atmosphere. Without positions, the Earth is a sphere of 6378.137 km.
    pub fn illumination(&self) -> Illumination {
        match &self.satellite_and_sun {
            Some((satellite, sun)) => ShadowModel::Atmosphere.illumination(satellite, sun),
            None => {
                // The satellite is placed in the plane of the equator, where the ellipsoid is a circle.
                let radius_km = EARTH_EQUATORIAL_RADIUS_KM + self.geometry.height_km;
                let (sin, cos) = self.geometry.sun_latitude_rad.sin_cos();
                let satellite = Position::<Gcrs>::new(radius_km * sin, radius_km * cos, 0.0);
                ShadowModel::Atmosphere.illumination(&satellite, &Position::new(AU_KM, 0.0, 0.0))
            }
        }
    }
}

/// Computes the viewing geometry of records chunk by chunk. Tables of Sun and Earth are kept from chunk to chunk.
pub struct Placer<'a> {
    placement: &'a Placement<'a>,
    ephemeris: Ephemeris,
}

/// Minutes in a day.
const MINUTES_A_DAY: f64 = 1440.0;
/// Number of records per task.
const RUN: usize = 2048;

impl<'a> Placer<'a> {
    /// Creates a placer without prepared tables.
    pub fn new(placement: &'a Placement<'a>) -> Self {
        Self { placement, ephemeris: Ephemeris::new(placement.eop.clone()) }
    }

    /// Computes the geometry of each record in parallel. For a record without geometry, the result is the reason.
    ///
    /// If delays are fitted, the rows of a track should be in one chunk, because parts of a track in different chunks
    /// are fitted separately.
    pub fn place(&mut self, source: &impl RecordSource, records: &[Record]) -> Vec<Result<Placed, DropReason>> {
        self.ephemeris.prepare(records.iter().filter_map(|record| record.epoch));
        let sites: Vec<SiteAxes> = source.sites().iter().map(SiteAxes::new).collect();
        let groups = source.groups();
        let placer = ChunkPlacer { placement: self.placement, ephemeris: &self.ephemeris, sites: &sites, groups };
        let offsets = placer.offsets_s(records);
        let runs: Vec<Vec<_>> = records
            .par_chunks(RUN)
            .map(|run| {
                let mut orbit = None;
                run.iter().map(|record| placer.place(record, &mut orbit, &offsets)).collect()
            })
            .collect();
        runs.concat()
    }
}

/// Data for the records of one chunk.
struct ChunkPlacer<'a> {
    placement: &'a Placement<'a>,
    ephemeris: &'a Ephemeris,
    sites: &'a [SiteAxes],
    groups: &'a [String],
}

impl<'a> ChunkPlacer<'a> {
    fn place(
        &self,
        record: &Record,
        orbit: &mut Option<NearestOrbit>,
        offsets_s: &HashMap<u32, f64>,
    ) -> Result<Placed, DropReason> {
        let norad_id = self.placement.norad_of(record, self.groups);
        let placed = match self.placement.source {
            PositionSource::Elements { .. } => {
                let offset_s = offsets_s.get(&record.group).copied().unwrap_or(0.0);
                let (moment, site) = self.moment_and_observer(record).ok_or(DropReason::NoGeometry)?;
                let satellite = self.satellite(record, norad_id, offset_s, &moment, orbit)?;
                placed_at(&satellite, &moment, site)
            }
            PositionSource::Recorded { radius } => match record.sighting {
                Sighting::Horizontal { altitude_rad, azimuth_rad, height_km } => {
                    self.moment_and_observer(record).and_then(|(moment, site)| {
                        let sight = Direction::<Horizontal>::from_lon_lat_rad(azimuth_rad, altitude_rad);
                        let sight = site.horizon.inverse() * sight;
                        let range_km =
                            range_to_ellipsoidal_height_km(site.position.vector(), sight.vector(), height_km);
                        let satellite = moment.orientation.itrs_to_gcrs * (site.position + sight.at_range(range_km));
                        placed_at(&satellite, &moment, site)
                    })
                }
                Sighting::Equatorial { right_ascension_rad, declination_rad, range_km } => {
                    self.moment_and_observer(record).and_then(|(moment, site)| {
                        let sight = Direction::<Gcrs>::from_lon_lat_rad(right_ascension_rad, declination_rad);
                        let (observer, _) = site.at(&moment);
                        placed_at(&(observer + sight.at_range(range_km)), &moment, site)
                    })
                }
                Sighting::SunRelative { sun_altitude_rad, altitude_rad, azimuth_from_sun_rad, height_km } => {
                    sun_relative(sun_altitude_rad, altitude_rad, azimuth_from_sun_rad, height_km)
                }
                Sighting::Distance { range_km, phase_rad } => {
                    let (Some(phase_rad), Some(radius)) = (phase_rad, radius) else {
                        return Err(DropReason::NoGeometry);
                    };
                    let (moment, site) = self.moment_and_observer(record).ok_or(DropReason::NoGeometry)?;
                    let radius_km = match radius {
                        OrbitRadius::HeightKm(height_km) => EARTH_EQUATORIAL_RADIUS_KM + height_km,
                        OrbitRadius::Elements => self.satellite(record, norad_id, 0.0, &moment, orbit)?.norm_km(),
                    };
                    let (telescope, _) = site.at(&moment);
                    let along_km = telescope.vector().dot(&moment.sun.vector().normalize());
                    let sun_distance_au = moment.sun.norm_km() / AU_KM;
                    triangle::geometry(radius_km, range_km, phase_rad, telescope.norm_km(), along_km).map(|geometry| {
                        // The solution of the triangle assumes that the Sun is at 1 au.
                        let geometry = ViewingGeometry { sun_distance_au, ..geometry };
                        Placed {
                            altitude_rad: geometry.geocentric_altitude_rad(),
                            geometry,
                            satellite_and_sun: None,
                            norad_id: None,
                        }
                    })
                }
                Sighting::Nothing => None,
            },
        };
        placed.map(|placed| Placed { norad_id, ..placed }).ok_or(DropReason::NoGeometry)
    }

    fn moment_and_observer(&self, record: &Record) -> Option<(Moment, &'a SiteAxes)> {
        Some((self.ephemeris.at(record.epoch?)?, self.sites.get(record.site? as usize)?))
    }

    /// Returns the geocentric position by the nearest element set, predicted for `offset_s` after the record.
    fn satellite(
        &self,
        record: &Record,
        norad_id: Option<NoradId>,
        offset_s: f64,
        moment: &Moment,
        kept: &mut Option<NearestOrbit>,
    ) -> Result<Position<Gcrs>, DropReason> {
        let (Some(history), Some(norad_id), Some(epoch)) = (self.placement.history, norad_id, record.epoch) else {
            return Err(DropReason::NoElements);
        };
        if !kept.as_ref().is_some_and(|orbit| orbit.is_nearest(norad_id, epoch)) {
            *kept = NearestOrbit::new(history, norad_id, epoch);
        }
        let orbit = kept.as_ref().ok_or(DropReason::NoElements)?;
        let propagator = orbit.propagator.as_ref().ok_or(DropReason::NoPosition)?;
        let minutes = propagator.minutes_since_epoch(epoch);
        if minutes.abs() > self.placement.max_element_age_days * MINUTES_A_DAY {
            return Err(DropReason::StaleElements);
        }
        let minutes = minutes + offset_s / 60.0;
        let state = propagator.state_at_minutes(minutes, &moment.orientation.teme_to_gcrs);
        state.map(|state| state.position).map_err(|_| DropReason::NoPosition)
    }

    /// Returns the fitted time offset of each group in a chunk, s.
    fn offsets_s(&self, records: &[Record]) -> HashMap<u32, f64> {
        let (PositionSource::Elements { fit_offset_s: Some(limit_s) }, Some(history)) =
            (&self.placement.source, self.placement.history)
        else {
            return HashMap::new();
        };
        let mut tracks: HashMap<u32, Vec<&Record>> = HashMap::new();
        for record in records {
            tracks.entry(record.group).or_default().push(record);
        }
        let fitted = tracks.into_par_iter().filter_map(|(group, track)| {
            let first = track.first()?;
            let norad_id = self.placement.norad_of(first, self.groups)?;
            let nearest = history.nearest(norad_id, first.epoch?)?;
            let propagator = Propagator::new(nearest).ok()?;
            let ranged: Vec<Ranged> = Ranged::thinned(&track)
                .filter_map(|record| Ranged::from_record(record, self.ephemeris, self.sites))
                .collect();
            Some((group, fitted_offset_s(&propagator, &ranged, *limit_s)?.offset_s))
        });
        fitted.collect()
    }
}

/// Returns the viewing geometry of a satellite at a known position.
fn placed_at(satellite: &Position<Gcrs>, moment: &Moment, observer: &SiteAxes) -> Option<Placed> {
    let (observer, zenith) = observer.at(moment);
    let geometry = ViewingGeometry::new(satellite, &observer, &moment.sun)?;
    let sine = zenith.dot(&(satellite.vector() - observer.vector())) / geometry.range_km;
    let altitude_rad = Some(sine.clamp(-1.0, 1.0).asin());
    Some(Placed { geometry, satellite_and_sun: Some((*satellite, moment.sun)), altitude_rad, norad_id: None })
}

/// Returns the viewing geometry for an observer on a sphere. The zenith is the x axis, and azimuths are counted from
/// the Sun.
fn sun_relative(sun_altitude: f64, altitude_rad: f64, azimuth: f64, height_km: f64) -> Option<Placed> {
    let site = Vector3::new(MEAN_RADIUS_KM, 0.0, 0.0);
    let towards = |altitude: f64, azimuth: f64| {
        Vector3::new(altitude.sin(), altitude.cos() * azimuth.cos(), altitude.cos() * azimuth.sin())
    };
    let sight = towards(altitude_rad, azimuth);
    let range_km = range_to_height_km(&site, &sight, height_km);
    let positions = [site + sight * range_km, site, towards(sun_altitude, 0.0) * AU_KM];
    let [satellite, observer, sun] = positions.map(Position::<Gcrs>::from_vector);
    let geometry = ViewingGeometry::new(&satellite, &observer, &sun)?;
    Some(Placed { geometry, satellite_and_sun: None, altitude_rad: Some(altitude_rad), norad_id: None })
}

/// Returns the distance along a line of sight to the point at a height above the sphere through the site, km.
fn range_to_height_km(site_km: &Vector3<f64>, sight: &Vector3<f64>, height_km: f64) -> f64 {
    let (site, rise) = (site_km.norm(), site_km.dot(sight));
    let radius = site + height_km;
    -rise + (rise * rise + radius * radius - site * site).sqrt()
}

/// Returns the distance along a line of sight to the point at a height above the WGS84 ellipsoid, km, from Earth-fixed
/// position and direction.
///
/// The height as a function of the distance ρ is inverted by Newton's method, which starts from the solution for a
/// sphere. dh/dρ is the sine of the angle of the line of sight above the satellite's horizontal plane.
fn range_to_ellipsoidal_height_km(site_km: &Vector3<f64>, sight: &Vector3<f64>, height_km: f64) -> f64 {
    /// The solution for a sphere has an error of at most 30 km; each step squares the relative error.
    const STEPS: usize = 4;
    let mut range_km = range_to_height_km(site_km, sight, height_km);
    for _ in 0..STEPS {
        let satellite = Position::<Itrs>::from_vector(site_km + sight * range_km);
        let rise = satellite.vector().normalize().dot(sight);
        range_km += (height_km - ellipsoidal_height_km(&satellite)) / rise;
    }
    range_km
}

/// Element set nearest in time, kept between rows, since neighbouring rows mostly have the same one.
struct NearestOrbit {
    norad_id: NoradId,
    /// Interval, in minutes from the epoch of the element set, in which no other element set is nearer.
    nearest_min: [f64; 2],
    /// Propagator; `None` if SGP4 rejects the element set.
    propagator: Option<Propagator>,
}

impl NearestOrbit {
    fn new(history: &History, norad_id: NoradId, epoch: Epoch) -> Option<Self> {
        let nearest = history.nearest(norad_id, epoch)?;
        let sets = history.sets_of(norad_id);
        // The ends of the interval are half way to the adjacent element sets.
        let half_min = |other: Option<&ElementSet>, sign: f64| {
            other.map_or(sign * f64::INFINITY, |other| 0.5 * (other.epoch - nearest.epoch).to_unit(Unit::Minute))
        };
        let before = sets[..sets.partition_point(|set| set.epoch < nearest.epoch)].last();
        let after = sets.get(sets.partition_point(|set| set.epoch <= nearest.epoch));
        let nearest_min = [half_min(before, -1.0), half_min(after, 1.0)];
        Some(Self { norad_id, nearest_min, propagator: Propagator::new(nearest).ok() })
    }

    /// Returns true if no other element set of the satellite is nearer to this epoch.
    fn is_nearest(&self, norad_id: NoradId, epoch: Epoch) -> bool {
        let [from, to] = self.nearest_min;
        let minutes = self.propagator.as_ref().map(|propagator| propagator.minutes_since_epoch(epoch));
        self.norad_id == norad_id && minutes.is_some_and(|minutes| from < minutes && minutes < to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Site;

    /// A satellite's position at a known height is extrapolated from sites with its latitude and longitude.
    #[test]
    fn verif_ranges_reach_the_ellipsoidal_height() {
        // Pomenis's site, 2.79 km high.
        let observer = Site::new_deg("Pomenis", 32.4434, -110.7881, 2790.0).unwrap().itrs();
        for (latitude_deg, longitude_deg) in [(32.4434, -110.7881), (40.0, -105.0), (24.0, -118.0), (33.0, -130.0)] {
            // The tallest site allowed is 100 km high: continue along the ellipsoid's normal to 550 km.
            let [ground, high] = [0.0, 100_000.0]
                .map(|height_m| Site::new_deg("", latitude_deg, longitude_deg, height_m).unwrap().itrs());
            let satellite_km = ground.vector() + (high.vector() - ground.vector()) * 5.5;
            let line_km = satellite_km - observer.vector();
            let range_km = range_to_ellipsoidal_height_km(observer.vector(), &line_km.normalize(), 550.0);
            // Tolerance: 1 mm is far below the 1 km of the recorded heights.
            assert!((range_km - line_km.norm()).abs() < 1e-6, "{latitude_deg} {longitude_deg}: {range_km}");
        }
    }
}

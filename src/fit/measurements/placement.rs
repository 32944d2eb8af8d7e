//! Records put into their geometry: by element sets, or by what the rows themselves say.

use std::collections::HashMap;

use hifitime::{Duration, Epoch, Unit};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::constants::{AU_KM, EARTH_EQUATORIAL_RADIUS_KM};
use crate::elements::{ElementSet, History, NoradId};
use crate::frames::{Direction, EopTable, Gcrs, Horizontal, Itrs, Position, Rotation};
use crate::geometry::{Site, ViewingGeometry};
use crate::orbit::Propagator;

use super::dropped::DropReason;
use super::ephemeris::{Ephemeris, Moment};
use super::nearest_orbit::{Orbit, Orbits};
use super::offset::{Ranged, fitted_offset_s};
use super::record::{Record, RecordSource, Sighting};
use super::triangle;

/// No site is named in such a table: the observer stands on a sphere of the Earth's mean radius, km.
const MEAN_RADIUS_KM: f64 = 6371.0;

/// Where the satellite of a row is taken to be.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// Where its nearest element set has it: SGP4 at the row's time.
    Elements {
        /// Shift each track along its orbit until its ranges fit the recorded ones, by at most so many seconds either way (10 is usual);
        /// `None`: take the element set as it is. Tracks without ranges are not shifted.
        fit_offset_s: Option<f64>,
    },
    /// Where the row has it; of distance and phase alone, on an orbit of this radius.
    Recorded {
        /// `None`: rows with distance and phase have no geometry.
        radius: Option<OrbitRadius>,
    },
}

/// Distance from the Earth's centre to a satellite of which only distance and phase are recorded.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum OrbitRadius {
    /// A circle so many km above 6378.137 km. Wrong by the J2 short-period term, ±10 km in low orbits, which moves α by 13° at the 90th
    /// percentile.
    HeightKm(f64),
    /// As SGP4 has it at the row's time, short-period terms and all: a satellite late by a minute stands at nearly the right height.
    Elements,
}

/// How records are put into their geometry.
#[derive(Clone, Debug)]
pub struct Placement<'a> {
    /// By what.
    pub place: Place,
    /// Element sets of all satellites in question, over time.
    pub history: Option<&'a History>,
    /// Satellites of groups whose rows name none: what an [`association`](super::associate) found.
    pub identified: HashMap<String, NoradId>,
    /// An element set farther away in time is not used, days.
    pub max_element_age_days: f64,
    /// The Earth's orientation.
    pub eop: EopTable,
}

impl Placement<'_> {
    /// By what rows say, of distance and phase on circles of this height (km above 6378.137).
    pub fn recorded(height_km: Option<f64>) -> Placement<'static> {
        let place = Place::Recorded { radius: height_km.map(OrbitRadius::HeightKm) };
        Placement {
            place,
            history: None,
            identified: HashMap::new(),
            max_element_age_days: 14.0,
            eop: EopTable::embedded(),
        }
    }

    /// By element sets as they are, at most two weeks away.
    pub fn elements(history: &History) -> Placement<'_> {
        Placement {
            place: Place::Elements { fit_offset_s: None },
            history: Some(history),
            identified: HashMap::new(),
            max_element_age_days: 14.0,
            eop: EopTable::embedded(),
        }
    }

    /// Which satellite a record is of.
    pub(super) fn norad_of(&self, record: &Record, groups: &[String]) -> Option<NoradId> {
        record.norad_id.or_else(|| {
            // Almost always there are none, and a look-up by name for each row would be felt.
            if self.identified.is_empty() {
                None
            } else {
                self.identified.get(groups.get(record.group as usize)?).copied()
            }
        })
    }
}

/// A record in its geometry.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Placed {
    /// What brightness depends on.
    pub geometry: ViewingGeometry,
    /// Geocentric place of the satellite, and of the Sun; `None` where they are not known.
    pub satellite_and_sun: Option<(Position<Gcrs>, Position<Gcrs>)>,
    /// Above the horizon, radians; `None` where it cannot be told.
    pub altitude_rad: Option<f64>,
    /// Which satellite.
    pub norad_id: Option<NoradId>,
}

/// Puts records into their geometry, chunk by chunk; keeps what one chunk can leave to the next.
pub struct Placer<'a> {
    placement: &'a Placement<'a>,
    ephemeris: Ephemeris,
}

/// Minutes in a day.
const MINUTES_A_DAY: f64 = 1440.0;
/// Records that one thread does in a row.
const RUN: usize = 2048;

impl<'a> Placer<'a> {
    /// Makes ready.
    pub fn new(placement: &'a Placement<'a>) -> Self {
        Self { placement, ephemeris: Ephemeris::new(placement.eop.clone()) }
    }

    /// The geometry of each record, or why it has none: in the order given, in parallel.
    ///
    /// Where offsets are fitted, the rows of a track should be in one chunk; parts of it in different chunks are fitted apart.
    pub fn place(&mut self, source: &impl RecordSource, records: &[Record]) -> Vec<Result<Placed, DropReason>> {
        self.ephemeris.prepare(records.iter().filter_map(|record| record.epoch));
        let sites: Vec<Stand> = source.sites().iter().map(Stand::new).collect();
        let groups = source.groups();
        let one = Placing { placement: self.placement, ephemeris: &self.ephemeris, sites: &sites, groups };
        let offsets = one.offsets_s(records);
        let runs: Vec<Vec<_>> = records
            .par_chunks(RUN)
            .map(|run| {
                let mut orbits = Orbits::default();
                run.iter().map(|record| one.place(record, &mut orbits, &offsets)).collect()
            })
            .collect();
        runs.concat()
    }
}

/// A site with its axes.
pub(super) struct Stand {
    place: Position<Itrs>,
    horizon: Rotation<Itrs, Horizontal>,
}

impl Stand {
    pub(super) fn new(site: &Site) -> Self {
        Self { place: site.itrs(), horizon: site.horizon() }
    }

    /// Among the stars: place, and the direction of the zenith.
    pub(super) fn at(&self, moment: &Moment) -> (Position<Gcrs>, Vector3<f64>) {
        let to_gcrs = &moment.orientation.itrs_to_gcrs;
        let zenith = self.horizon.matrix().row(2).transpose();
        (*to_gcrs * self.place, to_gcrs.matrix() * zenith)
    }
}

/// One chunk.
struct Placing<'a> {
    placement: &'a Placement<'a>,
    ephemeris: &'a Ephemeris,
    sites: &'a [Stand],
    groups: &'a [String],
}

impl<'a> Placing<'a> {
    fn place(&self, record: &Record, orbits: &mut Orbits, offsets_s: &HashMap<u32, f64>) -> Result<Placed, DropReason> {
        let norad_id = self.placement.norad_of(record, self.groups);
        let placed = match self.placement.place {
            Place::Elements { .. } => {
                let offset_s = offsets_s.get(&record.group).copied().unwrap_or(0.0);
                let (moment, stand) = self.moment_and_stand(record).ok_or(DropReason::NoGeometry)?;
                let satellite = self.satellite(record, norad_id, offset_s, &moment, orbits)?;
                seen(&satellite, &moment, stand)
            }
            Place::Recorded { radius } => match record.sighting {
                Sighting::Horizontal { altitude_rad, azimuth_rad, height_km } => {
                    self.moment_and_stand(record).and_then(|(moment, stand)| {
                        let sight = Direction::<Horizontal>::from_lon_lat_rad(azimuth_rad, altitude_rad);
                        let sight = stand.horizon.inverse() * sight;
                        let range_km = range_to_height_km(stand.place.vector(), sight.vector(), height_km);
                        let satellite = moment.orientation.itrs_to_gcrs * (stand.place + sight.at_range(range_km));
                        seen(&satellite, &moment, stand)
                    })
                }
                Sighting::Equatorial { right_ascension_rad, declination_rad, range_km } => {
                    self.moment_and_stand(record).and_then(|(moment, stand)| {
                        let sight = Direction::<Gcrs>::from_lon_lat_rad(right_ascension_rad, declination_rad);
                        let (observer, _) = stand.at(&moment);
                        seen(&(observer + sight.at_range(range_km)), &moment, stand)
                    })
                }
                Sighting::SunRelative { sun_altitude_rad, altitude_rad, azimuth_from_sun_rad, height_km } => {
                    sun_relative(sun_altitude_rad, altitude_rad, azimuth_from_sun_rad, height_km)
                }
                Sighting::Distance { range_km, phase_rad } => {
                    let (Some(phase_rad), Some(radius)) = (phase_rad, radius) else {
                        return Err(DropReason::NoGeometry);
                    };
                    let (moment, stand) = self.moment_and_stand(record).ok_or(DropReason::NoGeometry)?;
                    let radius_km = match radius {
                        OrbitRadius::HeightKm(height_km) => EARTH_EQUATORIAL_RADIUS_KM + height_km,
                        OrbitRadius::Elements => self.satellite(record, norad_id, 0.0, &moment, orbits)?.norm_km(),
                    };
                    let (telescope, _) = stand.at(&moment);
                    let along_km = telescope.vector().dot(&moment.sun.vector().normalize());
                    let sun_distance_au = moment.sun.norm_km() / AU_KM;
                    triangle::geometry(radius_km, range_km, phase_rad, telescope.norm_km(), along_km).map(|geometry| {
                        // The triangle's angles tell nothing of how far the Sun is that day.
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

    fn moment_and_stand(&self, record: &Record) -> Option<(Moment, &'a Stand)> {
        Some((self.ephemeris.at(record.epoch?)?, self.sites.get(record.site? as usize)?))
    }

    /// Geocentric place by the nearest element set, `offset_s` later than the record.
    fn satellite(
        &self,
        record: &Record,
        norad_id: Option<NoradId>,
        offset_s: f64,
        moment: &Moment,
        orbits: &mut Orbits,
    ) -> Result<Position<Gcrs>, DropReason> {
        let (Some(history), Some(norad_id), Some(epoch)) = (self.placement.history, norad_id, record.epoch) else {
            return Err(DropReason::NoElements);
        };
        if !orbits.last.as_ref().is_some_and(|orbit| orbit.serves(norad_id, epoch)) {
            orbits.last = Orbit::nearest(history, norad_id, epoch);
        }
        let orbit = orbits.last.as_ref().ok_or(DropReason::NoElements)?;
        let propagator = orbit.propagator.as_ref().ok_or(DropReason::NoPosition)?;
        let minutes = propagator.minutes_since_epoch(epoch);
        if minutes.abs() > self.placement.max_element_age_days * MINUTES_A_DAY {
            return Err(DropReason::StaleElements);
        }
        let minutes = minutes + offset_s / 60.0;
        let state = propagator.state_at_minutes(minutes, &moment.orientation.teme_to_gcrs);
        state.map(|state| state.position).map_err(|_| DropReason::NoPosition)
    }

    /// How late each group of a chunk is, where that is asked for and can be told.
    fn offsets_s(&self, records: &[Record]) -> HashMap<u32, f64> {
        let (Place::Elements { fit_offset_s: Some(limit_s) }, Some(history)) =
            (&self.placement.place, self.placement.history)
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
            let ranged: Vec<Ranged> =
                Ranged::thinned(&track).filter_map(|record| Ranged::of(record, self.ephemeris, self.sites)).collect();
            Some((group, fitted_offset_s(&propagator, &ranged, *limit_s)?.offset_s))
        });
        fitted.collect()
    }
}

/// Days from an element set to a moment.
pub(super) fn age_days(set: &ElementSet, epoch: Epoch) -> f64 {
    let age: Duration = epoch - set.epoch;
    age.to_unit(Unit::Day)
}

/// The geometry of a satellite at a known place.
pub(super) fn seen(satellite: &Position<Gcrs>, moment: &Moment, stand: &Stand) -> Option<Placed> {
    let (observer, zenith) = stand.at(moment);
    let geometry = ViewingGeometry::new(satellite, &observer, &moment.sun)?;
    let sine = zenith.dot(&(satellite.vector() - observer.vector())) / geometry.range_km;
    let altitude_rad = Some(sine.clamp(-1.0, 1.0).asin());
    Some(Placed { geometry, satellite_and_sun: Some((*satellite, moment.sun)), altitude_rad, norad_id: None })
}

/// Observer on a sphere, up is x; azimuths count from the Sun's.
fn sun_relative(sun_altitude: f64, altitude_rad: f64, azimuth: f64, height_km: f64) -> Option<Placed> {
    let site = Vector3::new(MEAN_RADIUS_KM, 0.0, 0.0);
    let towards = |altitude: f64, azimuth: f64| {
        Vector3::new(altitude.sin(), altitude.cos() * azimuth.cos(), altitude.cos() * azimuth.sin())
    };
    let sight = towards(altitude_rad, azimuth);
    let range_km = range_to_height_km(&site, &sight, height_km);
    let places = [site + sight * range_km, site, towards(sun_altitude, 0.0) * AU_KM];
    let [satellite, observer, sun] = places.map(Position::<Gcrs>::from_vector);
    let geometry = ViewingGeometry::new(&satellite, &observer, &sun)?;
    Some(Placed { geometry, satellite_and_sun: None, altitude_rad: Some(altitude_rad), norad_id: None })
}

/// How far along a line of sight a satellite of this height (above a sphere about the geocentre through the site) is, km.
fn range_to_height_km(site_km: &Vector3<f64>, sight: &Vector3<f64>, height_km: f64) -> f64 {
    let (site, rise) = (site_km.norm(), site_km.dot(sight));
    let radius = site + height_km;
    -rise + (rise * rise + radius * radius - site * site).sqrt()
}

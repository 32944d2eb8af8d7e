//! How bright the ground is: the same everywhere, or by land, ocean, ice and cloud.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;

/// Albedo of the paper's Earth (Lu 2024, section 2.4).
pub const PAPER_ALBEDO: f64 = 0.3;

const LATITUDES: usize = 18;
const LONGITUDES: usize = 36;
const CELL_RAD: f64 = PI / LATITUDES as f64;

/// Land and lasting ice in cells of 10°, from the south pole and 180° W; made by `tests/reference/make_albedo.py`.
const LAND: &str = include_str!("land_10deg.csv");

/// Albedo of the ground, clouds included, as a satellite sees it.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Albedo<'a> {
    /// The same everywhere, 0 to 1; the paper takes 0.3.
    Uniform(f64),
    /// By place, for a satellite above this one.
    Map(&'a AlbedoMap, EarthBelow),
}

/// Where a satellite stands above the ground, and how its body frame is turned there: what a map of the Earth needs and
/// brightness otherwise does not.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct EarthBelow {
    /// Geocentric latitude of the point below, radians.
    pub latitude_rad: f64,
    /// Its longitude, east positive, radians.
    pub longitude_rad: f64,
    /// Azimuth of the Sun there, from north through east, radians: the body frame's x.
    pub sun_azimuth_rad: f64,
}

/// Albedos of what the ground is made of, seen from above the air, and how much of it clouds cover.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SurfaceAlbedos {
    /// Open ocean.
    pub ocean: f64,
    /// Land without lasting ice.
    pub land: f64,
    /// Lasting ice on land: Antarctica and Greenland.
    pub ice: f64,
    /// Cloud tops.
    pub cloud: f64,
    /// Share of the ocean under clouds.
    pub cloud_over_ocean: f64,
    /// Share of land and ice under clouds.
    pub cloud_over_land: f64,
}

impl SurfaceAlbedos {
    /// A mean year with a mean albedo of 0.30, as the paper's uniform Earth.
    ///
    /// Clouds cover 72 % of the ocean and 55 % of the land (MODIS, nine to twelve years: King et al. 2013, IEEE TGRS 51,
    /// 3826). Ocean and land are what the Earth shows above its air under a clear sky, a least-squares fit to the CERES clear-sky
    /// albedos of 2018 within 60° of the equator by these shares of land, ice from the same fit over all latitudes, rounded to
    /// 0.01 (the fit of the first two leaves 0.034 rms). The clouds' albedo is what makes the mean 0.30; CERES' own mean of that
    /// year, weighted by sunlight, is 0.293. Sea ice, seasons, the zones of cloudiness, and the glint of the sea are not in it:
    /// by land and ocean alone the clouds' belts stay 0.08 rms away from CERES.
    pub const MEAN_YEAR: Self =
        Self { ocean: 0.11, land: 0.21, ice: 0.75, cloud: 0.3634, cloud_over_ocean: 0.72, cloud_over_land: 0.55 };

    /// The same ground without a cloud.
    pub const CLOUD_FREE: Self = Self { cloud_over_ocean: 0.0, cloud_over_land: 0.0, ..Self::MEAN_YEAR };

    /// Of a cell with these shares of land and ice (ice is part of the land).
    fn mixed(&self, land: f64, ice: f64) -> f64 {
        let under = |cover: f64, clear: f64| cover * self.cloud + (1.0 - cover) * clear;
        (1.0 - land) * under(self.cloud_over_ocean, self.ocean)
            + (land - ice) * under(self.cloud_over_land, self.land)
            + ice * under(self.cloud_over_land, self.ice)
    }
}

/// Albedo in cells of 10°, interpolated between their centres.
#[derive(Clone, Debug, PartialEq)]
pub struct AlbedoMap {
    cells: Vec<f64>,
}

impl AlbedoMap {
    /// From albedos of the kinds of ground.
    pub fn of_surfaces(surfaces: &SurfaceAlbedos) -> Self {
        let cells = LAND
            .lines()
            .filter(|line| !line.starts_with(['#', 'l']))
            .map(|line| {
                let mut shares = line.split(',').skip(2).map(|share| share.parse().unwrap_or(0.0));
                let (land, ice) = (shares.next().unwrap_or(0.0), shares.next().unwrap_or(0.0));
                surfaces.mixed(land, ice)
            })
            .collect();
        Self { cells }
    }

    /// From 18 x 36 albedos (latitude, longitude), cells of 10° from the south pole up and from 180° W eastwards.
    ///
    /// `None` where their number is another, or one is not within 0 to 1.
    pub fn from_cells(cells: Vec<f64>) -> Option<Self> {
        let sound = cells.len() == LATITUDES * LONGITUDES && cells.iter().all(|a| (0.0..=1.0).contains(a));
        sound.then_some(Self { cells })
    }

    /// At a place; longitudes may be any, east positive.
    pub fn at(&self, latitude_rad: f64, longitude_rad: f64) -> f64 {
        let row = ((latitude_rad + FRAC_PI_2) / CELL_RAD - 0.5).clamp(0.0, (LATITUDES - 1) as f64);
        let column = ((longitude_rad + PI) / CELL_RAD - 0.5).rem_euclid(LONGITUDES as f64);
        let (south, west) = ((row as usize).min(LATITUDES - 2), column as usize % LONGITUDES);
        let (up, along) = (row - south as f64, (column - west as f64).clamp(0.0, 1.0));
        let cell = |row: usize, column: usize| self.cells[row * LONGITUDES + column % LONGITUDES];
        let across = |row: usize| (1.0 - along) * cell(row, west) + along * cell(row, west + 1);
        (1.0 - up) * across(south) + up * across(south + 1)
    }

    /// Mean over the sphere, each cell by its area.
    pub fn mean(&self) -> f64 {
        let edge = |row: usize| (row as f64 * CELL_RAD - FRAC_PI_2).sin();
        let of_row = |row: usize| {
            let mean = self.cells[row * LONGITUDES..][..LONGITUDES].iter().sum::<f64>() / LONGITUDES as f64;
            0.5 * (edge(row + 1) - edge(row)) * mean
        };
        (0..LATITUDES).map(of_row).sum()
    }
}

impl Albedo<'_> {
    /// At a point of the ground, given as a unit vector from the Earth's centre in body axes.
    pub(super) fn at(&self, ground: &Vector3<f64>) -> f64 {
        match self {
            Self::Uniform(albedo) => *albedo,
            Self::Map(map, below) => {
                let place = below.to_earth(ground);
                map.at(place.z.clamp(-1.0, 1.0).asin(), place.y.atan2(place.x))
            }
        }
    }
}

impl EarthBelow {
    /// From body axes to axes that turn with the Earth (x to longitude 0, z to the north pole).
    fn to_earth(self, body: &Vector3<f64>) -> Vector3<f64> {
        let (sin_lat, cos_lat) = self.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = self.longitude_rad.sin_cos();
        let up = Vector3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
        let north = Vector3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
        let east = Vector3::new(-sin_lon, cos_lon, 0.0);
        let (sin, cos) = self.sun_azimuth_rad.sin_cos();
        // x towards the Sun's azimuth, y = z × x: a quarter turn towards smaller azimuths.
        let (x, y) = (north * cos + east * sin, north * sin - east * cos);
        x * body.x + y * body.y + up * body.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(latitude: f64, longitude: f64) -> (f64, f64) {
        (latitude.to_radians(), longitude.to_radians())
    }

    #[test]
    fn verif_the_mean_year_has_the_papers_albedo_and_its_continents() {
        let map = AlbedoMap::of_surfaces(&SurfaceAlbedos::MEAN_YEAR);
        assert!((map.mean() - PAPER_ALBEDO).abs() < 5e-4, "{}", map.mean());
        let clear = AlbedoMap::of_surfaces(&SurfaceAlbedos::CLOUD_FREE);
        let at = |map: &AlbedoMap, place: (f64, f64)| map.at(place.0, place.1);
        assert!((at(&clear, degrees(-15.0, -125.0)) - 0.11).abs() < 1e-3, "the Pacific");
        assert!((at(&clear, degrees(25.0, 5.0)) - 0.21).abs() < 1e-3, "the Sahara");
        assert!((at(&clear, degrees(-85.0, 60.0)) - 0.75).abs() < 1e-3, "Antarctica");
        // Over the date line nothing jumps.
        let jump = at(&clear, degrees(65.0, 179.999)) - at(&clear, degrees(65.0, -179.999));
        assert!(jump.abs() < 1e-4);
    }

    #[test]
    fn verif_body_axes_stand_on_the_earth() {
        // Above 30° E on the equator with the Sun in the east: x is east, y is north.
        let (latitude_rad, longitude_rad) = degrees(0.0, 30.0);
        let below = EarthBelow { latitude_rad, longitude_rad, sun_azimuth_rad: FRAC_PI_2 };
        let place = |body: Vector3<f64>| {
            let earth = below.to_earth(&body);
            (earth.z.asin().to_degrees(), earth.y.atan2(earth.x).to_degrees())
        };
        let tilted = |x: f64, y: f64| Vector3::new(x, y, (1.0 - x * x - y * y).sqrt());
        let ten = 10_f64.to_radians().sin();
        for (body, latitude, longitude) in
            [(Vector3::z(), 0.0, 30.0), (tilted(ten, 0.0), 0.0, 40.0), (tilted(0.0, ten), 10.0, 30.0)]
        {
            let (lat, lon) = place(body);
            assert!((lat - latitude).abs() < 1e-9 && (lon - longitude).abs() < 1e-9, "{lat} {lon}");
        }
    }

    #[test]
    fn verif_cells_are_checked() {
        assert!(AlbedoMap::from_cells(vec![0.3; 648]).is_some());
        assert!(AlbedoMap::from_cells(vec![0.3; 647]).is_none());
        assert!(AlbedoMap::from_cells(vec![1.2; 648]).is_none());
        assert!((AlbedoMap::from_cells(vec![0.25; 648]).unwrap().mean() - 0.25).abs() < 1e-12);
    }
}

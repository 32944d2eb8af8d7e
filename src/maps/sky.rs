//! Apparent magnitude over the sky of a site, for satellites at one height and one position of the Sun.
//!
//! ```text
//!            satellite ·---- ρ = -b + √(b² + r² - q²)          q  observer's distance from the Earth's centre
//!                     /                                        r  6378.137 km + height
//!           observer /                                         b  = q · d, the observer along the direction d
//!      ─────────────·───────────  horizon
//!                   |  q
//!                   |
//!            Earth's centre
//! ```
//!
//! A line of sight above the horizon meets the sphere of the satellites in one point. Without a site, the Earth is a
//! sphere of 6378.137 km, and the observer is on its surface. With a site, the Earth is the WGS84 ellipsoid, and
//! altitudes are measured from the plane perpendicular to the ellipsoid's normal. The shadow is that of the same sphere
//! or ellipsoid. Altitudes are geometric, without refraction. [`SkyView::with_shadow`] selects the model of the
//! sunlight that grazes the Earth.

use nalgebra::{Matrix3, Vector3};

use super::error;
use crate::constants::{AU_KM, EARTH_EQUATORIAL_RADIUS_KM};
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, Gcrs, Horizontal, Position, itrs_to_horizontal};
use crate::geometry::{ShadowModel, Site, ViewingGeometry};
use crate::photometry::{BrightnessModel, Magnitude, PhotometryOptions, SatellitePositions, StandardMagnitude};
use crate::watch::Watch;

use super::error::{height, latitude};
use super::grid::{Grid, GridRow, fill};
use super::light::{Fact, FactValue, MapPhotometry, rounded};

/// Shape of the Earth for a map of the sky.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Earth {
    /// Sphere of radius 6378.137 km with the observer on its surface, as in Lu (2024).
    Sphere,
    /// WGS84 ellipsoid with the observer at this site.
    Ellipsoid(Site),
}

/// Brightness of satellites at one height, in any direction of the sky of a site.
///
/// Azimuths are measured from north through east, altitudes from the horizon. The Sun is at 1 au.
#[derive(Clone, Debug)]
pub struct SkyView<'a> {
    light: MapPhotometry<'a>,
    earth: Earth,
    shadow: ShadowModel,
    /// Rotation from north, east and zenith to the Earth-fixed axes.
    pub(super) axes: Matrix3<f64>,
    pub(super) observer: Position<Gcrs>,
    pub(super) sun: Position<Gcrs>,
    pub(super) radius_km: f64,
    per_radius_km: f64,
    /// The difference q² - r² of the drawing in the module documentation, km²; it is negative.
    below_km2: f64,
    sun_azimuth_rad: f64,
    sun_altitude_rad: f64,
    watch: Watch,
}

/// One direction of a [`SkyMap`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SkyPoint {
    /// Azimuth from north through east, [0, 2π), radians.
    pub azimuth_rad: f64,
    /// Altitude above the horizon, [0, π/2], radians.
    pub altitude_rad: f64,
    /// Distance from observer to satellite, km.
    pub range_km: f64,
    /// Fraction of the Sun's light that reaches the satellite, [0, 1]; 0 in the umbra.
    pub lit_fraction: f64,
    /// Apparent magnitude; `None` in the umbra, if no lit surface is visible, and on the horizon if extinction is
    /// applied.
    pub magnitude: Option<Magnitude>,
}

/// Apparent magnitudes over the sky of a site.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SkyMap {
    /// Grid of the directions.
    pub grid: Grid,
    /// Metadata of the map: model, options and geometry.
    #[doc(hidden)]
    pub facts: Vec<Fact>,
    /// Values in the order of the grid. Regular grids begin on the horizon.
    pub points: Vec<SkyPoint>,
}

impl<'a> SkyView<'a> {
    /// Creates a view of satellites `height_km` above 6378.137 km, with the Sun at a geometric azimuth and altitude in
    /// radians.
    ///
    /// # Errors
    /// The Sun's altitude is beyond ±90° or its azimuth beyond ±360°, or the height is not between 0 and 100,000 km or
    /// is below the site.
    pub fn new(
        model: &'a BrightnessModel,
        earth: Earth,
        height_km: f64,
        sun_azimuth_rad: f64,
        sun_altitude_rad: f64,
        options: PhotometryOptions,
    ) -> Result<Self, Error> {
        let sun_altitude_rad = latitude("Sun's altitude", sun_altitude_rad)?;
        let azimuth_deg = sun_azimuth_rad.to_degrees();
        let is_angle = azimuth_deg.abs() <= 360.0 + 1e-9;
        error::in_range("Sun's azimuth", azimuth_deg, " deg", "-360 to 360 deg", is_angle)?;
        let radius_km = EARTH_EQUATORIAL_RADIUS_KM + height(height_km)?;
        // The rotation of the Earth does not matter here, so that Earth-fixed axes serve as celestial axes.
        let (horizon, observer) = match &earth {
            Earth::Sphere => (itrs_to_horizontal(0.0, 0.0), Vector3::new(EARTH_EQUATORIAL_RADIUS_KM, 0.0, 0.0)),
            Earth::Ellipsoid(site) => {
                let observer = *site.itrs().vector();
                if observer.norm() >= radius_km {
                    let site_km = observer.norm() - EARTH_EQUATORIAL_RADIUS_KM;
                    return Err(Error::new(
                        ErrorKind::Invalid,
                        format!("satellite height is {height_km} km, below site {}", site.name),
                    )
                    .allowing(format!("above {site_km:.1} km (over the sphere of 6378.137 km)")));
                }
                (site.horizon(), observer)
            }
        };
        let axes = horizon.inverse().matrix().to_owned();
        let sun = axes * Direction::<Horizontal>::from_lon_lat_rad(sun_azimuth_rad, sun_altitude_rad).vector() * AU_KM;
        Ok(Self {
            light: MapPhotometry::new(model, options),
            earth,
            shadow: ShadowModel::default(),
            axes,
            observer: Position::from_vector(observer),
            sun: Position::from_vector(sun),
            radius_km,
            per_radius_km: 1.0 / radius_km,
            below_km2: observer.norm_squared() - radius_km * radius_km,
            sun_azimuth_rad,
            sun_altitude_rad,
            watch: Watch::default(),
        })
    }

    /// Sets the model of the Earth's shadow, with the atmosphere by default.
    pub fn with_shadow(self, shadow: ShadowModel) -> Self {
        Self { shadow, ..self }
    }

    /// Returns the view whose maps stop after [`Watch::stop`].
    pub fn watched(self, watch: &Watch) -> Self {
        Self { watch: watch.clone(), ..self }
    }

    /// Returns the shape of the Earth.
    pub fn earth(&self) -> &Earth {
        &self.earth
    }

    /// Returns the azimuth of the Sun, radians.
    pub fn sun_azimuth_rad(&self) -> f64 {
        self.sun_azimuth_rad
    }

    /// Returns the altitude of the Sun, radians.
    pub fn sun_altitude_rad(&self) -> f64 {
        self.sun_altitude_rad
    }

    /// Returns the extinction, mag per airmass; `None` if magnitudes are without extinction.
    pub fn extinction_mag_per_airmass(&self) -> Option<f64> {
        self.light.extinction()
    }

    /// Returns the height of the satellites above 6378.137 km, in km.
    pub fn height_km(&self) -> f64 {
        self.radius_km - EARTH_EQUATORIAL_RADIUS_KM
    }

    /// Computes the brightness in one direction, given in radians. For a direction below the horizon, the satellite is
    /// where the line of sight meets the sphere of the satellites on the other side of the Earth.
    pub fn at(&self, azimuth_rad: f64, altitude_rad: f64) -> SkyPoint {
        self.point(&self.row(altitude_rad), azimuth_rad)
    }

    /// Returns the metadata of the view: model, options and geometry.
    #[doc(hidden)]
    pub fn facts(&self) -> Vec<Fact> {
        let degrees = |angle: f64| FactValue::Real(rounded(angle.to_degrees()));
        let earth = match &self.earth {
            Earth::Sphere => "sphere of 6378.137 km".to_owned(),
            Earth::Ellipsoid(_) => "WGS84 ellipsoid".to_owned(),
        };
        let mut facts = vec![
            Fact::new("frame", "COORDSYS", FactValue::text("HORIZON"), "longitude azimuth (N to E), latitude altitude"),
            Fact::new("sun_altitude_deg", "SUNALT", degrees(self.sun_altitude_rad), "[deg] Sun above the horizon"),
            Fact::new("sun_azimuth_deg", "SUNAZ", degrees(self.sun_azimuth_rad), "[deg] Sun from north through east"),
            Fact::new(
                "height_km",
                "HEIGHT",
                FactValue::Real(rounded(self.height_km())),
                "[km] satellites above 6378.137 km",
            ),
            Fact::new("earth", "EARTH", FactValue::Text(earth), "figure of the Earth and its shadow"),
            Fact::new("shadow", "SHADOW", FactValue::text(self.shadow.name()), "model of the Earth's shadow"),
        ];
        if let Earth::Ellipsoid(site) = &self.earth {
            let number = |value: f64| FactValue::Real(rounded(value));
            facts.extend([
                Fact::new("site", "SITE", FactValue::Text(site.name.clone()), "observer"),
                Fact::new("latitude_deg", "SITELAT", degrees(site.latitude_rad), "[deg] geodetic"),
                Fact::new("longitude_deg", "SITELONG", degrees(site.longitude_rad), "[deg] east"),
                Fact::new("site_height_m", "SITEELEV", number(site.height_m), "[m] above the ellipsoid"),
            ]);
        }
        facts.extend(self.light.facts());
        if let Some(k) = self.extinction_mag_per_airmass() {
            facts.push(Fact::new("extinction_mag_per_airmass", "EXTINCT", FactValue::Real(k), "[mag] per airmass"));
        }
        facts
    }

    /// Computes the brightness for all directions of a grid at or above the horizon, on all threads of the current
    /// pool.
    ///
    /// # Errors
    /// [`Cancelled`](crate::ErrorKind::Cancelled) after [`Watch::stop`].
    pub fn map(&self, grid: Grid) -> Result<SkyMap, Error> {
        let blank = SkyPoint { azimuth_rad: 0.0, altitude_rad: 0.0, range_km: 0.0, lit_fraction: 0.0, magnitude: None };
        let fill_row = |grid_row: &GridRow, points: &mut [SkyPoint]| {
            let row = self.row(grid_row.latitude_rad);
            if !self.light.is_single() {
                return self.fill_by_columns(&row, grid_row, points);
            }
            for (point, azimuth_rad) in points.iter_mut().zip(grid_row.longitudes_rad()) {
                *point = self.point(&row, azimuth_rad);
            }
        };
        let points = fill(grid.northern(), blank, fill_row, &self.watch)?;
        Ok(SkyMap { grid, facts: self.facts(), points })
    }

    /// Computes the quantities that are the same at all azimuths of one altitude.
    fn row(&self, altitude_rad: f64) -> AltitudeRow {
        let (sin, cos) = altitude_rad.sin_cos();
        // On a sphere the range depends only on the altitude.
        let range_and_dimming = (self.earth == Earth::Sphere).then(|| {
            let range_km = self.range_km(EARTH_EQUATORIAL_RADIUS_KM * sin);
            (range_km, self.light.dimming(range_km, altitude_rad))
        });
        let axis = |index: usize| self.axes.column(index).into_owned();
        AltitudeRow { altitude_rad, up: axis(2) * sin, north: axis(0) * cos, east: axis(1) * cos, range_and_dimming }
    }

    /// Computes all directions of one altitude together; the values agree within 1e-9 mag with those of
    /// [`at`](Self::at).
    fn fill_by_columns(&self, row: &AltitudeRow, grid_row: &GridRow, points: &mut [SkyPoint]) {
        let mut columns = [const { Vec::new() }; 3];
        columns.iter_mut().for_each(|column: &mut Vec<f64>| column.reserve(points.len()));
        let azimuths = grid_row.longitudes_rad().zip(grid_row.sines_and_cosines());
        for (point, (azimuth_rad, sine_and_cosine)) in points.iter_mut().zip(azimuths) {
            let (direction, range_km, dimming) = self.sight(row, sine_and_cosine);
            let satellite = self.observer.vector() + direction * range_km;
            columns.iter_mut().zip(satellite.iter()).for_each(|(column, coordinate)| column.push(*coordinate));
            let lit_fraction = self.lit_fraction(&satellite);
            *point =
                SkyPoint { azimuth_rad, altitude_rad: row.altitude_rad, range_km, lit_fraction, magnitude: dimming };
        }
        let positions = SatellitePositions {
            x_km: &columns[0],
            y_km: &columns[1],
            z_km: &columns[2],
            observer_km: (*self.observer.vector()).into(),
            sun_km: (*self.sun.vector()).into(),
        };
        let mut standard = vec![0.0; points.len()];
        self.light.sunlight_at(&positions, &mut standard);
        for (point, standard) in points.iter_mut().zip(standard) {
            let shaded = self.light.shaded(StandardMagnitude(standard), point.lit_fraction);
            point.magnitude = match (point.magnitude, shaded) {
                (Some(dimming), Some(standard)) => Some(dimming.dimmed_by(standard.0)),
                _ => None,
            };
        }
    }

    /// Returns the unit vector of a direction (given by sine and cosine of its azimuth), the range of the satellite,
    /// and the change of its magnitude by distance and extinction.
    fn sight(&self, row: &AltitudeRow, (east, north): (f64, f64)) -> (Vector3<f64>, f64, Option<Magnitude>) {
        let direction = row.up + row.north * north + row.east * east;
        let (range_km, dimming) = row.range_and_dimming.unwrap_or_else(|| {
            let range_km = self.range_km(self.observer.vector().dot(&direction));
            (range_km, self.light.dimming(range_km, row.altitude_rad))
        });
        (direction, range_km, dimming)
    }

    fn point(&self, row: &AltitudeRow, azimuth_rad: f64) -> SkyPoint {
        let (direction, range_km, dimming) = self.sight(row, azimuth_rad.sin_cos());
        let satellite = self.observer.vector() + direction * range_km;
        let lit_fraction = self.lit_fraction(&satellite);
        let magnitude = dimming.filter(|_| lit_fraction > 0.0 || self.light.shines_in_shadow()).and_then(|dimming| {
            let geometry = ViewingGeometry::new(&Position::from_vector(satellite), &self.observer, &self.sun)?;
            let standard = self.light.standard_magnitude(&geometry, lit_fraction)?;
            Some(dimming.dimmed_by(standard.0))
        });
        SkyPoint { azimuth_rad, altitude_rad: row.altitude_rad, range_km, lit_fraction, magnitude }
    }

    /// Returns the range of the satellites in a direction. `along_km` is the component of the observer's position along
    /// this direction (b in the module documentation).
    fn range_km(&self, along_km: f64) -> f64 {
        // ρ = -b + √(b² - c), with c = q² - r² < 0. For b > 0 it is rewritten to avoid cancellation.
        let root = (along_km * along_km - self.below_km2).sqrt();
        if along_km > 0.0 { -self.below_km2 / (along_km + root) } else { root - along_km }
    }

    pub(super) fn lit_fraction(&self, satellite: &Vector3<f64>) -> f64 {
        match self.earth {
            Earth::Ellipsoid(_) => {
                self.shadow.illumination(&Position::from_vector(*satellite), &self.sun).lit_fraction()
            }
            Earth::Sphere => {
                let towards_sun = satellite.dot(self.sun.vector());
                if towards_sun >= 0.0 {
                    return 1.0;
                }
                let cos = (towards_sun * (self.per_radius_km / AU_KM)).max(-1.0);
                let sin = (1.0 - cos * cos).sqrt();
                // On a sphere only the angle to the Sun matters, so the position is moved to the plane of the equator,
                // where the ellipsoid is a circle.
                let turned = || {
                    let position = Position::new(self.radius_km * cos, self.radius_km * sin, 0.0);
                    self.shadow.illumination(&position, &Position::new(AU_KM, 0.0, 0.0)).lit_fraction()
                };
                // Distance from the axis of the shadow, compared with the Earth's radius minus or plus the Sun's
                // angular radius (0.0047 rad) times the distance behind the Earth.
                let (across_km, slope_km) = (self.radius_km * sin, -0.005 * self.radius_km * cos);
                if self.shadow == ShadowModel::Geometric && across_km > EARTH_EQUATORIAL_RADIUS_KM * 1.0002 + slope_km {
                    return 1.0;
                }
                // The geometric umbra is dark with either model.
                if across_km < EARTH_EQUATORIAL_RADIUS_KM * 0.9998 - slope_km {
                    return 0.0;
                }
                turned()
            }
        }
    }
}

/// Quantities that all directions of one altitude have in common.
#[derive(Copy, Clone, Debug)]
struct AltitudeRow {
    altitude_rad: f64,
    /// The direction at an azimuth is up + north cos(azimuth) + east sin(azimuth).
    up: Vector3<f64>,
    north: Vector3<f64>,
    east: Vector3<f64>,
    /// Range, and change of magnitude by distance and extinction, if they are the same for all azimuths.
    range_and_dimming: Option<(f64, Option<Magnitude>)>,
}

//! Standard magnitudes of a satellite (at a range of 1000 km) for all directions below its chassis.

use crate::error::Error;
use crate::geometry::ViewingGeometry;
use crate::photometry::{BodyAngles, BrightnessModel, PhotometryOptions, StandardMagnitude};
use crate::watch::Watch;

use super::error::{height, latitude};
use super::grid::{Grid, GridRow, fill};
use super::light::{Fact, FactValue, MapPhotometry, STANDARD_RANGE_KM, rounded};

/// Brightness of a satellite in full sunlight in any direction, as in figure 6 of Lu (2024).
///
/// A direction is given by its longitude from the Sun's azimuth, right-handed about the satellite's zenith (0 to 2π),
/// and its latitude above the plane of the chassis (-π/2 straight below). The Sun is at 1 au and there is no
/// extinction. Directions that do not meet the ground are included. The height of the satellite affects only the
/// earthshine.
#[derive(Clone, Debug)]
pub struct BodyView<'a> {
    light: MapPhotometry<'a>,
    sun_latitude_rad: f64,
    height_km: f64,
    watch: Watch,
}

/// One direction of a [`BodyMap`].
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyPoint {
    /// Longitude from the Sun's azimuth, [0, 2π), radians.
    pub observer_longitude_rad: f64,
    /// Latitude above the plane of the chassis, [-π/2, 0], radians.
    pub observer_latitude_rad: f64,
    /// Magnitude at a range of 1000 km; `None` if no lit surface is visible from this direction.
    pub standard_magnitude: Option<StandardMagnitude>,
}

/// Standard magnitudes over the hemisphere below a satellite.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyMap {
    /// Grid of the directions.
    pub grid: Grid,
    /// Metadata of the map: model, options and geometry.
    #[doc(hidden)]
    pub facts: Vec<Fact>,
    /// Values in the order of the grid. Regular grids begin with the direction straight below.
    pub points: Vec<BodyPoint>,
}

impl<'a> BodyView<'a> {
    /// Creates a view with the Sun at `sun_latitude_rad` above the plane of the chassis and the satellite at
    /// `height_km` above the equatorial radius of the Earth, 6378.137 km.
    ///
    /// The Sun's distance and the extinction in `options` are ignored, because standard magnitudes include neither.
    ///
    /// # Errors
    /// An error if the latitude is outside ±90°, or the height is not between 0 km (excluded) and 100,000 km.
    pub fn new(
        model: &'a BrightnessModel,
        sun_latitude_rad: f64,
        height_km: f64,
        options: PhotometryOptions,
    ) -> Result<Self, Error> {
        let sun_latitude_rad = latitude("Sun's latitude", sun_latitude_rad)?;
        Ok(Self {
            light: MapPhotometry::new(model, options),
            sun_latitude_rad,
            height_km: height(height_km)?,
            watch: Watch::default(),
        })
    }

    /// Returns the view whose maps stop after [`Watch::stop`].
    pub fn watched(self, watch: &Watch) -> Self {
        Self { watch: watch.clone(), ..self }
    }

    /// Returns the latitude of the Earth's limb, radians: -acos(R / (R + h)). Observers on the ground are at lower
    /// latitudes.
    pub fn limb_latitude_rad(&self) -> f64 {
        let radius_km = crate::constants::EARTH_EQUATORIAL_RADIUS_KM;
        -(radius_km / (radius_km + self.height_km)).acos()
    }

    /// Returns the Sun's latitude above the plane of the chassis, radians.
    pub fn sun_latitude_rad(&self) -> f64 {
        self.sun_latitude_rad
    }

    /// Returns the height of the satellite above 6378.137 km, in km.
    pub fn height_km(&self) -> f64 {
        self.height_km
    }

    /// Returns the magnitude at a range of 1000 km in one direction; `None` if no lit surface is visible.
    pub fn at(&self, observer_longitude_rad: f64, observer_latitude_rad: f64) -> Option<StandardMagnitude> {
        let geometry = ViewingGeometry::from_angles(
            self.sun_latitude_rad,
            observer_longitude_rad,
            observer_latitude_rad,
            STANDARD_RANGE_KM,
            self.height_km,
        )?;
        self.light.standard_magnitude(&geometry, 1.0)
    }

    /// Returns the metadata of the view: model, options and geometry.
    #[doc(hidden)]
    pub fn facts(&self) -> Vec<Fact> {
        let degrees = |angle: f64| FactValue::Real(rounded(angle.to_degrees()));
        let mut facts = vec![
            Fact::new(
                "frame",
                "COORDSYS",
                FactValue::text("BODY"),
                "longitude from the Sun, latitude above the chassis",
            ),
            Fact::new(
                "sun_latitude_deg",
                "SUNLAT",
                degrees(self.sun_latitude_rad),
                "[deg] Sun above the chassis plane",
            ),
            Fact::new("height_km", "HEIGHT", FactValue::Real(self.height_km), "[km] satellite above 6378.137 km"),
            Fact::new("range_km", "RANGE", FactValue::Real(STANDARD_RANGE_KM), "[km] satellite to observer"),
        ];
        facts.extend(self.light.facts());
        facts
    }

    /// Computes the magnitudes for all directions of a grid at or below the plane of the chassis, on all threads of the
    /// current pool.
    ///
    /// # Errors
    /// [`Cancelled`](crate::ErrorKind::Cancelled) after [`Watch::stop`].
    pub fn map(&self, grid: Grid) -> Result<BodyMap, Error> {
        let blank = BodyPoint { observer_longitude_rad: 0.0, observer_latitude_rad: 0.0, standard_magnitude: None };
        let fill_row = |row: &GridRow, points: &mut [BodyPoint]| {
            if !self.light.is_single() {
                return self.fill_by_columns(row, points);
            }
            for (point, observer_longitude_rad) in points.iter_mut().zip(row.longitudes_rad()) {
                let standard_magnitude = self.at(observer_longitude_rad, row.latitude_rad);
                *point =
                    BodyPoint { observer_longitude_rad, observer_latitude_rad: row.latitude_rad, standard_magnitude };
            }
        };
        let points = fill(grid.southern(), blank, fill_row, &self.watch)?;
        Ok(BodyMap { grid, facts: self.facts(), points })
    }

    /// Computes all directions of one latitude together; the values agree within 1e-9 mag with those of
    /// [`at`](Self::at).
    fn fill_by_columns(&self, row: &GridRow, points: &mut [BodyPoint]) {
        let longitudes: Vec<f64> = row.longitudes_rad().collect();
        let mut magnitudes = vec![0.0; longitudes.len()];
        let angles = BodyAngles {
            sun_latitude_rad: &vec![self.sun_latitude_rad; longitudes.len()],
            observer_longitude_rad: &longitudes,
            observer_latitude_rad: &vec![row.latitude_rad; longitudes.len()],
        };
        self.light.sunlight_towards(&angles, &mut magnitudes);
        for (point, (observer_longitude_rad, magnitude)) in
            points.iter_mut().zip(longitudes.into_iter().zip(magnitudes))
        {
            *point = BodyPoint {
                observer_longitude_rad,
                observer_latitude_rad: row.latitude_rad,
                standard_magnitude: self.light.shaded(StandardMagnitude(magnitude), 1.0),
            };
        }
    }
}

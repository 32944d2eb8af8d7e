//! Reference frames as types; positions, velocities, directions and rotations between them.

use std::f64::consts::TAU;
use std::fmt::Debug;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Neg, Sub};

use nalgebra::{Matrix3, Vector3};

/// Reference frame as a type. Only the empty types of this file implement it.
pub trait Frame: Copy + Clone + Debug + PartialEq + Send + Sync + 'static {
    /// Name of the frame for display.
    const NAME: &'static str;
}

macro_rules! frame {
    ($(#[$doc:meta])* $name:ident, $text:literal) => {
        $(#[$doc])*
        #[derive(Copy, Clone, Debug, PartialEq, Eq)]
        pub struct $name;
        impl Frame for $name {
            const NAME: &'static str = $text;
        }
    };
}

frame!(
    /// True equator, mean equinox of date: the frame of SGP4's output. Only the module `orbit` has positions of
    /// satellites in this frame.
    Teme, "TEME"
);
frame!(
    /// Geocentric celestial reference system; its axes are those of the ICRS.
    Gcrs, "GCRS"
);
frame!(
    /// Mean equator and equinox of J2000, 23 milliarcseconds from GCRS.
    Eme2000, "EME2000"
);
frame!(
    /// True equator and equinox of date: x to the equinox, z to the celestial intermediate pole.
    OfDate, "true equator and equinox of date"
);
frame!(
    /// Earth-fixed: x to longitude 0 on the equator, z to the pole.
    Itrs, "ITRS"
);
frame!(
    /// A site's horizon: x to the north, y to the east, z to the zenith (left-handed, so that longitude is azimuth).
    Horizontal, "horizontal"
);
frame!(
    /// Body frame of a satellite: z to the zenith, x in the half plane of z and the Sun, y = z × x (Lu 2024, section
    /// 2.2).
    Body, "body"
);

macro_rules! framed_vector {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Copy, Clone, Debug, PartialEq)]
        pub struct $name<F: Frame> {
            vector: Vector3<f64>,
            frame: PhantomData<F>,
        }

        impl<F: Frame> $name<F> {
            /// Creates a vector from components that are already in this frame and unit.
            #[doc(hidden)]
            pub fn from_vector(vector: Vector3<f64>) -> Self {
                Self { vector, frame: PhantomData }
            }

            /// Returns the components in the axes of the frame.
            pub fn components(&self) -> [f64; 3] {
                self.vector.into()
            }

            /// Returns the components in the axes of the frame.
            #[doc(hidden)]
            pub fn vector(&self) -> &Vector3<f64> {
                &self.vector
            }
        }
    };
}

framed_vector!(
    /// Position in km relative to the Earth's centre. `Horizontal` positions and differences of positions are relative
    /// to the point stated where they are documented.
    Position
);
framed_vector!(
    /// A velocity, km/s.
    Velocity
);
framed_vector!(
    /// An acceleration, m/s².
    Acceleration
);
framed_vector!(
    /// A unit vector.
    Direction
);

impl<F: Frame> Position<F> {
    /// Creates a position from components in km.
    pub fn new(x_km: f64, y_km: f64, z_km: f64) -> Self {
        Self::from_vector(Vector3::new(x_km, y_km, z_km))
    }

    /// Returns the distance from the origin, km.
    pub fn norm_km(&self) -> f64 {
        self.vector.norm()
    }

    /// Returns the direction from the origin; `None` at the origin itself or where a component is not finite.
    pub fn direction(&self) -> Option<Direction<F>> {
        let norm = self.vector.norm();
        (norm > 0.0 && norm.is_finite()).then(|| Direction::from_vector(self.vector / norm))
    }
}

impl<F: Frame> Velocity<F> {
    /// Creates a velocity from components in km/s.
    pub fn new(x_km_s: f64, y_km_s: f64, z_km_s: f64) -> Self {
        Self::from_vector(Vector3::new(x_km_s, y_km_s, z_km_s))
    }

    /// Returns the speed, km/s.
    pub fn norm_km_s(&self) -> f64 {
        self.vector.norm()
    }

    /// Returns the displacement after `seconds` of motion at this velocity.
    pub fn displacement(&self, seconds: f64) -> Position<F> {
        Position::from_vector(self.vector * seconds)
    }
}

impl<F: Frame> Direction<F> {
    /// Creates a direction from longitude (right ascension, azimuth) and latitude (declination, altitude), radians.
    pub fn from_lon_lat_rad(longitude_rad: f64, latitude_rad: f64) -> Self {
        let (sin_lon, cos_lon) = longitude_rad.sin_cos();
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        Self::from_vector(Vector3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat))
    }

    /// Returns the longitude (right ascension, azimuth) in [0, 2π), radians.
    pub fn longitude_rad(&self) -> f64 {
        let longitude = self.vector.y.atan2(self.vector.x).rem_euclid(TAU);
        // rem_euclid of a tiny negative number rounds to 2π itself.
        if longitude >= TAU { 0.0 } else { longitude }
    }

    /// Returns the latitude (declination, altitude) in [-π/2, π/2], radians; accurate near the poles too.
    pub fn latitude_rad(&self) -> f64 {
        self.vector.z.atan2(self.vector.x.hypot(self.vector.y))
    }

    /// Returns the angle to another direction in [0, π], radians; accurate for tiny and for nearly opposite angles.
    pub fn separation_rad(&self, other: &Self) -> f64 {
        self.vector.cross(&other.vector).norm().atan2(self.vector.dot(&other.vector))
    }

    /// Returns the cosine of the angle to another direction.
    pub fn cosine(&self, other: &Self) -> f64 {
        self.vector.dot(&other.vector)
    }

    /// Returns the position angle of `other` from this direction: from the frame's north through increasing longitude
    /// (east), in [0, 2π), radians.
    pub fn position_angle_rad(&self, other: &Self) -> f64 {
        let (east, north) = self.east_north();
        let angle = other.vector.dot(&east).atan2(other.vector.dot(&north)).rem_euclid(TAU);
        if angle >= TAU { 0.0 } else { angle }
    }

    /// Returns the unit vectors towards increasing longitude and increasing latitude at this direction. At a pole they
    /// are those of longitude 0.
    #[doc(hidden)]
    pub fn east_north(&self) -> (Vector3<f64>, Vector3<f64>) {
        let (sin_lon, cos_lon) = self.longitude_rad().sin_cos();
        let east = Vector3::new(-sin_lon, cos_lon, 0.0);
        (east, self.vector.cross(&east))
    }

    /// Returns the position at `range_km` in this direction.
    pub fn at_range(&self, range_km: f64) -> Position<F> {
        Position::from_vector(self.vector * range_km)
    }
}

impl<F: Frame> Add for Position<F> {
    type Output = Position<F>;
    fn add(self, other: Self) -> Self {
        Self::from_vector(self.vector + other.vector)
    }
}

impl<F: Frame> Sub for Position<F> {
    type Output = Position<F>;
    fn sub(self, other: Self) -> Self {
        Self::from_vector(self.vector - other.vector)
    }
}

impl<F: Frame> Add for Velocity<F> {
    type Output = Velocity<F>;
    fn add(self, other: Self) -> Self {
        Self::from_vector(self.vector + other.vector)
    }
}

impl<F: Frame> Sub for Velocity<F> {
    type Output = Velocity<F>;
    fn sub(self, other: Self) -> Self {
        Self::from_vector(self.vector - other.vector)
    }
}

impl<F: Frame> Neg for Direction<F> {
    type Output = Direction<F>;
    fn neg(self) -> Self {
        Self::from_vector(-self.vector)
    }
}

/// Orthogonal transformation of vector components from frame `A` to frame `B`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Rotation<A: Frame, B: Frame> {
    matrix: Matrix3<f64>,
    frames: PhantomData<(A, B)>,
}

impl<A: Frame, B: Frame> Rotation<A, B> {
    /// Creates a rotation from an orthogonal matrix; row i holds the components in `A` of the i-th axis of `B`.
    pub(crate) fn from_matrix(matrix: Matrix3<f64>) -> Self {
        Self { matrix, frames: PhantomData }
    }

    /// Returns the matrix; row i holds the components in `A` of the i-th axis of `B`.
    #[doc(hidden)]
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }

    /// Returns the inverse rotation.
    pub fn inverse(&self) -> Rotation<B, A> {
        Rotation::from_matrix(self.matrix.transpose())
    }
}

impl<A: Frame, B: Frame, C: Frame> Mul<Rotation<A, B>> for Rotation<B, C> {
    type Output = Rotation<A, C>;
    fn mul(self, first: Rotation<A, B>) -> Rotation<A, C> {
        Rotation::from_matrix(self.matrix * first.matrix)
    }
}

macro_rules! rotates {
    ($name:ident) => {
        impl<A: Frame, B: Frame> Mul<$name<A>> for Rotation<A, B> {
            type Output = $name<B>;
            fn mul(self, vector: $name<A>) -> $name<B> {
                $name::from_vector(self.matrix * vector.vector)
            }
        }
    };
}
rotates!(Position);
rotates!(Velocity);
rotates!(Acceleration);
rotates!(Direction);

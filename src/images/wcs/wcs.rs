//! Transformation between pixels and the sky.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use crate::error::Error;
use crate::frames::{Direction, Gcrs};

use super::super::card::Card;
use super::super::header::Header;
use super::header_terms::HeaderTerms;
use super::projection::NativePole;
use super::projection::Projection;
use crate::images::pixels::PixelPosition;

/// Number of arcseconds in a radian.
const ARCSEC: f64 = 648_000.0 / std::f64::consts::PI;

/// Smallest margin around a frame in which its distortion is used, pixels. A margin in which the distortion folds, that
/// is, maps different pixels to the same position, is reduced further.
const LEAST_MARGIN_PIX: f64 = 1000.0;

/// Side of a frame whose header does not give its size, pixels.
const UNKNOWN_SIDE_PIX: usize = 4096;

/// Number of points along each side of a frame at which a distortion is checked for folds.
const FOLD_GRID: usize = 13;

/// Smallest accepted slope of the distortion, relative to that at the centre. If the slope is above it everywhere, no
/// two pixels have the same position.
const LEAST_SLOPE: f64 = 0.1;

/// Fractions of the margin that are tried in turn until the distortion does not fold inside it.
const MARGINS: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.0];

/// Precision at which Newton's method stops, pixels.
const CLOSE_PIX: f64 = 1e-11;

/// Largest number of steps of Newton's method; usually three or four suffice.
const MOST_STEPS: usize = 25;

/// Transformation between the pixels of one frame and astrometric ICRS directions, which have the axes of [`Gcrs`].
///
/// A transformation is read from a header by [`from_header`](Wcs::from_header) or created by [`tangent`](Wcs::tangent).
/// FK5 of equinox 2000 is taken as ICRS, from which it differs by 0.02 arcsec. A frame with a polynomial distortion has
/// positions only within the frame and a margin around it. The margin is the longer side of the frame and at least 1000
/// pixels, or less if the polynomial folds. Farther out, polynomials bend back, so that a satellite far from the frame
/// would appear inside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Wcs {
    terms: HeaderTerms,
    /// Matrix from pixels to degrees of the projection plane.
    matrix: Matrix2<f64>,
    inverse: Matrix2<f64>,
    to_sky: Matrix3<f64>,
    size: [usize; 2],
    trusted: Option<Trusted>,
}

/// Area around a distorted frame in which pixels and positions on the sky correspond one to one.
#[derive(Clone, Debug, PartialEq)]
struct Trusted {
    /// Smallest and largest coordinates, in pixels relative to CRPIX.
    low: Vector2<f64>,
    high: Vector2<f64>,
    /// Centre of the frame, its position in the projection plane, and the inverse of the slopes there, from which
    /// Newton's method starts.
    centre: Vector2<f64>,
    plane_centre: Vector2<f64>,
    inverse_slopes: Matrix2<f64>,
}

impl Wcs {
    /// Reads the world coordinates of a header.
    ///
    /// # Errors
    /// The header has no celestial axes; a number is missing or invalid; the projection or the reference system is not
    /// supported; the matrix has no inverse; or the distortion folds within the frame.
    pub fn from_header(header: &Header) -> Result<Self, Error> {
        Self::from_terms(HeaderTerms::from_header(header)?)
    }

    /// Creates a gnomonic transformation for simulated frames. `centre` is the direction of the middle of `columns` by
    /// `rows` pixels with sides of `scale_arcsec`.
    ///
    /// Without rotation, north is up (row numbers increase northwards) and east is left (column numbers increase
    /// westwards). `rotation_rad` is the position angle, from north through east, of the direction in which row numbers
    /// increase.
    pub fn tangent(
        centre: Direction<Gcrs>,
        scale_arcsec: f64,
        rotation_rad: f64,
        columns: usize,
        rows: usize,
    ) -> Result<Self, Error> {
        let scale_deg = scale_arcsec / 3600.0;
        let (sine, cosine) = rotation_rad.sin_cos();
        Self::from_terms(HeaderTerms {
            longitude_axis: 0,
            reference_pixel: [(columns as f64 + 1.0) / 2.0, (rows as f64 + 1.0) / 2.0],
            matrix_deg: [[-scale_deg * cosine, scale_deg * sine], [scale_deg * sine, scale_deg * cosine]],
            pixel_distortion: None,
            plane_distortion: None,
            projection: Projection::Tan,
            pole: NativePole {
                right_ascension_deg: centre.longitude_rad().to_degrees(),
                declination_deg: centre.latitude_rad().to_degrees(),
                lonpole_deg: Some(180.0),
                latpole_deg: None,
                is_zenithal: true,
            },
            size: Some([columns, rows]),
        })
    }

    fn from_terms(terms: HeaderTerms) -> Result<Self, Error> {
        let [[a, b], [c, d]] = terms.matrix_deg;
        let matrix = Matrix2::new(a, b, c, d);
        let inverse =
            matrix.try_inverse().filter(|inverse| inverse.iter().all(|entry| entry.is_finite())).ok_or_else(|| {
                let allowed = "a matrix that has an inverse (CDi_j, or PCi_j with CDELTi)";
                Error::invalid("matrix of pixels to degrees", format!("[{a}, {b}; {c}, {d}]"), allowed)
            })?;
        let to_sky = terms.pole.to_sky().ok_or_else(|| {
            let given =
                |angle_deg: Option<f64>| angle_deg.map_or("missing".to_owned(), |angle_deg| angle_deg.to_string());
            Error::invalid(
                "LONPOLE".to_owned(),
                format!("{} with LATPOLE {}", given(terms.pole.lonpole_deg), given(terms.pole.latpole_deg)),
                "a native pole that is consistent with CRVAL",
            )
        })?;
        let size = terms.size.unwrap_or([UNKNOWN_SIDE_PIX; 2]);
        let mut wcs = Self { terms, matrix, inverse, to_sky, size, trusted: None };
        if let Some(kind) = wcs.distortion() {
            let trusted = wcs.trusted_area().ok_or_else(|| {
                let allowed = "one position on the sky for each pixel";
                Error::invalid(format!("distortion ({kind})"), "folded within the frame", allowed)
            })?;
            wcs.trusted = Some(trusted);
        }
        Ok(wcs)
    }

    /// Returns the kind of distortion (SIP, TPV, TNX, ZPX); `None` without distortion.
    pub fn distortion(&self) -> Option<&'static str> {
        let terms = &self.terms;
        terms.pixel_distortion.as_ref().or(terms.plane_distortion.as_ref()).map(|distortion| distortion.kind)
    }

    /// Returns the numbers of columns and rows of the frame; 4096 each if the header does not give them.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns the direction of a position in the frame; `None` if the position is outside the range of the projection
    /// or far outside a distorted frame.
    pub fn to_sky(&self, position: PixelPosition) -> Option<Direction<Gcrs>> {
        let offset = self.offset(position);
        if !(offset.x.is_finite() && offset.y.is_finite()) {
            return None;
        }
        if let Some(trusted) = &self.trusted
            && !trusted.contains(&offset)
        {
            return None;
        }
        let plane = self.plane(&offset).0;
        let native = self.terms.projection.to_native(plane.x.to_radians(), plane.y.to_radians())?;
        Some(Direction::from_vector(self.to_sky * native))
    }

    /// Returns the position of a direction in the frame; `None` if the direction is outside the range of the projection
    /// or far outside a distorted frame.
    ///
    /// In undistorted frames, directions far beyond the edges have positions too: up to 90° from the centre of a
    /// gnomonic frame.
    pub fn to_pixel(&self, direction: Direction<Gcrs>) -> Option<PixelPosition> {
        let native = self.to_sky.tr_mul(direction.vector());
        let [x, y] = self.terms.projection.to_plane(&native)?;
        let plane = Vector2::new(x.to_degrees(), y.to_degrees());
        let offset = match &self.trusted {
            None => self.inverse * plane,
            Some(trusted) => self.solve_pixel(trusted, &plane)?,
        };
        let [reference_x, reference_y] = self.terms.reference_pixel;
        Some(PixelPosition::from_fits(offset.x + reference_x, offset.y + reference_y))
    }

    /// Returns the side of a square that has the area of the pixel at a position, arcseconds (the geometric mean of the
    /// scales along both axes). NaN if [`to_sky`](Wcs::to_sky) returns `None`.
    pub fn pixel_scale_arcsec(&self, position: PixelPosition) -> f64 {
        self.pixel_area_arcsec2(position).sqrt()
    }

    /// Returns the area on the sky of the pixel at a position, square arcseconds; NaN if [`to_sky`](Wcs::to_sky)
    /// returns `None`.
    pub fn pixel_area_arcsec2(&self, position: PixelPosition) -> f64 {
        match self.pixel_sides(position) {
            Some([across, along]) => across.cross(&along).norm() * ARCSEC * ARCSEC,
            None => f64::NAN,
        }
    }

    /// Returns the ratio of width (along rows) to height of the pixel at a position, on the sky; NaN if
    /// [`to_sky`](Wcs::to_sky) returns `None`.
    pub fn pixel_aspect(&self, position: PixelPosition) -> f64 {
        self.pixel_sides(position).map_or(f64::NAN, |[across, along]| across.norm() / along.norm())
    }

    /// Returns the vectors on the sky from the left to the right side of a pixel and from its lower to its upper side.
    fn pixel_sides(&self, position: PixelPosition) -> Option<[Vector3<f64>; 2]> {
        let half = 0.5;
        let at = |x: f64, y: f64| self.to_sky(PixelPosition { x: position.x + x, y: position.y + y });
        let across = at(half, 0.0)?.vector() - at(-half, 0.0)?.vector();
        Some([across, at(0.0, half)?.vector() - at(0.0, -half)?.vector()])
    }

    /// Returns the header cards that describe an undistorted gnomonic frame (see [`tangent`](Wcs::tangent)); empty for
    /// other frames.
    #[doc(hidden)]
    pub fn cards(&self) -> Vec<Card> {
        if self.distortion().is_some() || self.terms.projection != Projection::Tan || self.terms.longitude_axis != 0 {
            return Vec::new();
        }
        let [crpix1, crpix2] = self.terms.reference_pixel;
        let [[cd1_1, cd1_2], [cd2_1, cd2_2]] = self.terms.matrix_deg;
        let pole = &self.terms.pole;
        let texts = [
            ("CTYPE1", "RA---TAN", "right ascension, gnomonic"),
            ("CTYPE2", "DEC--TAN", "declination, gnomonic"),
            ("CUNIT1", "deg", ""),
            ("CUNIT2", "deg", ""),
        ];
        let numbers = [
            ("CRPIX1", crpix1, "reference pixel, counted from 1"),
            ("CRPIX2", crpix2, "reference pixel, counted from 1"),
            ("CRVAL1", pole.right_ascension_deg, "[deg] right ascension there"),
            ("CRVAL2", pole.declination_deg, "[deg] declination there"),
            ("CD1_1", cd1_1, "[deg] a pixel"),
            ("CD1_2", cd1_2, "[deg] a pixel"),
            ("CD2_1", cd2_1, "[deg] a pixel"),
            ("CD2_2", cd2_2, "[deg] a pixel"),
        ];
        let mut cards = Card::with_value("WCSAXES", &2_i64.into(), "number of world coordinate axes");
        cards.extend(
            texts.iter().flat_map(|(keyword, text, comment)| Card::with_value(keyword, &(*text).into(), comment)),
        );
        cards.extend(
            numbers.iter().flat_map(|(keyword, number, comment)| Card::with_value(keyword, &(*number).into(), comment)),
        );
        if let Some(lonpole_deg) = pole.lonpole_deg {
            cards.extend(Card::with_value(
                "LONPOLE",
                &lonpole_deg.into(),
                "[deg] native longitude of the celestial pole",
            ));
        }
        cards.extend(Card::with_value("RADESYS", &"ICRS".into(), "system of axes"));
        cards
    }

    /// Converts a position in the frame to pixels relative to CRPIX.
    fn offset(&self, position: PixelPosition) -> Vector2<f64> {
        let [x, y] = position.fits();
        Vector2::new(x - self.terms.reference_pixel[0], y - self.terms.reference_pixel[1])
    }

    /// Returns the position in the projection plane, degrees, and its derivatives with respect to pixels.
    fn plane(&self, offset: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let (mut position, mut slopes) = (*offset, Matrix2::identity());
        if let Some(distortion) = &self.terms.pixel_distortion {
            let [u, v] = distortion.at(position.x, position.y);
            position = Vector2::new(u.value, v.value);
            slopes = Matrix2::new(u.du, u.dv, v.du, v.dv);
        }
        position = self.matrix * position;
        slopes = self.matrix * slopes;
        if let Some(distortion) = &self.terms.plane_distortion {
            let [u, v] = distortion.at(position.x, position.y);
            position = Vector2::new(u.value, v.value);
            slopes = Matrix2::new(u.du, u.dv, v.du, v.dv) * slopes;
        }
        (position, slopes)
    }

    /// Returns the frame with the largest margin in which the distortion does not fold; `None` if it folds within the
    /// frame.
    ///
    /// A map f of a convex area with the Jacobian J is one to one if (J₀⁻¹ J) + (J₀⁻¹ J)ᵀ is positive definite
    /// everywhere, where J₀ is the Jacobian at one point, because f is then monotonic along any straight line. The
    /// condition is checked at the points of a grid.
    fn trusted_area(&self) -> Option<Trusted> {
        let [columns, rows] = self.size.map(|count| count as f64);
        let corner = self.offset(PixelPosition { x: -0.5, y: -0.5 });
        let side = Vector2::new(columns, rows);
        let centre = corner + side / 2.0;
        let (plane_centre, slopes) = self.plane(&centre);
        let inverse_slopes = slopes.try_inverse()?;
        let margin = columns.max(rows).max(LEAST_MARGIN_PIX);
        MARGINS.iter().find_map(|part| {
            let around = Vector2::from_element(margin * part);
            let (low, high) = (corner - around, corner + side + around);
            let is_plain = |index: usize| {
                let step = |position: usize| position as f64 / (FOLD_GRID - 1) as f64;
                let at =
                    low + (high - low).component_mul(&Vector2::new(step(index % FOLD_GRID), step(index / FOLD_GRID)));
                let relative = inverse_slopes * self.plane(&at).1;
                let both = (relative + relative.transpose()) / 2.0;
                // Smaller eigenvalue of the symmetric matrix.
                let smaller = both.trace() / 2.0 - ((both.m11 - both.m22) / 2.0).hypot(both.m12);
                smaller > LEAST_SLOPE
            };
            (0..FOLD_GRID * FOLD_GRID).all(is_plain).then_some(Trusted {
                low,
                high,
                centre,
                plane_centre,
                inverse_slopes,
            })
        })
    }

    /// Returns the pixel (relative to CRPIX) whose position in the projection plane is `target`, by Newton's method.
    fn solve_pixel(&self, trusted: &Trusted, target: &Vector2<f64>) -> Option<Vector2<f64>> {
        let mut offset = trusted.centre + trusted.inverse_slopes * (target - trusted.plane_centre);
        for _ in 0..MOST_STEPS {
            if !trusted.is_near(&offset) {
                return None;
            }
            let (plane, slopes) = self.plane(&offset);
            let determinant = slopes.m11 * slopes.m22 - slopes.m12 * slopes.m21;
            let miss = target - plane;
            let step =
                Vector2::new(slopes.m22 * miss.x - slopes.m12 * miss.y, slopes.m11 * miss.y - slopes.m21 * miss.x)
                    / determinant;
            offset += step;
            if step.amax() < CLOSE_PIX * (1.0 + offset.amax() * 1e-4) {
                return trusted.contains(&offset).then_some(offset);
            }
        }
        None
    }
}

impl Trusted {
    fn contains(&self, offset: &Vector2<f64>) -> bool {
        (0..2).all(|axis| (self.low[axis]..=self.high[axis]).contains(&offset[axis]))
    }

    /// Returns true within the area enlarged by half its size on each side, which the steps of Newton's method may use.
    fn is_near(&self, offset: &Vector2<f64>) -> bool {
        let around = (self.high - self.low) / 2.0;
        (0..2).all(|axis| (self.low[axis] - around[axis]..=self.high[axis] + around[axis]).contains(&offset[axis]))
    }
}

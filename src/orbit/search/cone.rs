//! Search cones: fields of view of an observer over a time interval, directions about an axis, and the Earth's shadow.

use nalgebra::Vector3;

use super::super::propagator::DECAYED_RADIUS_KM;
use super::kepler::Phase;
use super::side::Cap;
use crate::constants::WGS72_MU_KM3_S2;
use crate::frames::{Direction, Gcrs, Position, Rotation, Teme};

/// Margin added at both ends of the interval in which a satellite may be inside a cone, seconds.
const NEAR_MARGIN_S: f64 = 0.5;

/// Length of the interval in which a satellite may be inside a cone, as a fraction of the previous one, below which the
/// interval is computed once more.
const WORTHWHILE: f64 = 0.8;

/// Largest speed of a satellite, km/s: above the escape velocity at the Earth's surface, 11.2 km/s.
const FASTEST_KM_S: f64 = 12.0;

/// A field of view over a time interval.
#[derive(Copy, Clone, Debug)]
pub struct Cone {
    /// Middle of the time interval, seconds after the start of the window.
    pub mid_s: f64,
    /// Half the length of the interval, seconds. The margins of the search are small for a minute or less.
    pub half_duration_s: f64,
    /// Position of the observer at the middle of the interval, km.
    pub observer: Position<Gcrs>,
    /// Largest speed of the observer during the interval, km/s.
    pub observer_speed_km_s: f64,
    /// Axis of the cone.
    pub axis: Direction<Gcrs>,
    /// Half opening angle, radians. It must include a margin for aberration and light time; 2e-4 suffices.
    pub radius_rad: f64,
}

/// A cone that is tested as a whole before its parts are tested.
#[derive(Copy, Clone, Debug)]
pub struct Cones<'a> {
    /// Cone that contains all parts over all of their time intervals.
    pub whole: &'a Cone,
    /// Parts of the cone; empty if only the whole cone is searched.
    pub parts: &'a [Cone],
    /// Number of the first part, or of the whole cone if there are no parts.
    pub first: u32,
    /// Region of the shadow in which no satellite is lit; `None` if satellites in shadow are searched for, too.
    pub shadow: Option<&'a ShadowCone>,
    /// Satellites that are searched for.
    pub scope: SearchScope,
}

/// Satellites that a search finds.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum SearchScope {
    /// Satellites that cross at their predicted positions.
    Nominal,
    /// Satellites that cross with a delay and a cross-track offset within their errors.
    Delayed,
}

/// Result of the phase test for a satellite that may be inside a cone.
#[derive(Copy, Clone, Debug)]
pub(super) struct ConePassage {
    /// Interval during which the predicted position is inside the cone, seconds from the middle of the cone's time
    /// interval.
    pub near_s: [f64; 2],
    /// True if the satellite is inside the shadow whenever it may be inside the cone.
    pub is_dark: bool,
}

/// A cone transformed to TEME.
pub(super) struct ConeTest<'a> {
    cone: &'a Cone,
    observer: Vector3<f64>,
    beam: Beam,
    window_span_s: f64,
    fraction: f64,
    moved_km: f64,
    scope: SearchScope,
}

impl<'a> ConeTest<'a> {
    /// Transforms a cone to TEME; `window_span_s` is the length of the window.
    pub fn new(cone: &'a Cone, teme_to_gcrs: &Rotation<Teme, Gcrs>, window_span_s: f64, scope: SearchScope) -> Self {
        let gcrs_to_teme = teme_to_gcrs.inverse();
        Self {
            cone,
            observer: *(gcrs_to_teme * cone.observer).vector(),
            beam: Beam::new(*(gcrs_to_teme * cone.axis).vector(), cone.radius_rad),
            window_span_s,
            fraction: cone.mid_s / window_span_s,
            moved_km: cone.observer_speed_km_s * cone.half_duration_s,
            scope,
        }
    }

    /// Returns the largest delay with which a satellite is searched for, seconds.
    #[inline]
    pub fn delay_s(&self, along_track_s: f32) -> f64 {
        if self.scope == SearchScope::Nominal { 0.0 } else { f64::from(along_track_s) }
    }

    pub fn observer(&self) -> &Vector3<f64> {
        &self.observer
    }

    pub fn axis(&self) -> &Vector3<f64> {
        self.beam.axis()
    }

    /// Returns the middle of the cone's time interval as a fraction of the window, from 0 to 1.
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// Returns the middle of the cone's time interval, seconds after the start of the window.
    pub fn mid_s(&self) -> f64 {
        self.cone.mid_s
    }

    /// Returns the time interval, seconds after the start of the window.
    pub fn interval_s(&self) -> [f64; 2] {
        [self.cone.mid_s - self.cone.half_duration_s, self.cone.mid_s + self.cone.half_duration_s]
    }

    /// Returns the observer's displacement between the middle and the ends of the interval, km.
    pub fn moved_km(&self) -> f64 {
        self.moved_km
    }

    pub fn radius_rad(&self) -> f64 {
        self.beam.radius_rad()
    }

    /// Returns the cap on the celestial sphere around the Earth's centre that contains a part of the cone: the part
    /// between two distances from the observer, for orbits no lower than `lowest_km`. `None` if the cap may be the
    /// whole sphere.
    pub fn cap(&self, distances_km: [f64; 2], lowest_km: f64) -> Option<Cap> {
        Cap::from_cone(&self.observer, self.axis(), self.radius_rad(), distances_km, lowest_km)
    }

    /// Side test: returns whether a satellite that passed the plane test may be in the direction of the cap during the
    /// interval.
    #[inline]
    pub fn may_be_over(&self, cap: &Cap, phase: &Phase, normal: &Vector3<f64>) -> bool {
        phase.only_plane
            || cap.may_hold(
                phase,
                normal,
                self.cone.mid_s,
                self.half_s(phase.along_track_s),
                f64::from(phase.slop_km) + self.moved_km,
            )
    }

    /// Phase test: returns the time during which a satellite that passed the plane test may be inside the cone; `None`
    /// if it cannot be inside. `normal` returns the normal of the orbit plane at a fraction of the window.
    #[inline]
    pub fn inside(
        &self,
        phase: &Phase,
        normal: impl Fn(f64) -> Vector3<f64>,
        shadow: Option<&ShadowConeInTeme>,
    ) -> Option<ConePassage> {
        if phase.only_plane {
            return Some(self.anywhere(phase.along_track_s));
        }
        let slop_km = f64::from(phase.slop_km);
        let (mut middle_s, mut half_s) = (0.0, self.half_s(phase.along_track_s));
        loop {
            let fraction = self.fraction + middle_s / self.window_span_s;
            let (position, velocity) = phase.state(&normal(fraction), self.cone.mid_s + middle_s, fraction);
            let sight = position - self.observer;
            // During a time t the satellite departs from its tangent by at most ½ g t², where g is gravity at its
            // lowest point.
            let lowest_km = phase.perigee_km(fraction).max(position.norm() - FASTEST_KM_S * half_s) - slop_km;
            let bend_km = 0.5 * WGS72_MU_KM3_S2 / lowest_km.max(DECAYED_RADIUS_KM).powi(2) * half_s * half_s;
            let total_km = slop_km + bend_km + self.moved_km;
            let [from_s, to_s] = self.beam.near_s(&sight, &velocity, half_s, total_km)?;
            let (from_s, to_s) = ((from_s - NEAR_MARGIN_S).max(-half_s), (to_s + NEAR_MARGIN_S).min(half_s));
            let near_half_s = 0.5 * (to_s - from_s);
            // With large delays the tangent is a rough approximation, so that the interval is too long. The tangent at
            // its middle is a better one.
            if bend_km > slop_km && near_half_s < WORTHWHILE * half_s {
                middle_s += 0.5 * (from_s + to_s);
                half_s = near_half_s;
                continue;
            }
            // Ends of the range of positions that a delayed satellite can have inside the cone.
            let ends = [-half_s, half_s].map(|time_s| position + velocity * time_s);
            let is_dark = shadow.is_some_and(|shadow| ends.iter().all(|end| shadow.holds(end, total_km)));
            return Some(ConePassage { near_s: [middle_s + from_s, middle_s + to_s], is_dark });
        }
    }

    /// Returns the whole time in which a delayed satellite may be anywhere.
    pub fn anywhere(&self, along_track_s: f32) -> ConePassage {
        let half_s = self.half_s(along_track_s);
        ConePassage { near_s: [-half_s, half_s], is_dark: false }
    }

    /// Returns false for a satellite that cannot be inside the cone with any delay, because it is too far away at the
    /// middle of the interval, at a position with an error of at most `slop_km`. Its velocity is at most the escape
    /// velocity.
    pub fn may_be_reached(&self, position_km: &Vector3<f64>, along_track_s: f32, slop_km: f64) -> bool {
        let reach_km = FASTEST_KM_S * self.half_s(along_track_s) + slop_km + self.moved_km;
        self.beam.meets_ball(&(position_km - self.observer), reach_km)
    }

    /// Returns half of the interval of predicted times at which a delayed satellite may be inside the cone, seconds.
    fn half_s(&self, along_track_s: f32) -> f64 {
        self.cone.half_duration_s + self.delay_s(along_track_s)
    }
}

/// Cone radius, radians, above which a satellite's path is bounded by a ball instead of a line.
const WIDE_RAD: f64 = 0.5;

/// Directions within an angle of an axis, in any frame.
#[derive(Clone, Debug)]
pub struct Beam {
    axis: Vector3<f64>,
    radius_rad: f64,
    tangent: f64,
    secant: f64,
}

impl Beam {
    /// Creates a cone about a unit vector.
    pub fn new(axis: Vector3<f64>, radius_rad: f64) -> Self {
        Self { axis, radius_rad, tangent: radius_rad.tan(), secant: 1.0 / radius_rad.cos() }
    }

    /// Returns the unit vector of the axis.
    pub fn axis(&self) -> &Vector3<f64> {
        &self.axis
    }

    /// Returns the half opening angle, radians.
    pub fn radius_rad(&self) -> f64 {
        self.radius_rad
    }

    /// Returns true if a part of the ball of radius `reach_km` around `sight_km` is inside the cone.
    fn meets_ball(&self, sight_km: &Vector3<f64>, reach_km: f64) -> bool {
        let distance_km = sight_km.norm();
        let angle_rad = sight_km.cross(&self.axis).norm().atan2(sight_km.dot(&self.axis));
        distance_km <= reach_km || angle_rad <= self.radius_rad + (reach_km / distance_km).asin()
    }

    /// Returns the interval, seconds, in which an object may be inside the cone; `None` if it cannot be inside. The
    /// object is at `sight_km` relative to the observer at time 0 and moves uniformly from -`half_s` to `half_s`; its
    /// position error is at most `slop_km`.
    ///
    /// The interval may extend beyond ±`half_s`.
    #[inline]
    pub fn near_s(
        &self,
        sight_km: &Vector3<f64>,
        velocity_km_s: &Vector3<f64>,
        half_s: f64,
        slop_km: f64,
    ) -> Option<[f64; 2]> {
        if self.radius_rad > WIDE_RAD {
            // The whole path is bounded by a ball around its middle.
            let reach_km = slop_km + velocity_km_s.norm() * half_s;
            return self.meets_ball(sight_km, reach_km).then_some([-half_s, half_s]);
        }
        // The path is a straight line. Its least distance from the axis is compared with the width of the cone at the
        // greatest depth. A ball of radius s touches the surface of the cone at a distance of s / cos ψ across it.
        let (depth, depth_rate) = (sight_km.dot(&self.axis), velocity_km_s.dot(&self.axis));
        let deepest_km = depth + depth_rate.abs() * half_s + slop_km;
        if deepest_km < 0.0 {
            return None;
        }
        let (across, across_rate) = (sight_km - self.axis * depth, velocity_km_s - self.axis * depth_rate);
        let rate2 = across_rate.norm_squared().max(1e-12);
        let nearest_s = -across.dot(&across_rate) / rate2;
        let width_km = deepest_km * self.tangent + slop_km * self.secant;
        let missed_km2 = |time_s: f64| (across + across_rate * time_s).norm_squared();
        if missed_km2(nearest_s.clamp(-half_s, half_s)) > width_km * width_km {
            return None;
        }
        // The object is inside the cone while |across + rate t| ≤ width.
        let about_s = ((width_km * width_km - missed_km2(nearest_s)).max(0.0) / rate2).sqrt();
        Some([nearest_s - about_s, nearest_s + about_s])
    }
}

/// A cone around the anti-solar direction that starts at the Earth's centre and in which no satellite is lit.
#[derive(Copy, Clone, Debug)]
pub struct ShadowCone {
    /// Axis: direction from the Earth's centre away from the Sun.
    pub away_from_sun: Direction<Gcrs>,
    /// Radius at the Earth's centre, km.
    pub radius_km: f64,
    /// Decrease of the radius, km per km of distance behind the Earth's centre.
    pub narrowing: f64,
}

/// A [`ShadowCone`] in TEME.
pub(super) struct ShadowConeInTeme {
    away_from_sun: Vector3<f64>,
    radius_km: f64,
    narrowing: f64,
}

impl ShadowCone {
    pub(super) fn in_teme(&self, teme_to_gcrs: &Rotation<Teme, Gcrs>) -> ShadowConeInTeme {
        let away_from_sun = *(teme_to_gcrs.inverse() * self.away_from_sun).vector();
        ShadowConeInTeme { away_from_sun, radius_km: self.radius_km, narrowing: self.narrowing }
    }
}

impl ShadowConeInTeme {
    /// Returns true if all positions within `slop_km` of a position are inside the cone.
    pub fn holds(&self, position: &Vector3<f64>, slop_km: f64) -> bool {
        let depth_km = position.dot(&self.away_from_sun);
        let across_km = (position - self.away_from_sun * depth_km).norm();
        // The surface of the cone is nearly parallel to its axis, so a step along the axis changes the distance from
        // the surface less than the same step across.
        depth_km > slop_km && across_km + slop_km < self.radius_km - self.narrowing * (depth_km + slop_km)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_near_while_they_are_within_the_width() {
        // 1000 km away, past the axis at 20 km, 7 km/s: the cone is 17.5 km wide there, with 10 km of margin.
        let beam = Beam::new(Vector3::z(), 1f64.to_radians());
        let (sight, velocity) = (Vector3::new(-70.0, 20.0, 1000.0), Vector3::new(7.0, 0.0, 0.0));
        let [from_s, to_s] = beam.near_s(&sight, &velocity, 30.0, 10.0).expect("near");
        let width_km = 1010.0 * 1f64.to_radians().tan() + 10.0 / 1f64.to_radians().cos();
        let half_s = (width_km * width_km - 400.0).sqrt() / 7.0;
        assert!((from_s - (10.0 - half_s)).abs() < 1e-9 && (to_s - (10.0 + half_s)).abs() < 1e-9, "{from_s} {to_s}");
        assert_eq!(beam.near_s(&sight, &velocity, 30.0, 1.0), None);
        // The object is there only 10 s later, and not behind the observer.
        assert_eq!(beam.near_s(&sight, &velocity, 4.0, 10.0), None);
        assert_eq!(beam.near_s(&-sight, &velocity, 30.0, 10.0), None);
        let wide = Beam::new(Vector3::z(), 1.0);
        assert_eq!(wide.near_s(&sight, &velocity, 30.0, 10.0), Some([-30.0, 30.0]));
        assert_eq!(wide.near_s(&-sight, &velocity, 30.0, 10.0), None);
    }

    /// Phase of an orbit in the plane x, y with its perigee on the x axis, and a longitude at the time 1000 s.
    fn phase(semi_major_axis_km: f64, eccentricity: f32, longitude_rad: f64, slop_km: f32) -> Phase {
        let rate_rad_s = (WGS72_MU_KM3_S2 / semi_major_axis_km.powi(3)).sqrt();
        Phase {
            element_index: 0,
            reference: [1.0, 0.0, 0.0],
            mean_longitude_rad: longitude_rad - 1000.0 * rate_rad_s,
            mean_longitude_rate_rad_s: rate_rad_s,
            eccentricity: [eccentricity, 0.0],
            eccentricity_change: [0.0; 2],
            semi_major_axis_km: semi_major_axis_km as f32,
            semi_major_axis_change_km: 0.0,
            slop_km,
            along_track_s: 300.0,
            swing_rad: 0.0,
            only_plane: false,
        }
    }

    /// The interval of a satellite that may be 300 s late contains all times at which its predicted position is inside
    /// the cone, also near the perigee of an eccentric orbit, where gravity is larger than in the middle of the time.
    /// On a circular orbit it is hardly longer: a tangent over 300 s alone would leave minutes.
    #[test]
    fn verif_large_delays_leave_a_short_interval() {
        let normal = |_| Vector3::z();
        let identity = Rotation::from_matrix(nalgebra::Matrix3::identity());
        for (semi_major_axis_km, eccentricity, slop_km) in
            [(6928.0, 0.0, 1.0), (6928.0, 0.001, 30.0), (11_528.0, 0.42, 1.0), (24_421.0, 0.727, 1.0)]
        {
            let mut found = 0;
            for step in 0..400 {
                let phase = phase(semi_major_axis_km, eccentricity, f64::from(step) / 400.0 * 0.8 - 0.4, slop_km);
                let cone = Cone {
                    mid_s: 1000.0,
                    half_duration_s: 15.0,
                    observer: Position::from_vector(Vector3::new(6378.0, 0.0, 0.0)),
                    observer_speed_km_s: 0.46,
                    axis: Direction::from_vector(Vector3::new(0.8, 0.6, 0.0)),
                    radius_rad: 0.03,
                };
                let test = ConeTest::new(&cone, &identity, 6.0 * 3600.0, SearchScope::Delayed);
                let is_inside = |time_s: &f64| {
                    let (position, _) = phase.state(&Vector3::z(), 1000.0 + time_s, 0.0);
                    let sight = position - test.observer;
                    sight.angle(test.axis()) < cone.radius_rad
                };
                let inside_s: Vec<f64> = (-315..=315).map(f64::from).filter(is_inside).collect();
                let passage = test.inside(&phase, normal, None);
                let (Some(first_s), Some(last_s)) = (inside_s.first(), inside_s.last()) else { continue };
                found += 1;
                let [from_s, to_s] = passage.unwrap_or_else(|| panic!("{phase:?} is lost")).near_s;
                assert!(from_s <= first_s + 1e-6 && last_s - 1e-6 <= to_s, "{inside_s:?}: {from_s} to {to_s}");
                if eccentricity < 0.1 {
                    let margin_s = 5.0 + 3.0 * f64::from(slop_km);
                    assert!(to_s - from_s < last_s - first_s + margin_s, "{inside_s:?}: {from_s} to {to_s}");
                }
            }
            assert!(found > 20, "{found}");
        }
    }

    #[test]
    fn a_position_is_inside_only_with_its_whole_error() {
        let shadow = ShadowConeInTeme { away_from_sun: Vector3::x(), radius_km: 6300.0, narrowing: 0.01 };
        let at = |depth_km: f64, across_km: f64| Vector3::new(depth_km, 0.6 * across_km, -0.8 * across_km);
        assert!(shadow.holds(&at(3000.0, 6100.0), 50.0));
        assert!(!shadow.holds(&at(3000.0, 6100.0), 200.0));
        assert!(!shadow.holds(&at(20_000.0, 6150.0), 0.0));
        // On the sunlit side of the Earth's centre, or nearly.
        assert!(!shadow.holds(&at(-3000.0, 100.0), 0.0));
        assert!(!shadow.holds(&at(40.0, 100.0), 50.0));
    }
}

//! placeholder
use crate::catalogue::ElementSet;
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum OrbitClass {
    OnStation,
}
impl OrbitClass {
    pub fn of(_e: &ElementSet) -> Self {
        Self::OnStation
    }
}
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct OrbitUncertainty {
    pub along_track_s: f64,
    pub cross_track_km: f64,
}
pub fn uncertainty(_c: OrbitClass, age_days: f64) -> OrbitUncertainty {
    OrbitUncertainty { along_track_s: 0.13 + 0.05 * age_days.abs(), cross_track_km: 0.3 }
}

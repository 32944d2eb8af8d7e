//! Altitudes in a column of a schedule, which show whether it was made for the site.

use super::horizon::altitude_rad;
use super::scheduled::Schedule;
use crate::frames::{EopTable, OrientationTable, seconds_after};
use crate::math::quantile::median;
use crate::passes::Viewpoint;

/// Largest median difference of altitudes, degrees. Simulations neglect precession (0.4 deg), and others include
/// refraction (0.5 deg at the horizon).
const LARGEST_DIFFERENCE_DEG: f64 = 1.0;

impl Schedule {
    /// Returns a warning if the altitudes in the schedule are those of another site; `None` for a telescope in orbit, or
    /// if the schedule has none.
    #[doc(hidden)]
    pub fn altitude_warning(&self, viewpoint: &Viewpoint, eop: &EopTable) -> Option<String> {
        let site = viewpoint.site()?.site();
        let differences = self.stated_altitudes.iter().map(|(exposure, stated_deg)| {
            // The time in the exposure to which the altitude belongs is unknown.
            let end = seconds_after(exposure.start, exposure.duration_s);
            let earth = OrientationTable::new(exposure.start, end, eop);
            let at = |share: f64| altitude_rad(exposure, viewpoint, &earth, share * exposure.duration_s).to_degrees();
            [0.0, 0.5, 1.0].map(|share| (at(share) - stated_deg).abs()).into_iter().fold(f64::INFINITY, f64::min)
        });
        let median_deg = median(differences.collect());
        (median_deg > LARGEST_DIFFERENCE_DEG).then(|| {
            format!(
                "the altitudes in the schedule differ from those at {} by {median_deg:.1} deg (median of {} exposures): its \
                 site or its times are probably others",
                site.name,
                self.stated_altitudes.len()
            )
        })
    }
}

//! Query for passes through a field over many exposures, and its results.

use rayon::prelude::*;

use super::super::candidates::CandidateInterval;
use super::super::exposure::{Exposure, groups};
use super::super::field::Field;
use super::super::scene::{Scene, middle_of_window, window_number};
use super::super::sky::Sky;
use super::super::track::Pass;
use super::exposed_field::ExposedField;
use super::options::PassOptions;
use crate::error::Error;
use crate::orbit::{CrossingCandidate, LeftOut, SearchScope};

/// Passes through a field, grouped by exposure.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Passes {
    /// Passes of each exposure in order of entry; exposures are in the order given.
    pub by_exposure: Vec<Vec<Pass>>,
    /// Satellites without a position in at least one of the exposures, without repetition, in catalogue order.
    /// Positions are not computed while the field is below the ground.
    pub left_out: Vec<LeftOut>,
}

impl Sky {
    /// Finds all satellites that cross the field in each exposure, on all threads of the current pool.
    ///
    /// Exposures may be in any order and last from zero to days; the exposures of one night share data that are
    /// computed once. The result does not depend on the number of threads. A satellite that returns to the field (in an
    /// exposure of hours) has a separate pass each time.
    ///
    /// # Errors
    /// An exposure has no finite direction or length, or lies outside the years of the Sun's ephemeris,
    /// or if the elements of a telescope in orbit give no position.
    pub fn field_passes(&self, exposures: &[Exposure], field: &Field, options: &PassOptions) -> Result<Passes, Error> {
        self.field_passes_until(exposures, field, options, |_, _| false)
    }

    /// Finds passes as [`Sky::field_passes`] until there are enough for each exposure: `is_enough` is called with the
    /// index of an exposure and its passes in any order, whenever their number has doubled.
    pub(crate) fn field_passes_until(
        &self,
        exposures: &[Exposure],
        field: &Field,
        options: &PassOptions,
        is_enough: impl Fn(usize, &[Pass]) -> bool + Sync,
    ) -> Result<Passes, Error> {
        let scope = if options.min_probability.is_some() { SearchScope::Delayed } else { SearchScope::Nominal };
        let (by_exposure, left_out) = self.by_exposure(exposures, scope, |scene, (index, exposure), seen| {
            let exposed = ExposedField::new(self, scene, exposure, field)?;
            let (mut passes, left_out) = exposed.evaluate(
                options.with_shadow(),
                seen,
                |interval| exposed.pass(interval, options),
                |passes| is_enough(index, passes),
            )?;
            passes.sort_by(|a, b| a.enter.epoch.cmp(&b.enter.epoch).then(a.element_index.cmp(&b.element_index)));
            Ok((passes, left_out))
        })?;
        Ok(Passes { by_exposure, left_out })
    }

    /// Computes the passes of [`Sky::field_passes`] without the search for candidates: SGP4 is evaluated for every
    /// satellite over the whole time. This is the reference for the search, and thousands of times slower. Unlike
    /// [`Sky::field_passes`], it includes near misses of fields below the ground.
    ///
    /// # Errors
    /// The errors of [`Sky::field_passes`].
    pub fn field_passes_by_brute_force(
        &self,
        exposures: &[Exposure],
        field: &Field,
        options: &PassOptions,
    ) -> Result<Vec<Vec<Pass>>, Error> {
        exposures.iter().try_for_each(Exposure::check)?;
        exposures
            .par_iter()
            .map(|exposure| {
                let scene = self.scene_without_windows(exposure.start, exposure.duration_s);
                let exposed = ExposedField::new(self, &scene, exposure, field)?;
                let mut passes: Vec<Pass> = Vec::new();
                for element_index in
                    (0..self.elements().len()).filter(|&element_index| !self.is_observer(element_index))
                {
                    self.watch().check()?;
                    let sgp4 =
                        || self.too_old(element_index, middle_of_window(window_number(exposure.start))).is_none();
                    let over = self.propagator_over(exposure.start, element_index, [0.0, exposure.duration_s]);
                    if over.is_some_and(|propagator| propagator.has_ephemeris() || sgp4()) {
                        let interval = CandidateInterval::over(element_index, 0.0, exposure.duration_s);
                        passes.extend(exposed.pass(&interval, options).ok().flatten());
                    }
                }
                passes.sort_by(|a, b| a.enter.epoch.cmp(&b.enter.epoch).then(a.element_index.cmp(&b.element_index)));
                Ok(passes)
            })
            .collect()
    }

    /// Evaluates each exposure, with its index, with the function `of`, on all threads; exposures of one group share a
    /// scene. Returns the results for each exposure, and the satellites without a position.
    pub(super) fn by_exposure<T: Send>(
        &self,
        exposures: &[Exposure],
        scope: SearchScope,
        of: impl Fn(&Scene, (usize, &Exposure), &mut Vec<CrossingCandidate>) -> Result<(Vec<T>, Vec<LeftOut>), Error> + Sync,
    ) -> Result<(Vec<Vec<T>>, Vec<LeftOut>), Error> {
        exposures.iter().try_for_each(Exposure::check)?;
        let mut by_exposure: Vec<Vec<T>> = exposures.iter().map(|_| Vec::new()).collect();
        let mut left_out = self.left_out().to_vec();
        for group in groups(exposures) {
            let start = exposures[group[0]].start;
            let span_s = group.iter().map(|&index| exposures[index].end_s(start)).fold(0.0, f64::max);
            let scene = self.scene(start, span_s, scope)?;
            left_out.extend(scene.windows.iter().flat_map(|window| window.left_out()).cloned());
            let found = group
                .par_iter()
                .map_init(Vec::new, |seen, &index| {
                    self.watch().check()?;
                    Ok((index, of(&scene, (index, &exposures[index]), seen)?))
                })
                .collect::<Result<Vec<_>, Error>>()?;
            for (index, (of_one, without)) in found {
                by_exposure[index] = of_one;
                left_out.extend(without);
            }
        }
        left_out.sort_by_key(|left_out| left_out.element_index);
        left_out.dedup_by_key(|left_out| left_out.element_index);
        Ok((by_exposure, left_out))
    }
}

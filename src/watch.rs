//! Handle by which a caller stops a computation that runs in other threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, ErrorKind};

/// Handle to a running computation. All clones refer to the same computation.
///
/// Computations test it once per exposure, satellite or row of pixels, and then return an error of the kind
/// [`Cancelled`](ErrorKind::Cancelled). A
/// [`Sky`](crate::Sky) carries it to all of its queries ([`Sky::watched`](crate::Sky::watched)); other computations
/// have it as an argument.
///
/// ```
/// use streakcast::frames::parse_instant;
/// use streakcast::{Exposure, Field, Policy, Satellites, Site, Sky, Watch};
///
/// let start = "2026-08-14T23:36:25Z";
/// let sky = Sky::new(Satellites::synthetic("oneweb", parse_instant(start, None)?)?, Site::from_mpc("X05")?);
/// let watch = Watch::default();
/// let in_other_thread = watch.clone();
/// in_other_thread.stop();
/// let exposure = Exposure::new(start, 30.0, "14h53m36s", "-08d54m")?;
/// let error = sky.watched(&watch).judge(&exposure, &Field::circle_deg(3.5)?, &Policy::default()).unwrap_err();
/// assert_eq!(error.to_string(), "interrupted");
/// # Ok::<(), streakcast::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Watch {
    stopped: Arc<AtomicBool>,
}

impl Watch {
    /// Stops the computation. It cannot be continued.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Continues only if the computation is not stopped.
    ///
    /// # Errors
    /// An error of the kind [`Cancelled`](ErrorKind::Cancelled) after [`Watch::stop`].
    pub fn check(&self) -> Result<(), Error> {
        if self.stopped.load(Ordering::Relaxed) { Err(Error::new(ErrorKind::Cancelled, "interrupted")) } else { Ok(()) }
    }
}

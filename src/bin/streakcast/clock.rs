//! Clock of the machine.

use std::time::SystemTime;

use hifitime::Epoch;

/// Returns the present time.
pub fn now() -> Epoch {
    let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    // Unix time has days of 86400 s, without leap seconds.
    Epoch::from_unix_seconds(since_1970.as_secs_f64())
}

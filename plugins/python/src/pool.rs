//! Thread pool of the process. A forked child process has no threads of its parent, so that the pool of the parent
//! would block forever. The child creates a new pool.

use std::mem;
use std::process;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::PyResult;
use pyo3::exceptions::PyRuntimeError;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Process id of the process that created the pool, and the pool.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Returns the pool of this process: one thread per core, or RAYON_NUM_THREADS threads.
pub fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut kept = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let own = process::id();
    if let Some((process, pool)) = kept.as_ref()
        && *process == own
    {
        return Ok(pool.clone());
    }
    let pool = ThreadPoolBuilder::new().build().map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let pool = Arc::new(pool);
    // The pool of the parent is not dropped: that would wait for threads that do not exist in this process.
    mem::forget(kept.replace((own, pool.clone())));
    Ok(pool)
}

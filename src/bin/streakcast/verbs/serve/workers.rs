//! Worker threads that compute responses, with a bounded queue, a time limit, and a cache of responses.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::body::Bytes;
use axum::http::header::RETRY_AFTER;
use quick_cache::{Weighter, unsync::Cache};
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use super::problem::Problem;

/// Largest number of requests that wait while all workers are busy.
const MAX_WAITING: usize = 256;
/// Time limit for waiting and computing together.
const RESPONSE_TIMEOUT: Duration = Duration::from_secs(30);
/// Largest size of the cache, bytes.
const CACHE_BYTES: u64 = 16 << 20;
/// Expected number of cached responses.
const CACHE_ENTRIES: usize = 1000;

/// Pool that computes responses and caches the last ones by path and query. The inputs of the server do not change, so
/// cached responses stay valid.
pub struct WorkerPool {
    /// Permits for requests that are waiting or being computed.
    queue: Semaphore,
    workers: Arc<Semaphore>,
    cache: Mutex<Cache<String, Bytes, ByteSize>>,
}

#[derive(Clone)]
struct ByteSize;

impl Weighter<String, Bytes> for ByteSize {
    fn weight(&self, target: &String, body: &Bytes) -> u64 {
        (target.len() + body.len()) as u64
    }
}

impl WorkerPool {
    pub fn new(workers: usize) -> Self {
        Self {
            queue: Semaphore::new(workers + MAX_WAITING),
            workers: Arc::new(Semaphore::new(workers)),
            cache: Mutex::new(Cache::with_weighter(CACHE_ENTRIES, CACHE_BYTES, ByteSize)),
        }
    }

    /// Returns the response for `target` (path and query) from the cache, or computes it with `work` on a worker
    /// thread.
    ///
    /// # Errors
    /// The error of `work`; status 503 if the queue is full or the time limit has passed; 500 if `work` panics.
    pub async fn response<W>(&self, target: &str, work: W) -> Result<Bytes, Problem>
    where
        W: FnOnce() -> Result<String, Problem> + Send + 'static,
    {
        if let Some(body) = self.cache().get(target) {
            return Ok(body.clone());
        }
        let _place = self.queue.try_acquire().map_err(|_| busy())?;
        let computed = timeout(RESPONSE_TIMEOUT, async {
            let worker = Arc::clone(&self.workers).acquire_owned().await;
            spawn_blocking(move || {
                // The permit is held until the computation ends, also if the request times out.
                let _worker = worker;
                work()
            })
            .await
        });
        let body: Bytes = match computed.await {
            Ok(Ok(body)) => body?.into(),
            Ok(Err(_)) => {
                return Err(Problem::new(500, "the response cannot be computed because of an error in the program"));
            }
            Err(_) => return Err(busy()),
        };
        self.cache().insert(target.to_owned(), body.clone());
        Ok(body)
    }

    fn cache(&self) -> MutexGuard<'_, Cache<String, Bytes, ByteSize>> {
        self.cache.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn busy() -> Problem {
    Problem::new(503, "the server is busy").with(RETRY_AFTER, "1")
}

#[cfg(test)]
mod tests {
    use std::future::poll_fn;
    use std::pin::Pin;
    use std::sync::mpsc;
    use std::task::Poll;

    use super::*;

    fn run(test: impl Future<Output = ()>) {
        tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap().block_on(test);
    }

    #[test]
    fn a_full_queue_is_refused_and_drains() {
        run(async {
            let pool = WorkerPool::new(1);
            let (release, blocked) = mpsc::channel::<()>();
            let first = pool.response("/first", move || {
                let _ = blocked.recv();
                Ok("first".to_owned())
            });
            let targets: Vec<String> = (0..MAX_WAITING).map(|number| format!("/{number}")).collect();
            let others = targets.iter().map(|target| pool.response(target, || Ok("other".to_owned())));
            type ResponseFuture<'a> = Pin<Box<dyn Future<Output = Result<Bytes, Problem>> + 'a>>;
            let mut waiting: Vec<ResponseFuture> = vec![Box::pin(first)];
            waiting.extend(others.map(|other| Box::pin(other) as ResponseFuture));
            for one in &mut waiting {
                assert!(poll_fn(|context| Poll::Ready(one.as_mut().poll(context))).await.is_pending());
            }
            let refused = pool.response("/one-more", || Ok(String::new())).await.unwrap_err();
            assert_eq!(refused.status, 503);
            assert_eq!(refused.response("/one-more").headers()["retry-after"], "1");
            release.send(()).unwrap();
            for one in waiting {
                assert!(one.await.is_ok());
            }
            assert_eq!(pool.response("/one-more", || Ok("now".to_owned())).await.unwrap(), "now");
        });
    }

    #[test]
    fn responses_are_computed_once_and_panics_are_errors() {
        run(async {
            let pool = WorkerPool::new(1);
            assert_eq!(pool.response("/a", || Ok("a".to_owned())).await.unwrap(), "a");
            assert_eq!(pool.response("/a", || panic!("computed again")).await.unwrap(), "a");
            let failed = pool.response("/b", || panic!("this panic is part of the test")).await.unwrap_err();
            assert_eq!(failed.status, 500);
            assert_eq!(pool.response("/b", || Ok("b".to_owned())).await.unwrap(), "b");
        });
    }
}

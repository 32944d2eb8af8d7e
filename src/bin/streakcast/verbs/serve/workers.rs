//! Worker threads that compute responses, with a bounded queue, time limits, and a cache of responses.
//!
//! Every computation starts in the fast lane. If it takes longer than [`FAST_LIMIT`] while no other place is free
//! there, it is stopped and started again in the slow lane, which has its own threads, so that long computations do not
//! delay short ones. A computation is also stopped when the client leaves.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::body::Bytes;
use axum::http::header::RETRY_AFTER;
use quick_cache::{Weighter, unsync::Cache};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use streakcast::Watch;
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use super::problem::Problem;

/// Largest number of requests that wait while all workers are busy.
const MAX_WAITING: usize = 256;
/// Longest computation in the fast lane while no other place is free there. Most take a few milliseconds.
const FAST_LIMIT: Duration = Duration::from_millis(500);
/// Longest computation.
const LONGEST: Duration = Duration::from_secs(20);
/// Time limit for waiting and computing together.
const RESPONSE_TIMEOUT: Duration = Duration::from_secs(30);
/// Largest size of the cache, bytes.
const CACHE_BYTES: u64 = 16 << 20;
/// Expected number of cached responses.
const CACHE_ENTRIES: usize = 1000;

/// The last responses, by path and query. They stay valid while the inputs of the server do not change.
pub struct ResponseCache(Mutex<Cache<String, Bytes, ByteSize>>);

impl Default for ResponseCache {
    fn default() -> Self {
        Self(Mutex::new(Cache::with_weighter(CACHE_ENTRIES, CACHE_BYTES, ByteSize)))
    }
}

impl ResponseCache {
    /// Returns a response, by a key that is not a path.
    pub fn get(&self, key: &str) -> Option<String> {
        String::from_utf8(self.cached().get(key)?.to_vec()).ok()
    }

    /// Keeps a response.
    pub fn insert(&self, key: String, response: &str) {
        self.cached().insert(key, Bytes::copy_from_slice(response.as_bytes()));
    }

    fn cached(&self) -> MutexGuard<'_, Cache<String, Bytes, ByteSize>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Pool that computes responses.
pub struct WorkerPool {
    /// Permits for requests that are waiting or being computed.
    queue: Semaphore,
    fast: Lane,
    slow: Lane,
}

#[derive(Clone)]
struct ByteSize;

impl Weighter<String, Bytes> for ByteSize {
    fn weight(&self, target: &String, body: &Bytes) -> u64 {
        (target.len() + body.len()) as u64
    }
}

impl WorkerPool {
    /// Creates a pool whose fast lane has `workers` threads and whose slow lane has half as many.
    ///
    /// # Errors
    /// The threads cannot be created.
    pub fn new(workers: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self {
            queue: Semaphore::new(workers + MAX_WAITING),
            fast: Lane::new(workers, workers, FAST_LIMIT)?,
            // One computation at a time, which bounds the memory.
            slow: Lane::new(1, (workers / 2).max(1), LONGEST)?,
        })
    }

    /// Returns the response for `target` (path and query) from the cache, or computes it with `work` on a worker
    /// thread. `work` must end soon after its watch is stopped. If it is slow, it is called twice.
    ///
    /// # Errors
    /// The error of `work`; status 503 if the queue is full or a time limit has passed; 500 if `work` panics.
    pub async fn response<W>(&self, cache: &ResponseCache, target: &str, work: W) -> Result<Bytes, Problem>
    where
        W: Fn(&Watch) -> Result<String, Problem> + Send + Sync + 'static,
    {
        if let Some(body) = cache.cached().get(target) {
            return Ok(body.clone());
        }
        let _place = self.queue.try_acquire().map_err(|_| busy())?;
        let work = Arc::new(work);
        let computed = timeout(RESPONSE_TIMEOUT, async {
            match self.fast.compute(&work).await {
                Some(result) => result,
                None => self.slow.compute(&work).await.unwrap_or_else(|| Err(busy())),
            }
        });
        let body: Bytes = computed.await.unwrap_or_else(|_| Err(busy()))?.into();
        cache.cached().insert(target.to_owned(), body.clone());
        Ok(body)
    }
}

/// Threads for a number of simultaneous computations.
struct Lane {
    places: Arc<Semaphore>,
    threads: Arc<ThreadPool>,
    /// Time after which a computation must leave if no other place is free.
    limit: Duration,
}

impl Lane {
    fn new(places: usize, threads: usize, limit: Duration) -> Result<Self, ThreadPoolBuildError> {
        let threads = Arc::new(ThreadPoolBuilder::new().num_threads(threads).build()?);
        Ok(Self { places: Arc::new(Semaphore::new(places)), threads, limit })
    }

    /// Computes `work` when a place is free. `None` if the computation had to leave the lane.
    async fn compute<W>(&self, work: &Arc<W>) -> Option<Result<String, Problem>>
    where
        W: Fn(&Watch) -> Result<String, Problem> + Send + Sync + 'static,
    {
        let place = Arc::clone(&self.places).acquire_owned().await;
        let stop = StopOnDrop(Watch::default());
        let (watch, work, threads) = (stop.0.clone(), Arc::clone(work), Arc::clone(&self.threads));
        let mut computing = spawn_blocking(move || {
            // The place is taken until the computation ends, also after it was stopped.
            let _place = place;
            threads.install(|| work(&watch))
        });
        let began = Instant::now();
        loop {
            match timeout(self.limit, &mut computing).await {
                Ok(Ok(result)) => return Some(result),
                Ok(Err(_)) => {
                    let detail = "the response cannot be computed because of an error in the program";
                    return Some(Err(Problem::new(500, detail)));
                }
                Err(_) if began.elapsed() >= LONGEST => return Some(Err(too_long())),
                Err(_) if self.places.available_permits() > 0 => {}
                Err(_) => return None,
            }
        }
    }
}

/// Stops a computation at its time limit, and when the client leaves: the future of its response is then dropped.
struct StopOnDrop(Watch);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.stop();
    }
}

fn busy() -> Problem {
    Problem::new(503, "the server is busy").with(RETRY_AFTER, "1")
}

fn too_long() -> Problem {
    let seconds = LONGEST.as_secs();
    let detail =
        format!("the computation was stopped after {seconds} s; allowed: a smaller request, or the command line");
    Problem::new(503, detail).with(RETRY_AFTER, "60")
}

#[cfg(test)]
mod tests {
    use std::future::poll_fn;
    use std::pin::Pin;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc;
    use std::task::Poll;

    use super::*;

    fn run(test: impl Future<Output = ()>) {
        tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap().block_on(test);
    }

    #[test]
    fn a_full_queue_is_refused_and_drains() {
        run(async {
            let (pool, cache) = (WorkerPool::new(1).unwrap(), ResponseCache::default());
            let (release, blocked) = mpsc::channel::<()>();
            let blocked = Mutex::new(blocked);
            let first = pool.response(&cache, "/first", move |_| {
                let _ = blocked.lock().unwrap().recv();
                Ok("first".to_owned())
            });
            let targets: Vec<String> = (0..MAX_WAITING).map(|number| format!("/{number}")).collect();
            let others = targets.iter().map(|target| pool.response(&cache, target, |_| Ok("other".to_owned())));
            type ResponseFuture<'a> = Pin<Box<dyn Future<Output = Result<Bytes, Problem>> + 'a>>;
            let mut waiting: Vec<ResponseFuture> = vec![Box::pin(first)];
            waiting.extend(others.map(|other| Box::pin(other) as ResponseFuture));
            for response in &mut waiting {
                assert!(poll_fn(|context| Poll::Ready(response.as_mut().poll(context))).await.is_pending());
            }
            let refused = pool.response(&cache, "/one-more", |_| Ok(String::new())).await.unwrap_err();
            assert_eq!(refused.status, 503);
            assert_eq!(refused.response("/one-more").headers()["retry-after"], "1");
            drop(release);
            for response in waiting {
                assert!(response.await.is_ok());
            }
            assert_eq!(pool.response(&cache, "/one-more", |_| Ok("now".to_owned())).await.unwrap(), "now");
        });
    }

    #[test]
    fn responses_are_computed_once_and_panics_are_errors() {
        run(async {
            let (pool, cache) = (WorkerPool::new(1).unwrap(), ResponseCache::default());
            assert_eq!(pool.response(&cache, "/a", |_| Ok("a".to_owned())).await.unwrap(), "a");
            assert_eq!(pool.response(&cache, "/a", |_| panic!("computed again")).await.unwrap(), "a");
            let failed = pool.response(&cache, "/b", |_| panic!("this panic is part of the test")).await.unwrap_err();
            assert_eq!(failed.status, 500);
            assert_eq!(pool.response(&cache, "/b", |_| Ok("b".to_owned())).await.unwrap(), "b");
        });
    }

    /// Computes until the watch stops it. A watch that does not stop fails the test.
    fn stopped(watch: &Watch) -> Result<String, Problem> {
        for _ in 0..60_000 {
            if watch.check().is_err() {
                return Err(busy());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("not stopped");
    }

    #[test]
    fn a_slow_computation_is_repeated_in_the_slow_lane() {
        run(async {
            let (pool, cache) = (WorkerPool::new(1).unwrap(), ResponseCache::default());
            let calls = Arc::new(AtomicUsize::new(0));
            let counted = Arc::clone(&calls);
            let work = move |watch: &Watch| match counted.fetch_add(1, Ordering::Relaxed) {
                0 => stopped(watch),
                _ => Ok("slow".to_owned()),
            };
            assert_eq!(pool.response(&cache, "/slow", work).await.unwrap(), "slow");
            assert_eq!(calls.load(Ordering::Relaxed), 2);
        });
    }

    #[test]
    fn a_computation_stops_when_the_client_leaves() {
        run(async {
            let (pool, cache) = (WorkerPool::new(1).unwrap(), ResponseCache::default());
            let (sender, ended) = mpsc::channel();
            let work = move |watch: &Watch| {
                let result = stopped(watch);
                let _ = sender.send(());
                result
            };
            let mut slow = Box::pin(pool.response(&cache, "/slow", work));
            let fast = async {
                // The first computation has left the fast lane when this one begins, and continues in the slow lane.
                while pool.slow.places.available_permits() > 0 {
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
                pool.response(&cache, "/fast", |_| Ok("fast".to_owned())).await
            };
            tokio::select! {
                _ = &mut slow => panic!("the computation does not end before it is stopped"),
                fast = fast => assert_eq!(fast.unwrap(), "fast"),
            }
            drop(slow);
            for _lane in ["fast", "slow"] {
                ended.recv_timeout(Duration::from_secs(60)).unwrap();
            }
        });
    }
}

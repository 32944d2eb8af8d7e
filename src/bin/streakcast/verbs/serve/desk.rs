//! Where the work is done: on threads of its own, so many at a time, so many waiting, and what was answered before is answered again.

use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use super::house::House;
use super::question::Question;
use super::reply::{Problem, Reply};
use super::routes::Route;

/// Questions that wait while others are answered.
const MOST_WAITING: usize = 256;
/// Waiting and computing together.
const LONGEST: Duration = Duration::from_secs(30);
/// What is kept of answers, bytes.
const KEPT_BYTES: usize = 16 << 20;

pub struct Desk {
    house: Arc<House>,
    places: Arc<Semaphore>,
    waiting: AtomicUsize,
    kept: Mutex<Kept>,
}

/// The last answers by path and query: nothing that they rest on ever changes.
#[derive(Default)]
struct Kept {
    replies: HashMap<Arc<str>, Reply>,
    oldest_first: VecDeque<Arc<str>>,
    bytes: usize,
}

impl Desk {
    pub fn new(house: House, workers: usize) -> Self {
        Self {
            house: Arc::new(house),
            places: Arc::new(Semaphore::new(workers.max(1))),
            waiting: AtomicUsize::new(0),
            kept: Mutex::default(),
        }
    }

    /// The answer to a question; `target` is its path and query.
    pub async fn ask(&self, route: &'static Route, question: Question, target: &str) -> Result<Reply, Problem> {
        if let Some(reply) = self.kept().replies.get(target) {
            return Ok(reply.clone());
        }
        let seat = Seat::take(&self.waiting).ok_or_else(busy)?;
        let work = async {
            let place = Arc::clone(&self.places).acquire_owned().await.map_err(|_| busy())?;
            drop(seat);
            let house = Arc::clone(&self.house);
            let answered = spawn_blocking(move || {
                // The place is held until the work is done, whether anybody still waits for it or not.
                let _place = place;
                catch_unwind(AssertUnwindSafe(|| (route.answer)(&house, &question)))
            });
            match answered.await {
                Ok(Ok(answer)) => answer,
                _ => Err(Problem::new(500, "the answer could not be computed: a fault of the program")),
            }
        };
        let answer = timeout(LONGEST, work).await.unwrap_or_else(|_| Err(busy()));
        if let Ok(reply) = &answer {
            self.kept().keep(target, reply);
        }
        answer
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn busy() -> Problem {
    Problem::new(503, "too much work is waiting").with("Retry-After", "1")
}

/// One that waits, counted until it is dropped.
struct Seat<'a>(&'a AtomicUsize);

impl<'a> Seat<'a> {
    fn take(waiting: &'a AtomicUsize) -> Option<Self> {
        let seat = Self(waiting);
        (waiting.fetch_add(1, Ordering::Relaxed) < MOST_WAITING).then_some(seat)
    }
}

impl Drop for Seat<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Kept {
    fn keep(&mut self, target: &str, reply: &Reply) {
        let bytes = target.len() + reply.body.len();
        if bytes > KEPT_BYTES / 8 || self.replies.contains_key(target) {
            return;
        }
        let target: Arc<str> = target.into();
        self.replies.insert(Arc::clone(&target), reply.clone());
        self.oldest_first.push_back(target);
        self.bytes += bytes;
        while self.bytes > KEPT_BYTES {
            let Some(oldest) = self.oldest_first.pop_front() else { break };
            if let Some(reply) = self.replies.remove(&oldest) {
                self.bytes -= oldest.len() + reply.body.len();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_stays_bounded() {
        let mut kept = Kept::default();
        let reply = Reply::json("x".repeat(1 << 20));
        for turn in 0..40 {
            kept.keep(&format!("/{turn}"), &reply);
            kept.keep(&format!("/{turn}"), &reply);
        }
        assert!(kept.bytes <= KEPT_BYTES && kept.replies.len() == kept.oldest_first.len());
        assert!(kept.replies.contains_key("/39") && !kept.replies.contains_key("/0"));
        kept.keep("/large", &Reply::json("x".repeat(KEPT_BYTES / 4)));
        assert!(!kept.replies.contains_key("/large"));
    }

    #[test]
    fn seats_are_given_back() {
        let waiting = AtomicUsize::new(0);
        let seats: Vec<_> = (0..MOST_WAITING).map(|_| Seat::take(&waiting).unwrap()).collect();
        assert!(Seat::take(&waiting).is_none());
        drop(seats);
        assert_eq!(waiting.load(Ordering::Relaxed), 0);
        assert!(Seat::take(&waiting).is_some());
    }
}

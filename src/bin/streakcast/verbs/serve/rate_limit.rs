//! Limit on the requests a second of each address.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Most addresses that are tracked; those without recent requests are dropped first.
const MAX_ADDRESSES: usize = 4096;
/// Requests that arrive within this time may come all at once.
const BURST: Duration = Duration::from_secs(1);

/// Generic cell rate algorithm: each request of an address moves its due time ahead by one interval, at most `BURST` ahead of now.
#[derive(Debug)]
pub struct RateLimiter {
    interval: Duration,
    due: Mutex<HashMap<IpAddr, Instant>>,
}

impl RateLimiter {
    pub fn new(requests_per_second: u32) -> Self {
        Self { interval: BURST / requests_per_second, due: Mutex::default() }
    }

    /// Counts a request.
    ///
    /// # Errors
    /// The time until the next request is allowed, if this one is not.
    pub fn check(&self, address: IpAddr, now: Instant) -> Result<(), Duration> {
        let mut due = self.due.lock().unwrap_or_else(PoisonError::into_inner);
        let network = network_of(address);
        if due.len() >= MAX_ADDRESSES && !due.contains_key(&network) {
            due.retain(|_, due| *due > now);
            if due.len() >= MAX_ADDRESSES {
                return Err(BURST);
            }
        }
        let due = due.entry(network).or_insert(now);
        let next = now.max(*due) + self.interval;
        let wait = next.saturating_duration_since(now + BURST);
        if wait > Duration::ZERO {
            return Err(wait);
        }
        *due = next;
        Ok(())
    }
}

/// The /64 network of an IPv6 address, which belongs to one customer as a rule; an IPv4 address itself.
fn network_of(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            IpAddr::from([a, b, c, d, 0, 0, 0, 0])
        }
        address => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_is_allowed_and_then_the_rate() {
        let limiter = RateLimiter::new(10);
        let (one, other): (IpAddr, IpAddr) = ("192.0.2.1".parse().unwrap(), "192.0.2.2".parse().unwrap());
        let begin = Instant::now();
        assert!((0..10).all(|_| limiter.check(one, begin).is_ok()));
        assert_eq!(limiter.check(one, begin), Err(Duration::from_millis(100)));
        assert!(limiter.check(other, begin).is_ok(), "addresses are counted separately");
        let later = begin + Duration::from_millis(150);
        assert!(limiter.check(one, later).is_ok() && limiter.check(one, later).is_err());
        let network: [IpAddr; 2] = ["2001:db8::1".parse().unwrap(), "2001:db8::2".parse().unwrap()];
        assert!((0..10).all(|turn| limiter.check(network[turn % 2], later).is_ok()));
        assert!(limiter.check(network[0], later).is_err());
    }

    #[test]
    fn the_number_of_addresses_is_bounded() {
        let limiter = RateLimiter::new(1);
        let begin = Instant::now();
        let address = |number: u32| IpAddr::from(number.to_be_bytes());
        let allowed = (0..10_000).filter(|number| limiter.check(address(*number), begin).is_ok()).count();
        assert_eq!((allowed, limiter.due.lock().unwrap().len()), (MAX_ADDRESSES, MAX_ADDRESSES));
        // Addresses without a request in the last second are dropped.
        assert!(limiter.check(address(20_000), begin + Duration::from_secs(2)).is_ok());
        assert_eq!(limiter.due.lock().unwrap().len(), 1);
    }
}

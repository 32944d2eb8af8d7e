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

    /// Counts a request and returns whether it is allowed. If not, one a second later is.
    pub fn allows(&self, address: IpAddr, now: Instant) -> bool {
        let mut due = self.due.lock().unwrap_or_else(PoisonError::into_inner);
        let network = network_of(address);
        if due.len() >= MAX_ADDRESSES && !due.contains_key(&network) {
            due.retain(|_, due| *due > now);
            if due.len() >= MAX_ADDRESSES {
                return false;
            }
        }
        let due = due.entry(network).or_insert(now);
        let next = now.max(*due) + self.interval;
        let is_allowed = next <= now + BURST;
        if is_allowed {
            *due = next;
        }
        is_allowed
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
        assert!((0..10).all(|_| limiter.allows(one, begin)));
        assert!(!limiter.allows(one, begin) && !limiter.allows(one, begin + Duration::from_millis(99)));
        assert!(limiter.allows(other, begin), "addresses are counted separately");
        let later = begin + Duration::from_millis(150);
        assert!(limiter.allows(one, later) && !limiter.allows(one, later));
        let network: [IpAddr; 2] = ["2001:db8::1".parse().unwrap(), "2001:db8::2".parse().unwrap()];
        assert!((0..10).all(|turn| limiter.allows(network[turn % 2], later)));
        assert!(!limiter.allows(network[0], later));
    }

    #[test]
    fn the_number_of_addresses_is_bounded() {
        let limiter = RateLimiter::new(1);
        let begin = Instant::now();
        let address = |number: u32| IpAddr::from(number.to_be_bytes());
        let allowed = (0..10_000).filter(|number| limiter.allows(address(*number), begin)).count();
        assert_eq!((allowed, limiter.due.lock().unwrap().len()), (MAX_ADDRESSES, MAX_ADDRESSES));
        // Addresses without a request in the last second are dropped.
        assert!(limiter.allows(address(20_000), begin + Duration::from_secs(2)));
        assert_eq!(limiter.due.lock().unwrap().len(), 1);
    }
}

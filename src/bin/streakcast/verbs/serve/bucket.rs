//! How often an address may ask: a bucket of tokens each, filled at a steady rate.

use std::collections::HashMap;
use std::net::IpAddr;
use std::time::{Duration, Instant};

/// Buckets that are kept; full ones are forgotten first.
const MOST: usize = 4096;

/// The buckets of all addresses.
#[derive(Debug)]
pub struct Buckets {
    /// Tokens a second, and the most that a bucket holds.
    rate: f64,
    kept: HashMap<IpAddr, Bucket>,
}

#[derive(Debug)]
struct Bucket {
    tokens: f64,
    filled: Instant,
}

impl Buckets {
    /// So many requests a second, and as many at once.
    pub fn new(rate: u32) -> Self {
        Self { rate: f64::from(rate), kept: HashMap::new() }
    }

    /// Takes a token, or tells how long until there is one.
    pub fn take(&mut self, address: IpAddr, now: Instant) -> Result<(), Duration> {
        let key = of_network(address);
        if self.kept.len() >= MOST && !self.kept.contains_key(&key) {
            let rate = self.rate;
            self.kept.retain(|_, bucket| bucket.filled_at(now, rate) < rate);
            if self.kept.len() >= MOST {
                return Err(Duration::from_secs(1));
            }
        }
        let bucket = self.kept.entry(key).or_insert(Bucket { tokens: self.rate, filled: now });
        bucket.tokens = bucket.filled_at(now, self.rate);
        bucket.filled = now;
        if bucket.tokens < 1.0 {
            return Err(Duration::from_secs_f64((1.0 - bucket.tokens) / self.rate));
        }
        bucket.tokens -= 1.0;
        Ok(())
    }
}

impl Bucket {
    fn filled_at(&self, now: Instant, rate: f64) -> f64 {
        (self.tokens + rate * now.saturating_duration_since(self.filled).as_secs_f64()).min(rate)
    }
}

/// A household of IPv6 has a /64: its addresses share a bucket.
fn of_network(address: IpAddr) -> IpAddr {
    match address {
        IpAddr::V6(address) if address.to_ipv4_mapped().is_none() => {
            let [a, b, c, d, ..] = address.segments();
            IpAddr::from([a, b, c, d, 0, 0, 0, 0])
        }
        other => other.to_canonical(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_empty_and_fill() {
        let mut buckets = Buckets::new(10);
        let (one, other): (IpAddr, IpAddr) = ("192.0.2.1".parse().unwrap(), "192.0.2.2".parse().unwrap());
        let begin = Instant::now();
        assert!((0..10).all(|_| buckets.take(one, begin).is_ok()));
        let wait = buckets.take(one, begin).unwrap_err();
        assert!((0.05..=0.1).contains(&wait.as_secs_f64()), "{wait:?}");
        assert!(buckets.take(other, begin).is_ok(), "one address does not wait for another");
        let later = begin + Duration::from_millis(150);
        assert!(buckets.take(one, later).is_ok() && buckets.take(one, later).is_err());
        let household: [IpAddr; 2] = ["2001:db8::1".parse().unwrap(), "2001:db8::2".parse().unwrap()];
        assert!((0..10).all(|turn| buckets.take(household[turn % 2], later).is_ok()));
        assert!(buckets.take(household[0], later).is_err());
    }

    #[test]
    fn no_crowd_of_addresses_fills_the_memory() {
        let mut buckets = Buckets::new(1);
        let begin = Instant::now();
        let address = |number: u32| IpAddr::from(number.to_be_bytes());
        let taken = (0..10_000).filter(|number| buckets.take(address(*number), begin).is_ok()).count();
        assert_eq!((taken, buckets.kept.len()), (MOST, MOST));
        // A second later all are full again, and forgotten.
        assert!(buckets.take(address(20_000), begin + Duration::from_secs(2)).is_ok());
        assert_eq!(buckets.kept.len(), 1);
    }
}

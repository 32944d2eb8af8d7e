//! RICE_1: differences of neighbours in blocks, each with as many plain low bits as suit it.
//!
//! FITS standard 4.0, section 10.4.1; R. Rice, P.-S. Yeh and W. Miller (1993, Proc. 9th AIAA Computing in Aerospace Conf.).

/// Sizes that go with the bytes of a pixel.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Rice {
    /// Pixels in a block (BLOCKSIZE).
    block: usize,
    /// Bits of a pixel.
    bits: u32,
    /// Bits that hold the number of plain bits.
    split_bits: u32,
    /// From this number of plain bits on differences stand as they are.
    split_most: u32,
}

impl Rice {
    /// From BLOCKSIZE and BYTEPIX; `None` for what the standard does not know.
    pub fn new(block: usize, bytes: usize) -> Option<Self> {
        let (split_bits, split_most) = match bytes {
            1 => (3, 6),
            2 => (4, 14),
            4 => (5, 25),
            _ => return None,
        };
        (block > 0).then_some(Self { block, bits: 8 * bytes as u32, split_bits, split_most })
    }

    fn mask(self) -> u64 {
        (1 << self.bits) - 1
    }

    /// A number of as many bits with its sign; bytes have none.
    fn signed(self, number: u64) -> i64 {
        match self.bits {
            8 => (number & 0xff) as i64,
            16 => i64::from(number as u16 as i16),
            _ => i64::from(number as u32 as i32),
        }
    }

    /// Unpacks `count` pixels; `None` where the bits end before.
    pub fn unpack(self, bytes: &[u8], count: usize) -> Option<Vec<i64>> {
        let mut bits = BitReader { bytes, at: 0 };
        let mut pixels = Vec::with_capacity(count);
        let mut last = bits.take(self.bits)?;
        while pixels.len() < count {
            let split = bits.take(self.split_bits)?;
            let in_block = self.block.min(count - pixels.len());
            for _ in 0..in_block {
                let folded = if split == 0 {
                    0
                } else if split == u64::from(self.split_most) + 1 {
                    bits.take(self.bits)?
                } else {
                    let plain = split as u32 - 1;
                    let high = bits.zeros()?;
                    (high << plain) | bits.take(plain)?
                };
                // 0, -1, 1, -2, 2, ... are folded to 0, 1, 2, 3, 4, ...
                let difference = if folded & 1 == 1 { !(folded >> 1) } else { folded >> 1 };
                last = last.wrapping_add(difference) & self.mask();
                pixels.push(self.signed(last));
            }
        }
        Some(pixels)
    }

    /// Packs pixels.
    pub fn pack(self, pixels: &[i64]) -> Vec<u8> {
        let mut bits = BitWriter::default();
        let Some(first) = pixels.first() else { return Vec::new() };
        let mut last = *first as u64 & self.mask();
        bits.put(last, self.bits);
        for block in pixels.chunks(self.block) {
            let mut folded = Vec::with_capacity(block.len());
            for pixel in block {
                let pixel = *pixel as u64 & self.mask();
                let difference = pixel.wrapping_sub(last) & self.mask();
                let is_negative = difference >> (self.bits - 1) == 1;
                let doubled = (difference << 1) & self.mask();
                folded.push(if is_negative { !doubled & self.mask() } else { doubled });
                last = pixel;
            }
            let sum: u64 = folded.iter().sum();
            // As many plain bits as half of the mean difference has.
            let half = (sum as f64 - (block.len() / 2) as f64 - 1.0).max(0.0) / block.len() as f64;
            let plain = u64::BITS - ((half as u64) >> 1).leading_zeros();
            if plain >= self.split_most {
                bits.put(u64::from(self.split_most) + 1, self.split_bits);
                folded.iter().for_each(|number| bits.put(*number, self.bits));
            } else if plain == 0 && sum == 0 {
                bits.put(0, self.split_bits);
            } else {
                bits.put(u64::from(plain) + 1, self.split_bits);
                for number in folded {
                    bits.put_zeros(number >> plain);
                    bits.put(1, 1);
                    bits.put(number & ((1 << plain) - 1), plain);
                }
            }
        }
        bits.bytes
    }
}

struct BitReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl BitReader<'_> {
    fn bit(&mut self) -> Option<u64> {
        let byte = *self.bytes.get(self.at / 8)?;
        let bit = byte >> (7 - self.at % 8) & 1;
        self.at += 1;
        Some(u64::from(bit))
    }

    fn take(&mut self, count: u32) -> Option<u64> {
        let (mut number, mut left) = (0, count);
        while left > 0 {
            let byte = u64::from(*self.bytes.get(self.at / 8)?);
            let there = 8 - (self.at % 8) as u32;
            let now = there.min(left);
            number = number << now | byte >> (there - now) & ((1 << now) - 1);
            self.at += now as usize;
            left -= now;
        }
        Some(number)
    }

    /// Zeros before the next one, which is taken as well.
    fn zeros(&mut self) -> Option<u64> {
        let mut count = 0;
        while self.bit()? == 0 {
            count += 1;
        }
        Some(count)
    }
}

#[derive(Default)]
struct BitWriter {
    bytes: Vec<u8>,
    used: u32,
}

impl BitWriter {
    fn put(&mut self, number: u64, count: u32) {
        let mut left = count;
        while left > 0 {
            if self.used == 0 {
                self.bytes.push(0);
            }
            let room = 8 - self.used;
            let now = room.min(left);
            let part = (number >> (left - now) & ((1 << now) - 1)) as u8;
            if let Some(last) = self.bytes.last_mut() {
                *last |= part << (room - now);
            }
            self.used = (self.used + now) % 8;
            left -= now;
        }
    }

    fn put_zeros(&mut self, mut count: u64) {
        while count > 0 {
            let now = count.min(32);
            self.put(0, now as u32);
            count -= now;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_pixels_come_back() {
        for (bytes, low, high) in [(1, 0, 255), (2, -32_768, 32_767), (4, -2_147_483_648, 2_147_483_647)] {
            let rice = Rice::new(32, bytes).unwrap();
            let mut state = 7u64;
            let mut random = move |range: i64| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) as i64 % range
            };
            let noisy: Vec<i64> = (0..333).map(|_| (low + high) / 2 + random(20)).collect();
            let wild: Vec<i64> = (0..100).map(|index| if index % 3 == 0 { low } else { high - random(100) }).collect();
            let mut mixed = vec![5; 64];
            mixed.extend(&noisy);
            mixed.extend(&wild);
            for pixels in [noisy, wild, vec![low; 40], vec![high], mixed] {
                assert_eq!(rice.unpack(&rice.pack(&pixels), pixels.len()).unwrap(), pixels, "{bytes}");
            }
        }
    }

    #[test]
    fn verif_broken_bits_are_refused() {
        let rice = Rice::new(32, 2).unwrap();
        let packed = rice.pack(&(0..100).collect::<Vec<i64>>());
        assert_eq!(rice.unpack(&packed[..packed.len() - 4], 100), None);
        assert_eq!(rice.unpack(&[], 1), None);
        assert_eq!(Rice::new(32, 3), None);
    }
}

//! Chance from one number. Each purpose draws from a stream of its own, so that one draw more or less in one place moves
//! nothing elsewhere: what is left out of a failing schedule does not change the rest of it.

use std::sync::{Mutex, PoisonError};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rts_host::clock::Chance;

/// The number that a whole run follows from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Seed(pub u64);

impl Seed {
    /// The stream of this name.
    pub fn stream(self, name: &str) -> Stream {
        // FNV-1a: the same on every machine and in every version of the compiler.
        let fold = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        let name = name.as_bytes().iter().fold(0xcbf2_9ce4_8422_2325, fold);
        let mut rng = ChaCha8Rng::seed_from_u64(self.0);
        rng.set_stream(name);
        Stream(Mutex::new(rng))
    }
}

/// Draws in a row.
#[derive(Debug)]
pub struct Stream(Mutex<ChaCha8Rng>);

impl Stream {
    /// Draws with the generator.
    pub fn draw<T>(&self, draw: impl FnOnce(&mut ChaCha8Rng) -> T) -> T {
        draw(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// True with this probability, 0.0 to 1.0.
    pub fn chance(&self, probability: f64) -> bool {
        self.draw(|rng| rng.random_bool(probability.clamp(0.0, 1.0)))
    }

    /// A number from `low` to `high`, both included.
    pub fn between(&self, low: u64, high: u64) -> u64 {
        self.draw(|rng| rng.random_range(low..=high.max(low)))
    }

    /// One of these; none when there is none.
    pub fn pick<'a, T>(&self, of: &'a [T]) -> Option<&'a T> {
        let last = of.len().checked_sub(1)?;
        let at = self.draw(|rng| rng.random_range(0..=last));
        of.get(at)
    }
}

impl Chance for Stream {
    fn unit(&self) -> f64 {
        self.draw(|rng| rng.random())
    }

    fn uuid(&self) -> String {
        let bytes = self.draw(|rng| rng.random());
        uuid::Builder::from_random_bytes(bytes)
            .into_uuid()
            .to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_depends_on_seed_and_name_alone() {
        let uuids = |seed: u64, name: &str| {
            let stream = Seed(seed).stream(name);
            [stream.uuid(), stream.uuid()]
        };
        assert_eq!(uuids(1, "net"), uuids(1, "net"));
        assert_ne!(uuids(1, "net"), uuids(1, "disk"));
        assert_ne!(uuids(1, "net"), uuids(2, "net"));
        let [first, second] = uuids(1, "net");
        assert_ne!(first, second);
    }
}

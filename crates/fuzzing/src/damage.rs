//! Damage that is the same on every run.

/// `SplitMix64`.
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// A row of numbers.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number below `n`; 0 if there is none.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}

/// The bytes with a few faults: changed, cut out, repeated, cut short.
#[must_use]
pub fn damaged(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    // Headers are at the front, so faults are spread evenly over orders of magnitude.
    let place = |n: usize, dice: &mut Dice| {
        let reach = n >> dice.below(8);
        dice.below(reach.max(1)).min(n.saturating_sub(1))
    };
    for _ in 0..=dice.below(4) {
        let at = place(bytes.len(), dice);
        let end = (at + 1 + dice.below(8)).min(bytes.len());
        match dice.below(8) {
            0..=1 if at < bytes.len() => bytes[at] = dice.below(256) as u8,
            2..=3 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
            4 if at < bytes.len() => bytes[at] = [0, 0xff, 0x7f, 0x80][dice.below(4)],
            5 => drop(bytes.drain(at.min(end)..end)),
            6 => {
                let piece = bytes[at.min(end)..end].to_vec();
                bytes.splice(end..end, piece);
            }
            _ if dice.below(4) == 0 => bytes.truncate(at),
            _ => {}
        }
    }
    bytes
}

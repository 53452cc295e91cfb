//! Lights drawn in proportion to a weight, in constant time.
//!
//! Based on: Michael D. Vose, "A linear algorithm for generating random numbers with a given
//! distribution", 1991.
//! Deviations: a power of two of slots, each of 2^32 shares of whole numbers, so that 32 random bits
//! choose a slot and 32 more a light in it: a light is drawn with exactly the probability that is
//! stated, in every form. One that weighs anything has at least one share, however little it weighs.

use crate::{LightsError, sample::Random};
use bytemuck::{Pod, Zeroable};

/// Most lights: shares are then exact, and the heaviest light outweighs all rounding.
const MOST: usize = 1 << 24;

/// Shares of a slot.
const FULL: u64 = 1 << 32;

/// A slot: of 2^32 shares `own` are the light's of the slot's number, the rest another's. 16 bytes:
/// one load tells all that a draw needs.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Slot {
    /// Shares of the light of this number.
    pub own: u32,
    /// The light that has the rest.
    pub other: u32,
    /// One over the probability of the light of this number; 0 where it is never drawn.
    pub inverse_own: f32,
    /// One over the other's.
    pub inverse_other: f32,
}

/// What lights are drawn from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    /// At least 2; a power of two. Empty where no light weighs anything.
    pub slots: Vec<Slot>,
    /// 32 minus the binary logarithm of their number.
    pub shift: u32,
    /// Of each light; exact to the rounding of f64.
    pub probability: Vec<f64>,
}

impl Table {
    /// A table over weights that are finite and at least 0.
    ///
    /// # Errors
    /// More than 2^24 lights.
    pub fn new(weights: &[f64]) -> Result<Self, LightsError> {
        if weights.len() > MOST {
            let limit = format!("{} are more than 2^24 that can be drawn from", weights.len());
            return Err(LightsError::value("lights", limit));
        }
        let greatest = weights.iter().copied().fold(0.0, f64::max);
        if greatest == 0.0 {
            return Ok(Self { probability: vec![0.0; weights.len()], ..Self::default() });
        }
        let slots = weights.len().next_power_of_two().max(2);
        let all = slots as u64 * FULL;
        let shares = shares(weights, greatest, all);
        let probability: Vec<_> = shares.iter().map(|share| *share as f64 / all as f64).collect();
        let mut slots = fill(shares, slots);
        let inverse = |light: usize| match probability.get(light) {
            Some(p) if *p > 0.0 => (1.0 / p) as f32,
            _ => 0.0,
        };
        for (place, slot) in slots.iter_mut().enumerate() {
            slot.inverse_own = inverse(place);
            slot.inverse_other = inverse(slot.other as usize);
        }
        Ok(Self { shift: 32 - slots.len().trailing_zeros(), slots, probability })
    }

    /// A light and one over its probability; two numbers of the stream. The table is not empty.
    #[inline]
    pub fn draw(&self, random: &mut Random) -> (u32, f32) {
        let place = random.bits() >> self.shift;
        let slot = self.slots[place as usize];
        if random.bits() < slot.own {
            (place, slot.inverse_own)
        } else {
            (slot.other, slot.inverse_other)
        }
    }

    /// Bytes of the table.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.slots[..]) + size_of_val(&self.probability[..])) as u64
    }
}

/// Whole shares of `all`, in proportion to the weights; the heaviest takes what rounding leaves.
fn shares(weights: &[f64], greatest: f64, all: u64) -> Vec<u64> {
    // Scaled first: the sum of finite weights may not be finite.
    let sum: f64 = weights.iter().map(|w| w / greatest).sum();
    let share = |w: &f64| {
        let exact = w / greatest / sum * all as f64;
        if *w > 0.0 { (exact as u64).max(1) } else { 0 }
    };
    let mut shares: Vec<u64> = weights.iter().map(share).collect();
    let heaviest = (0..shares.len()).max_by_key(|i| (shares[*i], std::cmp::Reverse(*i)));
    if let Some(heaviest) = heaviest {
        // It has at least 2^32 (the mean over at most all slots); rounding and lifting to one share
        // moved fewer than 2^28 over 2^24 lights.
        let others: u64 = shares.iter().sum::<u64>() - shares[heaviest];
        shares[heaviest] = all.saturating_sub(others);
    }
    shares
}

fn fill(mut shares: Vec<u64>, slots: usize) -> Vec<Slot> {
    shares.resize(slots, 0);
    let whole = |other: u32| Slot { other, ..Slot::default() };
    let mut table: Vec<_> = (0..slots as u32).map(whole).collect();
    let (mut light, mut heavy): (Vec<_>, Vec<_>) = (0..slots).partition(|i| shares[*i] < FULL);
    // Every light slot is filled up by a heavy one; the sum of shares stays that of the slots left,
    // so there is a heavy one as long as there is a light one.
    while let (Some(small), Some(large)) = (light.pop(), heavy.last().copied()) {
        table[small] = Slot { own: shares[small] as u32, ..whole(large as u32) };
        shares[large] -= FULL - shares[small];
        if shares[large] < FULL {
            heavy.pop();
            light.push(large);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Shares of each light, counted over the slots.
    fn counted(table: &Table) -> Vec<u64> {
        let mut shares = vec![0; table.slots.len()];
        for (place, slot) in table.slots.iter().enumerate() {
            shares[place] += u64::from(slot.own);
            shares[slot.other as usize] += FULL - u64::from(slot.own);
        }
        shares
    }

    fn check(weights: &[f64]) {
        let table = Table::new(weights).unwrap();
        let sum: f64 = weights.iter().sum();
        let all = (table.slots.len() as u64 * FULL) as f64;
        let shares = counted(&table);
        assert!(shares[weights.len()..].iter().all(|s| *s == 0));
        for (light, weight) in weights.iter().enumerate() {
            assert_eq!(shares[light] as f64 / all, table.probability[light]);
            assert_eq!(shares[light] > 0, *weight > 0.0, "light {light}");
            let off = (shares[light] as f64 - weight / sum * all).abs();
            assert!(off <= 2.0 * weights.len() as f64 + 1e-12 * all, "light {light}: {off}");
        }
    }

    proptest! {
        #[test]
        fn shares_are_those_of_the_weights(
            weights in prop::collection::vec(
                prop_oneof![Just(0.0), 1e-30..1e-20, 0.0..1.0, 1e10..1e12], 1..70)
        ) {
            prop_assume!(weights.iter().any(|w| *w > 0.0));
            check(&weights);
        }
    }

    #[test]
    fn tables_of_one_two_and_alike_lights_are_exact() {
        for count in [1, 2, 3, 4, 5, 1000] {
            check(&vec![1.0; count]);
        }
        let table = Table::new(&[0.0, 3.0, 1.0]).unwrap();
        assert_eq!(table.probability, [0.0, 0.75, 0.25]);
    }

    #[test]
    fn a_light_next_to_nothing_is_still_drawn() {
        let table = Table::new(&[f64::MAX, 5e-324, f64::MAX]).unwrap();
        assert!(table.probability[1] > 0.0);
        assert_eq!(table.probability.iter().sum::<f64>(), 1.0);
        let mut weights = vec![1e-300; 1 << 20];
        weights[77] = 1.0;
        let table = Table::new(&weights).unwrap();
        assert_eq!(counted(&table).iter().filter(|s| **s > 0).count(), weights.len());
    }

    #[test]
    fn without_weight_nothing_can_be_drawn() {
        assert!(Table::new(&[]).unwrap().slots.is_empty());
        assert!(Table::new(&[0.0, 0.0]).unwrap().slots.is_empty());
        assert!(Table::new(&vec![1.0; MOST + 1]).is_err());
    }

    #[test]
    fn draws_follow_the_probabilities() {
        let table = Table::new(&[1.0, 2.0, 0.0, 4.0, 0.5]).unwrap();
        let mut random = Random::new(1, 2, 3);
        let mut counts = [0u32; 5];
        let all = 200_000;
        for _ in 0..all {
            let (light, inverse) = table.draw(&mut random);
            assert_eq!(inverse, (1.0 / table.probability[light as usize]) as f32);
            counts[light as usize] += 1;
        }
        // Chi-squared of 3 degrees of freedom: above 16.3 once in 1000.
        let chi: f64 = (0..5)
            .filter(|i| table.probability[*i] > 0.0)
            .map(|i| {
                let expected = table.probability[i] * f64::from(all);
                (f64::from(counts[i]) - expected).powi(2) / expected
            })
            .sum();
        assert!(chi < 16.3 && counts[2] == 0, "{chi} {counts:?}");
    }
}

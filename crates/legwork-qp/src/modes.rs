//! The last optimal working set of each of a few modes: with a foot on the ground other limits are met than without.

use crate::working_set::Member;

/// Modes that are remembered.
pub(crate) const CAPACITY: usize = 8;

#[derive(Clone, Debug)]
struct Slot {
    key: u64,
    last_used: u64,
    members: Vec<Member>,
}

/// A small map in which the mode that was not used for longest makes room for a new one.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    slots: Vec<Slot>,
    current: Option<usize>,
    clock: u64,
}

impl Modes {
    /// For working sets of up to `n` members.
    pub(crate) fn new(n: usize) -> Self {
        let slot = |_| Slot { key: 0, last_used: 0, members: Vec::with_capacity(n) };
        Self { slots: (0..CAPACITY).map(slot).collect(), current: None, clock: 0 }
    }

    /// Makes `key` the mode of what follows. If that is a change to a mode that is known: its working set.
    pub(crate) fn select(&mut self, key: u64) -> Option<&[Member]> {
        self.clock += 1;
        let known = self.slots.iter().position(|slot| slot.last_used > 0 && slot.key == key);
        let position = known.unwrap_or_else(|| {
            let oldest = (0..CAPACITY).min_by_key(|&k| self.slots[k].last_used).unwrap_or(0);
            self.slots[oldest].key = key;
            self.slots[oldest].members.clear();
            oldest
        });
        self.slots[position].last_used = self.clock;
        let changed = self.current.replace(position) != Some(position);
        (known.is_some() && changed).then(|| &self.slots[position].members[..])
    }

    /// Keeps the optimal working set of the current mode, if one is selected.
    pub(crate) fn keep(&mut self, members: &[Member]) {
        if let Some(current) = self.current {
            self.slots[current].members.clear();
            self.slots[current].members.extend_from_slice(members);
        }
    }

    pub(crate) fn forget(&mut self) {
        self.current = None;
        self.slots.iter_mut().for_each(|slot| slot.last_used = 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mode_not_used_for_longest_makes_room() {
        let member = |c: u64| Member { c: c as usize, sign: 1.0 };
        let mut modes = Modes::new(3);
        modes.keep(&[member(99)]);
        for key in 0..CAPACITY as u64 {
            assert_eq!(modes.select(key), None);
            modes.keep(&[member(key)]);
        }
        // The same again is no change.
        assert_eq!(modes.select(CAPACITY as u64 - 1), None);
        assert_eq!(modes.select(0), Some(&[member(0)][..]));
        // Mode 1 is the oldest now.
        assert_eq!(modes.select(100), None);
        assert_eq!(modes.select(2), Some(&[member(2)][..]));
        assert_eq!(modes.select(1), None);
        modes.forget();
        assert_eq!(modes.select(2), None);
    }
}

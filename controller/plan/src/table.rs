//! Maps whose keys are numbered from 0: a lookup is one step, whatever the number of entries.

/// A key with its number.
pub(crate) trait Numbered: Copy {
    /// Its place in a [`Table`].
    fn number(&self) -> usize;
}

/// A map from numbered keys, in the order of their numbers. It takes room up to the highest number that was inserted.
#[derive(Debug, Clone)]
pub(crate) struct Table<K, V> {
    slots: Vec<Option<(K, V)>>,
    len: usize,
}

impl<K, V> Default for Table<K, V> {
    fn default() -> Self {
        Self {
            slots: Vec::new(),
            len: 0,
        }
    }
}

impl<K: Numbered, V> Table<K, V> {
    pub fn get(&self, key: &K) -> Option<&V> {
        let slot = self.slots.get(key.number())?;
        slot.as_ref().map(|(_, value)| value)
    }

    pub fn contains_key(&self, key: &K) -> bool {
        self.get(key).is_some()
    }

    pub fn insert(&mut self, key: K, value: V) {
        let slot = self.slot(key);
        let new = slot.replace((key, value)).is_none();
        self.len += usize::from(new);
    }

    pub fn remove(&mut self, key: &K) -> Option<V> {
        let (_, value) = self.slots.get_mut(key.number())?.take()?;
        self.len -= 1;
        Some(value)
    }

    /// The value of a key, which is made when there is none.
    pub fn or_insert_with(&mut self, key: K, make: impl FnOnce() -> V) -> &mut V {
        self.len += usize::from(!self.contains_key(&key));
        let (_, value) = self.slot(key).get_or_insert_with(|| (key, make()));
        value
    }

    /// Makes room for so many numbers at once.
    pub fn reserve(&mut self, numbers: usize) {
        self.slots.reserve(numbers);
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub fn iter(&self) -> impl Iterator<Item = (&K, &V)> {
        let filled = if self.is_empty() {
            &[]
        } else {
            self.slots.as_slice()
        };
        filled.iter().flatten().map(|(key, value)| (key, value))
    }

    pub fn keys(&self) -> impl Iterator<Item = &K> {
        self.iter().map(|(key, _)| key)
    }

    pub fn values(&self) -> impl Iterator<Item = &V> {
        self.iter().map(|(_, value)| value)
    }

    fn slot(&mut self, key: K) -> &mut Option<(K, V)> {
        let number = key.number();
        if self.slots.len() <= number {
            self.slots.resize_with(number + 1, || None);
        }
        &mut self.slots[number]
    }
}

impl<K: Numbered, V: Default> Table<K, V> {
    pub fn or_default(&mut self, key: K) -> &mut V {
        self.or_insert_with(key, V::default)
    }
}

impl<K: Numbered, V> std::ops::Index<&K> for Table<K, V> {
    type Output = V;

    fn index(&self, key: &K) -> &V {
        match self.get(key) {
            Some(value) => value,
            None => panic!("no entry of number {}", key.number()),
        }
    }
}

impl<K: Numbered, V> Extend<(K, V)> for Table<K, V> {
    fn extend<T: IntoIterator<Item = (K, V)>>(&mut self, entries: T) {
        for (key, value) in entries {
            self.insert(key, value);
        }
    }
}

impl<K: Numbered, V> FromIterator<(K, V)> for Table<K, V> {
    fn from_iter<T: IntoIterator<Item = (K, V)>>(entries: T) -> Self {
        let mut table = Self::default();
        table.extend(entries);
        table
    }
}

impl<K: Numbered, V> IntoIterator for Table<K, V> {
    type Item = (K, V);
    type IntoIter = std::iter::Flatten<std::vec::IntoIter<Option<(K, V)>>>;

    fn into_iter(self) -> Self::IntoIter {
        self.slots.into_iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::{Numbered, Table};

    impl Numbered for u8 {
        fn number(&self) -> usize {
            usize::from(*self)
        }
    }

    proptest! {
        /// It does what a sorted map does.
        #[test]
        fn is_a_map(ops in prop::collection::vec((any::<bool>(), 0..20u8, any::<u32>()), 0..60)) {
            let (mut table, mut map) = (Table::default(), BTreeMap::new());
            for (insert, key, value) in ops {
                if insert {
                    table.insert(key, value);
                    map.insert(key, value);
                } else {
                    prop_assert_eq!(table.remove(&key), map.remove(&key));
                }
                prop_assert_eq!(table.len(), map.len());
                prop_assert_eq!(table.get(&key), map.get(&key));
            }
            prop_assert!(table.iter().eq(map.iter()));
        }
    }
}

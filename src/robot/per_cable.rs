//! One value per cable, for any number of cables, without the heap.

use std::fmt;
use std::ops::{Deref, DerefMut};

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A rig has at most as many cables as this.
pub const MOST_CABLES: usize = 16;

/// One value per cable, in the order of the cable numbers 1 to n, n ≤ [`MOST_CABLES`]. It reads like a slice of length n and copies like an
/// array.
#[derive(Clone, Copy)]
pub struct PerCable<T> {
    count: usize,
    /// Those from `count` on are the default, and nobody sees them.
    values: [T; MOST_CABLES],
}

impl<T: Copy + Default> PerCable<T> {
    /// What `value` gives for each cable, counted from 0.
    ///
    /// # Panics
    /// If `count` is greater than [`MOST_CABLES`].
    pub fn from_fn(count: usize, mut value: impl FnMut(usize) -> T) -> Self {
        assert!(count <= MOST_CABLES, "{count} cables: at most {MOST_CABLES} are supported");
        let mut values = [T::default(); MOST_CABLES];
        values[..count].iter_mut().enumerate().for_each(|(i, v)| *v = value(i));
        Self { count, values }
    }

    /// The same value for each of `count` cables.
    ///
    /// # Panics
    /// As [`Self::from_fn`].
    pub fn filled(count: usize, value: T) -> Self {
        Self::from_fn(count, |_| value)
    }

    /// `None` if there are more than [`MOST_CABLES`].
    pub fn from_slice(values: &[T]) -> Option<Self> {
        (values.len() <= MOST_CABLES).then(|| Self::from_fn(values.len(), |i| values[i]))
    }

    /// Each value changed by `f`.
    pub fn map<U: Copy + Default>(&self, mut f: impl FnMut(T) -> U) -> PerCable<U> {
        PerCable::from_fn(self.count, |i| f(self.values[i]))
    }
}

impl<T> Deref for PerCable<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.values[..self.count]
    }
}

impl<T> DerefMut for PerCable<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.values[..self.count]
    }
}

impl<T> IntoIterator for PerCable<T> {
    type Item = T;
    type IntoIter = std::iter::Take<std::array::IntoIter<T, MOST_CABLES>>;

    fn into_iter(self) -> Self::IntoIter {
        self.values.into_iter().take(self.count)
    }
}

impl<'a, T> IntoIterator for &'a PerCable<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: PartialEq> PartialEq for PerCable<T> {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl<T: PartialEq, const N: usize> PartialEq<[T; N]> for PerCable<T> {
    fn eq(&self, other: &[T; N]) -> bool {
        self[..] == other[..]
    }
}

impl<T: fmt::Debug> fmt::Debug for PerCable<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self[..].fmt(f)
    }
}

impl<T: Copy + Default, const N: usize> From<[T; N]> for PerCable<T> {
    fn from(values: [T; N]) -> Self {
        const { assert!(N <= MOST_CABLES) };
        Self::from_fn(N, |i| values[i])
    }
}

impl<T: Serialize> Serialize for PerCable<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self[..].serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de> + Copy + Default> Deserialize<'de> for PerCable<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Values<T>(PerCable<T>);

        impl<'de, T: Deserialize<'de> + Copy> Visitor<'de> for Values<T> {
            type Value = PerCable<T>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "at most {MOST_CABLES} values, one per cable")
            }

            fn visit_seq<A: SeqAccess<'de>>(mut self, mut sequence: A) -> Result<Self::Value, A::Error> {
                while let Some(value) = sequence.next_element()? {
                    if self.0.count == MOST_CABLES {
                        return Err(A::Error::invalid_length(MOST_CABLES + 1, &self));
                    }
                    self.0.values[self.0.count] = value;
                    self.0.count += 1;
                }
                Ok(self.0)
            }
        }

        deserializer.deserialize_seq(Values(Self::from_fn(0, |_| T::default())))
    }
}

/// Some of the cables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CableSet(u32);

impl CableSet {
    /// Their numbers, from 1, in order.
    pub fn numbers(self) -> impl Iterator<Item = usize> {
        (1..=MOST_CABLES).filter(move |number| self.contains(*number))
    }

    /// Whether the cable with this number, from 1, is one of them.
    pub fn contains(self, number: usize) -> bool {
        (1..=MOST_CABLES).contains(&number) && self.0 >> (number - 1) & 1 == 1
    }

    /// How many there are.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl FromIterator<usize> for CableSet {
    /// Of numbers from 1; others are left out.
    fn from_iter<I: IntoIterator<Item = usize>>(numbers: I) -> Self {
        let known = numbers.into_iter().filter(|number| (1..=MOST_CABLES).contains(number));
        Self(known.fold(0, |set, number| set | 1 << (number - 1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_as_many_as_there_are_cables() {
        let eight = PerCable::from_fn(8, |i| i as f64);
        assert_eq!(eight.len(), 8);
        assert_eq!(eight.map(|x| 2.0 * x)[7], 14.0);
        assert_eq!(eight.into_iter().sum::<f64>(), 28.0);
        assert!(PerCable::from_slice(&[0.0; 17]).is_none());
        assert_ne!(PerCable::filled(6, 1.0), PerCable::filled(7, 1.0));
    }

    #[test]
    fn is_read_back_from_a_saved_state_and_never_overflows() {
        let saved = PerCable::from([1.5, 2.5, 3.5]);
        let bytes = postcard::to_stdvec(&saved).unwrap();
        assert_eq!(postcard::from_bytes::<PerCable<f64>>(&bytes).unwrap(), saved);
        let too_many = postcard::to_stdvec(&vec![0.0; 17]).unwrap();
        assert!(postcard::from_bytes::<PerCable<f64>>(&too_many).is_err());
    }
}

//! Memory that threads work in, kept from frame to frame.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// One of something for each thread of the pool that it was made in.
#[derive(Debug)]
pub(crate) struct Pool<T>(Vec<Mutex<T>>);

impl<T> Pool<T> {
    /// With so many threads as there are.
    pub(crate) fn new(mut make: impl FnMut() -> T) -> Self {
        Self((0..rayon::current_num_threads().max(1)).map(|_| Mutex::new(make())).collect())
    }

    /// With so many threads as there are, by what may fail.
    pub(crate) fn try_new<E>(mut make: impl FnMut() -> Result<T, E>) -> Result<Self, E> {
        let threads = rayon::current_num_threads().max(1);
        (0..threads).map(|_| make().map(Mutex::new)).collect::<Result<_, E>>().map(Self)
    }

    /// That of the current thread, until what is returned is dropped. It holds what was left in it. No
    /// parallel work may be begun meanwhile: the thread would take up other work that waits for this.
    pub(crate) fn own(&self) -> MutexGuard<'_, T> {
        let thread = rayon::current_thread_index().unwrap_or(0);
        // It is overwritten before it is read: a panic elsewhere leaves nothing to distrust.
        self.0[thread % self.0.len()].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// All of them, while no thread works.
    pub(crate) fn all(&self) -> impl Iterator<Item = MutexGuard<'_, T>> {
        self.0.iter().map(|own| own.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }
}

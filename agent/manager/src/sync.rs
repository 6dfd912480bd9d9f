//! Locks that survive a panic: what they protect is plain data, valid after every statement.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks, whatever another thread did while it held the lock.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

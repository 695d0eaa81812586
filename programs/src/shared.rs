//! What a program works on, shared with the values that it was handed.

use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Shared work.
pub(crate) type Shared<T> = Arc<RwLock<T>>;

/// To read it; what a panic left is read as it is.
pub(crate) fn read<T>(work: &Shared<T>) -> RwLockReadGuard<'_, T> {
    work.read().unwrap_or_else(PoisonError::into_inner)
}

/// To change it.
pub(crate) fn write<T>(work: &Shared<T>) -> RwLockWriteGuard<'_, T> {
    work.write().unwrap_or_else(PoisonError::into_inner)
}

//! How much is read. What people write is far below each of these.

/// Bytes of one file.
pub const FILE: usize = 1 << 20;

/// Bytes of all files together; one that is included twice counts twice.
pub(super) const BYTES: usize = 16 << 20;

/// Files that are included, all together.
pub(super) const INCLUDES: usize = 1000;

/// Files that are open at once.
pub(super) const INCLUDE_DEPTH: usize = 32;

/// Braces, angle brackets and parentheses within each other, and types made of types.
pub(super) const DEPTH: usize = 64;

/// Interfaces that one interface inherits from, directly or not.
pub(super) const ANCESTORS: usize = 256;

/// Values without parts that one value of a type has at least (an array of 1000 points in space has 3000).
pub(super) const VALUES: u64 = 1 << 26;

/// Tokens that macros are replaced by, all together.
pub(super) const EXPANDED: usize = 10_000;

/// Problems that are told.
pub(super) const PROBLEMS: usize = 100;

/// Memory that definitions may take for a byte that was read, and in any case.
pub(super) const PER_BYTE: usize = 32;
/// See [`PER_BYTE`].
pub(super) const AT_LEAST: usize = 384 << 10;

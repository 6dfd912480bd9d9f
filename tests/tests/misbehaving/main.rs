//! A component that misbehaves in every way that is known: what is said of it, that nobody else is touched, and that a
//! teardown leaves nothing.

mod failing;
mod flooding;
mod grandchildren;
mod hanging;
mod lab;

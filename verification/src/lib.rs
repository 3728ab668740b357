//! Verification of tegula: cases with their references, a study of locking, and one of work and precision of integrators.

pub mod locking;
pub mod precision;
pub mod verify;

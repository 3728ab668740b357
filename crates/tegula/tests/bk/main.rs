#![allow(clippy::unwrap_used, missing_docs)]
#[path = "../common/mod.rs"]
mod common;
#[path = "../analyses/buckling.rs"]
mod buckling;

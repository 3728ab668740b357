//! tegula
fn main() {}

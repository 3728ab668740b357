//! Benchmarks of tegula beside faer are in `benches` and `examples`.

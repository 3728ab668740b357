//! Refuses builds for interpreters that the package does not support.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if pyo3_build_config::get().target_abi().kind().is_free_threaded() {
        println!(
            "cargo::error=tegula does not support free-threaded builds of Python (3.13t, 3.14t, ...): install it with an \
             ordinary build of Python 3.11 or later"
        );
    }
}

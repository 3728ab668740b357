//! Compiles the C part against PETSc and MPI of the machine, which `pkg-config` finds.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(feature = "link")]
    link();
}

#[cfg(feature = "link")]
fn link() {
    println!("cargo::rerun-if-changed=src/shim.c");
    let probe = |name: &str| pkg_config::Config::new().probe(name);
    let petsc = probe("PETSc").or_else(|_| probe("petsc"));
    let mpi =
        ["ompi-c", "mpich", "mpi"].iter().fold(probe("mpi-c"), |found, name| found.or_else(|_| probe(name)));
    let found = (petsc, mpi);
    let (petsc, mpi) = match found {
        (Ok(petsc), Ok(mpi)) => (petsc, mpi),
        (petsc, mpi) => {
            for error in [petsc.err(), mpi.err()].into_iter().flatten() {
                println!("cargo::error={}", error.to_string().lines().next().unwrap_or_default());
            }
            println!(
                "cargo::error=PETSc and MPI are not found by `pkg-config`: install `petsc-dev` of Debian or Ubuntu, or set PKG_CONFIG_PATH to \
                 the folder that holds `PETSc.pc`"
            );
            return;
        }
    };
    cc::Build::new()
        .file("src/shim.c")
        .includes(petsc.include_paths.iter().chain(&mpi.include_paths))
        // Headers of MPI and PETSc are not ours to correct.
        .flag_if_supported("-Wno-unused-parameter")
        .compile("tegula_petsc_shim");
}

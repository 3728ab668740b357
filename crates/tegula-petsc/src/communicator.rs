//! All ranks of a run.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::PetscError;
use crate::shim;

/// Whether MPI and PETSc are started: once in the life of a process.
static STARTED: AtomicBool = AtomicBool::new(false);

/// Variables that `mpirun`, `mpiexec` and `srun` set for the processes that they start.
const LAUNCHERS: [&str; 4] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMI_RANK", "PMIX_RANK"];

/// Whether a launcher of MPI has started this process.
pub fn is_launched() -> bool {
    LAUNCHERS.iter().any(|name| std::env::var_os(name).is_some())
}

/// All ranks of a run of MPI. Its methods are collective where they say so: all ranks must call them, in the same order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Communicator {
    rank: usize,
    size: usize,
}

impl Communicator {
    /// Starts MPI and PETSc (collective).
    ///
    /// # Errors
    /// They do not start, or have been started before in this process.
    pub fn start() -> Result<Self, PetscError> {
        if STARTED.swap(true, Ordering::SeqCst) {
            return Err(PetscError("MPI and PETSc are started once in a process".into()));
        }
        let (mut rank, mut size) = (0, 0);
        // SAFETY: both are places for a number.
        shim::outcome(unsafe { shim::tegula_petsc_start(&mut rank, &mut size) })?;
        Ok(Self { rank: rank.max(0) as usize, size: size.max(1) as usize })
    }

    /// Number of this rank, from 0.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Number of ranks.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Whether a statement is true in some rank (collective).
    ///
    /// # Errors
    /// MPI failed.
    pub fn any(&self, here: bool) -> Result<bool, PetscError> {
        Ok(self.largest(i64::from(here))? != 0)
    }

    /// Largest of the numbers of all ranks (collective).
    ///
    /// # Errors
    /// MPI failed.
    pub fn largest(&self, value: i64) -> Result<i64, PetscError> {
        let mut largest = value;
        // SAFETY: the place of a number.
        shim::outcome(unsafe { shim::tegula_petsc_largest(&mut largest) })?;
        Ok(largest)
    }

    /// Number of rank 0 (collective).
    ///
    /// # Errors
    /// MPI failed.
    pub fn of_first(&self, value: u64) -> Result<u64, PetscError> {
        let mut bytes = value.to_le_bytes();
        // SAFETY: there are as many bytes as told.
        shim::outcome(unsafe {
            shim::tegula_petsc_broadcast(bytes.as_mut_ptr().cast(), bytes.len() as i32)
        })?;
        Ok(u64::from_le_bytes(bytes))
    }

    /// Gathers parts of a vector (collective): each rank r has `values[begins[r]..begins[r + 1]]`, and all of them have the whole vector then.
    ///
    /// # Errors
    /// MPI failed, or there are more than 2³¹ values.
    ///
    /// # Panics
    /// `begins` has not one entry for each rank and the number of values behind them, in ascending order from 0.
    pub fn gather(&self, values: &mut [f64], begins: &[usize]) -> Result<(), PetscError> {
        assert_eq!(begins.len(), self.size + 1, "there is a place for each rank");
        assert!(
            begins[0] == 0 && begins.is_sorted() && begins[self.size] == values.len(),
            "the places are those of the values"
        );
        let begins: Vec<i64> = begins.iter().map(|&begin| begin as i64).collect();
        // SAFETY: the places of all ranks lie in `values`.
        shim::outcome(unsafe { shim::tegula_petsc_gather(values.as_mut_ptr(), begins.as_ptr()) })
    }

    /// Ends all ranks at once, with an exit code.
    pub fn abort(&self, code: i32) -> ! {
        // SAFETY: it takes any number.
        unsafe { shim::tegula_petsc_abort(code) };
        std::process::exit(code)
    }

    /// Ends PETSc and MPI (collective): no factorisation may live on.
    ///
    /// # Errors
    /// They do not end.
    pub fn end(self) -> Result<(), PetscError> {
        // SAFETY: they have been started, and this value, which was made by that, is gone.
        shim::outcome(unsafe { shim::tegula_petsc_end() })
    }
}

//! Direct method MUMPS on all ranks.

use std::ffi::c_void;

use tegula_sparse::{DirectMethod, Factor, FactorError, Inertia, SymmetricPattern};

use crate::Communicator;
use crate::shim;

/// LDLᵀ factorisation by MUMPS on all ranks (collective in all its methods): every rank has the whole matrix and the whole solution, and gives rows of its own
/// to the factorisation.
#[derive(Debug, Clone, Copy)]
pub struct Mumps(pub Communicator);

/// Solver of matrices of one pattern.
struct MumpsFactor {
    handle: *mut c_void,
    /// Pointers of this rank's rows of the upper triangle, which are columns of the lower one.
    pointers: Vec<i64>,
    size: usize,
    factored: bool,
    factorizations: usize,
}

// SAFETY: MPI is started for calls of any thread, one after another, and `&mut self` lets no two threads call at once.
unsafe impl Send for MumpsFactor {}

impl DirectMethod for Mumps {
    fn analyse(&self, pattern: &SymmetricPattern) -> Result<Box<dyn Factor>, FactorError> {
        let (pointers, rows) = pattern.columns();
        let (first, last) = self.rows(pointers);
        let own = &rows[pointers[first]..pointers[last]];
        let pointers: Vec<i64> = pointers[first..=last].iter().map(|&p| p as i64).collect();
        let (mut handle, size) = (std::ptr::null_mut(), pattern.size());
        // SAFETY: `pointers` has an entry for each row and one more, and `own` the columns of all of them.
        let code = unsafe {
            shim::tegula_petsc_analyse(
                size as i64,
                first as i64,
                last as i64,
                pointers.as_ptr(),
                own.as_ptr(),
                &mut handle,
            )
        };
        if code != 0 {
            return Err(error(code));
        }
        Ok(Box::new(MumpsFactor { handle, pointers, size, factored: false, factorizations: 0 }))
    }
}

impl Mumps {
    /// First row of this rank and that behind its last one: all ranks have about as many entries.
    fn rows(&self, pointers: &[usize]) -> (usize, usize) {
        let (size, entries) = (pointers.len() - 1, pointers[pointers.len() - 1]);
        let begin = |rank: usize| {
            if rank == self.0.size() {
                return size;
            }
            let share = (entries as u128 * rank as u128 / self.0.size() as u128) as usize;
            pointers.partition_point(|&p| p < share).min(size)
        };
        (begin(self.0.rank()), begin(self.0.rank() + 1))
    }
}

impl Factor for MumpsFactor {
    fn factor(&mut self, values: &[f64]) -> Result<Inertia, FactorError> {
        self.factored = false;
        if !values.iter().all(|value| value.is_finite()) {
            return Err(FactorError::NotFinite);
        }
        self.factorizations += 1;
        let (begin, end) = (self.pointers[0], self.pointers[self.pointers.len() - 1]);
        let own = &values[begin as usize..end as usize];
        let mut inertia = [0_i64; 3];
        // SAFETY: `own` has the values of the rows to which `pointers` belongs, and there is place for three numbers.
        let code = unsafe {
            shim::tegula_petsc_factor(self.handle, self.pointers.as_ptr(), own.as_ptr(), inertia.as_mut_ptr())
        };
        if code != 0 {
            return Err(error(code));
        }
        self.factored = true;
        let [negative, zero, positive] = inertia.map(|count| count as usize);
        Ok(Inertia { positive, negative, zero })
    }

    fn solve(&mut self, right_side: &mut [f64]) {
        assert_eq!(right_side.len(), self.size, "the right side has another size");
        let solved = self.factored && {
            // SAFETY: the vector has the size of the matrix.
            unsafe { shim::tegula_petsc_solve(self.handle, right_side.as_mut_ptr()) == 0 }
        };
        if !solved {
            // Without a factor there is no solution, and the result must not look like one.
            right_side.fill(f64::NAN);
        }
    }

    fn factorizations(&self) -> usize {
        self.factorizations
    }

    fn factor_entries(&self) -> usize {
        0
    }
}

impl Drop for MumpsFactor {
    fn drop(&mut self) {
        // SAFETY: the handle is this value's own.
        unsafe { shim::tegula_petsc_free(self.handle) };
    }
}

fn error(code: i32) -> FactorError {
    match code {
        shim::SINGULAR => FactorError::Singular,
        shim::NO_MEMORY | shim::TOO_LARGE => FactorError::TooLarge,
        code => {
            FactorError::Other(shim::outcome(code).err().map(|error| error.to_string()).unwrap_or_default())
        }
    }
}

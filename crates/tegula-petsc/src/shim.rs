//! Functions of `shim.c`.

use std::ffi::{CStr, c_char, c_void};

use crate::PetscError;

unsafe extern "C" {
    pub fn tegula_petsc_start(rank: *mut i32, size: *mut i32) -> i32;
    pub fn tegula_petsc_end() -> i32;
    pub fn tegula_petsc_abort(code: i32);
    pub fn tegula_petsc_largest(value: *mut i64) -> i32;
    pub fn tegula_petsc_broadcast(bytes: *mut c_void, count: i32) -> i32;
    pub fn tegula_petsc_gather(values: *mut f64, begins: *const i64) -> i32;
    pub fn tegula_petsc_analyse(
        n: i64,
        first: i64,
        last: i64,
        pointers: *const i64,
        columns: *const u32,
        handle: *mut *mut c_void,
    ) -> i32;
    pub fn tegula_petsc_factor(
        handle: *mut c_void,
        pointers: *const i64,
        values: *const f64,
        inertia: *mut i64,
    ) -> i32;
    pub fn tegula_petsc_solve(handle: *mut c_void, x: *mut f64) -> i32;
    pub fn tegula_petsc_free(handle: *mut c_void);
    fn tegula_petsc_message(code: i32) -> *const c_char;
}

/// Codes of `shim.c`.
pub const SINGULAR: i32 = 10001;
pub const NO_MEMORY: i32 = 10002;
pub const TOO_LARGE: i32 = 10003;

/// Outcome of a function of `shim.c`.
pub fn outcome(code: i32) -> Result<(), PetscError> {
    if code == 0 {
        return Ok(());
    }
    // SAFETY: the function returns a string that lives as long as the program, or until the next error of this thread.
    let text = unsafe { CStr::from_ptr(tegula_petsc_message(code)) };
    Err(PetscError(text.to_string_lossy().into_owned()))
}

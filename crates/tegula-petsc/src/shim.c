/* Part of the program that calls PETSc and MPI, whose types, sizes of integers and macros differ from build to build: behind these functions are
   fixed types only. All return 0, or a number other than 0 that `tegula_petsc_message` explains. */
#include <petscmat.h>
#include <petscvec.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if !defined(PETSC_HAVE_MUMPS)
#error "This PETSc has no MUMPS: configure it with --download-mumps, or install petsc-dev of Debian"
#endif
#if defined(PETSC_USE_COMPLEX)
#error "This PETSc has complex numbers: take the one with real numbers"
#endif
#if !defined(PETSC_USE_REAL_DOUBLE)
#error "This PETSc has not double precision"
#endif

#define CHECK(call)                                                                                                                        \
    do {                                                                                                                                   \
        int code_ = (int)(call);                                                                                                           \
        if (code_) return code_;                                                                                                           \
    } while (0)

/* Codes that are none of PETSc's. */
enum { SINGULAR = 10001, NO_MEMORY = 10002, TOO_LARGE = 10003 };

/* Largest number of attempts with more and more memory. */
enum { ATTEMPTS = 6 };

static char message[1024];

static PetscErrorCode keep_message(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code, PetscErrorType type,
                                   const char *text, void *context)
{
    (void)comm, (void)line, (void)file, (void)context;
    if (type == PETSC_ERROR_INITIAL && text) snprintf(message, sizeof message, "%s: %s", function ? function : "PETSc", text);
    return code;
}

int tegula_petsc_start(int32_t *rank, int32_t *size)
{
    int provided, is_running, r, n;
    CHECK(MPI_Initialized(&is_running));
    if (!is_running) CHECK(MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided));
    CHECK(PetscOptionsSetValue(NULL, "-no_signal_handler", "true"));
    CHECK(PetscInitializeNoArguments());
    CHECK(PetscPushErrorHandler(keep_message, NULL));
    CHECK(MPI_Comm_rank(PETSC_COMM_WORLD, &r));
    CHECK(MPI_Comm_size(PETSC_COMM_WORLD, &n));
    *rank = r;
    *size = n;
    return 0;
}

/* PETSc does not end an MPI that it has not started. */
int tegula_petsc_end(void)
{
    CHECK(PetscFinalize());
    return MPI_Finalize();
}

void tegula_petsc_abort(int32_t code)
{
    MPI_Abort(MPI_COMM_WORLD, code);
}

const char *tegula_petsc_message(int32_t code)
{
    const char *text = NULL;
    if (code == NO_MEMORY) return "there is not enough memory";
    if (code == TOO_LARGE) return "there are more numbers than one call of MPI or PETSc can take";
    if (message[0]) return message;
    PetscErrorMessage((PetscErrorCode)code, &text, NULL);
    return text ? text : "unknown error of PETSc or MPI";
}

/* Largest of the numbers of all ranks. */
int tegula_petsc_largest(int64_t *value)
{
    int64_t mine = *value;
    return MPI_Allreduce(&mine, value, 1, MPI_INT64_T, MPI_MAX, PETSC_COMM_WORLD);
}

/* Bytes of rank 0, in all ranks. */
int tegula_petsc_broadcast(void *bytes, int32_t count)
{
    return MPI_Bcast(bytes, count, MPI_BYTE, 0, PETSC_COMM_WORLD);
}

/* Gathers parts of a vector: `begins` has the place of the first value of each rank, and the number of all. */
int tegula_petsc_gather(double *values, const int64_t *begins)
{
    int size;
    CHECK(MPI_Comm_size(PETSC_COMM_WORLD, &size));
    if (begins[size] > INT32_MAX) return TOO_LARGE;
    int *counts = malloc(2 * (size_t)size * sizeof *counts);
    if (!counts) return NO_MEMORY;
    for (int r = 0; r < size; r++) {
        counts[r] = (int)(begins[r + 1] - begins[r]);
        counts[size + r] = (int)begins[r];
    }
    int code = MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, values, counts, counts + size, MPI_DOUBLE, PETSC_COMM_WORLD);
    free(counts);
    return code;
}

/* Factorisation of symmetric matrices of one pattern by MUMPS. */
typedef struct {
    Mat matrix, factor;
    Vec right, solution, whole;
    VecScatter gather;
    PetscInt first, last, *columns;
} Factorization;

void tegula_petsc_free(void *handle)
{
    Factorization *f = handle;
    if (!f) return;
    VecScatterDestroy(&f->gather);
    VecDestroy(&f->whole);
    VecDestroy(&f->solution);
    VecDestroy(&f->right);
    MatDestroy(&f->factor);
    MatDestroy(&f->matrix);
    free(f->columns);
    free(f);
}

static int make(Factorization *f, int64_t n, const int64_t *pointers, const uint32_t *columns)
{
    PetscInt rows = f->last - f->first, *starts;
    int64_t entries = pointers[rows] - pointers[0];
    if (n > PETSC_MAX_INT || entries > PETSC_MAX_INT) return TOO_LARGE;
    starts = malloc(((size_t)rows + 1) * sizeof *starts);
    f->columns = malloc(((size_t)entries + 1) * sizeof *f->columns);
    if (!starts || !f->columns) {
        free(starts);
        return NO_MEMORY;
    }
    for (PetscInt i = 0; i <= rows; i++) starts[i] = (PetscInt)(pointers[i] - pointers[0]);
    for (int64_t k = 0; k < entries; k++) f->columns[k] = (PetscInt)columns[k];
    int code = MatCreate(PETSC_COMM_WORLD, &f->matrix);
    if (!code) code = MatSetSizes(f->matrix, rows, rows, (PetscInt)n, (PetscInt)n);
    if (!code) code = MatSetType(f->matrix, MATSBAIJ);
    if (!code) code = MatSeqSBAIJSetPreallocationCSR(f->matrix, 1, starts, f->columns, NULL);
    if (!code) code = MatMPISBAIJSetPreallocationCSR(f->matrix, 1, starts, f->columns, NULL);
    free(starts);
    CHECK(code);
    CHECK(MatCreateVecs(f->matrix, &f->solution, &f->right));
    return VecScatterCreateToAll(f->solution, &f->gather, &f->whole);
}

static int analyse(int64_t n, int64_t first, int64_t last, const int64_t *pointers, const uint32_t *columns, void **handle)
{
    Factorization *f = calloc(1, sizeof *f);
    if (!f) return NO_MEMORY;
    f->first = (PetscInt)first;
    f->last = (PetscInt)last;
    int code = make(f, n, pointers, columns);
    if (code) {
        tegula_petsc_free(f);
        return code;
    }
    *handle = f;
    return 0;
}

/* Largest code of all ranks: where one fails, all do. */
static int of_all(int code)
{
    int largest = code, sent = MPI_Allreduce(&code, &largest, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
    return sent ? sent : largest;
}

/* Rows `first` to `last` − 1 of the upper triangle of a matrix of size n belong to this rank: `pointers` and `columns` of these rows, with the
   diagonal entry first. */
int tegula_petsc_analyse(int64_t n, int64_t first, int64_t last, const int64_t *pointers, const uint32_t *columns, void **handle)
{
    void *mine = NULL;
    int code = of_all(analyse(n, first, last, pointers, columns, &mine));
    if (code) tegula_petsc_free(mine);
    else *handle = mine;
    return code;
}

static int symbolic(Factorization *f, PetscInt more_memory)
{
    MatFactorInfo info;
    CHECK(MatGetFactor(f->matrix, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, &f->factor));
    /* The inertia counts the pivots of the last front only where one process factors it. */
    CHECK(MatMumpsSetIcntl(f->factor, 13, 1));
    CHECK(MatMumpsSetIcntl(f->factor, 14, more_memory));
    /* Pivots that are round-off are counted, and not taken as numbers. */
    CHECK(MatMumpsSetIcntl(f->factor, 24, 1));
    CHECK(MatFactorInfoInitialize(&info));
    return MatCholeskyFactorSymbolic(f->factor, f->matrix, NULL, &info);
}

static int factor(Factorization *f, const int64_t *pointers, const double *values, int64_t *inertia)
{
    MatFactorInfo info;
    message[0] = 0;
    const PetscInt *columns = f->columns;
    for (PetscInt row = f->first; row < f->last; row++) {
        PetscInt i = row - f->first, count = (PetscInt)(pointers[i + 1] - pointers[i]);
        const double *of_row = values + (pointers[i] - pointers[0]);
        CHECK(MatSetValues(f->matrix, 1, &row, count, columns, of_row, INSERT_VALUES));
        columns += count;
    }
    CHECK(MatAssemblyBegin(f->matrix, MAT_FINAL_ASSEMBLY));
    CHECK(MatAssemblyEnd(f->matrix, MAT_FINAL_ASSEMBLY));
    CHECK(MatFactorInfoInitialize(&info));
    PetscInt more_memory = 30;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++, more_memory *= 3) {
        MatFactorError error;
        PetscInt outcome;
        if (!f->factor) CHECK(symbolic(f, more_memory));
        CHECK(MatCholeskyFactorNumeric(f->factor, f->matrix, &info));
        CHECK(MatFactorGetError(f->factor, &error));
        CHECK(MatMumpsGetInfog(f->factor, 1, &outcome));
        if (error == MAT_FACTOR_NOERROR && outcome >= 0) {
            PetscInt null_pivots, negative, zero, positive;
            CHECK(MatMumpsGetInfog(f->factor, 28, &null_pivots));
            if (null_pivots > 0) return SINGULAR;
            CHECK(MatGetInertia(f->factor, &negative, &zero, &positive));
            inertia[0] = negative;
            inertia[1] = zero;
            inertia[2] = positive;
            return 0;
        }
        CHECK(MatDestroy(&f->factor));
        if (error == MAT_FACTOR_NUMERIC_ZEROPIVOT || error == MAT_FACTOR_STRUCT_ZEROPIVOT) return SINGULAR;
        if (error != MAT_FACTOR_OUTMEMORY) {
            snprintf(message, sizeof message, "MUMPS ended with INFOG(1) = %ld", (long)outcome);
            return PETSC_ERR_LIB;
        }
    }
    return NO_MEMORY;
}

/* Factors the matrix with the values of this rank's rows; `inertia`: numbers of negative, zero and positive pivots. */
int tegula_petsc_factor(void *handle, const int64_t *pointers, const double *values, int64_t *inertia)
{
    return of_all(factor(handle, pointers, values, inertia));
}

static int solve(Factorization *f, double *x)
{
    double *local;
    const double *whole;
    PetscInt size;
    CHECK(VecGetArray(f->right, &local));
    memcpy(local, x + f->first, (size_t)(f->last - f->first) * sizeof *local);
    CHECK(VecRestoreArray(f->right, &local));
    CHECK(MatSolve(f->factor, f->right, f->solution));
    CHECK(VecScatterBegin(f->gather, f->solution, f->whole, INSERT_VALUES, SCATTER_FORWARD));
    CHECK(VecScatterEnd(f->gather, f->solution, f->whole, INSERT_VALUES, SCATTER_FORWARD));
    CHECK(VecGetSize(f->whole, &size));
    CHECK(VecGetArrayRead(f->whole, &whole));
    memcpy(x, whole, (size_t)size * sizeof *x);
    return VecRestoreArrayRead(f->whole, &whole);
}

/* Solves with the last factor, in place of the right side, which all ranks have as a whole, as they have the solution. */
int tegula_petsc_solve(void *handle, double *x)
{
    return of_all(solve(handle, x));
}

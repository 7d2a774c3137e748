/* cvode.c: CVODE on a compiled model's own f (and J), timed. M must be the identity. */
#include "clock.h"

#include <cvode/cvode.h>
#include <klu.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <string.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

typedef struct {
    const bgc_model *m;
    double *h, *u, *work, *jac, *dfdt;
    int entries, *pointers, *indices, *place; /* J by columns, with its diagonal */
} problem;

static int rhs(realtype t, N_Vector y, N_Vector f, void *data) {
    problem *q = data;

    q->m->rhs(q->h, t, N_VGetArrayPointer(y), q->u, N_VGetArrayPointer(f), q->work);
    return 0;
}

static int sparse_jacobian(realtype t, N_Vector y, N_Vector f, SUNMatrix J, void *data, N_Vector a,
                           N_Vector b, N_Vector c) {
    problem *q = data;
    realtype *values = SUNSparseMatrix_Data(J);

    (void)f, (void)a, (void)b, (void)c;
    for (int j = 0; j <= q->m->n_state; j++) {
        SUNSparseMatrix_IndexPointers(J)[j] = q->pointers[j];
    }
    for (int k = 0; k < q->entries; k++) {
        SUNSparseMatrix_IndexValues(J)[k] = q->indices[k];
        values[k] = 0.0;
    }
    q->m->jacobian(q->h, t, N_VGetArrayPointer(y), q->u, q->jac, q->dfdt, q->work);
    for (int k = 0; k < q->m->n_jac; k++) {
        values[q->place[k]] = q->jac[k];
    }
    return 0;
}

/* The pattern of J by columns, rows ascending. */
static void lay_out(problem *q) {
    const int n = q->m->n_state;
    char *is_there = calloc((size_t)n * (size_t)n, 1);

    for (int k = 0; k < n; k++) {
        is_there[k * n + k] = 1;
    }
    for (int k = 0; k < q->m->n_jac; k++) {
        is_there[q->m->jac_col[k] * n + q->m->jac_row[k]] = 1;
    }
    q->entries = 0;
    q->pointers = calloc((size_t)n + 1, sizeof *q->pointers);
    q->indices = calloc((size_t)n * (size_t)n, sizeof *q->indices);
    q->place = calloc((size_t)q->m->n_jac + 1, sizeof *q->place);
    for (int j = 0; j < n; j++) {
        q->pointers[j] = q->entries;
        for (int i = 0; i < n; i++) {
            if (is_there[j * n + i]) {
                q->indices[q->entries++] = i;
            }
        }
    }
    q->pointers[n] = q->entries;
    for (int k = 0; k < q->m->n_jac; k++) {
        int at = q->pointers[q->m->jac_col[k]];
        while (q->indices[at] != q->m->jac_row[k]) {
            at++;
        }
        q->place[k] = at;
    }
    free(is_there);
}

/* Integrates from x0 at times[0] and writes outputs at all times; absolute tolerances are rtol times
 * each state's scale, as the runtime's are. sparse: KLU and our J; else dense difference quotients.
 * Returns the seconds from CVodeInit on, or -1 - flag. counts: steps, f, J. */
double cvode_run(const bgc_model *m, const double *p, const double *x0, const double *times,
                 size_t rows, double *out, double rtol, int sparse, long counts[3]) {
    const int n = m->n_state;
    problem q = {.m = m};
    SUNContext context;
    N_Vector y, atol;
    SUNMatrix A;
    SUNLinearSolver solver;
    void *memory;
    double start, seconds;
    int flag = 0;

    q.h = calloc((size_t)m->n_hoist + 1, sizeof *q.h);
    q.u = calloc((size_t)m->n_input + 1, sizeof *q.u);
    q.work = calloc((size_t)m->n_work + (size_t)n + 1, sizeof *q.work);
    q.jac = calloc((size_t)m->n_jac + 1, sizeof *q.jac);
    q.dfdt = calloc((size_t)n, sizeof *q.dfdt);
    m->prepare(p, q.h, q.work);
    lay_out(&q);
    SUNContext_Create(NULL, &context);
    y = N_VNew_Serial(n, context);
    atol = N_VNew_Serial(n, context);
    m->scale(q.h, N_VGetArrayPointer(atol), q.work);
    for (int i = 0; i < n; i++) {
        N_VGetArrayPointer(y)[i] = x0[i];
        N_VGetArrayPointer(atol)[i] *= rtol;
    }

    start = clock_now();
    memory = CVodeCreate(CV_BDF, context);
    CVodeInit(memory, rhs, times[0], y);
    CVodeSVtolerances(memory, rtol, atol);
    CVodeSetUserData(memory, &q);
    CVodeSetMaxNumSteps(memory, 100000000);
    CVodeSetErrFile(memory, NULL);
    A = sparse ? SUNSparseMatrix(n, n, q.entries, CSC_MAT, context)
               : SUNDenseMatrix(n, n, context);
    solver = sparse ? SUNLinSol_KLU(y, A, context) : SUNLinSol_Dense(y, A, context);
    CVodeSetLinearSolver(memory, solver, A);
    if (sparse) {
        CVodeSetJacFn(memory, sparse_jacobian);
    }
    m->outputs(q.h, times[0], x0, q.u, out, q.work);
    for (size_t k = 1; k < rows && flag >= 0; k++) {
        realtype t;
        flag = CVode(memory, times[k], y, &t, CV_NORMAL);
        m->outputs(q.h, times[k], N_VGetArrayPointer(y), q.u, out + k * (size_t)m->n_output, q.work);
    }
    seconds = clock_now() - start;
    CVodeGetNumSteps(memory, &counts[0]);
    CVodeGetNumRhsEvals(memory, &counts[1]);
    CVodeGetNumJacEvals(memory, &counts[2]);

    CVodeFree(&memory);
    SUNLinSolFree(solver), SUNMatDestroy(A), N_VDestroy(y), N_VDestroy(atol);
    SUNContext_Free(&context);
    free(q.h), free(q.u), free(q.work), free(q.jac), free(q.dfdt);
    free(q.pointers), free(q.indices), free(q.place);
    return flag < 0 ? -1.0 + flag : seconds;
}

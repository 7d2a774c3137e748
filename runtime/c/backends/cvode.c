/* cvode.c: CVODE of SUNDIALS as a solver of compiled models.
 *
 * A shared object of its own, compiled when a run asks for it, where SUNDIALS is installed. BDF with
 * Newton's method on the emitted Jacobian, factorised by KLU (with BGC_KLU) or densely. Tolerances
 * of the states are those of the runtime's methods without their reduction for small motions. The
 * energy accounts are two more states; their entries of the Jacobian are omitted, which costs Newton
 * iterations but no accuracy. Where a switch changes its mode the step ends and CVODE restarts. M has
 * to be the identity, there has to be a state, and there may be no sampled inputs. */
#include "bgc_internal.h"
#include "inner.h"

#include <cvode/cvode.h>
#include <float.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_config.h>
#include <time.h>
#ifdef BGC_KLU
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>
#else
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#endif

/* The data of CVODE's callbacks. */
typedef struct {
    const bgc_model *m;
    bgc_data *d;
    int size;         /* states, and two accounts */
    int *first, *row; /* the Jacobian by columns, its diagonal included */
    int *place;       /* of the entries of df/dx */
    double *inner;    /* a matrix of all unknowns, where the model has inner ones */
} problem;

/* Whether all entries are finite. Where they are not, CVODE tries a shorter step. */
static int all_finite(int n, const double *v) {
    double sum = 0.0;

    for (int i = 0; i < n; i++) {
        sum += 0.0 * v[i];
    }
    return sum == 0.0;
}

/* f of the states, and the powers as rates of the accounts. */
static int derivatives(sunrealtype t, N_Vector y, N_Vector slope, void *data) {
    const problem *q = data;
    const double *x = N_VGetArrayPointer(y);
    double *f = N_VGetArrayPointer(slope);

    q->m->rhs(q->d->h, t, x, q->d->u, f, q->d->work);
    if (q->size > q->m->n_state) {
        double energy[3];
        q->m->energy(q->d->h, t, x, q->d->u, energy, q->d->work);
        f[q->m->n_state] = energy[1];
        f[q->m->n_state + 1] = energy[2];
    }
    return all_finite(q->size, f) ? 0 : 1;
}

/* df/dx in the storage of CVODE. */
static int jacobian(sunrealtype t, N_Vector y, N_Vector f, SUNMatrix J, void *data, N_Vector a,
                    N_Vector b, N_Vector c) {
    const problem *q = data;
    const double *x = N_VGetArrayPointer(y);

    (void)f, (void)a, (void)b, (void)c;
    if (q->m->n_inner == 0) {
        q->m->jacobian(q->d->h, t, x, q->d->u, q->d->jac, q->d->dfdt, q->d->work);
    } else {
        size_t width;
        q->m->jacobian(q->d->h, t, x, q->d->u, q->d->local, q->d->dfdt, q->d->work);
        width = bgc_eliminate_inner(q->m, q->d->local, q->inner);
        bgc_gather_slopes(q->m, q->inner, width, q->d->jac);
    }
#ifdef BGC_KLU
    for (int j = 0; j <= q->size; j++) {
        SUNSparseMatrix_IndexPointers(J)[j] = q->first[j];
    }
    for (int k = 0; k < q->first[q->size]; k++) {
        SUNSparseMatrix_IndexValues(J)[k] = q->row[k];
        SUNSparseMatrix_Data(J)[k] = 0.0;
    }
    for (int k = 0; k < q->m->n_jac; k++) {
        SUNSparseMatrix_Data(J)[q->place[k]] = q->d->jac[k];
    }
#else
    SUNMatZero(J);
    for (int k = 0; k < q->m->n_jac; k++) {
        SM_ELEMENT_D(J, q->m->jac_row[k], q->m->jac_col[k]) = q->d->jac[k];
    }
#endif
    return all_finite(q->m->n_jac, q->d->jac) ? 0 : 1;
}

/* Arguments of the switches, as root functions. */
static int switches(sunrealtype t, N_Vector y, sunrealtype *argument, void *data) {
    const problem *q = data;

    q->m->switches(q->d->h, t, N_VGetArrayPointer(y), q->d->u, argument, q->d->work);
    return 0;
}

/* Fills the pattern of the Jacobian by columns. */
static bgc_status lay_out(problem *q) {
    const bgc_model *m = q->m;
    const size_t n = (size_t)q->size;
    const size_t unknowns = m->n_inner > 0 ? (size_t)bgc_unknowns(m) : 0;
    int *seen = calloc(n + 1, sizeof *seen), *next = calloc(n + 1, sizeof *next), at = 0;

    q->first = calloc(n + 1, sizeof *q->first);
    q->row = calloc((size_t)m->n_jac + n + 1, sizeof *q->row);
    q->place = calloc((size_t)m->n_jac + 1, sizeof *q->place);
    q->inner = calloc(unknowns * unknowns + 1, sizeof *q->inner);
    if (seen == NULL || next == NULL || q->first == NULL || q->row == NULL || q->place == NULL ||
        q->inner == NULL) {
        free(seen), free(next);
        return BGC_NO_MEMORY;
    }
    /* Entries of each column in the emitted order, then the diagonal where it is missing. */
    for (int k = 0; k < m->n_jac; k++) {
        next[m->jac_col[k]]++;
        seen[m->jac_col[k]] |= m->jac_row[k] == m->jac_col[k];
    }
    for (int j = 0; j < q->size; j++) {
        q->first[j] = at;
        at += next[j] + !seen[j];
        next[j] = q->first[j];
    }
    q->first[q->size] = at;
    for (int k = 0; k < m->n_jac; k++) {
        q->place[k] = next[m->jac_col[k]]++;
        q->row[q->place[k]] = m->jac_row[k];
    }
    for (int j = 0; j < q->size; j++) {
        if (!seen[j]) {
            q->row[next[j]] = j;
        }
    }
    free(seen), free(next);
    return BGC_OK;
}

/* The status of the runtime for a flag of CVODE. */
static bgc_status status_of(int flag) {
    switch (flag) {
    case CV_MEM_FAIL:
        return BGC_NO_MEMORY;
    case CV_LSETUP_FAIL:
    case CV_LSOLVE_FAIL:
        return BGC_SINGULAR;
    case CV_RHSFUNC_FAIL:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
        return BGC_NOT_FINITE;
    case CV_CONV_FAILURE:
        return BGC_NOT_CONVERGED;
    default:
        return flag >= 0 ? BGC_OK : BGC_STEP_TOO_SMALL;
    }
}

/* Writes a row from the state y at t, normalised, and its accounts. */
static void write_row(const problem *q, double t, const double *y, double *row) {
    const bgc_model *m = q->m;
    bgc_data *d = q->d;

    memcpy(d->point, y, (size_t)m->n_state * sizeof *y);
    if (m->project != NULL) {
        m->project(d->h, t, d->point, d->work);
    }
    m->outputs(d->h, t, d->point, d->u, row, d->work);
    if (q->size > m->n_state) {
        double *account = row + m->n_output, energy[3];
        m->energy(d->h, t, d->point, d->u, energy, d->work);
        account[0] = energy[0] - d->core.stored0;
        account[1] = y[m->n_state];
        account[2] = y[m->n_state + 1];
        account[3] = account[0] - account[1] + account[2];
    }
}

/* Adds the counts of CVODE since its last start to those of the instance. */
static void add_counts(void *memory, bgc_counts *counts) {
    long steps = 0, rejected = 0, rhs = 0, jacobians = 0, setups = 0, solves = 0;

    CVodeGetNumSteps(memory, &steps);
    CVodeGetNumErrTestFails(memory, &rejected);
    CVodeGetNumRhsEvals(memory, &rhs);
    CVodeGetNumJacEvals(memory, &jacobians);
    CVodeGetNumLinSolvSetups(memory, &setups);
    CVodeGetNumNonlinSolvIters(memory, &solves);
    CVodeGetLastStep(memory, &counts->last_step);
    counts->steps += steps;
    counts->rejected += rejected;
    counts->rhs += rhs;
    counts->jacobians += jacobians;
    counts->factorisations += setups;
    counts->solves += solves;
}

static double seconds(void) {
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Steps to the last row, with rows by dense output; y is the state at the present. */
static bgc_status integrate(const problem *q, void *memory, N_Vector y, const double *times,
                            size_t n, double *rows, size_t *done) {
    bgc_data *d = q->d;
    const size_t width = (size_t)(q->m->n_output + (q->size > q->m->n_state ? 4 : 0));
    N_Vector inside = N_VClone(y);
    bgc_status status = inside == NULL ? BGC_NO_MEMORY : BGC_OK;
    long steps = 0;  /* between two rows */
    int restart = 0; /* a switch changes its mode at the present */

    while (status == BGC_OK && *done < n) {
        const double row = times[*done];
        const double slack = 8.0 * DBL_EPSILON * fabs(d->core.t);

        /* A row at or before the present. */
        if (row <= d->core.t + slack) {
            const double at = fmin(row, d->core.t);
            const double *shown = N_VGetArrayPointer(y);
            if (at < d->core.t) {
                status = status_of(CVodeGetDky(memory, at, 0, inside));
                shown = N_VGetArrayPointer(inside);
            }
            if (status == BGC_OK) {
                write_row(q, at, shown, rows + *done * width);
                ++*done;
                steps = 0;
            }
            continue;
        }

        /* One step. */
        if (atomic_exchange(&d->stop, 0) != 0) {
            return N_VDestroy(inside), BGC_INTERRUPTED;
        }
        if (steps++ >= d->core.max_steps) {
            return N_VDestroy(inside), BGC_TOO_MANY_STEPS;
        }
        if (restart) {
            add_counts(memory, &d->core.counts);
            CVodeReInit(memory, d->core.t, y);
        }
        const double start = seconds();
        const int flag = CVode(memory, times[n - 1], y, &d->core.t, CV_ONE_STEP);
        d->core.counts.worst_step_seconds =
            fmax(d->core.counts.worst_step_seconds, seconds() - start);
        status = status_of(flag);
        restart = flag == CV_ROOT_RETURN;
        d->core.counts.events += restart;
        if (status == BGC_OK) {
            status = bgc_check_asserts(q->m, d, d->core.t, N_VGetArrayPointer(y));
        }
    }
    N_VDestroy(inside);
    return status;
}

/* bgc_run by CVODE. */
bgc_status bgc_cvode_run(const bgc_model *m, bgc_data *d, const double *times, size_t n,
                         double *rows, size_t *done);

bgc_status bgc_cvode_run(const bgc_model *m, bgc_data *d, const double *times, size_t n,
                         double *rows, size_t *done) {
    problem q = {.m = m, .d = d, .size = m->n_state + (d->core.accounts ? 2 : 0)};
    SUNContext context = NULL;
    const double begin = seconds();
    bgc_status status = BGC_OK;

    *done = 0;
    for (int k = 0; k < m->n_switch; k++) {
        d->u[m->n_input + k] = NAN; /* operations are evaluated, not held */
    }
    status = bgc_check_asserts(m, d, d->core.t, d->x);
    if (status != BGC_OK || (status = lay_out(&q)) != BGC_OK) {
        return status;
    }

    /* Vectors, integrator, matrix and linear solver. */
#if SUNDIALS_VERSION_MAJOR >= 7
    SUNContext_Create(SUN_COMM_NULL, &context);
    SUNContext_ClearErrHandlers(context);
#else
    SUNContext_Create(NULL, &context);
#endif
    const int size = q.size;
    N_Vector y = N_VNew_Serial(size, context), atol = N_VNew_Serial(size, context);
    void *memory = CVodeCreate(CV_BDF, context);
#ifdef BGC_KLU
    SUNMatrix A = SUNSparseMatrix(size, size, q.first[size], CSC_MAT, context);
    SUNLinearSolver solver = SUNLinSol_KLU(y, A, context);
#else
    SUNMatrix A = SUNDenseMatrix(size, size, context);
    SUNLinearSolver solver = SUNLinSol_Dense(y, A, context);
#endif
    if (y == NULL || atol == NULL || memory == NULL || A == NULL || solver == NULL) {
        status = BGC_NO_MEMORY;
    } else {
        const bgc_core *core = &d->core;
        double *start = N_VGetArrayPointer(y), *tolerance = N_VGetArrayPointer(atol);

        /* Initial values and tolerances. */
        N_VConst(0.0, y);
        memcpy(start, d->x, (size_t)m->n_state * sizeof *start);
        for (int i = 0; i < size; i++) {
            const double scale = i < m->n_state ? d->scale[i] : 1.0;
            tolerance[i] = core->atol > 0.0 ? core->atol : core->rtol * scale;
        }
        for (int i = m->n_state; i < size; i++) {
            start[i] = i == m->n_state ? core->supplied : core->dissipated;
        }

        /* Options, then the run. */
#if SUNDIALS_VERSION_MAJOR < 7
        CVodeSetErrFile(memory, NULL);
#endif
        CVodeInit(memory, derivatives, core->t, y);
        CVodeSVtolerances(memory, core->rtol, atol);
        CVodeSetUserData(memory, &q);
        CVodeSetMaxNumSteps(memory, -1);
        CVodeSetMaxStep(memory, core->given.max_step);
        CVodeSetInitStep(memory, core->step);
        CVodeSetLinearSolver(memory, solver, A);
        CVodeSetJacFn(memory, jacobian);
        if (m->n_switch > 0) {
            CVodeRootInit(memory, m->n_switch, switches);
            CVodeSetNoInactiveRootWarn(memory);
        }
        status = integrate(&q, memory, y, times, n, rows, done);
        add_counts(memory, &d->core.counts);
        memcpy(d->x, start, (size_t)m->n_state * sizeof *start);
        d->core.f_valid = d->core.jac_valid = 0;
    }
    CVodeFree(&memory);
    SUNLinSolFree(solver), SUNMatDestroy(A);
    N_VDestroy(y), N_VDestroy(atol);
    SUNContext_Free(&context);
    free(q.first), free(q.row), free(q.place), free(q.inner);
    d->core.counts.run_seconds += seconds() - begin;
    return status;
}

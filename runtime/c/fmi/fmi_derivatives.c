/* fmi_derivatives.c: directional and adjoint derivatives of rates and outputs by states and inputs.
 *
 * From the emitted partial derivatives of f, outputs y, commands and energies by all states and inputs. With
 * the free states x, the inputs u and the other states z, which follow from g(x, z, u) = 0:
 *
 *   g_z dz = -(g_x dx + g_u du),   M dx' = f_x dx + f_z dz + f_u du,   and dy likewise.
 *
 * The adjoint goes through the same equations backwards, with transposed matrices. Modes are held.
 */
#include "fmi.h"

/* --- the linear systems ------------------------------------------------------------------------ */

/* Solves with M, or its transpose, in the rows and columns of the free states. */
static bgc_fmi_status solve_mass(bgc_fmi *i, double *right, int transposed) {
    const bgc_model *m = i->m;
    const int n = m->n_state;
    int coupled = 0;

    for (int k = 0; k < n; k++) {
        coupled |= bgc_fmi_is_free(i, k) && i->d->inverse_mass[k] == 0.0;
    }
    for (int k = 0; k < n; k++) {
        right[k] = !bgc_fmi_is_free(i, k) ? 0.0 : coupled ? right[k] : right[k] * i->d->inverse_mass[k];
    }
    if (!coupled) {
        return BGC_FMI_OK;
    }
    memset(i->matrix, 0, (size_t)n * (size_t)n * sizeof *i->matrix);
    for (int k = 0; k < m->n_mass; k++) {
        const int r = transposed ? m->mass_col[k] : m->mass_row[k];
        const int c = transposed ? m->mass_row[k] : m->mass_col[k];
        i->matrix[(size_t)r * (size_t)n + (size_t)c] += i->d->mass[k];
    }
    for (int k = 0; k < n; k++) {
        i->matrix[(size_t)k * (size_t)(n + 1)] += bgc_fmi_is_free(i, k) ? 0.0 : 1.0;
    }
    return bgc_fmi_solve_matrix(i, right);
}

/* --- places of references ------------------------------------------------------------------------ */

typedef enum { AS_KNOWN, AS_UNKNOWN } role;

/* The column of a known or the row of an unknown; a row of an unknown state is -2 - its number; -1: neither. */
static int place_of(const bgc_fmi *i, unsigned ref, role as) {
    const bgc_model *m = i->m;
    const int at = (int)ref, n = m->n_state;
    const int inputs = bgc_fmi_place(i, BGC_FMI_INPUTS), outputs = bgc_fmi_place(i, BGC_FMI_OUTPUTS);
    const int accounts = bgc_fmi_place(i, BGC_FMI_ACCOUNTS), states = bgc_fmi_place(i, BGC_FMI_STATES);
    const int rates = bgc_fmi_place(i, BGC_FMI_RATES), powers = bgc_fmi_place(i, BGC_FMI_POWERS);

    if (as == AS_KNOWN) {
        return at >= states && at < rates     ? at - states
               : at >= inputs && at < outputs ? n + at - inputs
               : at > accounts && at <= accounts + 2 && i->info->n_continuous > i->info->n_free
                   ? n + m->n_input + at - accounts - 1
                   : -1;
    }
    return at >= rates && at < powers       ? at - rates
           : at >= states && at < rates     ? -2 - (at - states)
           : at >= outputs && at < accounts ? n + at - outputs
           : at >= accounts && at < accounts + 4 ? n + m->n_output + m->n_command + 3 + at - accounts
           : at >= powers && at < powers + 2     ? n + m->n_output + m->n_command + 1 + at - powers
                                                 : -1;
}

/* One number of a call: where it belongs, and where it is in the importer's array. */
typedef bgc_fmi_status (*visitor)(bgc_fmi *i, int place, double *value);

static bgc_fmi_status visit(bgc_fmi *i, const unsigned *ref, size_t n, role as, double *numbers,
                            size_t size, visitor each) {
    size_t at = 0;

    for (size_t r = 0; r < n; r++) {
        const int known = ref[r] < (unsigned)bgc_fmi_references(i);
        const int count = known ? i->info->count[ref[r]] : 0;
        for (int c = 0; c < count || c == 0; c++) {
            const int place = count > 0 ? place_of(i, ref[r] + (unsigned)c, as) : -1;
            if (place == -1 || at >= size) {
                char text[200];
                snprintf(text, sizeof text, "value reference %u has no derivative of this kind", ref[r]);
                return bgc_fmi_report(i, BGC_FMI_ERROR, text);
            }
            if (each(i, place, &numbers[at++]) != BGC_FMI_OK) {
                return BGC_FMI_ERROR;
            }
        }
    }
    return at == size ? BGC_FMI_OK : bgc_fmi_report(i, BGC_FMI_ERROR, "the number of values is wrong");
}

static bgc_fmi_status add_to_seed(bgc_fmi *i, int place, double *value) {
    i->seed[place] += *value;
    return BGC_FMI_OK;
}

/* Of the accounts by the states: stored energy less supplied plus dissipated is the residual. */
enum { STORED, SUPPLIED, DISSIPATED };

static bgc_fmi_status read_result(bgc_fmi *i, int place, double *value) {
    const bgc_model *m = i->m;
    const int energies = m->n_state + m->n_output + m->n_command;
    const double *account = i->seed + m->n_state + m->n_input;

    if (place <= -2) {
        *value = i->seed[-2 - place];
    } else if (place < energies + 3) {
        *value = i->result[place];
    } else {
        switch (place - energies - 3) {
        case STORED:
            *value = i->result[energies];
            break;
        case SUPPLIED:
            *value = account[0];
            break;
        case DISSIPATED:
            *value = account[1];
            break;
        default:
            *value = i->result[energies] - account[0] + account[1];
        }
    }
    return BGC_FMI_OK;
}

static bgc_fmi_status add_to_result(bgc_fmi *i, int place, double *value) {
    const bgc_model *m = i->m;
    const int energies = m->n_state + m->n_output + m->n_command;
    double *account = i->seed + m->n_state + m->n_input;

    if (place <= -2) {
        i->seed[-2 - place] += *value;
    } else if (place < energies + 3) {
        i->result[place] += *value;
    } else {
        const int kind = place - energies - 3;
        i->result[energies] += kind == STORED || kind > DISSIPATED ? *value : 0.0;
        account[0] += kind == SUPPLIED ? *value : kind > DISSIPATED ? -*value : 0.0;
        account[1] += kind == DISSIPATED || kind > DISSIPATED ? *value : 0.0;
    }
    return BGC_FMI_OK;
}

static bgc_fmi_status read_seed(bgc_fmi *i, int place, double *value) {
    *value = i->seed[place];
    return BGC_FMI_OK;
}

/* --- the derivatives ------------------------------------------------------------------------------ */

/* df/dx reads the inputs of the instance, which are those of the view meanwhile. */
static void evaluate_partials(bgc_fmi *i) {
    const bgc_model *m = i->m;
    bgc_data *d = i->d;
    const size_t inputs = ((size_t)m->n_input + (size_t)m->n_switch) * sizeof *d->u;

    memcpy(i->inputs, d->u, inputs);
    memcpy(d->u, i->view_u, inputs);
    bgc_differentiate(m, d, i->core.t, i->view_x, i->partial, d->dfdt);
    memcpy(d->u, i->inputs, inputs);
    d->core.jac_valid = 0;
    i->info->partials(d->h, i->core.t, i->view_x, i->view_u, i->partial + m->n_jac, d->work);
}

static bgc_fmi_status begin(bgc_fmi *i) {
    const bgc_model *m = i->m;
    const size_t columns = (size_t)m->n_state + (size_t)m->n_input + 2;
    const size_t rows = (size_t)m->n_state + (size_t)m->n_output + (size_t)m->n_command + 3;
    bgc_fmi_status status;

    if (!i->info->derivatives) {
        return bgc_fmi_report(i, BGC_FMI_ERROR, "this model has no directional derivatives");
    }
    status = bgc_fmi_view(i);
    if (status == BGC_FMI_OK) {
        evaluate_partials(i);
        memset(i->seed, 0, columns * sizeof *i->seed);
        memset(i->result, 0, rows * sizeof *i->result);
    }
    return status;
}

/* result = J seed. */
static void multiply_partials(bgc_fmi *i) {
    const size_t rows = (size_t)i->m->n_state + (size_t)i->m->n_output + (size_t)i->m->n_command + 3;

    memset(i->result, 0, rows * sizeof *i->result);
    for (int e = 0; e < i->n_partial; e++) {
        i->result[i->partial_row[e]] += i->partial[e] * i->seed[i->partial_col[e]];
    }
}

/* sensitivity = d(unknowns)/d(knowns) seed. */
bgc_fmi_status bgc_fmi_directional(bgc_fmi *i, const unsigned *unknown, size_t n_unknown,
                                   const unsigned *known, size_t n_known, const double *seed,
                                   size_t n_seed, double *result, size_t n_result) {
    const int n = i->m->n_state;
    bgc_fmi_status status = begin(i);

    if (status == BGC_FMI_OK) {
        status = visit(i, known, n_known, AS_KNOWN, (double *)seed, n_seed, add_to_seed);
    }
    if (status == BGC_FMI_OK && i->d->core.algebraic > 0) {
        multiply_partials(i);
        status = bgc_fmi_solve_algebraic(i, i->result, 0);
        for (int k = 0; k < n && status == BGC_FMI_OK; k++) {
            i->seed[k] = bgc_fmi_is_free(i, k) ? i->seed[k] : -i->result[k];
        }
    }
    if (status == BGC_FMI_OK) {
        multiply_partials(i);
        status = solve_mass(i, i->result, 0);
    }
    return status == BGC_FMI_OK
               ? visit(i, unknown, n_unknown, AS_UNKNOWN, result, n_result, read_result)
               : status;
}

/* sensitivity = seed' d(unknowns)/d(knowns). */
bgc_fmi_status bgc_fmi_adjoint(bgc_fmi *i, const unsigned *unknown, size_t n_unknown,
                               const unsigned *known, size_t n_known, const double *seed, size_t n_seed,
                               double *result, size_t n_result) {
    const int n = i->m->n_state;
    bgc_fmi_status status = begin(i);

    if (status == BGC_FMI_OK) {
        status = visit(i, unknown, n_unknown, AS_UNKNOWN, (double *)seed, n_seed, add_to_result);
    }
    if (status == BGC_FMI_OK) {
        status = solve_mass(i, i->result, 1);
    }
    if (status != BGC_FMI_OK) {
        return status;
    }
    for (int e = 0; e < i->n_partial; e++) {
        i->seed[i->partial_col[e]] += i->partial[e] * i->result[i->partial_row[e]];
    }
    if (i->d->core.algebraic > 0) {
        memcpy(i->rate, i->seed, (size_t)n * sizeof *i->rate);
        status = bgc_fmi_solve_algebraic(i, i->rate, 1);
        for (int e = 0; e < i->n_partial && status == BGC_FMI_OK; e++) {
            const int row = i->partial_row[e];
            if (row < n && !bgc_fmi_is_free(i, row)) {
                i->seed[i->partial_col[e]] -= i->partial[e] * i->rate[row];
            }
        }
    }
    return status == BGC_FMI_OK ? visit(i, known, n_known, AS_KNOWN, result, n_result, read_seed)
                                : status;
}

/* run.c: a run: rows of outputs at given times, and samples of the devices. */
#include "bgc_internal.h"
#include "control.h"

#include <math.h>
#include <string.h>
#include <time.h>

/* --- samples ------------------------------------------------------------------------------- */

/* Applies inputs that have been written: states without a rate and modes may jump. */
bgc_status bgc_apply_inputs(const bgc_model *m, bgc_data *d) {
    const size_t size = (size_t)m->n_input * sizeof *d->u;
    bgc_status status;

    if (memcmp(d->u, d->u_seen, size) == 0) {
        return BGC_OK;
    }
    d->core.f_valid = d->core.jac_valid = 0;
    memcpy(d->u_seen, d->u, size);
    bgc_reset_time_windows(m, d);
    status = bgc_settle(m, d);
    if (status == BGC_OK && m->n_jump > 0) {
        status = bgc_jump(m, d, NULL, 0.0);
    }
    bgc_hold_modes(m, d);
    return status;
}

/* Before and after what follows from other inputs, also beside the run. */
static void expect_inputs(const bgc_model *m, bgc_data *d) {
    if (d->follower != NULL) {
        d->follower->before_inputs(m, d, d->follower->of);
    }
}
static bgc_status follow_inputs(const bgc_model *m, bgc_data *d) {
    const bgc_status status = bgc_apply_inputs(m, d);

    return status == BGC_OK && d->follower != NULL ? d->follower->inputs(m, d, d->follower->of) : status;
}

/* Reads the devices. */
static bgc_status read_inputs(const bgc_model *m, bgc_data *d) {
    bgc_status status;

    expect_inputs(m, d);
    status = bgc_read_devices(m, d);
    return status == BGC_OK ? follow_inputs(m, d) : status;
}

/* After a sample of the devices: the time of the next one. */
static void count_sample(const bgc_model *m, bgc_core *core) {
    core->sample++;
    bgc_schedule(core);
    core->counts.samples += m->n_device > 0;
    core->counts.worst_sample_seconds = fmax(core->counts.worst_sample_seconds, core->since_sample);
    core->since_sample = 0.0;
}

/* In a model with sampled parts: these are evaluated between reading the devices and writing to them. */
static bgc_status sample_parts(const bgc_model *m, bgc_data *d, double slack) {
    bgc_core *core = &d->core;
    const int due = core->period > 0.0 &&
                    core->t >= core->origin + (double)core->sample * core->period - slack;
    bgc_status status = due ? read_inputs(m, d) : BGC_OK;

    if (status == BGC_OK && core->t >= core->instant - slack) {
        core->sampled_at = core->t;
        expect_inputs(m, d);
        status = bgc_take_sampled(m, d, slack);
        if (status == BGC_OK) {
            status = follow_inputs(m, d);
        }
    }
    if (status == BGC_OK && due) {
        status = bgc_write_devices(m, d);
        if (status == BGC_OK) {
            count_sample(m, core);
        }
    }
    return status;
}

/* Where a sample is due: reads the devices and writes commands to them. */
bgc_status bgc_sample(const bgc_model *m, bgc_data *d) {
    bgc_core *core = &d->core;
    const double slack = bgc_time_slack(core->t, core->t_old);
    bgc_status status;

    if (core->t < core->due - slack) {
        return BGC_OK;
    }
    if (m->n_rate > 0) {
        return sample_parts(m, d, slack);
    }
    status = read_inputs(m, d);
    if (status == BGC_OK) {
        status = bgc_write_devices(m, d);
    }
    if (status == BGC_OK) {
        count_sample(m, core);
    }
    return status;
}

/* --- rows ---------------------------------------------------------------------------------- */

/* Monotonic time, s. */
static double seconds(void) {
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Integrates until the present is at or beyond t, and takes the sample that is due at t or leaves it.
 * The clock is read once a step: reading it takes a fifth of the time of a large right-hand side. */
static bgc_status advance_to(const bgc_model *m, bgc_data *d, double t, int takes_sample) {
    bgc_core *core = &d->core;
    double start = -1.0; /* not read yet */

    for (long attempts = 0;; attempts++) {
        const int64_t before = core->sample;
        const double slack = bgc_time_slack(core->t, core->t_old);
        const int is_past = takes_sample ? core->t > t + slack : core->t >= t - slack;
        bgc_status status = is_past ? BGC_OK : bgc_sample(m, d);
        double now;

        /* Done, or stopped. */
        if (status != BGC_OK || core->t >= t - slack) {
            return status;
        }
        if (attempts >= core->max_steps) {
            return BGC_TOO_MANY_STEPS;
        }
        if (atomic_exchange(&d->stop, 0) != 0) {
            return BGC_INTERRUPTED;
        }

        /* One attempt, timed without the devices. */
        if (start < 0.0 || core->sample != before) {
            start = seconds();
        }
        status = bgc_attempt(m, d);
        now = seconds();
        core->counts.worst_step_seconds = fmax(core->counts.worst_step_seconds, now - start);
        core->since_sample += now - start;
        start = now;
        if (status != BGC_OK) {
            return status;
        }
    }
}

/* Whether a row at t is before an event at which the last step ended, be it by rounding: a row at the time of
 * `time > 1` has the values before. Where an instant of sampled parts is there too, it has the values after both. */
static int is_before_event(const bgc_core *core, double t) {
    return t < core->t && core->event_at == core->t && core->sampled_at != core->t &&
           core->dense != BGC_NO_DENSE;
}

/* Writes a row: outputs and accounts, at the present or inside the last step.
 * BGC_NOT_FINITE where an energy is not: it overflows before the states that it is a square of. */
bgc_status bgc_write_row(const bgc_model *m, bgc_data *d, double t, double *row) {
    const bgc_core *core = &d->core;
    const int inside = is_before_event(core, t) || t < core->t - bgc_time_slack(core->t, core->t_old);
    bgc_status status = BGC_OK;

    if (inside &&
        (core->dense == BGC_NO_DENSE || t < core->t_old - bgc_time_slack(core->t, core->t_old))) {
        return BGC_BAD_ARGUMENT;
    }
    bgc_evaluate_row(m, d, t, inside, row);
    if (d->follower != NULL) {
        status = d->follower->row(m, d, d->follower->of, t, inside);
    }
    if (status != BGC_OK) {
        return status;
    }
    if (core->errors) {
        bgc_write_errors(m, d, t, inside, row, row + m->n_output + (core->accounts ? 4 : 0));
    }
    if (core->accounts && bgc_first_bad(4, row + m->n_output) >= 0) {
        d->core.failed_state = -1;
        return BGC_NOT_FINITE;
    }
    return BGC_OK;
}

bgc_status bgc_state_at(const bgc_model *m, bgc_data *d, double t, double *x) {
    const bgc_core *core = &d->core;
    const double slack = bgc_time_slack(core->t, core->t_old);

    if (t >= core->t - slack) {
        memcpy(x, d->x, (size_t)m->n_state * sizeof *x);
        return t <= core->t + slack ? BGC_OK : BGC_BAD_ARGUMENT;
    }
    if (core->dense == BGC_NO_DENSE || t < core->t_old - slack) {
        return BGC_BAD_ARGUMENT;
    }
    bgc_interpolate(m, d, t, d->point);
    memcpy(x, d->point, (size_t)m->n_state * sizeof *x);
    return BGC_OK;
}

/* All rows; *done counts the finished ones. */
static bgc_status run(const bgc_model *m, bgc_data *d, const double *times, size_t n, double *rows,
                      size_t *done) {
    const size_t outputs = (size_t)m->n_output;
    const size_t width = outputs + (d->core.accounts ? 4 : 0) + (d->core.errors ? outputs : 0);
    bgc_status status;

    for (size_t i = 0; i < n; i++) {
        if (!isfinite(times[i]) || (i > 0 && times[i] < times[i - 1])) {
            return BGC_BAD_ARGUMENT;
        }
    }
    status = bgc_apply_inputs(m, d);
    if (status == BGC_OK) {
        status = bgc_check_asserts(m, d, d->core.t, d->x);
    }
    for (size_t i = 0; i < n && status == BGC_OK; i++) {
        status = advance_to(m, d, times[i], 1);
        if (status == BGC_OK) {
            status = bgc_write_row(m, d, times[i], rows + i * width);
        }
        *done += status == BGC_OK;
    }
    return status;
}

/* A call that integrates until a time. The caller may have written x and u. */
static void begin_run(const bgc_model *m, bgc_data *d, double until) {
    d->core.until = until;
    d->core.f_valid = d->core.jac_valid = 0;
    bgc_find_modes(m, d);
    bgc_hold_modes(m, d);
}

/* Forces are zero after a failure. */
static void end_run(const bgc_model *m, bgc_data *d, bgc_status status, double start) {
    bgc_release_modes(m, d);
    bgc_report_correction(m, d);
    if (status != BGC_OK) {
        bgc_zero_devices(m, d);
    }
    d->core.counts.run_seconds += seconds() - start;
}

double bgc_sample_period(const bgc_data *d) { return d->core.period; }

bgc_status bgc_advance(const bgc_model *m, bgc_data *d, double t) {
    const double start = seconds();
    bgc_status status;

    if (!d->core.ready || !isfinite(t)) {
        return BGC_BAD_ARGUMENT;
    }
    begin_run(m, d, t);
    status = bgc_apply_inputs(m, d);
    if (status == BGC_OK) {
        status = advance_to(m, d, t, 0);
    }
    end_run(m, d, status, start);
    return status;
}

bgc_status bgc_run(const bgc_model *m, bgc_data *d, const double *times, size_t n, double *rows,
                   size_t *done) {
    const double start = seconds();
    bgc_status status;

    *done = 0;
    if (!d->core.ready) {
        return BGC_BAD_ARGUMENT;
    }

    begin_run(m, d, n > 0 ? times[n - 1] : d->core.t);
    status = run(m, d, times, n, rows, done);
    end_run(m, d, status, start);
    return status;
}

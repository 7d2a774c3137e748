/* fmi3.c: the functions of FMI 3.0, Model Exchange and Co-Simulation.
 *
 * There are no clocks, so no Scheduled Execution: its functions exist and report errors. In Co-Simulation
 * the intermediate update is called after each internal step; the importer may read variables there and
 * ask for an early return.
 */
#include "fmi.h"
#include "fmi3.h"

#define EXPORTED3(type) BGC_EXPORT type
#define AS3(instance) ((bgc_fmi *)(instance))

static fmi3Status status3(bgc_fmi_status status) { return (fmi3Status)status; }

static fmi3Status refuse3(fmi3Instance instance, const char *text) {
    return status3(bgc_fmi_report(AS3(instance), BGC_FMI_ERROR, text));
}

/* --- callbacks --------------------------------------------------------------------------------- */

static void log3_message(bgc_fmi *i, bgc_fmi_status status, const char *message) {
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)i->logger;

    if (logger != NULL) {
        logger(i->environment, status3(status),
               status >= BGC_FMI_ERROR     ? "logStatusError"
               : status == BGC_FMI_DISCARD ? "logStatusDiscard"
                                           : "logStatusWarning",
               message);
    }
}

static int update_after_step(bgc_fmi *i, double t, double *stop) {
    const fmi3IntermediateUpdateCallback update = (fmi3IntermediateUpdateCallback)i->update;
    fmi3Boolean requested = false;
    fmi3Float64 at = t;

    if (update == NULL) {
        return 0;
    }
    update(i->environment, t, false, true, true, i->may_return_early != 0, &requested, &at);
    *stop = at;
    return requested && i->may_return_early;
}

/* --- instances --------------------------------------------------------------------------------- */

EXPORTED3(const char *) BGC_FMI3(fmi3GetVersion)(void) { return "3.0"; }

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetDebugLogging)(fmi3Instance instance, fmi3Boolean on, size_t n,
                                                    const fmi3String categories[]) {
    (void)n, (void)categories;
    AS3(instance)->logs = on;
    return fmi3OK;
}

EXPORTED3(fmi3Instance) BGC_FMI3(fmi3InstantiateModelExchange)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
    const bgc_fmi_hooks hooks = {log3_message, NULL};
    bgc_fmi *i = bgc_fmi_new(BGC_FMI_MODEL_EXCHANGE, name, token, &hooks, environment,
                             (void (*)(void))logger);

    (void)resources, (void)visible;
    if (i != NULL) {
        i->logs = logging;
    }
    return i;
}

EXPORTED3(fmi3Instance) BGC_FMI3(fmi3InstantiateCoSimulation)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference required[],
    size_t n_required, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3IntermediateUpdateCallback update) {
    const bgc_fmi_hooks hooks = {log3_message, update_after_step};
    bgc_fmi *i = bgc_fmi_new(BGC_FMI_CO_SIMULATION, name, token, &hooks, environment,
                             (void (*)(void))logger);

    (void)resources, (void)visible, (void)required, (void)n_required;
    if (i != NULL) {
        i->logs = logging;
        i->update = (void (*)(void))update;
        i->may_return_early = early_return;
        i->event_mode = event_mode;
    }
    return i;
}

EXPORTED3(fmi3Instance) BGC_FMI3(fmi3InstantiateScheduledExecution)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger, fmi3ClockUpdateCallback clock,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock, (void)lock;
    (void)unlock;
    if (logger != NULL) {
        logger(environment, fmi3Error, "logStatusError", "this FMU has no Scheduled Execution");
    }
    return NULL;
}

EXPORTED3(void) BGC_FMI3(fmi3FreeInstance)(fmi3Instance instance) { bgc_fmi_free(AS3(instance)); }

EXPORTED3(fmi3Status) BGC_FMI3(fmi3EnterInitializationMode)(fmi3Instance instance,
                                                            fmi3Boolean tolerance_defined,
                                                            fmi3Float64 tolerance, fmi3Float64 start,
                                                            fmi3Boolean stop_defined,
                                                            fmi3Float64 stop) {
    (void)stop_defined, (void)stop;
    return status3(
        bgc_fmi_enter_initialisation(AS3(instance), tolerance_defined ? tolerance : 0.0, start));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3ExitInitializationMode)(fmi3Instance instance) {
    bgc_fmi *i = AS3(instance);
    const bgc_fmi_status status = bgc_fmi_exit_initialisation(i);

    if (status == BGC_FMI_OK && i->event_mode) {
        i->core.phase = BGC_FMI_EVENTS;
    }
    return status3(status);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3EnterEventMode)(fmi3Instance instance) {
    AS3(instance)->core.phase = BGC_FMI_EVENTS;
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3Terminate)(fmi3Instance instance) {
    AS3(instance)->core.phase = BGC_FMI_TERMINATED;
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3Reset)(fmi3Instance instance) {
    return status3(bgc_fmi_reset(AS3(instance)));
}

/* --- variables ----------------------------------------------------------------------------------- */

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetFloat64)(fmi3Instance instance, const fmi3ValueReference ref[],
                                               size_t n, fmi3Float64 value[], size_t n_value) {
    return status3(bgc_fmi_get(AS3(instance), ref, n, value, n_value));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetFloat64)(fmi3Instance instance, const fmi3ValueReference ref[],
                                               size_t n, const fmi3Float64 value[], size_t n_value) {
    return status3(bgc_fmi_set(AS3(instance), ref, n, value, n_value));
}

/* Functions for variables of other types, which this FMU does not have. */
static fmi3Status without(fmi3Instance instance, size_t n, const char *name) {
    char text[200];

    if (n == 0) {
        return fmi3OK;
    }
    snprintf(text, sizeof text, "%s: all variables of this FMU are of type Float64", name);
    return refuse3(instance, text);
}

#define WITHOUT_VARIABLES3(kind)                                                                        \
    EXPORTED3(fmi3Status) BGC_FMI3(fmi3Get##kind)(fmi3Instance instance,                                \
                                                  const fmi3ValueReference ref[], size_t n,             \
                                                  fmi3##kind value[], size_t n_value) {                 \
        (void)ref, (void)value, (void)n_value;                                                          \
        return without(instance, n, "fmi3Get" #kind);                                                   \
    }                                                                                                   \
    EXPORTED3(fmi3Status) BGC_FMI3(fmi3Set##kind)(fmi3Instance instance,                                \
                                                  const fmi3ValueReference ref[], size_t n,             \
                                                  const fmi3##kind value[], size_t n_value) {           \
        (void)ref, (void)value, (void)n_value;                                                          \
        return without(instance, n, "fmi3Set" #kind);                                                   \
    }
WITHOUT_VARIABLES3(Float32)
WITHOUT_VARIABLES3(Int8)
WITHOUT_VARIABLES3(UInt8)
WITHOUT_VARIABLES3(Int16)
WITHOUT_VARIABLES3(UInt16)
WITHOUT_VARIABLES3(Int32)
WITHOUT_VARIABLES3(UInt32)
WITHOUT_VARIABLES3(Int64)
WITHOUT_VARIABLES3(UInt64)
WITHOUT_VARIABLES3(Boolean)
WITHOUT_VARIABLES3(String)

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetBinary)(fmi3Instance instance, const fmi3ValueReference ref[],
                                              size_t n, size_t size[], fmi3Binary value[],
                                              size_t n_value) {
    (void)ref, (void)size, (void)value, (void)n_value;
    return without(instance, n, "fmi3GetBinary");
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetBinary)(fmi3Instance instance, const fmi3ValueReference ref[],
                                              size_t n, const size_t size[], const fmi3Binary value[],
                                              size_t n_value) {
    (void)ref, (void)size, (void)value, (void)n_value;
    return without(instance, n, "fmi3SetBinary");
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetClock)(fmi3Instance instance, const fmi3ValueReference ref[],
                                             size_t n, fmi3Clock value[]) {
    (void)ref, (void)value;
    return without(instance, n, "fmi3GetClock");
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetClock)(fmi3Instance instance, const fmi3ValueReference ref[],
                                             size_t n, const fmi3Clock value[]) {
    (void)ref, (void)value;
    return without(instance, n, "fmi3SetClock");
}

/* Dependencies stand in the model description; sizes of arrays do not change. */
EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetNumberOfVariableDependencies)(fmi3Instance instance,
                                                                    fmi3ValueReference ref, size_t *n) {
    (void)ref, (void)n;
    return refuse3(instance, "the model description lists all dependencies");
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetVariableDependencies)(
    fmi3Instance instance, fmi3ValueReference ref, size_t element[], fmi3ValueReference independent[],
    size_t independent_element[], fmi3DependencyKind kind[], size_t n) {
    (void)ref, (void)element, (void)independent, (void)independent_element, (void)kind, (void)n;
    return refuse3(instance, "the model description lists all dependencies");
}

/* --- FMU states ------------------------------------------------------------------------------------ */

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetFMUState)(fmi3Instance instance, fmi3FMUState *state) {
    if (*state == NULL) {
        *state = malloc(bgc_fmi_state_size(AS3(instance)));
    }
    if (*state == NULL) {
        return refuse3(instance, "out of memory");
    }
    bgc_fmi_save(AS3(instance), *state);
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetFMUState)(fmi3Instance instance, fmi3FMUState state) {
    return state == NULL ? fmi3Error : status3(bgc_fmi_restore(AS3(instance), state));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3FreeFMUState)(fmi3Instance instance, fmi3FMUState *state) {
    (void)instance;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SerializedFMUStateSize)(fmi3Instance instance, fmi3FMUState state,
                                                           size_t *size) {
    (void)state;
    *size = bgc_fmi_state_size(AS3(instance));
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SerializeFMUState)(fmi3Instance instance, fmi3FMUState state,
                                                      fmi3Byte bytes[], size_t size) {
    if (size < bgc_fmi_state_size(AS3(instance))) {
        return refuse3(instance, "too little memory for the FMU state");
    }
    memcpy(bytes, state, bgc_fmi_state_size(AS3(instance)));
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3DeserializeFMUState)(fmi3Instance instance, const fmi3Byte bytes[],
                                                        size_t size, fmi3FMUState *state) {
    if (size != bgc_fmi_state_size(AS3(instance))) {
        return refuse3(instance, "the FMU state belongs to another model");
    }
    if (*state == NULL) {
        *state = malloc(size);
    }
    if (*state == NULL) {
        return refuse3(instance, "out of memory");
    }
    memcpy(*state, bytes, size);
    return fmi3OK;
}

/* --- derivatives ------------------------------------------------------------------------------------ */

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetDirectionalDerivative)(
    fmi3Instance instance, const fmi3ValueReference unknown[], size_t n_unknown,
    const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
    fmi3Float64 sensitivity[], size_t n_sensitivity) {
    return status3(bgc_fmi_directional(AS3(instance), unknown, n_unknown, known, n_known, seed, n_seed,
                                       sensitivity, n_sensitivity));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetAdjointDerivative)(
    fmi3Instance instance, const fmi3ValueReference unknown[], size_t n_unknown,
    const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
    fmi3Float64 sensitivity[], size_t n_sensitivity) {
    return status3(bgc_fmi_adjoint(AS3(instance), unknown, n_unknown, known, n_known, seed, n_seed,
                                   sensitivity, n_sensitivity));
}

/* --- configuration and clocks ------------------------------------------------------------------------ */

EXPORTED3(fmi3Status) BGC_FMI3(fmi3EnterConfigurationMode)(fmi3Instance instance) {
    return refuse3(instance, "this FMU has no structural parameters to configure");
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3ExitConfigurationMode)(fmi3Instance instance) {
    return refuse3(instance, "this FMU has no structural parameters to configure");
}

static fmi3Status no_clocks(fmi3Instance instance, size_t n) {
    return n == 0 ? fmi3OK : refuse3(instance, "this FMU has no clocks");
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetIntervalDecimal)(fmi3Instance instance,
                                                       const fmi3ValueReference ref[], size_t n,
                                                       fmi3Float64 interval[],
                                                       fmi3IntervalQualifier qualifier[]) {
    (void)ref, (void)interval, (void)qualifier;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetIntervalFraction)(fmi3Instance instance,
                                                        const fmi3ValueReference ref[], size_t n,
                                                        fmi3UInt64 counter[], fmi3UInt64 per_second[],
                                                        fmi3IntervalQualifier qualifier[]) {
    (void)ref, (void)counter, (void)per_second, (void)qualifier;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetShiftDecimal)(fmi3Instance instance,
                                                    const fmi3ValueReference ref[], size_t n,
                                                    fmi3Float64 offset[]) {
    (void)ref, (void)offset;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetShiftFraction)(fmi3Instance instance,
                                                     const fmi3ValueReference ref[], size_t n,
                                                     fmi3UInt64 counter[], fmi3UInt64 per_second[]) {
    (void)ref, (void)counter, (void)per_second;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetIntervalDecimal)(fmi3Instance instance,
                                                       const fmi3ValueReference ref[], size_t n,
                                                       const fmi3Float64 interval[]) {
    (void)ref, (void)interval;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetIntervalFraction)(fmi3Instance instance,
                                                        const fmi3ValueReference ref[], size_t n,
                                                        const fmi3UInt64 counter[],
                                                        const fmi3UInt64 per_second[]) {
    (void)ref, (void)counter, (void)per_second;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetShiftDecimal)(fmi3Instance instance,
                                                    const fmi3ValueReference ref[], size_t n,
                                                    const fmi3Float64 offset[]) {
    (void)ref, (void)offset;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetShiftFraction)(fmi3Instance instance,
                                                     const fmi3ValueReference ref[], size_t n,
                                                     const fmi3UInt64 counter[],
                                                     const fmi3UInt64 per_second[]) {
    (void)ref, (void)counter, (void)per_second;
    return no_clocks(instance, n);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3ActivateModelPartition)(fmi3Instance instance,
                                                           fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    return refuse3(instance, "this FMU has no Scheduled Execution");
}

/* --- events ------------------------------------------------------------------------------------------ */

EXPORTED3(fmi3Status) BGC_FMI3(fmi3EvaluateDiscreteStates)(fmi3Instance instance) {
    (void)instance;
    return fmi3OK;
}

/* In Co-Simulation the solver handles the events of the model, and inputs act at the next step. */
EXPORTED3(fmi3Status) BGC_FMI3(fmi3UpdateDiscreteStates)(
    fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
    fmi3Boolean *values_changed, fmi3Boolean *next_defined, fmi3Float64 *next_time) {
    bgc_fmi *i = AS3(instance);
    double next = (double)INFINITY;
    int changed = 0;
    const bgc_fmi_status status = i->kind == BGC_FMI_MODEL_EXCHANGE
                                      ? bgc_fmi_handle_events(i, &changed, &next)
                                      : BGC_FMI_OK;

    *again = *terminate = *nominals_changed = false;
    *values_changed = changed != 0;
    *next_defined = isfinite(next) != 0;
    *next_time = isfinite(next) ? next : 0.0;
    return status3(status);
}

/* --- Model Exchange ---------------------------------------------------------------------------------- */

EXPORTED3(fmi3Status) BGC_FMI3(fmi3EnterContinuousTimeMode)(fmi3Instance instance) {
    AS3(instance)->core.phase = BGC_FMI_CONTINUOUS;
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3CompletedIntegratorStep)(fmi3Instance instance,
                                                            fmi3Boolean no_rollback, fmi3Boolean *event,
                                                            fmi3Boolean *terminate) {
    int wanted = 0;
    const bgc_fmi_status status = bgc_fmi_completed_step(AS3(instance), &wanted);

    (void)no_rollback;
    *event = wanted != 0;
    *terminate = false;
    return status3(status);
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetTime)(fmi3Instance instance, fmi3Float64 time) {
    bgc_fmi_set_time(AS3(instance), time);
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3SetContinuousStates)(fmi3Instance instance, const fmi3Float64 x[],
                                                        size_t n) {
    return status3(bgc_fmi_set_states(AS3(instance), x, n));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetContinuousStateDerivatives)(fmi3Instance instance,
                                                                  fmi3Float64 rate[], size_t n) {
    return status3(bgc_fmi_get_rates(AS3(instance), rate, n));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetEventIndicators)(fmi3Instance instance, fmi3Float64 z[], size_t n) {
    return status3(bgc_fmi_get_indicators(AS3(instance), z, n));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetContinuousStates)(fmi3Instance instance, fmi3Float64 x[], size_t n) {
    return status3(bgc_fmi_get_states(AS3(instance), x, n));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetNominalsOfContinuousStates)(fmi3Instance instance, fmi3Float64 x[],
                                                                  size_t n) {
    return status3(bgc_fmi_get_nominals(AS3(instance), x, n));
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *n) {
    *n = (size_t)AS3(instance)->m->n_switch;
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetNumberOfContinuousStates)(fmi3Instance instance, size_t *n) {
    *n = (size_t)AS3(instance)->info->n_continuous;
    return fmi3OK;
}

/* --- Co-Simulation ----------------------------------------------------------------------------------- */

EXPORTED3(fmi3Status) BGC_FMI3(fmi3EnterStepMode)(fmi3Instance instance) {
    AS3(instance)->core.phase = BGC_FMI_STEPS;
    return fmi3OK;
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3GetOutputDerivatives)(fmi3Instance instance,
                                                         const fmi3ValueReference ref[], size_t n,
                                                         const fmi3Int32 order[], fmi3Float64 value[],
                                                         size_t n_value) {
    (void)ref, (void)order, (void)value, (void)n_value;
    return n == 0 ? fmi3OK : refuse3(instance, "derivatives of outputs are not given");
}

EXPORTED3(fmi3Status) BGC_FMI3(fmi3DoStep)(fmi3Instance instance, fmi3Float64 t, fmi3Float64 step,
                                           fmi3Boolean no_rollback, fmi3Boolean *event,
                                           fmi3Boolean *terminate, fmi3Boolean *early,
                                           fmi3Float64 *last) {
    double reached = t;
    const bgc_fmi_status status = bgc_fmi_step(AS3(instance), t, step, &reached);

    (void)no_rollback;
    *event = *terminate = false;
    *early = status == BGC_FMI_OK && reached < t + step;
    *last = reached;
    return status3(status);
}

/* fmi3.c: the functions of FMI 3.0, Model Exchange and Co-Simulation.
 *
 * There are no clocks, so no Scheduled Execution: its functions exist and report errors. In Co-Simulation
 * the intermediate update is called after each internal step; the importer may read variables there and
 * ask for an early return.
 */
#include "fmi.h"
#include "fmi3.h"

#define EXPORTED BGC_EXPORT

/* bgc_fmi_status has the first numbers of fmi3Status. */
static fmi3Status status3(bgc_fmi_status status) { return (fmi3Status)status; }

static fmi3Status refuse3(fmi3Instance instance, const char *text) {
    return status3(bgc_fmi_refuse(instance, text));
}

#define BOOLEAN fmi3Boolean
#define FUNCTION(in_2, in_3, parameters, call) \
    EXPORTED fmi3Status BGC_FMI3(fmi3##in_3) parameters { return status3(call); }
#include "fmi_functions.h"

/* --- callbacks --------------------------------------------------------------------------------- */

static void log3_message(bgc_fmi *i, bgc_fmi_status status, const char *category, const char *message) {
    const fmi3LogMessageCallback logger = (fmi3LogMessageCallback)i->logger;

    if (logger != NULL) {
        logger(i->environment, status3(status), category, message);
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

EXPORTED const char *BGC_FMI3(fmi3GetVersion)(void) { return "3.0"; }

EXPORTED fmi3Instance BGC_FMI3(fmi3InstantiateModelExchange)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
    const bgc_fmi_hooks hooks = {log3_message, NULL};

    (void)resources, (void)visible;
    return bgc_fmi_new(BGC_FMI_MODEL_EXCHANGE, name, token, logging, &hooks, environment,
                       (void (*)(void))logger);
}

EXPORTED fmi3Instance BGC_FMI3(fmi3InstantiateCoSimulation)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference required[],
    size_t n_required, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
    fmi3IntermediateUpdateCallback update) {
    const bgc_fmi_hooks hooks = {log3_message, update_after_step};
    bgc_fmi *i = bgc_fmi_new(BGC_FMI_CO_SIMULATION, name, token, logging, &hooks, environment,
                             (void (*)(void))logger);

    (void)resources, (void)visible, (void)required, (void)n_required;
    if (i != NULL) {
        i->update = (void (*)(void))update;
        i->may_return_early = early_return;
        i->event_mode = event_mode;
    }
    return i;
}

EXPORTED fmi3Instance BGC_FMI3(fmi3InstantiateScheduledExecution)(
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

EXPORTED void BGC_FMI3(fmi3FreeInstance)(fmi3Instance instance) { bgc_fmi_free(instance); }

EXPORTED fmi3Status BGC_FMI3(fmi3EnterInitializationMode)(fmi3Instance instance,
                                                          fmi3Boolean tolerance_defined,
                                                          fmi3Float64 tolerance, fmi3Float64 start,
                                                          fmi3Boolean stop_defined,
                                                          fmi3Float64 stop) {
    (void)stop_defined, (void)stop;
    return status3(
        bgc_fmi_enter_initialisation(instance, tolerance_defined ? tolerance : 0.0, start));
}

/* --- variables ----------------------------------------------------------------------------------- */

EXPORTED fmi3Status BGC_FMI3(fmi3GetFloat64)(fmi3Instance instance, const fmi3ValueReference ref[],
                                             size_t n, fmi3Float64 value[], size_t n_value) {
    return status3(bgc_fmi_get(instance, ref, n, value, n_value));
}

EXPORTED fmi3Status BGC_FMI3(fmi3SetFloat64)(fmi3Instance instance, const fmi3ValueReference ref[],
                                             size_t n, const fmi3Float64 value[], size_t n_value) {
    return status3(bgc_fmi_set(instance, ref, n, value, n_value));
}

/* Functions for variables of other types, which this FMU does not have. */
static fmi3Status without(fmi3Instance instance, size_t n, const char *name) {
    return status3(bgc_fmi_refuse_variables(instance, n, name, "Float64"));
}

#define WITHOUT_VARIABLES3(kind)                                                                     \
    EXPORTED fmi3Status BGC_FMI3(fmi3Get##kind)(fmi3Instance instance,                               \
                                                const fmi3ValueReference ref[], size_t n,            \
                                                fmi3##kind value[], size_t n_value) {                \
        (void)ref, (void)value, (void)n_value;                                                       \
        return without(instance, n, "fmi3Get" #kind);                                                \
    }                                                                                                \
    EXPORTED fmi3Status BGC_FMI3(fmi3Set##kind)(fmi3Instance instance,                               \
                                                const fmi3ValueReference ref[], size_t n,            \
                                                const fmi3##kind value[], size_t n_value) {          \
        (void)ref, (void)value, (void)n_value;                                                       \
        return without(instance, n, "fmi3Set" #kind);                                                \
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

EXPORTED fmi3Status BGC_FMI3(fmi3GetBinary)(fmi3Instance instance, const fmi3ValueReference ref[],
                                            size_t n, size_t size[], fmi3Binary value[],
                                            size_t n_value) {
    (void)ref, (void)size, (void)value, (void)n_value;
    return without(instance, n, "fmi3GetBinary");
}

EXPORTED fmi3Status BGC_FMI3(fmi3SetBinary)(fmi3Instance instance, const fmi3ValueReference ref[],
                                            size_t n, const size_t size[], const fmi3Binary value[],
                                            size_t n_value) {
    (void)ref, (void)size, (void)value, (void)n_value;
    return without(instance, n, "fmi3SetBinary");
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetClock)(fmi3Instance instance, const fmi3ValueReference ref[],
                                           size_t n, fmi3Clock value[]) {
    (void)ref, (void)value;
    return without(instance, n, "fmi3GetClock");
}

EXPORTED fmi3Status BGC_FMI3(fmi3SetClock)(fmi3Instance instance, const fmi3ValueReference ref[],
                                           size_t n, const fmi3Clock value[]) {
    (void)ref, (void)value;
    return without(instance, n, "fmi3SetClock");
}

/* Dependencies stand in the model description; sizes of arrays do not change. */
EXPORTED fmi3Status BGC_FMI3(fmi3GetNumberOfVariableDependencies)(fmi3Instance instance,
                                                                  fmi3ValueReference ref, size_t *n) {
    (void)ref, (void)n;
    return refuse3(instance, "the model description lists all dependencies");
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetVariableDependencies)(
    fmi3Instance instance, fmi3ValueReference ref, size_t element[], fmi3ValueReference independent[],
    size_t independent_element[], fmi3DependencyKind kind[], size_t n) {
    (void)ref, (void)element, (void)independent, (void)independent_element, (void)kind, (void)n;
    return refuse3(instance, "the model description lists all dependencies");
}

/* --- derivatives ------------------------------------------------------------------------------------ */

EXPORTED fmi3Status BGC_FMI3(fmi3GetDirectionalDerivative)(
    fmi3Instance instance, const fmi3ValueReference unknown[], size_t n_unknown,
    const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
    fmi3Float64 sensitivity[], size_t n_sensitivity) {
    return status3(bgc_fmi_directional(instance, unknown, n_unknown, known, n_known, seed, n_seed,
                                       sensitivity, n_sensitivity));
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetAdjointDerivative)(
    fmi3Instance instance, const fmi3ValueReference unknown[], size_t n_unknown,
    const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
    fmi3Float64 sensitivity[], size_t n_sensitivity) {
    return status3(bgc_fmi_adjoint(instance, unknown, n_unknown, known, n_known, seed, n_seed,
                                   sensitivity, n_sensitivity));
}

/* --- configuration and clocks ------------------------------------------------------------------------ */

EXPORTED fmi3Status BGC_FMI3(fmi3EnterConfigurationMode)(fmi3Instance instance) {
    return refuse3(instance, "this FMU has no structural parameters to configure");
}

EXPORTED fmi3Status BGC_FMI3(fmi3ExitConfigurationMode)(fmi3Instance instance) {
    return refuse3(instance, "this FMU has no structural parameters to configure");
}

static fmi3Status no_clocks(fmi3Instance instance, size_t n) {
    return n == 0 ? fmi3OK : refuse3(instance, "this FMU has no clocks");
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetIntervalDecimal)(fmi3Instance instance,
                                                     const fmi3ValueReference ref[], size_t n,
                                                     fmi3Float64 interval[],
                                                     fmi3IntervalQualifier qualifier[]) {
    (void)ref, (void)interval, (void)qualifier;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetIntervalFraction)(fmi3Instance instance,
                                                      const fmi3ValueReference ref[], size_t n,
                                                      fmi3UInt64 counter[], fmi3UInt64 per_second[],
                                                      fmi3IntervalQualifier qualifier[]) {
    (void)ref, (void)counter, (void)per_second, (void)qualifier;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetShiftDecimal)(fmi3Instance instance,
                                                  const fmi3ValueReference ref[], size_t n,
                                                  fmi3Float64 offset[]) {
    (void)ref, (void)offset;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetShiftFraction)(fmi3Instance instance,
                                                   const fmi3ValueReference ref[], size_t n,
                                                   fmi3UInt64 counter[], fmi3UInt64 per_second[]) {
    (void)ref, (void)counter, (void)per_second;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3SetIntervalDecimal)(fmi3Instance instance,
                                                     const fmi3ValueReference ref[], size_t n,
                                                     const fmi3Float64 interval[]) {
    (void)ref, (void)interval;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3SetIntervalFraction)(fmi3Instance instance,
                                                      const fmi3ValueReference ref[], size_t n,
                                                      const fmi3UInt64 counter[],
                                                      const fmi3UInt64 per_second[]) {
    (void)ref, (void)counter, (void)per_second;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3SetShiftDecimal)(fmi3Instance instance,
                                                  const fmi3ValueReference ref[], size_t n,
                                                  const fmi3Float64 offset[]) {
    (void)ref, (void)offset;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3SetShiftFraction)(fmi3Instance instance,
                                                   const fmi3ValueReference ref[], size_t n,
                                                   const fmi3UInt64 counter[],
                                                   const fmi3UInt64 per_second[]) {
    (void)ref, (void)counter, (void)per_second;
    return no_clocks(instance, n);
}

EXPORTED fmi3Status BGC_FMI3(fmi3ActivateModelPartition)(fmi3Instance instance,
                                                         fmi3ValueReference clock, fmi3Float64 time) {
    (void)clock, (void)time;
    return refuse3(instance, "this FMU has no Scheduled Execution");
}

/* --- events ------------------------------------------------------------------------------------------ */

EXPORTED fmi3Status BGC_FMI3(fmi3EvaluateDiscreteStates)(fmi3Instance instance) {
    (void)instance;
    return fmi3OK;
}

/* In Co-Simulation the solver handles the events of the model, and inputs act at the next step. */
EXPORTED fmi3Status BGC_FMI3(fmi3UpdateDiscreteStates)(
    fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
    fmi3Boolean *values_changed, fmi3Boolean *next_defined, fmi3Float64 *next_time) {
    bgc_fmi *i = instance;
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

EXPORTED fmi3Status BGC_FMI3(fmi3CompletedIntegratorStep)(fmi3Instance instance,
                                                          fmi3Boolean no_rollback, fmi3Boolean *event,
                                                          fmi3Boolean *terminate) {
    int wanted = 0;
    const bgc_fmi_status status = bgc_fmi_completed_step(instance, &wanted);

    (void)no_rollback;
    *event = wanted != 0;
    *terminate = false;
    return status3(status);
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetNumberOfEventIndicators)(fmi3Instance instance, size_t *n) {
    *n = (size_t)((bgc_fmi *)instance)->m->n_switch;
    return fmi3OK;
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetNumberOfContinuousStates)(fmi3Instance instance, size_t *n) {
    *n = (size_t)((bgc_fmi *)instance)->info->n_continuous;
    return fmi3OK;
}

/* --- Co-Simulation ----------------------------------------------------------------------------------- */

EXPORTED fmi3Status BGC_FMI3(fmi3EnterStepMode)(fmi3Instance instance) {
    return status3(bgc_fmi_enter(instance, BGC_FMI_STEPS));
}

EXPORTED fmi3Status BGC_FMI3(fmi3GetOutputDerivatives)(fmi3Instance instance,
                                                       const fmi3ValueReference ref[], size_t n,
                                                       const fmi3Int32 order[], fmi3Float64 value[],
                                                       size_t n_value) {
    (void)ref, (void)order, (void)value, (void)n_value;
    return n == 0 ? fmi3OK : refuse3(instance, "derivatives of outputs are not given");
}

EXPORTED fmi3Status BGC_FMI3(fmi3DoStep)(fmi3Instance instance, fmi3Float64 t, fmi3Float64 step,
                                         fmi3Boolean no_rollback, fmi3Boolean *event,
                                         fmi3Boolean *terminate, fmi3Boolean *early,
                                         fmi3Float64 *last) {
    double reached = t;
    const bgc_fmi_status status = bgc_fmi_step(instance, t, step, &reached);

    (void)no_rollback;
    *event = *terminate = false;
    *early = status == BGC_FMI_OK && reached < t + step;
    *last = reached;
    return status3(status);
}

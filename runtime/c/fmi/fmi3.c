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

#define BOOLEAN fmi3Boolean
#define FUNCTION(in_2, in_3, parameters, call) \
    EXPORTED fmi3Status BGC_FMI3(fmi3##in_3) parameters { return status3(call); }
#include "fmi_functions.h"

/* A function of this version alone. */
#define CALL3(name, parameters, call) FUNCTION(, name, parameters, call)

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

CALL3(EnterInitializationMode,
      (fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start,
       fmi3Boolean stop_defined, fmi3Float64 stop),
      ((void)stop_defined, (void)stop, bgc_fmi_enter_initialisation(c,
       tolerance_defined ? tolerance : 0.0, start)))

/* --- variables ----------------------------------------------------------------------------------- */

CALL3(GetFloat64,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, fmi3Float64 value[],
       size_t n_value),
      bgc_fmi_get(c, ref, n, value, n_value))

CALL3(SetFloat64,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3Float64 value[],
       size_t n_value),
      bgc_fmi_set(c, ref, n, value, n_value))

/* Functions for variables of other types, which this FMU does not have. */
static bgc_fmi_status without(bgc_fmi *i, size_t n, const char *name) {
    return bgc_fmi_refuse_variables(i, n, name, "Float64");
}

#define WITHOUT_VARIABLES3(kind)                                                                     \
    CALL3(Get##kind,                                                                                 \
          (fmi3Instance c, const fmi3ValueReference ref[], size_t n, fmi3##kind value[],             \
           size_t n_value),                                                                          \
          ((void)ref, (void)value, (void)n_value, without(c, n, "fmi3Get" #kind)))                   \
    CALL3(Set##kind,                                                                                 \
          (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3##kind value[],       \
           size_t n_value),                                                                          \
          ((void)ref, (void)value, (void)n_value, without(c, n, "fmi3Set" #kind)))
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

CALL3(GetBinary,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, size_t size[], fmi3Binary value[],
       size_t n_value),
      ((void)ref, (void)size, (void)value, (void)n_value, without(c, n, "fmi3GetBinary")))

CALL3(SetBinary,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const size_t size[],
       const fmi3Binary value[], size_t n_value),
      ((void)ref, (void)size, (void)value, (void)n_value, without(c, n, "fmi3SetBinary")))

CALL3(GetClock, (fmi3Instance c, const fmi3ValueReference ref[], size_t n, fmi3Clock value[]),
      ((void)ref, (void)value, without(c, n, "fmi3GetClock")))

CALL3(SetClock, (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3Clock value[]),
      ((void)ref, (void)value, without(c, n, "fmi3SetClock")))

/* Dependencies stand in the model description; sizes of arrays do not change. */
CALL3(GetNumberOfVariableDependencies, (fmi3Instance c, fmi3ValueReference ref, size_t *n),
      ((void)ref, (void)n, bgc_fmi_refuse(c, "the model description lists all dependencies")))

CALL3(GetVariableDependencies,
      (fmi3Instance c, fmi3ValueReference ref, size_t element[], fmi3ValueReference independent[],
       size_t independent_element[], fmi3DependencyKind kind[], size_t n),
      ((void)ref, (void)element, (void)independent, (void)independent_element, (void)kind, (void)n,
       bgc_fmi_refuse(c, "the model description lists all dependencies")))

/* --- derivatives ------------------------------------------------------------------------------------ */

CALL3(GetDirectionalDerivative,
      (fmi3Instance c, const fmi3ValueReference unknown[], size_t n_unknown,
       const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
       fmi3Float64 sensitivity[], size_t n_sensitivity),
      bgc_fmi_directional(c, unknown, n_unknown, known, n_known, seed, n_seed, sensitivity,
       n_sensitivity))

CALL3(GetAdjointDerivative,
      (fmi3Instance c, const fmi3ValueReference unknown[], size_t n_unknown,
       const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], size_t n_seed,
       fmi3Float64 sensitivity[], size_t n_sensitivity),
      bgc_fmi_adjoint(c, unknown, n_unknown, known, n_known, seed, n_seed, sensitivity,
       n_sensitivity))

/* --- configuration and clocks ------------------------------------------------------------------------ */

CALL3(EnterConfigurationMode, (fmi3Instance c),
      bgc_fmi_refuse(c, "this FMU has no structural parameters to configure"))

CALL3(ExitConfigurationMode, (fmi3Instance c),
      bgc_fmi_refuse(c, "this FMU has no structural parameters to configure"))

static bgc_fmi_status no_clocks(bgc_fmi *i, size_t n) {
    return n == 0 ? BGC_FMI_OK : bgc_fmi_refuse(i, "this FMU has no clocks");
}

CALL3(GetIntervalDecimal,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, fmi3Float64 interval[],
       fmi3IntervalQualifier qualifier[]),
      ((void)ref, (void)interval, (void)qualifier, no_clocks(c, n)))

CALL3(GetIntervalFraction,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, fmi3UInt64 counter[],
       fmi3UInt64 per_second[], fmi3IntervalQualifier qualifier[]),
      ((void)ref, (void)counter, (void)per_second, (void)qualifier, no_clocks(c, n)))

CALL3(GetShiftDecimal,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, fmi3Float64 offset[]),
      ((void)ref, (void)offset, no_clocks(c, n)))

CALL3(GetShiftFraction,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, fmi3UInt64 counter[],
       fmi3UInt64 per_second[]),
      ((void)ref, (void)counter, (void)per_second, no_clocks(c, n)))

CALL3(SetIntervalDecimal,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3Float64 interval[]),
      ((void)ref, (void)interval, no_clocks(c, n)))

CALL3(SetIntervalFraction,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3UInt64 counter[],
       const fmi3UInt64 per_second[]),
      ((void)ref, (void)counter, (void)per_second, no_clocks(c, n)))

CALL3(SetShiftDecimal,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3Float64 offset[]),
      ((void)ref, (void)offset, no_clocks(c, n)))

CALL3(SetShiftFraction,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3UInt64 counter[],
       const fmi3UInt64 per_second[]),
      ((void)ref, (void)counter, (void)per_second, no_clocks(c, n)))

CALL3(ActivateModelPartition, (fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time),
      ((void)clock, (void)time, bgc_fmi_refuse(c, "this FMU has no Scheduled Execution")))

/* --- events ------------------------------------------------------------------------------------------ */

CALL3(EvaluateDiscreteStates, (fmi3Instance c), ((void)c, BGC_FMI_OK))

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

CALL3(EnterStepMode, (fmi3Instance c), bgc_fmi_enter(c, BGC_FMI_STEPS))

CALL3(GetOutputDerivatives,
      (fmi3Instance c, const fmi3ValueReference ref[], size_t n, const fmi3Int32 order[],
       fmi3Float64 value[], size_t n_value),
      ((void)ref, (void)order, (void)value, (void)n_value,
       n == 0 ? BGC_FMI_OK : bgc_fmi_refuse(c, "derivatives of outputs are not given")))

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

/* fmi2.c: the functions of FMI 2.0, Model Exchange and Co-Simulation. */
#include "fmi.h"
#include "fmi2.h"

#define EXPORTED BGC_EXPORT

/* bgc_fmi_status has the first numbers of fmi2Status. */
static fmi2Status status2(bgc_fmi_status status) { return (fmi2Status)status; }

#define BOOLEAN fmi2Boolean
#define FUNCTION(in_2, in_3, parameters, call) \
    EXPORTED fmi2Status BGC_FMI2(fmi2##in_2) parameters { return status2(call); }
#include "fmi_functions.h"

/* A function of this version alone. */
#define CALL2(name, parameters, call) FUNCTION(name, , parameters, call)

/* --- instances --------------------------------------------------------------------------------- */

static void log2_message(bgc_fmi *i, bgc_fmi_status status, const char *category, const char *message) {
    const fmi2CallbackFunctions *callbacks = i->environment;

    if (callbacks != NULL && callbacks->logger != NULL) {
        callbacks->logger(callbacks->componentEnvironment, i->name, status2(status), category, "%s", message);
    }
}

EXPORTED const char *BGC_FMI2(fmi2GetTypesPlatform)(void) { return "default"; }

EXPORTED const char *BGC_FMI2(fmi2GetVersion)(void) { return "2.0"; }

EXPORTED fmi2Component BGC_FMI2(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid,
                                                 fmi2String resources,
                                                 const fmi2CallbackFunctions *callbacks,
                                                 fmi2Boolean visible, fmi2Boolean logging) {
    const bgc_fmi_hooks hooks = {log2_message, NULL};

    (void)resources, (void)visible;
    return bgc_fmi_new(type == fmi2CoSimulation ? BGC_FMI_CO_SIMULATION : BGC_FMI_MODEL_EXCHANGE, name, guid,
                       logging, &hooks, (void *)callbacks, NULL);
}

EXPORTED void BGC_FMI2(fmi2FreeInstance)(fmi2Component c) { bgc_fmi_free(c); }

EXPORTED fmi2Status BGC_FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined,
                                                  fmi2Real tolerance, fmi2Real start,
                                                  fmi2Boolean stop_defined, fmi2Real stop) {
    (void)stop_defined, (void)stop;
    ((bgc_fmi *)c)->core.rtol = tolerance_defined ? tolerance : 0.0;
    ((bgc_fmi *)c)->core.start_time = start;
    return fmi2OK;
}

CALL2(EnterInitializationMode, (fmi2Component c),
      bgc_fmi_enter_initialisation(c, ((bgc_fmi *)c)->core.rtol, ((bgc_fmi *)c)->core.start_time))

/* --- variables ----------------------------------------------------------------------------------- */

CALL2(GetReal, (fmi2Component c, const fmi2ValueReference ref[], size_t n, fmi2Real value[]),
      bgc_fmi_get(c, ref, n, value, n))

CALL2(SetReal, (fmi2Component c, const fmi2ValueReference ref[], size_t n, const fmi2Real value[]),
      bgc_fmi_set(c, ref, n, value, n))

/* Functions for variables of other types, which this FMU does not have. */
#define WITHOUT_VARIABLES(kind)                                                                       \
    CALL2(Get##kind, (fmi2Component c, const fmi2ValueReference ref[], size_t n, fmi2##kind value[]), \
          ((void)ref, (void)value, bgc_fmi_refuse_variables(c, n, "fmi2Get" #kind, "Real")))          \
    CALL2(Set##kind,                                                                                  \
          (fmi2Component c, const fmi2ValueReference ref[], size_t n, const fmi2##kind value[]),      \
          ((void)ref, (void)value, bgc_fmi_refuse_variables(c, n, "fmi2Set" #kind, "Real")))
WITHOUT_VARIABLES(Integer)
WITHOUT_VARIABLES(Boolean)
WITHOUT_VARIABLES(String)

/* --- derivatives --------------------------------------------------------------------------------- */

CALL2(GetDirectionalDerivative,
      (fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
       const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[], fmi2Real result[]),
      bgc_fmi_directional(c, unknown, n_unknown, known, n_known, seed, n_known, result, n_unknown))

/* --- Model Exchange ---------------------------------------------------------------------------------- */

EXPORTED fmi2Status BGC_FMI2(fmi2NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info) {
    double next = (double)INFINITY;
    int changed = 0;
    const bgc_fmi_status status = bgc_fmi_handle_events(c, &changed, &next);

    *info = (fmi2EventInfo){
        .valuesOfContinuousStatesChanged = changed,
        .nextEventTimeDefined = isfinite(next),
        .nextEventTime = isfinite(next) ? next : 0.0,
    };
    return status2(status);
}

EXPORTED fmi2Status BGC_FMI2(fmi2CompletedIntegratorStep)(fmi2Component c, fmi2Boolean no_rollback,
                                                          fmi2Boolean *event, fmi2Boolean *terminate) {
    (void)no_rollback;
    *terminate = 0;
    return status2(bgc_fmi_completed_step(c, event));
}

/* --- Co-Simulation ----------------------------------------------------------------------------------- */

CALL2(SetRealInputDerivatives,
      (fmi2Component c, const fmi2ValueReference ref[], size_t n, const fmi2Integer order[],
       const fmi2Real value[]),
      ((void)ref, (void)order, (void)value,
       n == 0 ? BGC_FMI_OK : bgc_fmi_refuse(c, "inputs are held between points")))

CALL2(GetRealOutputDerivatives,
      (fmi2Component c, const fmi2ValueReference ref[], size_t n, const fmi2Integer order[],
       fmi2Real value[]),
      ((void)ref, (void)order, (void)value,
       n == 0 ? BGC_FMI_OK : bgc_fmi_refuse(c, "derivatives of outputs are not given")))

EXPORTED fmi2Status BGC_FMI2(fmi2DoStep)(fmi2Component c, fmi2Real t, fmi2Real step,
                                         fmi2Boolean no_rollback) {
    double reached;

    (void)no_rollback;
    return status2(bgc_fmi_step(c, t, step, &reached));
}

CALL2(CancelStep, (fmi2Component c),
      bgc_fmi_refuse(c, "steps are not asynchronous: none is under way"))

static bgc_fmi_status not_pending(bgc_fmi *i) {
    return bgc_fmi_report(i, BGC_FMI_DISCARD, "steps are not asynchronous");
}

CALL2(GetStatus, (fmi2Component c, fmi2StatusKind kind, fmi2Status *value),
      ((void)kind, (void)value, not_pending(c)))

EXPORTED fmi2Status BGC_FMI2(fmi2GetRealStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) {
        return status2(not_pending(c));
    }
    *value = ((bgc_fmi *)c)->core.t;
    return fmi2OK;
}

CALL2(GetIntegerStatus, (fmi2Component c, fmi2StatusKind kind, fmi2Integer *value),
      ((void)kind, (void)value, not_pending(c)))

EXPORTED fmi2Status BGC_FMI2(fmi2GetBooleanStatus)(fmi2Component c, fmi2StatusKind kind,
                                                   fmi2Boolean *value) {
    if (kind != fmi2Terminated) {
        return status2(not_pending(c));
    }
    *value = 0;
    return fmi2OK;
}

CALL2(GetStringStatus, (fmi2Component c, fmi2StatusKind kind, fmi2String *value),
      ((void)kind, (void)value, not_pending(c)))

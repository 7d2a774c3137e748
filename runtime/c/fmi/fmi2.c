/* fmi2.c: the functions of FMI 2.0, Model Exchange and Co-Simulation. */
#include "fmi.h"
#include "fmi2.h"

#define EXPORTED BGC_EXPORT
#define AS(component) ((bgc_fmi *)(component))

/* bgc_fmi_status has the first numbers of fmi2Status. */
static fmi2Status status2(bgc_fmi_status status) { return (fmi2Status)status; }

/* --- messages ---------------------------------------------------------------------------------- */

static void log2_message(bgc_fmi *i, bgc_fmi_status status, const char *message) {
    const fmi2CallbackFunctions *callbacks = i->environment;

    if (callbacks != NULL && callbacks->logger != NULL) {
        callbacks->logger(callbacks->componentEnvironment, i->name, status2(status),
                          status >= BGC_FMI_ERROR     ? "logStatusError"
                          : status == BGC_FMI_DISCARD ? "logStatusDiscard"
                                                      : "logStatusWarning",
                          "%s", message);
    }
}

static fmi2Status no_such(fmi2Component c, size_t n, const char *what) {
    char text[200];

    if (n == 0) {
        return fmi2OK;
    }
    snprintf(text, sizeof text, "%s: all variables of this FMU are of type Real", what);
    return status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, text));
}

/* --- instances --------------------------------------------------------------------------------- */

EXPORTED const char *BGC_FMI2(fmi2GetTypesPlatform)(void) { return "default"; }

EXPORTED const char *BGC_FMI2(fmi2GetVersion)(void) { return "2.0"; }

EXPORTED fmi2Status BGC_FMI2(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n,
                                                  const fmi2String categories[]) {
    (void)n, (void)categories;
    AS(c)->logs = on;
    return fmi2OK;
}

EXPORTED fmi2Component BGC_FMI2(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid,
                                                 fmi2String resources,
                                                 const fmi2CallbackFunctions *callbacks,
                                                 fmi2Boolean visible, fmi2Boolean logging) {
    const bgc_fmi_hooks hooks = {log2_message, NULL};
    bgc_fmi *i = bgc_fmi_new(type == fmi2CoSimulation ? BGC_FMI_CO_SIMULATION : BGC_FMI_MODEL_EXCHANGE,
                             name, guid, &hooks, (void *)callbacks, NULL);

    (void)resources, (void)visible;
    if (i != NULL) {
        i->logs = logging;
    }
    return i;
}

EXPORTED void BGC_FMI2(fmi2FreeInstance)(fmi2Component c) { bgc_fmi_free(AS(c)); }

EXPORTED fmi2Status BGC_FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined,
                                                  fmi2Real tolerance, fmi2Real start,
                                                  fmi2Boolean stop_defined, fmi2Real stop) {
    (void)stop_defined, (void)stop;
    AS(c)->core.rtol = tolerance_defined ? tolerance : 0.0;
    AS(c)->core.start_time = start;
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2EnterInitializationMode)(fmi2Component c) {
    return status2(bgc_fmi_enter_initialisation(AS(c), AS(c)->core.rtol, AS(c)->core.start_time));
}

EXPORTED fmi2Status BGC_FMI2(fmi2ExitInitializationMode)(fmi2Component c) {
    return status2(bgc_fmi_exit_initialisation(AS(c)));
}

EXPORTED fmi2Status BGC_FMI2(fmi2Terminate)(fmi2Component c) {
    AS(c)->core.phase = BGC_FMI_TERMINATED;
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2Reset)(fmi2Component c) { return status2(bgc_fmi_reset(AS(c))); }

/* --- variables ----------------------------------------------------------------------------------- */

EXPORTED fmi2Status BGC_FMI2(fmi2GetReal)(fmi2Component c, const fmi2ValueReference ref[], size_t n,
                                          fmi2Real value[]) {
    return status2(bgc_fmi_get(AS(c), ref, n, value, n));
}

EXPORTED fmi2Status BGC_FMI2(fmi2SetReal)(fmi2Component c, const fmi2ValueReference ref[], size_t n,
                                          const fmi2Real value[]) {
    return status2(bgc_fmi_set(AS(c), ref, n, value, n));
}

/* Functions for variables of other types, which this FMU does not have. */
#define WITHOUT_VARIABLES(kind)                                                                       \
    EXPORTED fmi2Status BGC_FMI2(fmi2Get##kind)(fmi2Component c, const fmi2ValueReference ref[],      \
                                                size_t n, fmi2##kind value[]) {                       \
        (void)ref, (void)value;                                                                       \
        return no_such(c, n, "fmi2Get" #kind);                                                        \
    }                                                                                                 \
    EXPORTED fmi2Status BGC_FMI2(fmi2Set##kind)(fmi2Component c, const fmi2ValueReference ref[],      \
                                                size_t n, const fmi2##kind value[]) {                 \
        (void)ref, (void)value;                                                                       \
        return no_such(c, n, "fmi2Set" #kind);                                                        \
    }
WITHOUT_VARIABLES(Integer)
WITHOUT_VARIABLES(Boolean)
WITHOUT_VARIABLES(String)

/* --- FMU states ------------------------------------------------------------------------------------ */

EXPORTED fmi2Status BGC_FMI2(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state) {
    if (*state == NULL) {
        *state = malloc(bgc_fmi_state_size(AS(c)));
    }
    if (*state == NULL) {
        return status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, "out of memory"));
    }
    bgc_fmi_save(AS(c), *state);
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state) {
    return state == NULL ? fmi2Error : status2(bgc_fmi_restore(AS(c), state));
}

EXPORTED fmi2Status BGC_FMI2(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state,
                                                         size_t *size) {
    (void)state;
    *size = bgc_fmi_state_size(AS(c));
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state,
                                                    fmi2Byte bytes[], size_t size) {
    if (size < bgc_fmi_state_size(AS(c))) {
        return status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, "too little memory for the FMU state"));
    }
    memcpy(bytes, state, bgc_fmi_state_size(AS(c)));
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[],
                                                      size_t size, fmi2FMUstate *state) {
    if (size != bgc_fmi_state_size(AS(c))) {
        return status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, "the FMU state belongs to another model"));
    }
    if (*state == NULL) {
        *state = malloc(size);
    }
    if (*state == NULL) {
        return status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, "out of memory"));
    }
    memcpy(*state, bytes, size);
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetDirectionalDerivative)(fmi2Component c,
                                                           const fmi2ValueReference unknown[],
                                                           size_t n_unknown,
                                                           const fmi2ValueReference known[],
                                                           size_t n_known, const fmi2Real seed[],
                                                           fmi2Real result[]) {
    return status2(bgc_fmi_directional(AS(c), unknown, n_unknown, known, n_known, seed, n_known, result,
                                       n_unknown));
}

/* --- Model Exchange ---------------------------------------------------------------------------------- */

EXPORTED fmi2Status BGC_FMI2(fmi2EnterEventMode)(fmi2Component c) {
    AS(c)->core.phase = BGC_FMI_EVENTS;
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info) {
    double next = (double)INFINITY;
    int changed = 0;
    const bgc_fmi_status status = bgc_fmi_handle_events(AS(c), &changed, &next);

    *info = (fmi2EventInfo){
        .valuesOfContinuousStatesChanged = changed,
        .nextEventTimeDefined = isfinite(next),
        .nextEventTime = isfinite(next) ? next : 0.0,
    };
    return status2(status);
}

EXPORTED fmi2Status BGC_FMI2(fmi2EnterContinuousTimeMode)(fmi2Component c) {
    AS(c)->core.phase = BGC_FMI_CONTINUOUS;
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2CompletedIntegratorStep)(fmi2Component c, fmi2Boolean no_rollback,
                                                          fmi2Boolean *event, fmi2Boolean *terminate) {
    (void)no_rollback;
    *terminate = 0;
    return status2(bgc_fmi_completed_step(AS(c), event));
}

EXPORTED fmi2Status BGC_FMI2(fmi2SetTime)(fmi2Component c, fmi2Real time) {
    bgc_fmi_set_time(AS(c), time);
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2SetContinuousStates)(fmi2Component c, const fmi2Real x[], size_t n) {
    return status2(bgc_fmi_set_states(AS(c), x, n));
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetDerivatives)(fmi2Component c, fmi2Real rate[], size_t n) {
    return status2(bgc_fmi_get_rates(AS(c), rate, n));
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetEventIndicators)(fmi2Component c, fmi2Real z[], size_t n) {
    return status2(bgc_fmi_get_indicators(AS(c), z, n));
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetContinuousStates)(fmi2Component c, fmi2Real x[], size_t n) {
    return status2(bgc_fmi_get_states(AS(c), x, n));
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetNominalsOfContinuousStates)(fmi2Component c, fmi2Real x[], size_t n) {
    return status2(bgc_fmi_get_nominals(AS(c), x, n));
}

/* --- Co-Simulation ----------------------------------------------------------------------------------- */

EXPORTED fmi2Status BGC_FMI2(fmi2SetRealInputDerivatives)(fmi2Component c,
                                                          const fmi2ValueReference ref[], size_t n,
                                                          const fmi2Integer order[],
                                                          const fmi2Real value[]) {
    (void)ref, (void)order, (void)value;
    return n == 0 ? fmi2OK
                  : status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, "inputs are held between points"));
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetRealOutputDerivatives)(fmi2Component c,
                                                           const fmi2ValueReference ref[], size_t n,
                                                           const fmi2Integer order[], fmi2Real value[]) {
    (void)ref, (void)order, (void)value;
    return n == 0 ? fmi2OK
                  : status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, "derivatives of outputs are not given"));
}

EXPORTED fmi2Status BGC_FMI2(fmi2DoStep)(fmi2Component c, fmi2Real t, fmi2Real step,
                                         fmi2Boolean no_rollback) {
    double reached;

    (void)no_rollback;
    return status2(bgc_fmi_step(AS(c), t, step, &reached));
}

EXPORTED fmi2Status BGC_FMI2(fmi2CancelStep)(fmi2Component c) {
    return status2(bgc_fmi_report(AS(c), BGC_FMI_ERROR, "steps are not asynchronous: none is under way"));
}

static fmi2Status not_pending(fmi2Component c) {
    return status2(bgc_fmi_report(AS(c), BGC_FMI_DISCARD, "steps are not asynchronous"));
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Status *value) {
    (void)kind, (void)value;
    return not_pending(c);
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetRealStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) {
        return not_pending(c);
    }
    *value = AS(c)->core.t;
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetIntegerStatus)(fmi2Component c, fmi2StatusKind kind,
                                                   fmi2Integer *value) {
    (void)kind, (void)value;
    return not_pending(c);
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetBooleanStatus)(fmi2Component c, fmi2StatusKind kind,
                                                   fmi2Boolean *value) {
    if (kind != fmi2Terminated) {
        return not_pending(c);
    }
    *value = 0;
    return fmi2OK;
}

EXPORTED fmi2Status BGC_FMI2(fmi2GetStringStatus)(fmi2Component c, fmi2StatusKind kind,
                                                  fmi2String *value) {
    (void)kind, (void)value;
    return not_pending(c);
}

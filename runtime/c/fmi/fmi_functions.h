/* fmi_functions.h: the functions of the standard that FMI 2.0 and 3.0 have in common, but for names and types.
 *
 * One row for each: its name in 2.0, its name in 3.0, its parameters, and the call of fmi.h that it is. fmi2.c and
 * fmi3.c define FUNCTION, which makes a function of their version from a row, and BOOLEAN, the type of truth values
 * there. Instances and saved states are pointers to void in both versions, value references unsigned numbers.
 */
#ifndef BGC_FMI_FUNCTIONS_H
#define BGC_FMI_FUNCTIONS_H

/* --- instances */
FUNCTION(SetDebugLogging, SetDebugLogging,
         (void *c, BOOLEAN on, size_t n, const char *const categories[]),
         ((void)n, (void)categories, bgc_fmi_set_logging(c, on)))
FUNCTION(ExitInitializationMode, ExitInitializationMode, (void *c), bgc_fmi_exit_initialisation(c))
FUNCTION(Terminate, Terminate, (void *c), bgc_fmi_enter(c, BGC_FMI_TERMINATED))
FUNCTION(Reset, Reset, (void *c), bgc_fmi_reset(c))

/* --- FMU states */
FUNCTION(GetFMUstate, GetFMUState, (void *c, void **state), bgc_fmi_get_state(c, state))
FUNCTION(SetFMUstate, SetFMUState, (void *c, void *state), bgc_fmi_restore(c, state))
FUNCTION(FreeFMUstate, FreeFMUState, (void *c, void **state), bgc_fmi_free_state(c, state))
FUNCTION(SerializedFMUstateSize, SerializedFMUStateSize, (void *c, void *state, size_t *size),
         ((void)state, *size = bgc_fmi_state_size(c), BGC_FMI_OK))
FUNCTION(SerializeFMUstate, SerializeFMUState, (void *c, void *state, void *bytes, size_t size),
         bgc_fmi_copy_state(c, state, bytes, size))
FUNCTION(DeSerializeFMUstate, DeserializeFMUState, (void *c, const void *bytes, size_t size, void **state),
         bgc_fmi_take_state(c, bytes, size, state))

/* --- Model Exchange */
FUNCTION(EnterEventMode, EnterEventMode, (void *c), bgc_fmi_enter(c, BGC_FMI_EVENTS))
FUNCTION(EnterContinuousTimeMode, EnterContinuousTimeMode, (void *c), bgc_fmi_enter(c, BGC_FMI_CONTINUOUS))
FUNCTION(SetTime, SetTime, (void *c, double time), bgc_fmi_set_time(c, time))
FUNCTION(SetContinuousStates, SetContinuousStates, (void *c, const double x[], size_t n),
         bgc_fmi_set_states(c, x, n))
FUNCTION(GetContinuousStates, GetContinuousStates, (void *c, double x[], size_t n), bgc_fmi_get_states(c, x, n))
FUNCTION(GetDerivatives, GetContinuousStateDerivatives, (void *c, double rate[], size_t n),
         bgc_fmi_get_rates(c, rate, n))
FUNCTION(GetNominalsOfContinuousStates, GetNominalsOfContinuousStates, (void *c, double nominal[], size_t n),
         bgc_fmi_get_nominals(c, nominal, n))
FUNCTION(GetEventIndicators, GetEventIndicators, (void *c, double z[], size_t n), bgc_fmi_get_indicators(c, z, n))

#endif

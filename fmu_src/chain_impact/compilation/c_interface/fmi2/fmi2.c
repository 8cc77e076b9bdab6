/* The C interface of FMI 2.0 for co-simulation, sections 2.1 and 4.2. */
#include "instance.h"

#include <fmi2Functions.h>

/* Define a function of the standard: it evaluates `made`, a call of a shared function, and returns the status. */
#define FUNCTION(name, made, ...) \
    FMI2_Export fmi2Status name(__VA_ARGS__) { return (fmi2Status)(made); }

FMI2_Export const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
FMI2_Export const char *fmi2GetVersion(void) { return fmi2Version; }

/* --- instances: sections 2.1.5 and 2.1.6 of FMI 2.0 --- */

typedef void (*Logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

static void log_message(const Instance *instance, int status, const char *category, const char *message) {
    ((Logger)instance->logger)(instance->environment, instance->name, (fmi2Status)status, category, message);
}

static const Interface FMI2 = {
    .token = "fmuGUID", .resources = "fmuResourceLocation", .references = "vr", .values = "value", .state = "FMUstate",
    .types = {"Real", "Integer"},
    /* the logger takes a message as a format of printf, where % begins a value, and # begins a reference to a
       variable: both are doubled */
    .escaped = "%#",
    .by_uri = 1, .unfinished = DISCARD, .log = log_message,
};

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
    (void)visible;
    if (!functions || !functions->logger) return NULL;
    Instance draft = {.interface = &FMI2, .logger = (void (*)(void))functions->logger,
                      .environment = functions->componentEnvironment, .allocate = functions->allocateMemory,
                      .release = functions->freeMemory, .name = name ? name : "", .categories = ALL_CATEGORIES,
                      .advance = advance_to};
    if (!draft.allocate || !draft.release)
        return say(&draft, ERROR, "%s: the callbacks allocateMemory and freeMemory are needed", __func__), NULL;
    if (type != fmi2CoSimulation)
        return say(&draft, ERROR, "%s: this FMU is for co-simulation, not for model exchange", __func__), NULL;
    Instance *instance = new_instance(draft, __func__, guid, location);
    if (instance) instance->categories = logging ? ALL_CATEGORIES : REFUSALS;
    return instance;
}

/* Beyond the standard, for a slave in Python (slave.py): return another instance of the same FMU, which shares the
   table of the first instance; the first instance must be freed last. For the new instance, fmi2DoStep returns
   fmi2Pending after about a second of computing; the slave calls fmi2DoStep again with the same arguments, and the step
   goes on. Between these calls Python handles Ctrl-C. */
FMI2_Export fmi2Component another_fmi2_instance(fmi2Component first, fmi2String name) {
    Instance *instance = first ? another_instance(first, "fmi2Instantiate", name) : NULL;
    if (instance) instance->advance = advance_awhile;
    return instance;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c) { free_instance(c); }
FUNCTION(fmi2SetDebugLogging, set_logging(c, __func__, logging, count, names), fmi2Component c, fmi2Boolean logging,
         size_t count, const fmi2String names[])
FUNCTION(fmi2SetupExperiment, set_up(c, __func__, with_tolerance, tolerance, begin, with_stop, stop), fmi2Component c,
         fmi2Boolean with_tolerance, fmi2Real tolerance, fmi2Real begin, fmi2Boolean with_stop, fmi2Real stop)
FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    const Instance *instance = c;
    if (instance && instance->phase == INSTANTIATED && !instance->set_up)
        return (fmi2Status)say(instance, ERROR, "%s cannot be called before fmi2SetupExperiment", __func__);
    return (fmi2Status)enter_initialization(c, __func__);
}
FUNCTION(fmi2ExitInitializationMode, exit_initialization(c, __func__), fmi2Component c)
FUNCTION(fmi2Terminate, terminate(c, __func__), fmi2Component c)
FUNCTION(fmi2Reset, reset(c, __func__), fmi2Component c)

/* --- variables: section 2.1.7 of FMI 2.0; functions for absent types and derivatives accept an empty list only --- */

#define ACCESS(name, what, type, array)                                                                    \
    FUNCTION(name, what(c, __func__, array, vr, count, value, count), fmi2Component c,                     \
             const fmi2ValueReference vr[], size_t count, type value[])
ACCESS(fmi2GetReal, get, fmi2Real, FLOAT64S)
ACCESS(fmi2GetInteger, get, fmi2Integer, INT32S)
ACCESS(fmi2SetReal, set, const fmi2Real, FLOAT64S)
ACCESS(fmi2SetInteger, set, const fmi2Integer, INT32S)

#define MISSING(name, what, ...)                                                                         \
    FUNCTION(name, ((void)vr, none(c, __func__, count, what)), fmi2Component c, const fmi2ValueReference vr[], \
             size_t count, __VA_ARGS__)
#define NO_TYPE "variables of type Boolean or String"
MISSING(fmi2GetBoolean, NO_TYPE, fmi2Boolean value[])
MISSING(fmi2GetString, NO_TYPE, fmi2String value[])
MISSING(fmi2SetBoolean, NO_TYPE, const fmi2Boolean value[])
MISSING(fmi2SetString, NO_TYPE, const fmi2String value[])
MISSING(fmi2SetRealInputDerivatives, "derivatives of inputs", const fmi2Integer order[], const fmi2Real value[])
MISSING(fmi2GetRealOutputDerivatives, "derivatives of outputs", const fmi2Integer order[], fmi2Real value[])
MISSING(fmi2GetDirectionalDerivative, "directional derivatives", const fmi2ValueReference known[], size_t knowns,
        const fmi2Real change[], fmi2Real value[])

/* --- states: section 2.1.8 of FMI 2.0 --- */

FUNCTION(fmi2GetFMUstate, get_state(c, __func__, handle), fmi2Component c, fmi2FMUstate *handle)
FUNCTION(fmi2SetFMUstate, set_state(c, __func__, state), fmi2Component c, fmi2FMUstate state)
FUNCTION(fmi2FreeFMUstate, free_state(c, __func__, handle), fmi2Component c, fmi2FMUstate *handle)
FUNCTION(fmi2SerializedFMUstateSize, state_size(c, __func__, state, size), fmi2Component c, fmi2FMUstate state,
         size_t *size)
FUNCTION(fmi2SerializeFMUstate, serialize(c, __func__, state, bytes, size), fmi2Component c, fmi2FMUstate state,
         fmi2Byte bytes[], size_t size)
FUNCTION(fmi2DeSerializeFMUstate, deserialize(c, __func__, bytes, size, handle), fmi2Component c,
         const fmi2Byte bytes[], size_t size, fmi2FMUstate *handle)

/* --- steps and their status: sections 4.2.2 and 4.2.3 of FMI 2.0 --- */

/* fmi2DoStep does not tell the importer whether a step ends at an onset, the last result of do_step. */
FUNCTION(fmi2DoStep, ((void)never_back, do_step(c, __func__, now, size, &(int){0})), fmi2Component c, fmi2Real now,
         fmi2Real size, fmi2Boolean never_back)
FUNCTION(fmi2CancelStep, c ? say(c, ERROR, "%s: no step is in progress", __func__) : ERROR, fmi2Component c)

/* Define the function NAME for a status of the last step: for the kind KIND it writes `found` to *value and returns
   fmi2OK; for any other kind it returns fmi2Discard. */
#define STATUS(NAME, TYPE, KIND, found)                                                                      \
    FMI2_Export fmi2Status NAME(fmi2Component c, const fmi2StatusKind kind, TYPE *value) {                   \
        const Instance *instance = c;                                                                             \
        if (!allowed(instance, #NAME, IN(STEPPING) | IN(FAILED) | IN(TERMINATED))) return fmi2Error;              \
        if (!given(instance, #NAME, "value", value)) return fmi2Error;                                            \
        if ((int)kind != KIND) return (fmi2Status)say(instance, DISCARD, #NAME ": no status of kind %d", (int)kind); \
        *value = found;                                                                                      \
        return fmi2OK;                                                                                       \
    }
enum { NO_KIND = -1 };
STATUS(fmi2GetStatus, fmi2Status, fmi2DoStepStatus, instance->phase == FAILED ? fmi2Discard : fmi2OK)
STATUS(fmi2GetRealStatus, fmi2Real, fmi2LastSuccessfulTime, instance->time)
STATUS(fmi2GetIntegerStatus, fmi2Integer, NO_KIND, 0)
/* fmi2Terminated is always false: an importer would take true for an end of the simulation without a fault. */
STATUS(fmi2GetBooleanStatus, fmi2Boolean, fmi2Terminated, fmi2False)
STATUS(fmi2GetStringStatus, fmi2String, NO_KIND, NULL)

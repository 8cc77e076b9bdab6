/* The C interface of FMI 3.0 for co-simulation, with event mode and early return: sections 2.2, 2.3 and 4.2. */
#include "instance.h"
#include "registers.h"

#include <fmi3Functions.h>
#include <stdlib.h>

/* Define a function of the standard: it evaluates `made`, mostly a call of a shared function; returns the status. */
#define FUNCTION(name, made, ...) \
    FMI3_Export fmi3Status name(__VA_ARGS__) { return (fmi3Status)(made); }

FMI3_Export const char *fmi3GetVersion(void) { return fmi3Version; }

/* --- instances: section 2.3.1 of FMI 3.0 --- */

static void log_message(const Instance *instance, int status, const char *category, const char *message) {
    if (instance->logger)
        ((fmi3LogMessageCallback)instance->logger)(instance->environment, (fmi3Status)status, category, message);
}

static const Interface FMI3 = {
    .token = "instantiationToken", .resources = "resourcePath", .references = "valueReferences", .values = "values",
    .state = "FMUState", .types = {"Float64", "Int64"},
    /* in a message, # begins a value reference, so a # in a text is written twice */
    .escaped = "#",
    .says_errors = 1, .unfinished = ERROR, .log = log_message,
};

static Instance drafted(fmi3String name, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    return (Instance){.interface = &FMI3, .logger = (void (*)(void))log, .environment = environment,
                      .allocate = calloc, .release = free, .name = name, .categories = ALL_CATEGORIES};
}

FMI3_Export fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode,
                                                     fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                                     size_t intermediates, fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback log,
                                                     fmi3IntermediateUpdateCallback update) {
    (void)visible, (void)intermediate, (void)update;
    Instance draft = drafted(name, environment, log);
    if (intermediates > 0)
        return say(&draft, ERROR, "%s: no variable can be had or set during a step", __func__), NULL;
    draft.event_mode = event_mode;
    draft.advance = event_mode && early_return ? advance_to_onset : advance_to;
    Instance *instance = new_instance(draft, __func__, token, resources);
    if (instance) instance->categories = logging ? ALL_CATEGORIES : REFUSALS;
    return instance;
}

/* Define a function that would make an instance of a kind that this FMU lacks: it logs an error and returns NULL. */
#define NO_INSTANCE(function, ...)                                                                            \
    FMI3_Export fmi3Instance function(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, \
                                      fmi3Boolean logging, fmi3InstanceEnvironment environment, __VA_ARGS__) { \
        (void)token, (void)resources, (void)visible, (void)logging;                                           \
        Instance draft = drafted(name, environment, log);                                                     \
        return say(&draft, ERROR, "%s: this FMU is for co-simulation only", __func__), NULL;                  \
    }
NO_INSTANCE(fmi3InstantiateModelExchange, fmi3LogMessageCallback log)
NO_INSTANCE(fmi3InstantiateScheduledExecution, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
            fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)

FMI3_Export void fmi3FreeInstance(fmi3Instance c) { free_instance(c); }
FUNCTION(fmi3SetDebugLogging, set_logging(c, __func__, logging, count, names), fmi3Instance c, fmi3Boolean logging,
         size_t count, const fmi3String names[])
FMI3_Export fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean with_tolerance, fmi3Float64 tolerance,
                                                   fmi3Float64 begin, fmi3Boolean with_stop, fmi3Float64 stop) {
    int status = set_up(c, __func__, with_tolerance, tolerance, begin, with_stop, stop);
    return (fmi3Status)(status == OK ? enter_initialization(c, __func__) : status);
}
FUNCTION(fmi3ExitInitializationMode, exit_initialization(c, __func__), fmi3Instance c)
FUNCTION(fmi3Terminate, terminate(c, __func__), fmi3Instance c)
FUNCTION(fmi3Reset, reset(c, __func__), fmi3Instance c)

/* --- variables: section 2.2.6.2 of FMI 3.0 --- */

#define ACCESS(name, what, type, array)                                                                   \
    FUNCTION(name, what(c, __func__, array, vr, count, values, length), fmi3Instance c,                   \
             const fmi3ValueReference vr[], size_t count, type values[], size_t length)
ACCESS(fmi3GetFloat64, get, fmi3Float64, FLOAT64S)
ACCESS(fmi3GetInt64, get, fmi3Int64, INT64S)
ACCESS(fmi3SetFloat64, set, const fmi3Float64, FLOAT64S)
ACCESS(fmi3SetInt64, set, const fmi3Int64, INT64S)

/* Define a function that gets or sets values of a type that no variable has: it accepts only an empty list. */
#define NO_VARIABLES(name, ...)                                                                                \
    FUNCTION(name, ((void)vr, none(c, __func__, count, "variables of this type")), fmi3Instance c,             \
             const fmi3ValueReference vr[], size_t count, __VA_ARGS__)
#define NO_TYPE(type)                                                                    \
    NO_VARIABLES(fmi3Get##type, fmi3##type values[], size_t length)                      \
    NO_VARIABLES(fmi3Set##type, const fmi3##type values[], size_t length)
NO_TYPE(Int8) NO_TYPE(Int16) NO_TYPE(Int32)
NO_TYPE(UInt8) NO_TYPE(UInt16) NO_TYPE(UInt32) NO_TYPE(UInt64)
NO_TYPE(Float32) NO_TYPE(Boolean) NO_TYPE(String)
NO_VARIABLES(fmi3GetBinary, size_t sizes[], fmi3Binary values[], size_t length)
NO_VARIABLES(fmi3SetBinary, const size_t sizes[], const fmi3Binary values[], size_t length)
NO_VARIABLES(fmi3GetClock, fmi3Clock values[])
NO_VARIABLES(fmi3SetClock, const fmi3Clock values[])
NO_VARIABLES(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
NO_VARIABLES(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
             fmi3IntervalQualifier qualifiers[])
NO_VARIABLES(fmi3GetShiftDecimal, fmi3Float64 shifts[])
NO_VARIABLES(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
NO_VARIABLES(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
NO_VARIABLES(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NO_VARIABLES(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
NO_VARIABLES(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NO_VARIABLES(fmi3GetOutputDerivatives, const fmi3Int32 orders[], fmi3Float64 values[], size_t length)
NO_VARIABLES(fmi3GetDirectionalDerivative, const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
             size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities)
NO_VARIABLES(fmi3GetAdjointDerivative, const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[],
             size_t seeds, fmi3Float64 sensitivity[], size_t sensitivities)

/* --- states: section 2.2.6.4 of FMI 3.0 --- */

FUNCTION(fmi3GetFMUState, get_state(c, __func__, handle), fmi3Instance c, fmi3FMUState *handle)
FUNCTION(fmi3SetFMUState, set_state(c, __func__, state), fmi3Instance c, fmi3FMUState state)
FUNCTION(fmi3FreeFMUState, free_state(c, __func__, handle), fmi3Instance c, fmi3FMUState *handle)
FUNCTION(fmi3SerializedFMUStateSize, state_size(c, __func__, state, size), fmi3Instance c, fmi3FMUState state,
         size_t *size)
FUNCTION(fmi3SerializeFMUState, serialize(c, __func__, state, bytes, size), fmi3Instance c, fmi3FMUState state,
         fmi3Byte bytes[], size_t size)
FUNCTION(fmi3DeserializeFMUState, deserialize(c, __func__, bytes, size, handle), fmi3Instance c, const fmi3Byte bytes[],
         size_t size, fmi3FMUState *handle)

/* --- steps and events: sections 2.3.5 and 4.2.1 of FMI 3.0 --- */

FMI3_Export fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 now, fmi3Float64 size, fmi3Boolean never_back,
                                  fmi3Boolean *event_needed, fmi3Boolean *terminated, fmi3Boolean *early,
                                  fmi3Float64 *reached) {
    (void)never_back;
    Instance *instance = c;
    int onset_due;
    if (!instance || !given(instance, __func__, "eventHandlingNeeded", event_needed) ||
        !given(instance, __func__, "terminateSimulation", terminated) ||
        !given(instance, __func__, "earlyReturn", early) || !given(instance, __func__, "lastSuccessfulTime", reached))
        return fmi3Error;
    int status = do_step(instance, __func__, now, size, &onset_due);
    if (status != OK) return (fmi3Status)status;
    *event_needed = onset_due;
    *terminated = fmi3False;
    uint64_t registers = usual_registers();
    *early = onset_due && instance->time < now + size;
    put_registers_back(registers);
    *reached = instance->time;
    return fmi3OK;
}

/* Change from step mode to event mode or back; refuse this for an instance without event mode. Return a status. */
static int change_mode(Instance *instance, const char *call, Phase from, Phase to) {
    if (instance && !instance->event_mode)
        return say(instance, ERROR, "%s cannot be called: the instance was made with eventModeUsed = fmi3False", call);
    if (!allowed(instance, call, IN(from))) return ERROR;
    instance->phase = to;
    return OK;
}
FUNCTION(fmi3EnterEventMode, change_mode(c, __func__, STEPPING, EVENT), fmi3Instance c)
FUNCTION(fmi3EnterStepMode, change_mode(c, __func__, EVENT, STEPPING), fmi3Instance c)

FMI3_Export fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminated,
                                                fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                                fmi3Boolean *next_known, fmi3Float64 *next_time) {
    static const char *const NAMES[] = {"discreteStatesNeedUpdate", "terminateSimulation",
                                        "nominalsOfContinuousStatesChanged", "valuesOfContinuousStatesChanged",
                                        "nextEventTimeDefined", "nextEventTime"};
    void *const results[] = {again, terminated, nominals_changed, states_changed, next_known, next_time};
    Instance *instance = c;
    if (!allowed(instance, __func__, IN(EVENT))) return fmi3Error;
    for (int i = 0; i < 6; i++)
        if (!given(instance, __func__, NAMES[i], results[i])) return fmi3Error;
    instance->observed = NULL;
    int fault = event_update(instance->record);
    if (fault) return (fmi3Status)fail(instance, ERROR, fault);
    /* No flag is true: one update suffices, the FMU does not end the simulation, it shows the importer no continuous
       states, and the time of the next event is not known in advance. */
    *again = *terminated = *nominals_changed = *states_changed = *next_known = fmi3False;
    *next_time = instance->time;
    return fmi3OK;
}

/* --- functions for capabilities that the model description excludes --- */

static int not_there(const Instance *instance, const char *call, const char *what) {
    return instance ? say(instance, ERROR, "%s: this FMU has no %s", call, what) : ERROR;
}
#define NOT_THERE(name, what, ...) FUNCTION(name, not_there(c, __func__, what), fmi3Instance c __VA_ARGS__)
#define AND , /* AND: the comma before a second parameter; a plain comma would only begin an argument of NOT_THERE */
#define EXCHANGE "model exchange"
NOT_THERE(fmi3EvaluateDiscreteStates, "fmi3EvaluateDiscreteStates")
NOT_THERE(fmi3EnterConfigurationMode, "structural parameters")
NOT_THERE(fmi3ExitConfigurationMode, "structural parameters")
NOT_THERE(fmi3GetNumberOfVariableDependencies, "dependencies by element", AND fmi3ValueReference vr, size_t *count)
NOT_THERE(fmi3GetVariableDependencies, "dependencies by element", AND fmi3ValueReference vr, size_t dependent[],
          fmi3ValueReference independents[], size_t independent[], fmi3DependencyKind kinds[], size_t count)
NOT_THERE(fmi3EnterContinuousTimeMode, EXCHANGE)
NOT_THERE(fmi3CompletedIntegratorStep, EXCHANGE, AND fmi3Boolean never_back, fmi3Boolean *event, fmi3Boolean *end)
NOT_THERE(fmi3SetTime, EXCHANGE, AND fmi3Float64 time)
NOT_THERE(fmi3SetContinuousStates, EXCHANGE, AND const fmi3Float64 states[], size_t count)
NOT_THERE(fmi3GetContinuousStateDerivatives, EXCHANGE, AND fmi3Float64 derivatives[], size_t count)
NOT_THERE(fmi3GetEventIndicators, EXCHANGE, AND fmi3Float64 indicators[], size_t count)
NOT_THERE(fmi3GetContinuousStates, EXCHANGE, AND fmi3Float64 states[], size_t count)
NOT_THERE(fmi3GetNominalsOfContinuousStates, EXCHANGE, AND fmi3Float64 nominals[], size_t count)
NOT_THERE(fmi3GetNumberOfEventIndicators, EXCHANGE, AND size_t *count)
NOT_THERE(fmi3GetNumberOfContinuousStates, EXCHANGE, AND size_t *count)
NOT_THERE(fmi3ActivateModelPartition, "scheduled execution", AND fmi3ValueReference clock, fmi3Float64 time)

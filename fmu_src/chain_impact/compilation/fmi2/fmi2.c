/* The life of an instance (2.1.5, 2.1.6) and its steps (4.2.2, 4.2.3). Which call is answered when follows the
   table in section 4.2.4; a call that is refused changes nothing. */
#include "instance.h"

#include <math.h>
#include <string.h>

/* by how much the importer's clock may differ: a part of the step, and the round-off of adding steps up */
static const double TIME_TOLERANCE = 1e-9, ROUND_OFF = 1e-12;

FMI2_Export const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
FMI2_Export const char *fmi2GetVersion(void) { return fmi2Version; }

static void back_to_the_start(Instance *one) {
    memcpy(one->record, in_table(one->table, one->table->record_at), (size_t)one->table->record_size);
    one->phase = INSTANTIATED;
    one->set_up = one->initialized = one->observed = 0;
    one->time = 0.0;
    one->stop_time = INFINITY;
}

/* An instance with its record and its name, in one piece of memory of the callbacks; NULL if there is not enough. */
static Instance *allocated(const Instance *draft) {
    size_t record = (size_t)draft->table->record_size, name = strlen(draft->name) + 1;
    Instance *one = draft->functions.allocateMemory(1, sizeof *one + record + name);
    if (!one) return NULL;
    *one = *draft;
    one->record = (Word *)(one + 1);
    one->name = memcpy((char *)one->record + record, draft->name, name);
    back_to_the_start(one);
    return one;
}

/* The instance, as far as it can be made; why there is none is said in any case (2.1.5). */
static Instance *instantiated(Instance draft, fmi2Type type, const char *guid, const char *location) {
    static const char CALL[] = "fmi2Instantiate";
    const char *reason;
    if (!draft.functions.allocateMemory || !draft.functions.freeMemory)
        return say(&draft, fmi2Error, "%s: the callbacks allocateMemory and freeMemory are needed", CALL), NULL;
    if (draft.name[strspn(draft.name, " \t\r\n\v\f")] == '\0')
        return say(&draft, fmi2Error, "%s: the instance has no name", CALL), NULL;
    if (type != fmi2CoSimulation)
        return say(&draft, fmi2Error, "%s: this FMU is for co-simulation, not for model exchange", CALL), NULL;
    if (!given(&draft, CALL, "fmuGUID", guid) || !given(&draft, CALL, "fmuResourceLocation", location)) return NULL;
    if (!(draft.table = read_table(&draft.functions, location, &reason)))
        return say(&draft, fmi2Error, "%s: fmuResourceLocation %s %s", CALL, location, reason), NULL;
    Instance *one = NULL;
    if (strcmp(guid, draft.table->guid) != 0)
        say(&draft, fmi2Error, "%s: the GUID %s is not that of this FMU, %s", CALL, guid, draft.table->guid);
    else if (!(one = allocated(&draft)))
        say(&draft, fmi2Error, "%s: no memory for an instance", CALL);
    if (!one) draft.functions.freeMemory((void *)draft.table);
    return one;
}

FMI2_Export fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
    (void)visible;
    if (!functions || !functions->logger) return NULL;
    Instance draft = {.functions = *functions, .name = name ? name : "", .categories = ALL_CATEGORIES};
    Instance *one = instantiated(draft, type, guid, location);
    if (one) one->categories = logging ? ALL_CATEGORIES : 0;
    return one;
}

FMI2_Export void fmi2FreeInstance(fmi2Component c) {
    if (!c) return;
    void (*free_memory)(void *) = ((Instance *)c)->functions.freeMemory;
    free_memory((void *)((Instance *)c)->table);
    free_memory(c);
}

FMI2_Export fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean logging, size_t count,
                                           const fmi2String names[]) {
    static const char CALL[] = "fmi2SetDebugLogging";
    Instance *one = c;
    unsigned named = count == 0 ? ALL_CATEGORIES : 0;
    if (!allowed(one, CALL, ANY_PHASE) || (count > 0 && !given(one, CALL, "categories", names))) return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        unsigned bit = category_bit(names[i]);
        if (!bit) return say(one, fmi2Error, "%s: there is no category %s", CALL, names[i] ? names[i] : "NULL");
        named |= bit;
    }
    one->categories = logging ? named : one->categories & ~named;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean with_tolerance, fmi2Real tolerance,
                                           fmi2Real start_time, fmi2Boolean with_stop, fmi2Real stop_time) {
    static const char CALL[] = "fmi2SetupExperiment";
    Instance *one = c;
    if (!allowed(one, CALL, IN(INSTANTIATED))) return fmi2Error;
    if (!isfinite(start_time) || (with_stop && !(stop_time >= start_time)))
        return say(one, fmi2Error, "%s: start time %s s, stop time %s s", CALL, number(start_time).text,
                   with_stop ? number(stop_time).text : "None");
    if (with_tolerance && tolerance != one->record[one->table->tolerance_word].real)
        say(one, fmi2OK, "the importer's tolerance %s is not used: set the parameter solver.tolerance",
            number(tolerance).text);
    one->time = start_time;
    one->stop_time = with_stop ? stop_time : INFINITY;
    one->set_up = 1;
    one->initialized = 0;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *one = c;
    if (!allowed(one, "fmi2EnterInitializationMode", IN(INSTANTIATED))) return fmi2Error;
    if (!one->set_up)
        return say(one, fmi2Error, "fmi2EnterInitializationMode cannot be called before fmi2SetupExperiment");
    one->phase = INITIALIZING;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *one = c;
    if (!allowed(one, "fmi2ExitInitializationMode", IN(INITIALIZING))) return fmi2Error;
    if (start(one, "fmi2ExitInitializationMode") != fmi2OK) return fmi2Error;
    one->phase = STEPPING;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2Terminate(fmi2Component c) {
    Instance *one = c;
    if (!allowed(one, "fmi2Terminate", IN(STEPPING) | IN(FAILED))) return fmi2Error;
    one->phase = TERMINATED;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2Reset(fmi2Component c) {
    if (!allowed(c, "fmi2Reset", ANY_PHASE)) return fmi2Error;
    back_to_the_start(c);
    return fmi2OK;
}

/* The bound on the solver's work, solver.work_limit, ends every step. */
FMI2_Export fmi2Status fmi2DoStep(fmi2Component c, fmi2Real now, fmi2Real size, fmi2Boolean never_back) {
    (void)never_back;
    static const char CALL[] = "fmi2DoStep";
    Instance *one = c;
    if (!allowed(one, CALL, IN(STEPPING))) return fmi2Error;
    if (!(size > 0.0 && size < INFINITY))
        return say(one, fmi2Error, "%s: the step size %s s is not > 0", CALL, number(size).text);
    double slack = TIME_TOLERANCE * size + ROUND_OFF * fabs(one->time), time = fmax(one->time, now + size);
    if (!(fabs(now - one->time) <= slack))
        return say(one, fmi2Error, "%s: the time %s s is not the present %s s", CALL, number(now).text,
                   number(one->time).text);
    if (time > one->stop_time + slack)
        return say(one, fmi2Error, "%s: %s s lies beyond the stop time %s s", CALL, number(time).text,
                   number(one->stop_time).text);
    one->observed = 0;
    int status = advance(one->record, time);
    one->time = status ? one->record[one->table->time_word].real : time;
    if (!status) return fmi2OK;
    one->phase = FAILED;
    return say(one, fmi2Discard, "the simulation stopped at t = %.9g s: %s", one->time,
               status_text(one->table, status));
}

FMI2_Export fmi2Status fmi2CancelStep(fmi2Component c) {
    static const char TEXT[] = "fmi2CancelStep: no step is in progress, as fmi2DoStep returns at the end of one";
    return c ? say(c, fmi2Error, TEXT) : fmi2Error;
}

/* What can be asked of the last step: `found`, if the kind of status is KIND. */
#define STATUS(NAME, TYPE, KIND, found)                                                                      \
    FMI2_Export fmi2Status NAME(fmi2Component c, const fmi2StatusKind kind, TYPE *value) {                   \
        const Instance *one = c;                                                                             \
        if (!allowed(one, #NAME, IN(STEPPING) | IN(FAILED) | IN(TERMINATED))) return fmi2Error;              \
        if (!given(one, #NAME, "value", value)) return fmi2Error;                                            \
        if ((int)kind != KIND) return say(one, fmi2Discard, #NAME ": no status of kind %d", (int)kind);      \
        *value = found;                                                                                      \
        return fmi2OK;                                                                                       \
    }
enum { NO_KIND = -1 };
STATUS(fmi2GetStatus, fmi2Status, fmi2DoStepStatus, one->phase == FAILED ? fmi2Discard : fmi2OK)
STATUS(fmi2GetRealStatus, fmi2Real, fmi2LastSuccessfulTime, one->time)
STATUS(fmi2GetIntegerStatus, fmi2Integer, NO_KIND, 0)
/* It never wants to end the simulation: importers take that for an end without a fault. */
STATUS(fmi2GetBooleanStatus, fmi2Boolean, fmi2Terminated, fmi2False)
STATUS(fmi2GetStringStatus, fmi2String, NO_KIND, NULL)

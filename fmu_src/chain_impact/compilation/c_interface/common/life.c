/* The life of an instance: making, starting, stepping and freeing it. The standard's table (4.2.4 of FMI 2.0) or state
   machine (2.3 and 4.2 of FMI 3.0) says in which phase a call is allowed; a refused call changes nothing. */
#include "instance.h"
#include "registers.h"

#include <math.h>
#include <string.h>

/* [1] largest allowed difference between the time that the importer gives for a step and the instance's time, divided
   by the size of the step. It is above 0, because importers may round their time to 1 us. With a much larger value, a
   call after a skipped or repeated step would be accepted. */
static const double TIME_TOLERANCE = 1e-2;
/* [1] round-off of an importer's time that is a sum of steps, relative to the time */
static const double ROUND_OFF = 1e-12;

/* Give an instance the state after its making: the start values of the table, before initialization. */
static void back_to_the_start(Instance *instance) {
    const Table *table = instance->table;
    memcpy(instance->record, in_table(table, table->record_at), (size_t)table->record_size);
    instance->phase = INSTANTIATED;
    instance->set_up = instance->initialized = instance->warned = 0;
    instance->observed = NULL;
    instance->time = 0.0;
    instance->stop_time = INFINITY;
}

/* Return an instance with its name and its record in one block of memory; if there is not enough memory, log it and
   return NULL. The record comes last, so that a sanitizer notices when the kernel reads or writes beyond it. */
static Instance *allocated(const Instance *draft, const char *call) {
    size_t record = (size_t)draft->table->record_size, name = strlen(draft->name) + 1;
    size_t words = (name + sizeof(Word) - 1) / sizeof(Word);
    Instance *instance = draft->allocate(1, sizeof *instance + words * sizeof(Word) + record);
    if (!instance) return say(draft, ERROR, "%s: no memory for an instance", call), NULL;
    *instance = *draft;
    instance->name = memcpy(instance + 1, draft->name, name);
    instance->record = (Word *)(instance + 1) + words;
    instance->other = NULL;
    back_to_the_start(instance);
    return instance;
}

/* Return whether the name has a letter that is not white space; if not, log an error. A null name becomes "". */
static int is_named(Instance *draft, const char *call) {
    draft->name = draft->name ? draft->name : "";
    int named = draft->name[strspn(draft->name, " \t\r\n\v\f")] != '\0';
    if (!named) say(draft, ERROR, "%s: the instance has no name", call);
    return named;
}

/* Return a new instance; if it cannot be made, log the reason and return NULL. */
Instance *new_instance(Instance draft, const char *call, const char *token, const char *resources) {
    const Interface *names = draft.interface;
    const char *reason;
    draft.phase = INSTANTIATED;
    if (!is_named(&draft, call)) return NULL;
    if (!given(&draft, call, names->token, token) || !given(&draft, call, names->resources, resources)) return NULL;
    if (!(draft.table = read_table(&draft, resources, &reason)))
        return say(&draft, ERROR, "%s: %s %s %s", call, names->resources, resources, reason), NULL;
    Instance *instance = NULL;
    if (strcmp(token, draft.table->guid) != 0)
        say(&draft, ERROR, "%s: %s %s differs from that of this FMU, %s", call, names->token, token, draft.table->guid);
    else
        instance = allocated(&draft, call);
    if (!instance) draft.release((void *)draft.table);
    return instance;
}

Instance *another_instance(const Instance *first, const char *call, const char *name) {
    Instance draft = *first;
    draft.phase = INSTANTIATED;
    draft.name = name;
    draft.shares_table = 1;
    return is_named(&draft, call) ? allocated(&draft, call) : NULL;
}

void free_instance(Instance *instance) {
    if (!instance) return;
    void (*release)(void *) = instance->release;
    if (!instance->shares_table) release((void *)instance->table);
    if (instance->other) release(instance->other);
    release(instance);
}

int set_logging(Instance *instance, const char *call, int on, size_t count, const char *const names[]) {
    unsigned named = count == 0 ? ALL_CATEGORIES : 0;
    if (!allowed(instance, call, ANY_PHASE) || (count > 0 && !given(instance, call, "categories", names))) return ERROR;
    for (size_t i = 0; i < count; i++) {
        unsigned bit = category_bit(names[i]);
        if (!bit) return say(instance, ERROR, "%s: there is no category %s", call, names[i] ? names[i] : "NULL");
        named |= bit;
    }
    instance->categories = on ? named : instance->categories & ~named;
    return OK;
}

int set_up(Instance *instance, const char *call, int with_tolerance, double tolerance, double start_time, int with_stop,
           double stop_time) {
    if (!allowed(instance, call, IN(INSTANTIATED))) return ERROR;
    uint64_t registers = usual_registers();
    int possible = isfinite(start_time) && (!with_stop || stop_time >= start_time);
    int other_tolerance = with_tolerance && tolerance != instance->record[instance->table->tolerance_word].real;
    put_registers_back(registers);
    if (!possible)
        return say(instance, ERROR, "%s: start time %s s, stop time %s s", call, number(start_time).text,
                   with_stop ? number(stop_time).text : "None");
    if (other_tolerance)
        say(instance, OK, "the importer's tolerance %s is not used: set the parameter solver.tolerance",
            number(tolerance).text);
    instance->time = start_time;
    instance->stop_time = with_stop ? stop_time : INFINITY;
    instance->set_up = 1;
    instance->initialized = 0;
    return OK;
}

int enter_initialization(Instance *instance, const char *call) {
    if (!allowed(instance, call, IN(INSTANTIATED))) return ERROR;
    instance->phase = INITIALIZING;
    return OK;
}

int start(Instance *instance, const char *call) {
    if (instance->initialized) return OK;
    size_t size = (size_t)instance->table->record_size;
    Word *before = instance->allocate(1, size);
    if (!before) return say(instance, ERROR, "%s: no memory to start in", call);
    memcpy(before, instance->record, size);
    int status = initialize(instance->record, instance->time);
    Sentence why = reason(instance->table, instance->record, status);
    if (status) memcpy(instance->record, before, size);
    instance->release(before);
    if (status) return say(instance, ERROR, "%s: the simulation cannot start: %s", call, why.text);
    instance->initialized = 1;
    instance->observed = NULL;
    return OK;
}

int exit_initialization(Instance *instance, const char *call) {
    if (!allowed(instance, call, IN(INITIALIZING)) || start(instance, call) != OK) return ERROR;
    instance->phase = instance->event_mode ? EVENT : STEPPING;
    return OK;
}

int terminate(Instance *instance, const char *call) {
    if (!allowed(instance, call, IN(STEPPING) | IN(EVENT) | IN(FAILED))) return ERROR;
    instance->phase = TERMINATED;
    return OK;
}

int reset(Instance *instance, const char *call) {
    if (!allowed(instance, call, ANY_PHASE)) return ERROR;
    back_to_the_start(instance);
    return OK;
}

int fail(Instance *instance, int status, int fault) {
    instance->phase = FAILED;
    instance->time = instance->record[instance->table->time_word].real;
    return say(instance, status, "the simulation stopped at t = %s s: %s", rounded(instance->time).text,
               reason(instance->table, instance->record, fault).text);
}

/* Warn if the positions and velocities that the importer gives for a prescribed motion contradict each other, but at
   most once until a reset. */
static void warn(Instance *instance) {
    const Table *table = instance->table;
    if (table->contradiction_word == 0 || instance->warned) return;
    const Word *record = instance->record;
    const int64_t channel = record[table->contradiction_word].integer;
    if (channel == 0) return;
    const Variable *variables = in_table(table, table->variables_at);
    const char *name = "a motion";
    for (int64_t i = 0; i < table->variable_count; i++)
        if (variables[i].role == INPUT && variables[i].word == table->position_word + channel - 1)
            name = text_of(table, variables[i].name);
    instance->warned = 1;
    say(instance, WARNING, "%s has been moved by %s m in %s s, which contradicts its velocity of %s m/s: give both",
        name, rounded(record[table->distance_word].real).text, rounded(record[table->duration_word].real).text,
        rounded(record[table->velocity_word].real).text);
}

/* Make a step of `size` seconds from the time `now` [s]. Unless the call is refused, set *onset_due: 1 if the step ends
   at the onset of a contact, early or at the usual end of the step; else 0. The value is 1 only with event mode and
   early return (FMI 3.0). Return PENDING if the kernel pauses: the same call then goes on with the step. Every step
   ends, because solver.work_limit limits the solver's work. */
int do_step(Instance *instance, const char *call, double now, double size, int *onset_due) {
    if (!allowed(instance, call, IN(STEPPING))) return ERROR;
    uint64_t registers = usual_registers();
    double slack = TIME_TOLERANCE * size + ROUND_OFF * fabs(instance->time), time = fmax(instance->time, now + size);
    int is_step = size > 0.0 && size < INFINITY, is_now = fabs(now - instance->time) <= slack;
    int ends_in_time = time <= instance->stop_time + slack;
    put_registers_back(registers);
    if (!is_step) return say(instance, ERROR, "%s: the step size %s s is not > 0", call, number(size).text);
    if (!is_now)
        return say(instance, ERROR, "%s: the time %s s is not the present %s s", call, number(now).text,
                   number(instance->time).text);
    if (!ends_in_time)
        return say(instance, ERROR, "%s: %s s lies beyond the stop time %s s", call, number(time).text,
                   number(instance->stop_time).text);
    instance->observed = NULL;
    int status = instance->advance(instance->record, time);
    *onset_due = status == ONSET_DUE;
    if (status == PAUSED) return PENDING;
    if (status != 0 && !*onset_due) return fail(instance, instance->interface->unfinished, status);
    instance->time = *onset_due ? instance->record[instance->table->time_word].real : time;
    warn(instance);
    return OK;
}

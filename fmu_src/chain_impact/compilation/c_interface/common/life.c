/* The life of an instance, and its steps. The standard's table (4.2.4 of FMI 2.0) or state machine (2.3 and 4.2 of
   FMI 3.0) says when a call is allowed; a call that is refused changes nothing. */
#include "instance.h"
#include "registers.h"

#include <math.h>
#include <string.h>

#pragma STDC FENV_ACCESS ON /* arithmetic stays between the calls of registers.h */

/* The largest difference of the importer's clock, over the step: importers may round their clock to 1 us. With a much
   larger tolerance, a step that the importer skips or repeats would not be noticed. */
static const double TIME_TOLERANCE = 1e-2;
/* The round-off of a clock that adds up the steps, over the time. */
static const double ROUND_OFF = 1e-12;

static void back_to_the_start(Instance *one) {
    memcpy(one->record, in_table(one->table, one->table->record_at), (size_t)one->table->record_size);
    one->phase = INSTANTIATED;
    one->set_up = one->initialized = one->warned = 0;
    one->observed = NULL;
    one->time = 0.0;
    one->stop_time = INFINITY;
}

/* Return an instance with its name and its record, in one block of memory; NULL if there is not enough memory. The
   record comes last, so that a sanitizer detects when the kernel reads or writes beyond the record. */
static Instance *allocated(const Instance *draft) {
    size_t record = (size_t)draft->table->record_size, name = strlen(draft->name) + 1;
    size_t words = (name + sizeof(Word) - 1) / sizeof(Word);
    Instance *one = draft->allocate(1, sizeof *one + words * sizeof(Word) + record);
    if (!one) return NULL;
    *one = *draft;
    one->name = memcpy(one + 1, draft->name, name);
    one->record = (Word *)(one + 1) + words;
    one->other = NULL;
    back_to_the_start(one);
    return one;
}

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
    Instance *one = NULL;
    if (strcmp(token, draft.table->guid) != 0)
        say(&draft, ERROR, "%s: %s %s differs from that of this FMU, %s", call, names->token, token, draft.table->guid);
    else if (!(one = allocated(&draft)))
        say(&draft, ERROR, "%s: no memory for an instance", call);
    if (!one) draft.release((void *)draft.table);
    return one;
}

Instance *another_instance(const Instance *first, const char *call, const char *name) {
    Instance draft = *first, *one = NULL;
    draft.phase = INSTANTIATED;
    draft.name = name;
    draft.shares_table = 1;
    if (is_named(&draft, call) && !(one = allocated(&draft)))
        say(&draft, ERROR, "%s: no memory for an instance", call);
    return one;
}

void free_instance(Instance *one) {
    if (!one) return;
    void (*release)(void *) = one->release;
    if (!one->shares_table) release((void *)one->table);
    if (one->other) release(one->other);
    release(one);
}

int set_logging(Instance *one, const char *call, int on, size_t count, const char *const names[]) {
    unsigned named = count == 0 ? ALL_CATEGORIES : 0;
    if (!allowed(one, call, ANY_PHASE) || (count > 0 && !given(one, call, "categories", names))) return ERROR;
    for (size_t i = 0; i < count; i++) {
        unsigned bit = category_bit(names[i]);
        if (!bit) return say(one, ERROR, "%s: there is no category %s", call, names[i] ? names[i] : "NULL");
        named |= bit;
    }
    one->categories = on ? named : one->categories & ~named;
    return OK;
}

int set_up(Instance *one, const char *call, int with_tolerance, double tolerance, double start_time, int with_stop,
           double stop_time) {
    if (!allowed(one, call, IN(INSTANTIATED))) return ERROR;
    uint64_t registers = usual_registers();
    int possible = isfinite(start_time) && (!with_stop || stop_time >= start_time);
    int other_tolerance = with_tolerance && tolerance != one->record[one->table->tolerance_word].real;
    put_registers_back(registers);
    if (!possible)
        return say(one, ERROR, "%s: start time %s s, stop time %s s", call, number(start_time).text,
                   with_stop ? number(stop_time).text : "None");
    if (other_tolerance)
        say(one, OK, "the importer's tolerance %s is not used: set the parameter solver.tolerance",
            number(tolerance).text);
    one->time = start_time;
    one->stop_time = with_stop ? stop_time : INFINITY;
    one->set_up = 1;
    one->initialized = 0;
    return OK;
}

int enter_initialization(Instance *one, const char *call) {
    if (!allowed(one, call, IN(INSTANTIATED))) return ERROR;
    one->phase = INITIALIZING;
    return OK;
}

int start(Instance *one, const char *call) {
    if (one->initialized) return OK;
    size_t size = (size_t)one->table->record_size;
    Word *before = one->allocate(1, size);
    if (!before) return say(one, ERROR, "%s: no memory to start in", call);
    memcpy(before, one->record, size);
    int status = initialize(one->record, one->time);
    Sentence why = reason(one->table, one->record, status);
    if (status) memcpy(one->record, before, size);
    one->release(before);
    if (status) return say(one, ERROR, "%s: the simulation cannot start: %s", call, why.text);
    one->initialized = 1;
    one->observed = NULL;
    return OK;
}

int exit_initialization(Instance *one, const char *call) {
    if (!allowed(one, call, IN(INITIALIZING)) || start(one, call) != OK) return ERROR;
    one->phase = one->event_mode ? EVENT : STEPPING;
    return OK;
}

int terminate(Instance *one, const char *call) {
    if (!allowed(one, call, IN(STEPPING) | IN(EVENT) | IN(FAILED))) return ERROR;
    one->phase = TERMINATED;
    return OK;
}

int reset(Instance *one, const char *call) {
    if (!allowed(one, call, ANY_PHASE)) return ERROR;
    back_to_the_start(one);
    return OK;
}

int fail(Instance *one, int status, int fault) {
    one->phase = FAILED;
    one->time = one->record[one->table->time_word].real;
    return say(one, status, "the simulation stopped at t = %s s: %s", rounded(one->time).text,
               reason(one->table, one->record, fault).text);
}

/* Warn once if the given positions and velocities of a motion contradict each other. */
static void warn(Instance *one) {
    const Table *table = one->table;
    if (table->contradiction_word == 0 || one->warned) return;
    const Word *found = one->record + table->contradiction_word; /* channel from 1, distance, time, velocity */
    if (found->integer == 0) return;
    const Variable *variables = in_table(table, table->variables_at);
    const char *name = "a motion";
    for (int64_t i = 0; i < table->variable_count; i++)
        if (variables[i].kind == INPUT && variables[i].word == table->position_word + found->integer - 1)
            name = text_of(table, variables[i].name);
    one->warned = 1;
    say(one, WARNING, "%s has been moved by %s m in %s s, which contradicts its velocity of %s m/s: give both", name,
        rounded(found[1].real).text, rounded(found[2].real).text, rounded(found[3].real).text);
}

/* Make a step. The limits on the solver's work, by solver.work_limit, end every step. */
int do_step(Instance *one, const char *call, double now, double size, int *onset_due) {
    if (!allowed(one, call, IN(STEPPING))) return ERROR;
    uint64_t registers = usual_registers();
    double slack = TIME_TOLERANCE * size + ROUND_OFF * fabs(one->time), time = fmax(one->time, now + size);
    int is_step = size > 0.0 && size < INFINITY, is_now = fabs(now - one->time) <= slack;
    int ends_in_time = time <= one->stop_time + slack;
    put_registers_back(registers);
    if (!is_step)
        return say(one, ERROR, "%s: the step size %s s is not > 0", call, number(size).text);
    if (!is_now)
        return say(one, ERROR, "%s: the time %s s is not the present %s s", call, number(now).text,
                   number(one->time).text);
    if (!ends_in_time)
        return say(one, ERROR, "%s: %s s lies beyond the stop time %s s", call, number(time).text,
                   number(one->stop_time).text);
    one->observed = NULL;
    int status = one->advance(one->record, time);
    *onset_due = status == ONSET_DUE;
    if (status == PAUSED) return PENDING;
    if (status != 0 && !*onset_due) return fail(one, one->interface->unfinished, status);
    one->time = *onset_due ? one->record[one->table->time_word].real : time;
    warn(one);
    return OK;
}

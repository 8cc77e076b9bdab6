/* Getting and setting variables (2.1.7 of FMI 2.0, 2.2.6.2 of FMI 3.0): the table gives the words of the record for
   each variable. */
#include "instance.h"
#include "registers.h"

#include <limits.h>
#include <string.h>

#pragma STDC FENV_ACCESS ON /* arithmetic stays between the calls of registers.h */

enum { BEFORE = IN(INSTANTIATED) | IN(INITIALIZING), AT_ANY_TIME = BEFORE | IN(STEPPING) | IN(EVENT) };
static const unsigned SETTABLE[] = {
    [FIXED] = BEFORE, [TUNABLE] = AT_ANY_TIME, [INPUT] = AT_ANY_TIME, [OUTPUT] = 0, [TIME] = 0,
};
static const char *const KINDS[] = {"a fixed parameter", "a tunable parameter", "an input", "an output",
                                    "the independent variable"};

/* Return the variable of a value reference; NULL if there is none, or if it has another type. */
static const Variable *variable(const Instance *one, uint32_t vr, Element element) {
    const Variable *all = in_table(one->table, one->table->variables_at);
    int type = element == FLOAT64S ? REAL : INTEGER;
    return vr < one->table->variable_count && all[vr].type == type ? all + vr : NULL;
}

/* Return whether the kernel computes a value: outputs and, after the start is computed, derived parameters. */
static int worked_out(const Instance *one, const Variable *of) {
    return of->kind == OUTPUT || (of->word != of->set_word && one->phase != INSTANTIATED);
}

/* Return the record from which variables are read; NULL after an error. If the kernel computes one of the variables,
   the record has the outputs of the present time. Values that were set since the last step are tried in the second
   record, so that reading outputs does not change the run. If the run cannot continue with these values, the outputs do
   not change, and a warning is logged: other values may still be set. */
static const Word *source(Instance *one, const char *call, const uint32_t vr[], size_t count, int *status) {
    const Variable *all = in_table(one->table, one->table->variables_at);
    size_t i = 0;
    while (i < count && !worked_out(one, all + vr[i])) i++;
    if (i == count) return one->record;
    if (one->observed) return one->observed;
    if (one->phase == INSTANTIATED)
        return say(one, ERROR, "%s: outputs cannot be read %s", call, when(one)), NULL;
    if (start(one, call) != OK) return NULL;
    Word *seen = one->record;
    if (one->record[one->table->changed_word].integer) {
        size_t size = (size_t)one->table->record_size;
        if (!one->other && !(one->other = one->allocate(1, size)))
            return say(one, ERROR, "%s: no memory to try the values that are set", call), NULL;
        seen = memcpy(one->other, one->record, size);
    }
    int fault = observe(seen);
    if (fault && IN(one->phase) & (IN(STEPPING) | IN(EVENT)))
        *status = say(one, WARNING, "%s: the values that are set cannot take effect: %s", call,
                      reason(one->table, seen, fault).text);
    else
        one->observed = seen;
    return seen;
}

/* Return whether the number of given values equals the number of values of the variables, which are valid. */
static int fits(const Instance *one, const char *call, Element element, const uint32_t vr[], size_t count,
                size_t length) {
    size_t wanted = 0;
    for (size_t i = 0; i < count; i++) wanted += (size_t)variable(one, vr[i], element)->length;
    if (wanted != length)
        say(one, ERROR, "%s: the variables have %zu values, but %zu are given", call, wanted, length);
    return wanted == length;
}

static void store(Word word, Element element, void *values, size_t i) {
    if (element == FLOAT64S)
        ((double *)values)[i] = word.real;
    else if (element == INT64S)
        ((int64_t *)values)[i] = word.integer;
    else /* a count may have more bits than the result */
        ((int32_t *)values)[i] = word.integer > INT_MAX ? INT_MAX : (int32_t)word.integer;
}

int get(Instance *one, const char *call, Element element, const uint32_t vr[], size_t count, void *values,
        size_t length) {
    if (!allowed(one, call, ANY_PHASE)) return ERROR;
    if (count == 0 && length == 0) return OK;
    if (!given(one, call, one->interface->references, vr) || !given(one, call, one->interface->values, values))
        return ERROR;
    for (size_t i = 0; i < count; i++)
        if (!variable(one, vr[i], element))
            return say(one, ERROR, "%s: the value reference %u is no %s's", call, vr[i],
                       one->interface->types[element != FLOAT64S]);
    if (!fits(one, call, element, vr, count, length)) return ERROR;
    int status = OK;
    const Word *record = source(one, call, vr, count, &status);
    if (!record) return ERROR;
    for (size_t i = 0, at = 0; i < count; i++) {
        const Variable *from = variable(one, vr[i], element);
        const Word *word = from->kind == TIME ? &(const Word){.real = one->time} : record + from->word;
        for (int64_t k = 0; k < from->length; k++) store(word[k], element, values, at++);
    }
    return status;
}

static Word word_at(Element element, const void *values, size_t i) {
    if (element == FLOAT64S) return (Word){.real = ((const double *)values)[i]};
    return (Word){.integer = element == INT64S ? ((const int64_t *)values)[i] : ((const int32_t *)values)[i]};
}

/* Return whether a value can be set; a variable that can be set is never an array. */
static int check(const Instance *one, const char *call, Element element, uint32_t vr, Word new) {
    const Variable *at = variable(one, vr, element);
    if (!at) return say(one, ERROR, "%s: the value reference %u belongs to another type or to no variable", call, vr);
    const char *name = text_of(one->table, at->name), *range = text_of(one->table, at->allowed);
    if (!(SETTABLE[at->kind] & IN(one->phase)))
        return say(one, ERROR, "%s: %s is %s and cannot be set %s", call, name, KINDS[at->kind], when(one));
    uint64_t registers = usual_registers();
    double value = at->type == REAL ? new.real : (double)new.integer;
    int in_range = at->low <= value && value <= at->high; /* also false for NaN */
    put_registers_back(registers);
    if (in_range) return OK;
    if (at->type == INTEGER)
        return say(one, ERROR, "%s: %s = %lld must be %s", call, name, (long long)new.integer, range);
    return say(one, ERROR, "%s: %s = %s must be %s", call, name, number(new.real).text, range);
}

/* Set all values or, if one value is refused, none. */
int set(Instance *one, const char *call, Element element, const uint32_t vr[], size_t count, const void *values,
        size_t length) {
    if (!allowed(one, call, ANY_PHASE)) return ERROR;
    if (count == 0 && length == 0) return OK;
    if (!given(one, call, one->interface->references, vr) || !given(one, call, one->interface->values, values))
        return ERROR;
    if (length != count)
        return say(one, ERROR, "%s: %zu variables need one value each, but %zu values are given", call, count,
                   length);
    for (size_t i = 0; i < count; i++)
        if (check(one, call, element, vr[i], word_at(element, values, i)) != OK) return ERROR;
    int changed = 0;
    uint64_t registers = usual_registers();
    for (size_t i = 0; i < count; i++) {
        const Variable *at = variable(one, vr[i], element);
        Word *word = one->record + at->set_word, new = word_at(element, values, i);
        changed |= at->type == REAL ? word->real != new.real : word->integer != new.integer;
        one->record[at->word] = *word = new;
    }
    put_registers_back(registers);
    if (!changed) return OK;
    one->observed = NULL;
    if (IN(one->phase) & BEFORE)
        one->initialized = 0;
    else
        one->record[one->table->changed_word].integer = 1; /* the solver re-initializes at the present time */
    return OK;
}

int none(const Instance *one, const char *call, size_t count, const char *missing) {
    if (!allowed(one, call, ANY_PHASE)) return ERROR;
    return count == 0 ? OK : say(one, ERROR, "%s: there are no %s", call, missing);
}

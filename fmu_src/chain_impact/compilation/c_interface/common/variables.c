/* Getting and setting variables (2.1.7 of FMI 2.0, 2.2.6.2 of FMI 3.0). The table of the scene has, for each
   variable, the indices of the record's words with the values of this variable. */
#include "instance.h"
#include "registers.h"

#include <limits.h>
#include <string.h>

enum { BEFORE = IN(INSTANTIATED) | IN(INITIALIZING), AT_ANY_TIME = BEFORE | IN(STEPPING) | IN(EVENT) };
static const unsigned SETTABLE[] = {
    [FIXED] = BEFORE, [TUNABLE] = AT_ANY_TIME, [INPUT] = AT_ANY_TIME, [OUTPUT] = 0, [INDEPENDENT] = 0,
};
static const char *const ROLES[] = {"a fixed parameter", "a tunable parameter", "an input", "an output",
                                    "the independent variable"};

/* Return the variable with the value reference `vr`; NULL if there is none, or if its type is not that of the array. */
static const Variable *variable(const Instance *instance, uint32_t vr, ArrayType array) {
    const Variable *all = in_table(instance->table, instance->table->variables_at);
    int type = array == FLOAT64S ? REAL : INTEGER;
    return vr < instance->table->variable_count && all[vr].type == type ? all + vr : NULL;
}

/* Return whether the kernel must compute a variable before it is read. This is so for an output and, from
   initialization mode on, for a parameter whose given value and value in use are in two words, such as a parameter that
   the kernel can derive, also if the importer has set this parameter. */
static int worked_out(const Instance *instance, const Variable *of) {
    return of->role == OUTPUT || (of->word != of->set_word && instance->phase != INSTANTIATED);
}

/* Return the record from which variables are read; NULL after an error. If the kernel must compute one of the
   variables, it computes all outputs of the present time in the returned record, unless it has done so. If values are
   set that no step has used yet, this is the second record, so that reading does not change the run. If the run cannot
   continue with these values, *status becomes WARNING, not ERROR, because the importer may still set others. */
static const Word *source(Instance *instance, const char *call, const uint32_t vr[], size_t count, int *status) {
    const Variable *all = in_table(instance->table, instance->table->variables_at);
    size_t i = 0;
    while (i < count && !worked_out(instance, all + vr[i])) i++;
    if (i == count) return instance->record;
    if (instance->observed) return instance->observed;
    if (instance->phase == INSTANTIATED)
        return say(instance, ERROR, "%s: outputs cannot be read %s", call, when(instance)), NULL;
    if (start(instance, call) != OK) return NULL;
    Word *seen = instance->record;
    if (instance->record[instance->table->changed_word].integer) {
        size_t size = (size_t)instance->table->record_size;
        if (!instance->other && !(instance->other = instance->allocate(1, size)))
            return say(instance, ERROR, "%s: no memory to try the values that are set", call), NULL;
        seen = memcpy(instance->other, instance->record, size);
    }
    int fault = observe_now(seen);
    if (fault && IN(instance->phase) & (IN(STEPPING) | IN(EVENT)))
        *status = say(instance, WARNING, "%s: the values that are set cannot take effect: %s", call,
                      reason(instance->table, seen, fault).text);
    else
        instance->observed = seen;
    return seen;
}

/* Return whether the variables, which all exist, have together `length` values; if not, log an error. */
static int fits(const Instance *instance, const char *call, ArrayType array, const uint32_t vr[], size_t count,
                size_t length) {
    size_t wanted = 0;
    for (size_t i = 0; i < count; i++) wanted += (size_t)variable(instance, vr[i], array)->length;
    if (wanted != length)
        say(instance, ERROR, "%s: the variables have %zu values, but %zu are given", call, wanted, length);
    return wanted == length;
}

/* Return whether the call is allowed and has the arrays of references and values; if not, log an error. */
static int has_arrays(const Instance *instance, const char *call, const uint32_t vr[], const void *values) {
    return allowed(instance, call, ANY_PHASE) && given(instance, call, instance->interface->references, vr) &&
           given(instance, call, instance->interface->values, values);
}

static void store(Word word, ArrayType array, void *values, size_t i) {
    if (array == FLOAT64S)
        ((double *)values)[i] = word.real;
    else if (array == INT64S)
        ((int64_t *)values)[i] = word.integer;
    else /* a count above INT_MAX does not fit into 32 bits: the importer then gets INT_MAX */
        ((int32_t *)values)[i] = word.integer > INT_MAX ? INT_MAX : (int32_t)word.integer;
}

int get(Instance *instance, const char *call, ArrayType array, const uint32_t vr[], size_t count, void *values,
        size_t length) {
    if (instance && count == 0 && length == 0) return OK;
    if (!has_arrays(instance, call, vr, values)) return ERROR;
    for (size_t i = 0; i < count; i++)
        if (!variable(instance, vr[i], array))
            return say(instance, ERROR, "%s: the value reference %u is no %s's", call, vr[i],
                       instance->interface->types[array != FLOAT64S]);
    if (!fits(instance, call, array, vr, count, length)) return ERROR;
    int status = OK;
    const Word *record = source(instance, call, vr, count, &status);
    if (!record) return ERROR;
    for (size_t i = 0, at = 0; i < count; i++) {
        const Variable *from = variable(instance, vr[i], array);
        const Word *word = from->role == INDEPENDENT ? &(const Word){.real = instance->time} : record + from->word;
        for (int64_t k = 0; k < from->length; k++) store(word[k], array, values, at++);
    }
    return status;
}

static Word word_at(ArrayType array, const void *values, size_t i) {
    if (array == FLOAT64S) return (Word){.real = ((const double *)values)[i]};
    return (Word){.integer = array == INT64S ? ((const int64_t *)values)[i] : ((const int32_t *)values)[i]};
}

/* Return OK if the variable with the value reference `vr` may be set to `new`; else log the reason, return ERROR. */
static int check(const Instance *instance, const char *call, ArrayType array, uint32_t vr, Word new) {
    const Variable *at = variable(instance, vr, array);
    if (!at)
        return say(instance, ERROR, "%s: the value reference %u belongs to another type or to no variable", call, vr);
    const char *name = text_of(instance->table, at->name), *range = text_of(instance->table, at->allowed);
    if (!(SETTABLE[at->role] & IN(instance->phase)))
        return say(instance, ERROR, "%s: %s is %s and cannot be set %s", call, name, ROLES[at->role], when(instance));
    uint64_t registers = usual_registers();
    double value = at->type == REAL ? new.real : (double)new.integer;
    /* for NaN, in_range is 0, because each comparison with NaN is false */
    int in_range = at->low <= value && value <= at->high;
    put_registers_back(registers);
    if (in_range) return OK;
    if (at->type == INTEGER)
        return say(instance, ERROR, "%s: %s = %lld must be %s", call, name, (long long)new.integer, range);
    return say(instance, ERROR, "%s: %s = %s must be %s", call, name, number(new.real).text, range);
}

/* Set each of `count` variables to one value; if one value is refused, set none. */
int set(Instance *instance, const char *call, ArrayType array, const uint32_t vr[], size_t count, const void *values,
        size_t length) {
    if (instance && count == 0 && length == 0) return OK;
    if (!has_arrays(instance, call, vr, values)) return ERROR;
    if (length != count)
        return say(instance, ERROR, "%s: %zu variables need one value each, but %zu values are given", call, count,
                   length);
    for (size_t i = 0; i < count; i++)
        if (check(instance, call, array, vr[i], word_at(array, values, i)) != OK) return ERROR;
    int changed = 0;
    uint64_t registers = usual_registers();
    for (size_t i = 0; i < count; i++) {
        const Variable *at = variable(instance, vr[i], array);
        Word *word = instance->record + at->set_word, new = word_at(array, values, i);
        changed |= at->type == REAL ? word->real != new.real : word->integer != new.integer;
        instance->record[at->word] = *word = new;
    }
    put_registers_back(registers);
    if (!changed) return OK;
    instance->observed = NULL;
    if (IN(instance->phase) & BEFORE)
        instance->initialized = 0;
    else
        /* with this mark, the kernel re-initializes the run at the present time, before it goes on */
        instance->record[instance->table->changed_word].integer = REINITIALIZE;
    return OK;
}

int none(const Instance *instance, const char *call, size_t count, const char *missing) {
    if (!allowed(instance, call, ANY_PHASE)) return ERROR;
    return count == 0 ? OK : say(instance, ERROR, "%s: there are no %s", call, missing);
}

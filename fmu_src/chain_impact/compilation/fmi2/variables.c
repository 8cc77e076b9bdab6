/* Getting and setting variables (2.1.7): the table says which word of the record each one is. */
#include "instance.h"

#include <limits.h>

static const unsigned SETTABLE[] = {
    [FIXED] = IN(INSTANTIATED) | IN(INITIALIZING),
    [TUNABLE] = IN(INSTANTIATED) | IN(INITIALIZING) | IN(STEPPING),
    [INPUT] = IN(INSTANTIATED) | IN(INITIALIZING) | IN(STEPPING),
    [OUTPUT] = 0,
};
static const char *const KINDS[] = {"a fixed parameter", "a tunable parameter", "an input", "an output"};

fmi2Status start(Instance *one, const char *call) {
    if (one->initialized) return fmi2OK;
    int status = initialize(one->record, one->time);
    if (status)
        return say(one, fmi2Error, "%s: the simulation cannot start: %s", call, status_text(one->table, status));
    one->initialized = 1;
    one->observed = 0;
    return fmi2OK;
}

/* The variable of a value reference; NULL if there is none, or it is of another type. */
static const Variable *variable(const Instance *one, fmi2ValueReference vr, int type) {
    const Variable *all = in_table(one->table, one->table->variables_at);
    return vr < one->table->variable_count && all[vr].type == type ? all + vr : NULL;
}

/* See that the outputs in the record are those of the present time, if one of them is asked for. */
static fmi2Status refresh(Instance *one, const char *call, const fmi2ValueReference vr[], size_t count) {
    for (size_t i = 0; i < count && !one->observed; i++) {
        if (vr[i] < one->table->first_output) continue;
        if (one->phase == INSTANTIATED)
            return say(one, fmi2Error, "%s: outputs cannot be read %s", call, when(one->phase));
        if (start(one, call) != fmi2OK) return fmi2Error;
        observe(one->record);
        one->observed = 1;
    }
    return fmi2OK;
}

static fmi2Status get(Instance *one, const char *call, int type, const fmi2ValueReference vr[], size_t count,
                      void *values) {
    if (!allowed(one, call, ANY_PHASE)) return fmi2Error;
    if (count == 0) return fmi2OK;
    if (!given(one, call, "vr", vr) || !given(one, call, "value", values)) return fmi2Error;
    for (size_t i = 0; i < count; i++)
        if (!variable(one, vr[i], type))
            return say(one, fmi2Error, "%s: the value reference %u is no %s's", call, vr[i],
                       type == REAL ? "Real" : "Integer");
    if (refresh(one, call, vr, count) != fmi2OK) return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        Word word = one->record[variable(one, vr[i], type)->word];
        if (type == REAL)
            ((fmi2Real *)values)[i] = word.real;
        else /* counts have more bits than an fmi2Integer */
            ((fmi2Integer *)values)[i] = word.integer > INT_MAX ? INT_MAX : (fmi2Integer)word.integer;
    }
    return fmi2OK;
}

static double value_at(int type, const void *values, size_t i) {
    return type == REAL ? ((const fmi2Real *)values)[i] : ((const fmi2Integer *)values)[i];
}

static fmi2Status check(const Instance *one, const char *call, int type, fmi2ValueReference vr, double value) {
    const Variable *at = variable(one, vr, type);
    if (!at) return say(one, fmi2Error, "%s: the value reference %u is of another type or of nothing", call, vr);
    const char *name = text_of(one->table, at->name), *range = text_of(one->table, at->allowed);
    if (!(SETTABLE[at->kind] & IN(one->phase)))
        return say(one, fmi2Error, "%s: %s is %s and cannot be set %s", call, name, KINDS[at->kind], when(one->phase));
    if (at->low <= value && value <= at->high) return fmi2OK; /* false for NaN, too */
    if (type == INTEGER) return say(one, fmi2Error, "%s: %s = %.0f must be %s", call, name, value, range);
    return say(one, fmi2Error, "%s: %s = %s must be %s", call, name, number(value).text, range);
}

/* Set all of the values or, if one is refused, none. */
static fmi2Status set(Instance *one, const char *call, int type, const fmi2ValueReference vr[], size_t count,
                      const void *values) {
    if (!allowed(one, call, ANY_PHASE)) return fmi2Error;
    if (count == 0) return fmi2OK;
    if (!given(one, call, "vr", vr) || !given(one, call, "value", values)) return fmi2Error;
    for (size_t i = 0; i < count; i++)
        if (check(one, call, type, vr[i], value_at(type, values, i)) != fmi2OK) return fmi2Error;
    int changed = 0;
    for (size_t i = 0; i < count; i++) {
        Word *word = one->record + variable(one, vr[i], type)->word, new;
        double value = value_at(type, values, i);
        if (type == REAL)
            new.real = value;
        else
            new.integer = (int64_t)value;
        changed |= type == REAL ? word->real != value : word->integer != new.integer;
        *word = new;
    }
    if (!changed) return fmi2OK;
    one->observed = 0;
    if (one->phase == STEPPING)
        one->record[one->table->changed_word].integer = 1; /* the solver starts anew from this point in time */
    else
        one->initialized = 0;
    return fmi2OK;
}

#define ACCESS(NAME, access, TYPE, KIND)                                                                     \
    FMI2_Export fmi2Status NAME(fmi2Component c, const fmi2ValueReference vr[], size_t count, TYPE value[]) { \
        return access(c, #NAME, KIND, vr, count, value);                                                      \
    }
ACCESS(fmi2GetReal, get, fmi2Real, REAL)
ACCESS(fmi2GetInteger, get, fmi2Integer, INTEGER)
ACCESS(fmi2SetReal, set, const fmi2Real, REAL)
ACCESS(fmi2SetInteger, set, const fmi2Integer, INTEGER)

/* What the model description does not promise can be called for nothing only. */
static fmi2Status none(const Instance *one, const char *call, size_t count, const char *missing) {
    if (!allowed(one, call, ANY_PHASE)) return fmi2Error;
    return count == 0 ? fmi2OK : say(one, fmi2Error, "%s: there are no %s", call, missing);
}

#define MISSING(NAME, what, ...)                                                                            \
    FMI2_Export fmi2Status NAME(fmi2Component c, const fmi2ValueReference vr[], size_t count, __VA_ARGS__) { \
        (void)vr;                                                                                            \
        return none(c, #NAME, count, what);                                                                  \
    }
#define NO_TYPE "variables of type Boolean or String"
MISSING(fmi2GetBoolean, NO_TYPE, fmi2Boolean value[])
MISSING(fmi2GetString, NO_TYPE, fmi2String value[])
MISSING(fmi2SetBoolean, NO_TYPE, const fmi2Boolean value[])
MISSING(fmi2SetString, NO_TYPE, const fmi2String value[])
MISSING(fmi2SetRealInputDerivatives, "derivatives of inputs", const fmi2Integer order[], const fmi2Real value[])
MISSING(fmi2GetRealOutputDerivatives, "derivatives of outputs", const fmi2Integer order[], fmi2Real value[])
MISSING(fmi2GetDirectionalDerivative, "directional derivatives", const fmi2ValueReference known[], size_t knowns,
        const fmi2Real change[], fmi2Real value[])

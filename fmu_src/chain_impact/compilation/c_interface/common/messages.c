/* Messages to the importer, and checks at the start of a call: `allowed` and `given`. */
#include "instance.h"
#include "registers.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* [bytes] LONGEST: size of a message with its final 0, before characters are doubled; a longer message is cut */
enum { LONGEST = 2000 };

/* The names of the categories of messages, by status; the model description has them as LogCategories. */
static const char *const CATEGORIES[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                         "logStatusFatal"};

unsigned category_bit(const char *name) {
    for (unsigned i = 0; i < sizeof CATEGORIES / sizeof *CATEGORIES; i++)
        if (name && strcmp(name, CATEGORIES[i]) == 0) return i == 0 ? ALL_CATEGORIES : 1u << i;
    return 0;
}

int say(const Instance *instance, int status, const char *format, ...) {
    int wanted = (instance->categories & 1u << status) || (status >= ERROR && instance->interface->says_errors);
    if (!wanted) return status;
    char text[LONGEST], message[2 * LONGEST], *end = message;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (const char *at = text; *at; at++) {
        if (strchr(instance->interface->escaped, *at)) *end++ = *at;
        *end++ = *at;
    }
    *end = '\0';
    instance->interface->log(instance, status, CATEGORIES[status], message);
    return status;
}

const char *when(const Instance *instance) {
    static const char *const WHEN[] = {"before initialization", "in initialization mode", "after initialization",
                                       "after terminate", "after a step that failed", "in event mode"};
    return instance->phase == STEPPING && instance->event_mode ? "in step mode" : WHEN[instance->phase];
}

int allowed(const Instance *instance, const char *call, unsigned phases) {
    if (!instance) return 0;
    if (!(phases & IN(instance->phase))) say(instance, ERROR, "%s cannot be called %s", call, when(instance));
    return (phases & IN(instance->phase)) != 0;
}

int given(const Instance *instance, const char *call, const char *name, const void *argument) {
    if (!argument) say(instance, ERROR, "%s: the argument %s is a null pointer", call, name);
    return argument != NULL;
}

Number number(double value) {
    uint64_t registers = usual_registers();
    Number result = {"nan"};
    for (int digits = 15; digits <= 17 && value == value; digits++) {
        snprintf(result.text, sizeof result.text, "%.*g", digits, value);
        if (strtod(result.text, NULL) == value) break;
    }
    /* the locale of the importer's process may have a decimal comma, which becomes a point */
    char *comma = strchr(result.text, ',');
    if (comma) *comma = '.';
    if (result.text[strspn(result.text, "-0123456789")] == '\0') strcat(result.text, ".0");
    put_registers_back(registers);
    return result;
}

Number rounded(double value) {
    uint64_t registers = usual_registers();
    Number result;
    snprintf(result.text, sizeof result.text, "%.9g", value);
    put_registers_back(registers);
    return result;
}

Sentence reason(const Table *table, const Word *record, int status) {
    const int64_t *statuses = in_table(table, table->statuses_at), *parts = in_table(table, table->parts_at);
    int known = status >= 0 && status < table->status_count;
    const char *what = known ? text_of(table, statuses[status]) : "unknown status";
    /* the number of the part of the scene that causes the fault, from 1; 0 if no part is known */
    int64_t part = record[table->part_word].integer;
    int named = part >= 1 && part <= table->part_count;
    Sentence sentence;
    snprintf(sentence.text, sizeof sentence.text, named ? "%s: %s" : "%s", what,
             named ? text_of(table, parts[part - 1]) : "");
    return sentence;
}

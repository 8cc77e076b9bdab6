/* Messages to the importer, and the checks at the start of every call. */
#include "instance.h"
#include "registers.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#pragma STDC FENV_ACCESS ON /* arithmetic stays between the calls of registers.h */

enum { LONGEST = 2000 }; /* [bytes] of a message */

/* The categories of messages, by the number of the status: LogCategories of the model description. */
static const char *const CATEGORIES[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                         "logStatusFatal"};

unsigned category_bit(const char *name) {
    for (unsigned i = 0; i < sizeof CATEGORIES / sizeof *CATEGORIES; i++)
        if (name && strcmp(name, CATEGORIES[i]) == 0) return i == 0 ? ALL_CATEGORIES : 1u << i;
    return 0;
}

int say(const Instance *one, int status, const char *format, ...) {
    int wanted = (one->categories & 1u << status) || (status >= ERROR && one->interface->says_errors);
    if (!wanted) return status;
    char text[LONGEST], message[2 * LONGEST], *end = message;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (const char *at = text; *at; at++) {
        if (strchr(one->interface->escaped, *at)) *end++ = *at;
        *end++ = *at;
    }
    *end = '\0';
    one->interface->log(one, status, CATEGORIES[status], message);
    return status;
}

const char *when(const Instance *one) {
    static const char *const WHEN[] = {"before initialization", "in initialization mode", "after initialization",
                                       "after terminate", "after a step that failed", "in event mode"};
    return one->phase == STEPPING && one->event_mode ? "in step mode" : WHEN[one->phase];
}

int allowed(const Instance *one, const char *call, unsigned phases) {
    if (!one) return 0;
    if (!(phases & IN(one->phase))) say(one, ERROR, "%s cannot be called %s", call, when(one));
    return (phases & IN(one->phase)) != 0;
}

int given(const Instance *one, const char *call, const char *name, const void *argument) {
    if (!argument) say(one, ERROR, "%s: the argument %s is a null pointer", call, name);
    return argument != NULL;
}

Number number(double value) {
    uint64_t registers = usual_registers();
    Number found = {"nan"};
    for (int digits = 15; digits <= 17 && value == value; digits++) {
        snprintf(found.text, sizeof found.text, "%.*g", digits, value);
        if (strtod(found.text, NULL) == value) break;
    }
    char *comma = strchr(found.text, ','); /* the decimal mark of the importer's locale */
    if (comma) *comma = '.';
    if (found.text[strspn(found.text, "-0123456789")] == '\0') strcat(found.text, ".0");
    put_registers_back(registers);
    return found;
}

Number rounded(double value) {
    uint64_t registers = usual_registers();
    Number found;
    snprintf(found.text, sizeof found.text, "%.9g", value);
    put_registers_back(registers);
    return found;
}

Sentence reason(const Table *table, const Word *record, int status) {
    const int64_t *statuses = in_table(table, table->statuses_at), *places = in_table(table, table->places_at);
    int known = status >= 0 && status < table->status_count;
    const char *what = known ? text_of(table, statuses[status]) : "unknown status";
    int64_t place = record[table->place_word].integer; /* places count from 1 */
    int placed = place >= 1 && place <= table->place_count;
    Sentence found;
    snprintf(found.text, sizeof found.text, placed ? "%s: %s" : "%s", what,
             placed ? text_of(table, places[place - 1]) : "");
    return found;
}

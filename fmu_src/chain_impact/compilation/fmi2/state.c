/* States (2.1.8): the whole record and the interface's own few numbers, in memory as in bytes. */
#include "instance.h"

#include <math.h>
#include <string.h>

/* The slave of the pythonfmu FMU has the same one. The checksum is for the bytes only. */
typedef struct {
    char magic[8];
    uint64_t size, checksum; /* of what follows this number */
    char guid[40];
    int64_t phase, flags;
    double time, stop_time; /* and the record */
} State;

enum { INITIALIZED = 1, SET_UP = 2 }; /* flags */
enum { BEGIN = offsetof(State, guid) };
static const char MAGIC[] = "chainimp";

/* The state that an argument is; NULL if a call cannot be answered with it. */
static State *state_in(const Instance *one, const char *call, fmi2FMUstate state) {
    if (!allowed(one, call, ANY_PHASE) || !given(one, call, "FMUstate", state)) return NULL;
    if (memcmp(((State *)state)->magic, MAGIC, sizeof ((State *)state)->magic) == 0) return state;
    return say(one, fmi2Error, "%s: FMUstate is no state", call), NULL;
}

static size_t size_of(const State *state) { return BEGIN + (size_t)state->size; }

static int is_own(const Instance *one, const State *state) {
    return memcmp(state->guid, one->table->guid, sizeof state->guid) == 0 &&
           size_of(state) == sizeof(State) + (size_t)one->table->record_size;
}

/* Whether the kernel can go on from a state, whatever made it. */
static int is_sound(const Instance *one, State *state) {
    Word *record = (Word *)(state + 1);
    int started = state->phase != INSTANTIATED && state->phase != INITIALIZING;
    return state->phase >= 0 && state->phase < PHASES && (state->flags & ~(INITIALIZED | SET_UP)) == 0 &&
           (!started || state->flags == (INITIALIZED | SET_UP)) && isfinite(state->time) && !isnan(state->stop_time) &&
           memcmp(record, one->record, 2 * sizeof *record) == 0 && /* the numbers of links and candidates */
           sound(record) == 1;
}

FMI2_Export fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *place) {
    static const char CALL[] = "fmi2GetFMUstate";
    Instance *one = c;
    if (!allowed(one, CALL, ANY_PHASE) || !given(one, CALL, "FMUstate", place)) return fmi2Error;
    State *state = *place;
    if (state && !state_in(one, CALL, state)) return fmi2Error;
    if (state && !is_own(one, state)) return say(one, fmi2Error, "%s: FMUstate is a state of another FMU", CALL);
    size_t record = (size_t)one->table->record_size;
    if (!state && !(state = one->functions.allocateMemory(1, sizeof *state + record)))
        return say(one, fmi2Error, "%s: no memory for a state", CALL);
    int flags = (one->initialized ? INITIALIZED : 0) | (one->set_up ? SET_UP : 0);
    *state = (State){.size = sizeof *state + record - BEGIN, .phase = one->phase, .flags = flags, .time = one->time,
                     .stop_time = one->stop_time};
    memcpy(state->magic, MAGIC, sizeof state->magic);
    memcpy(state->guid, one->table->guid, sizeof state->guid);
    memcpy(state + 1, one->record, record);
    *place = state;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate given_state) {
    Instance *one = c;
    State *state = state_in(one, "fmi2SetFMUstate", given_state);
    if (!state) return fmi2Error;
    if (!is_own(one, state)) return say(one, fmi2Error, "fmi2SetFMUstate: the state is that of another FMU");
    if (!is_sound(one, state)) return say(one, fmi2Error, "fmi2SetFMUstate: the state is damaged");
    memcpy(one->record, state + 1, (size_t)one->table->record_size);
    one->phase = (Phase)state->phase;
    one->initialized = (state->flags & INITIALIZED) != 0;
    one->set_up = (state->flags & SET_UP) != 0;
    one->observed = 0;
    one->time = state->time;
    one->stop_time = state->stop_time;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *place) {
    if (!allowed(c, "fmi2FreeFMUstate", ANY_PHASE)) return fmi2Error;
    if (!place || !*place) return fmi2OK;
    State *state = state_in(c, "fmi2FreeFMUstate", *place);
    if (!state) return fmi2Error;
    memset(state->magic, 0, sizeof state->magic);
    ((Instance *)c)->functions.freeMemory(state);
    *place = NULL;
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate given_state, size_t *size) {
    State *state = state_in(c, "fmi2SerializedFMUstateSize", given_state);
    if (!state || !given(c, "fmi2SerializedFMUstateSize", "size", size)) return fmi2Error;
    *size = size_of(state);
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate given_state, fmi2Byte bytes[], size_t size) {
    static const char CALL[] = "fmi2SerializeFMUstate";
    State *state = state_in(c, CALL, given_state);
    if (!state || !given(c, CALL, "serializedState", bytes)) return fmi2Error;
    if (size < size_of(state))
        return say(c, fmi2Error, "%s: the state takes %zu bytes, there are %zu", CALL, size_of(state), size);
    state->checksum = checksum((char *)state + BEGIN, state->size);
    memcpy(bytes, state, size_of(state));
    return fmi2OK;
}

FMI2_Export fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                               fmi2FMUstate *place) {
    static const char CALL[] = "fmi2DeSerializeFMUstate";
    Instance *one = c;
    if (!allowed(one, CALL, ANY_PHASE) || !given(one, CALL, "FMUstate", place)) return fmi2Error;
    if (!given(one, CALL, "serializedState", bytes)) return fmi2Error;
    State head = {.size = 0};
    if (size >= sizeof head) memcpy(&head, bytes, sizeof head);
    if (memcmp(head.magic, MAGIC, sizeof head.magic) != 0 || size_of(&head) != size ||
        head.checksum != checksum(bytes + BEGIN, head.size))
        return say(one, fmi2Error, "%s: the bytes are no state, or damaged", CALL);
    State *state = one->functions.allocateMemory(1, size);
    if (!state) return say(one, fmi2Error, "%s: no memory for a state", CALL);
    *place = memcpy(state, bytes, size);
    return fmi2OK;
}

/* Saved states (2.1.8 of FMI 2.0, 2.2.6.4 of FMI 3.0): the whole record and a few numbers of the instance. A serialized
   state has the bytes of the state in memory, after the checksum has been set. */
#include "instance.h"

#include <math.h>
#include <string.h>

/* A saved state; the record follows in memory. `checksum` is valid only in serialized bytes. */
typedef struct {
    char magic[8];
    /* `size` is the number of bytes from guid to the end of the record, which the checksum covers */
    uint64_t size, checksum;
    char guid[40];
    int64_t phase, flags;
    double time, stop_time;
} State;

/* bits of State.flags: the members `initialized` and `set_up` of the instance */
enum { INITIALIZED = 1, SET_UP = 2 };
enum { BEGIN = offsetof(State, guid) };
static const char MAGIC[] = "chainimp";

/* Return the state to which `state` points; if no state is there or the call is not allowed, log it and return NULL. */
static State *state_in(const Instance *instance, const char *call, void *state) {
    if (!allowed(instance, call, ANY_PHASE) || !given(instance, call, instance->interface->state, state)) return NULL;
    if (memcmp(((State *)state)->magic, MAGIC, sizeof ((State *)state)->magic) == 0) return state;
    return say(instance, ERROR, "%s: %s is no state", call, instance->interface->state), NULL;
}

static size_t size_of(const State *state) { return BEGIN + (size_t)state->size; }

static int is_own(const Instance *instance, const State *state) {
    return memcmp(state->guid, instance->table->guid, sizeof state->guid) == 0 &&
           size_of(state) == sizeof(State) + (size_t)instance->table->record_size;
}

/* Return whether the kernel can continue from a state of this FMU. The state may come from anywhere, so its numbers are
   checked. */
static int state_is_sound(const Instance *instance, State *state) {
    Word *record = (Word *)(state + 1);
    int started = state->phase != INSTANTIATED && state->phase != INITIALIZING;
    return state->phase >= 0 && state->phase < PHASES && (state->phase != EVENT || instance->event_mode) &&
           (state->flags & ~(INITIALIZED | SET_UP)) == 0 &&
           (!started || state->flags == (INITIALIZED | SET_UP)) && isfinite(state->time) && !isnan(state->stop_time) &&
           memcmp(record, instance->record, SIZES * sizeof *record) == 0 &&
           is_sound(record) == 1;
}

int get_state(Instance *instance, const char *call, void **handle) {
    if (!allowed(instance, call, ANY_PHASE) || !given(instance, call, instance->interface->state, handle)) return ERROR;
    State *state = *handle;
    if (state && !state_in(instance, call, state)) return ERROR;
    if (state && !is_own(instance, state))
        return say(instance, ERROR, "%s: %s is a state of another FMU", call, instance->interface->state);
    size_t record = (size_t)instance->table->record_size;
    if (!state && !(state = instance->allocate(1, sizeof *state + record)))
        return say(instance, ERROR, "%s: no memory for a state", call);
    int flags = (instance->initialized ? INITIALIZED : 0) | (instance->set_up ? SET_UP : 0);
    *state = (State){.size = sizeof *state + record - BEGIN, .phase = instance->phase, .flags = flags,
                     .time = instance->time, .stop_time = instance->stop_time};
    memcpy(state->magic, MAGIC, sizeof state->magic);
    memcpy(state->guid, instance->table->guid, sizeof state->guid);
    memcpy(state + 1, instance->record, record);
    *handle = state;
    return OK;
}

int set_state(Instance *instance, const char *call, void *given_state) {
    State *state = state_in(instance, call, given_state);
    if (!state) return ERROR;
    if (!is_own(instance, state)) return say(instance, ERROR, "%s: the state is that of another FMU", call);
    if (!state_is_sound(instance, state)) return say(instance, ERROR, "%s: the state is damaged", call);
    memcpy(instance->record, state + 1, (size_t)instance->table->record_size);
    instance->phase = (Phase)state->phase;
    instance->initialized = (state->flags & INITIALIZED) != 0;
    instance->set_up = (state->flags & SET_UP) != 0;
    instance->observed = NULL;
    instance->time = state->time;
    instance->stop_time = state->stop_time;
    return OK;
}

int free_state(const Instance *instance, const char *call, void **handle) {
    if (!allowed(instance, call, ANY_PHASE)) return ERROR;
    if (!handle || !*handle) return OK;
    State *state = state_in(instance, call, *handle);
    if (!state) return ERROR;
    memset(state->magic, 0, sizeof state->magic);
    instance->release(state);
    *handle = NULL;
    return OK;
}

int state_size(const Instance *instance, const char *call, void *given_state, size_t *size) {
    State *state = state_in(instance, call, given_state);
    if (!state || !given(instance, call, "size", size)) return ERROR;
    *size = size_of(state);
    return OK;
}

int serialize(const Instance *instance, const char *call, void *given_state, void *bytes, size_t size) {
    State *state = state_in(instance, call, given_state);
    if (!state || !given(instance, call, "serializedState", bytes)) return ERROR;
    if (size < size_of(state))
        return say(instance, ERROR, "%s: the state needs %zu bytes, but %zu are given", call, size_of(state), size);
    state->checksum = checksum((char *)state + BEGIN, state->size);
    memcpy(bytes, state, size_of(state));
    return OK;
}

int deserialize(const Instance *instance, const char *call, const void *bytes, size_t size, void **handle) {
    if (!allowed(instance, call, ANY_PHASE) || !given(instance, call, instance->interface->state, handle)) return ERROR;
    if (!given(instance, call, "serializedState", bytes)) return ERROR;
    State head = {.size = 0};
    if (size >= sizeof head) memcpy(&head, bytes, sizeof head);
    if (memcmp(head.magic, MAGIC, sizeof head.magic) != 0 || size_of(&head) != size ||
        head.checksum != checksum((const char *)bytes + BEGIN, head.size))
        return say(instance, ERROR, "%s: the bytes are no state, or damaged", call);
    State *state = instance->allocate(1, size);
    if (!state) return say(instance, ERROR, "%s: no memory for a state", call);
    *handle = memcpy(state, bytes, size);
    return OK;
}

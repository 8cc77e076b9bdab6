/* Calls the C interface at random: fuzzer SEED SEQUENCES CALLS GUID LOCATION VARIABLES

   Each sequence of calls has two instances. Arguments are valid, or wrong: null pointers, unknown value references,
   NaN, states of the other instance, damaged bytes, too little memory. A page that cannot be accessed follows each
   block of memory, and a block cannot be accessed after it is freed. Checks follow each call. The last line is a
   checksum of all results: equal seeds give equal checksums. */
#define _DEFAULT_SOURCE
#include <fmi2Functions.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

fmi2Component fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean,
                              fmi2Boolean);
void fmi2FreeInstance(fmi2Component);
fmi2Status fmi2SetDebugLogging(fmi2Component, fmi2Boolean, size_t, const fmi2String[]);
fmi2Status fmi2SetupExperiment(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
fmi2Status fmi2EnterInitializationMode(fmi2Component);
fmi2Status fmi2ExitInitializationMode(fmi2Component);
fmi2Status fmi2Terminate(fmi2Component);
fmi2Status fmi2Reset(fmi2Component);
fmi2Status fmi2GetReal(fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
fmi2Status fmi2GetInteger(fmi2Component, const fmi2ValueReference[], size_t, fmi2Integer[]);
fmi2Status fmi2GetString(fmi2Component, const fmi2ValueReference[], size_t, fmi2String[]);
fmi2Status fmi2SetReal(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Real[]);
fmi2Status fmi2SetInteger(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Integer[]);
fmi2Status fmi2SetRealInputDerivatives(fmi2Component, const fmi2ValueReference[], size_t, const fmi2Integer[],
                                       const fmi2Real[]);
fmi2Status fmi2GetFMUstate(fmi2Component, fmi2FMUstate *);
fmi2Status fmi2SetFMUstate(fmi2Component, fmi2FMUstate);
fmi2Status fmi2FreeFMUstate(fmi2Component, fmi2FMUstate *);
fmi2Status fmi2SerializedFMUstateSize(fmi2Component, fmi2FMUstate, size_t *);
fmi2Status fmi2SerializeFMUstate(fmi2Component, fmi2FMUstate, fmi2Byte[], size_t);
fmi2Status fmi2DeSerializeFMUstate(fmi2Component, const fmi2Byte[], size_t, fmi2FMUstate *);
fmi2Status fmi2DoStep(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
fmi2Status fmi2CancelStep(fmi2Component);
fmi2Status fmi2GetStatus(fmi2Component, const fmi2StatusKind, fmi2Status *);
fmi2Status fmi2GetRealStatus(fmi2Component, const fmi2StatusKind, fmi2Real *);
fmi2Status fmi2GetBooleanStatus(fmi2Component, const fmi2StatusKind, fmi2Boolean *);
fmi2Status fmi2GetStringStatus(fmi2Component, const fmi2StatusKind, fmi2String *);

#define CHECK(condition)                              \
    do {                                              \
        if (!(condition)) fail(#condition, __LINE__); \
    } while (0)
static void fail(const char *what, int line) {
    fprintf(stderr, "line %d: not %s\n", line, what);
    exit(1);
}

/* --- chance: Marsaglia's xorshift, 2003 --- */
static uint64_t chance_state;
static uint64_t chance(uint64_t below) {
    chance_state ^= chance_state << 13;
    chance_state ^= chance_state >> 7;
    chance_state ^= chance_state << 17;
    return chance_state % below;
}
static int one_in(uint64_t count) { return chance(count) == 0; }

/* --- memory, followed by a page that cannot be accessed --- */
enum { MOST = 4096 };
static struct { char *pages, *block; size_t whole, size; } blocks[MOST];
static size_t block_count, page;
static long blocks_left; /* the number of blocks that can still be allocated */

static void *allocate(size_t count, size_t size) {
    if (blocks_left-- <= 0 || block_count == MOST) return NULL;
    size_t rounded_size = (count * size + 7) / 8 * 8, size_of_pages = (rounded_size + page - 1) / page * page;
    char *pages = mmap(NULL, size_of_pages + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    CHECK(pages != MAP_FAILED && mprotect(pages + size_of_pages, page, PROT_NONE) == 0);
    char *block = pages + size_of_pages - rounded_size;
    memset(block + count * size, 0x5a, rounded_size - count * size);
    blocks[block_count].pages = pages, blocks[block_count].block = block;
    blocks[block_count].whole = size_of_pages + page, blocks[block_count++].size = count * size;
    return block;
}

static void release(void *block) {
    if (!block) return;
    for (size_t i = 0; i < block_count; i++) {
        if (blocks[i].block != block) continue;
        for (char *at = blocks[i].block + blocks[i].size; at < blocks[i].pages + blocks[i].whole - page; at++)
            CHECK(*at == 0x5a);
        munmap(blocks[i].pages, blocks[i].whole);
        blocks[i] = blocks[--block_count];
        return;
    }
    fail("a block that was allocated", __LINE__);
}

/* --- messages --- */
static unsigned messages, remarks; /* all messages, and those that are no refusal */
static void log_message(void *environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    char formatted[8000];
    va_list none;
    CHECK(environment == &messages && strcmp(name, "#1 100%n") == 0 && status <= fmi2Error);
    CHECK(strncmp(category, "log", 3) == 0 && strlen(text) > 10);
    for (const char *at = text; *at; at++) {
        if (*at != '%' && *at != '#') continue;
        CHECK(*at == at[1]);
        at++;
    }
    va_start(none, text);
    vsnprintf(formatted, sizeof formatted, text, none);
    va_end(none);
    messages++;
    remarks += status < fmi2Discard;
}

/* --- the two instances --- */
enum { STATES = 4 };
typedef struct {
    fmi2Component component;
    fmi2FMUstate states[STATES];
    double time;
    int logging;
} Instance;
static Instance both[2];
static const char *guid, *location;
static unsigned variables;
static uint64_t digest = 14695981039346656037u; /* FNV-1a */
static void digest_bytes(const void *bytes, size_t size) {
    for (size_t i = 0; i < size; i++) digest = (digest ^ ((const unsigned char *)bytes)[i]) * 1099511628211u;
}

static void instantiate(Instance *instance) {
    fmi2CallbackFunctions callbacks = {log_message, allocate, release, NULL, &messages};
    unsigned before = messages;
    size_t blocks_before = block_count;
    int is_valid = !one_in(10);
    static const char *const WRONG[] = {"", "file:///nowhere", "%", "file:/%zz", "////////", "/"};
    instance->logging = one_in(2);
    fmi2Type type = is_valid ? fmi2CoSimulation : (fmi2Type)chance(2);
    const char *guid_text = is_valid || one_in(2) ? guid : "x", *location_text = is_valid ? location : WRONG[chance(6)];
    instance->component = fmi2Instantiate("#1 100%n", type, guid_text, location_text, &callbacks, 0, instance->logging);
    instance->time = 0.0;
    if (instance->component) return;
    CHECK(messages == before + 1 && block_count == blocks_before);
}

static double any_real(void) {
    static const double ODD[] = {0.0, -0.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 5e-324, 1e-3, 0.5, 1.0, 1e6};
    return one_in(2) ? ODD[chance(12)] : ((double)chance(2001) - 1000.0) / 100.0;
}

static unsigned any_reference(void) { return one_in(20) ? (unsigned)chance(UINT32_MAX) : (unsigned)chance(variables + 2); }

/* Get or set a few variables; an unknown variable must be refused. */
static fmi2Status access_values(Instance *instance) {
    enum { FEW = 5 };
    unsigned vr[FEW];
    double reals[FEW];
    int integers[FEW], unknown = 0;
    const char *texts[FEW];
    size_t count = chance(FEW + 1);
    for (size_t i = 0; i < FEW; i++) {
        vr[i] = any_reference();
        reals[i] = any_real();
        integers[i] = one_in(3) ? (int)chance(UINT32_MAX) : (int)chance(20);
        unknown |= i < count && vr[i] >= variables;
    }
    const unsigned *from = one_in(30) ? NULL : vr;
    double *real = one_in(30) ? NULL : reals;
    int *integer = one_in(30) ? NULL : integers;
    fmi2Status status = fmi2OK;
    int set = one_in(2);
    switch (chance(4)) {
    case 0:
        status = set ? fmi2SetReal(instance->component, from, count, real)
                     : fmi2GetReal(instance->component, from, count, real);
        if (status == fmi2OK && count) digest_bytes(reals, count * sizeof *reals);
        break;
    case 1:
        status = set ? fmi2SetInteger(instance->component, from, count, integer)
                     : fmi2GetInteger(instance->component, from, count, integer);
        if (status == fmi2OK && count) digest_bytes(integers, count * sizeof *integers);
        break;
    case 2: return fmi2GetString(instance->component, from, count, texts);
    default: return fmi2SetRealInputDerivatives(instance->component, from, count, integer, real);
    }
    CHECK(status == fmi2Error || !unknown);
    return status;
}

static fmi2Status step(Instance *instance) {
    double size = one_in(10) ? any_real() : (double)(1 + chance(64)) / 1024.0;
    double from = one_in(10) ? any_real() : instance->time;
    if (size > 10.0) size = 10.0; /* bounds the time that it all takes */
    fmi2Status status = fmi2DoStep(instance->component, from, size, (int)chance(2));
    if (status == fmi2OK) instance->time = from + size;
    CHECK(status == fmi2OK || status == fmi2Discard || status == fmi2Error);
    return status;
}

static fmi2Status serialize(Instance *instance, fmi2FMUstate *state) {
    size_t size = 0;
    fmi2Status status = fmi2SerializedFMUstateSize(instance->component, *state, one_in(20) ? NULL : &size);
    if (status != fmi2OK) return status;
    size_t room = one_in(10) ? chance(size) : size;
    char *bytes = malloc(room);
    CHECK(bytes);
    status = fmi2SerializeFMUstate(instance->component, *state, bytes, room);
    CHECK(status == fmi2OK || room < size || !*state);
    if (status == fmi2OK) {
        digest_bytes(bytes, size);
        size_t given = one_in(10) ? chance(size) : size;
        int damaged = one_in(3) || given < size;
        if (damaged && given == size) bytes[chance(size)] ^= (char)(1 << chance(8));
        fmi2FMUstate again = NULL;
        status = fmi2DeSerializeFMUstate(instance->component, bytes, given, &again);
        CHECK(!damaged || status == fmi2Error);
        if (status == fmi2OK) {
            fmi2FreeFMUstate(instance->component, state);
            *state = again;
        }
    }
    free(bytes);
    return status;
}

static fmi2Status use_state(Instance *instance) {
    Instance *other = one_in(5) ? &both[chance(2)] : instance;
    fmi2FMUstate *state = &other->states[chance(STATES)], none = NULL;
    fmi2Status status;
    switch (chance(5)) {
    case 0: return fmi2GetFMUstate(instance->component, one_in(30) ? NULL : state);
    case 1: return fmi2FreeFMUstate(instance->component, one_in(30) ? &none : state);
    case 2: return serialize(instance, state);
    default:
        status = fmi2SetFMUstate(instance->component, *state);
        if (status == fmi2OK) fmi2GetRealStatus(instance->component, fmi2LastSuccessfulTime, &instance->time);
        return status;
    }
}

static fmi2Status ask(Instance *instance) {
    fmi2StatusKind kind = (fmi2StatusKind)chance(4);
    fmi2Status status;
    fmi2Real real;
    fmi2Boolean boolean;
    fmi2String text;
    switch (chance(5)) {
    case 0: return fmi2GetStatus(instance->component, kind, one_in(10) ? NULL : &status);
    case 1: return fmi2GetRealStatus(instance->component, kind, one_in(10) ? NULL : &real);
    case 2: return fmi2GetBooleanStatus(instance->component, kind, one_in(10) ? NULL : &boolean);
    case 3: return fmi2GetStringStatus(instance->component, kind, one_in(10) ? NULL : &text);
    default: return fmi2CancelStep(instance->component);
    }
}

static fmi2Status set_logging(Instance *instance) {
    static const char *const NAMES[] = {"logAll", "logStatusError", "logStatusDiscard", "logNothing", NULL};
    const char *chosen[2] = {NAMES[chance(5)], NAMES[chance(5)]};
    size_t count = chance(3);
    int on = one_in(2);
    fmi2Status status = fmi2SetDebugLogging(instance->component, on, count, one_in(20) ? NULL : chosen);
    if (status == fmi2OK) instance->logging = count == 0 ? on : -1; /* -1: some */
    return status;
}

static fmi2Status call(Instance *instance) {
    switch (chance(24)) {
    case 0: return fmi2SetupExperiment(instance->component, one_in(2), any_real(), one_in(4) ? any_real() : 0.0,
                                        one_in(4), any_real());
    case 1: return fmi2EnterInitializationMode(instance->component);
    case 2: return fmi2ExitInitializationMode(instance->component);
    case 3: return one_in(8) ? fmi2Terminate(instance->component) : fmi2OK;
    case 4: return one_in(8) ? fmi2Reset(instance->component) : fmi2OK;
    case 5: return set_logging(instance);
    case 6: return ask(instance);
    case 7:
    case 8:
    case 9:
    case 10:
    case 11: return use_state(instance);
    case 12:
    case 13:
    case 14:
    case 15:
    case 16: return step(instance);
    default: return access_values(instance);
    }
}

static void sequence(unsigned calls) {
    for (int i = 0; i < 2; i++) instantiate(&both[i]);
    for (unsigned k = 0; k < calls; k++) {
        Instance *instance = &both[chance(2)];
        unsigned before = messages, remarks_before = remarks;
        int logging = instance->component ? instance->logging : 0;
        blocks_left = one_in(20) ? (long)chance(2) : MOST;
        fmi2Status status = call(instance);
        CHECK(status == fmi2OK || status == fmi2Discard || status == fmi2Error);
        CHECK(instance->component || status != fmi2Discard);
        if (logging == 0 && instance->logging == 0) CHECK(remarks == remarks_before);
        if (logging == 1 && status != fmi2OK) CHECK(messages > before);
        digest_bytes(&status, sizeof status);
    }
    Instance *alive = both[0].component ? &both[0] : &both[1];
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < STATES; k++)
            if (both[i].states[k]) CHECK(fmi2FreeFMUstate(alive->component, &both[i].states[k]) == fmi2OK);
    for (int i = 0; i < 2; i++) fmi2FreeInstance(both[i].component);
    CHECK(block_count == 0);
}

int main(int count, char **arguments) {
    CHECK(count == 7);
    page = (size_t)sysconf(_SC_PAGESIZE);
    chance_state = strtoull(arguments[1], NULL, 10) * 2654435761u + 1;
    guid = arguments[4];
    location = arguments[5];
    variables = (unsigned)atoi(arguments[6]);
    for (long n = atol(arguments[2]); n > 0; n--) {
        blocks_left = one_in(20) ? (long)chance(3) : MOST;
        sequence((unsigned)atoi(arguments[3]));
    }
    printf("%u messages, %016llx\n", messages, (unsigned long long)digest);
    return 0;
}

/* An importer in C for x86-64 and Linux, which sets the processor's floating-point registers:

       registers LIBRARY TOKEN RESOURCES STACK STEPS REFERENCE...

   It runs the FMU once for each of 16 settings, in a thread with a stack of STACK KiB, and prints a line for each: the
   registers, the number of bytes of the stack in use, and the bits of the variables at each step. After each call, and
   in each message, the registers must be as the importer has set them. The importer itself rounds no number. */
#define _GNU_SOURCE
#include "host.h"
#include <fenv.h>
#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <string.h>

enum { MOST = 400, PAINT = 0xa5, WORST = 3 };
static const double STEP = 1.0 / 512.0;
static const unsigned USUAL = 0x1f80, TRAPS = 0x1f80, FLUSH = 0x8040, ROUNDING = 0x2000;

static unsigned given, messages; /* the registers that are set; messages so far */
static char **arguments;
static int wanted, steps;
static double *values;

static unsigned registers(void) { return __builtin_ia32_stmxcsr(); }

/* Set the registers, also those of the older unit x87, as feenableexcept and fesetround do. */
static void set_registers(unsigned value) {
    static const int DIRECTIONS[] = {FE_TONEAREST, FE_DOWNWARD, FE_UPWARD, FE_TOWARDZERO};
    fesetenv(FE_DFL_ENV);
    fesetround(DIRECTIONS[value / ROUNDING % 4]);
    if (!(value & TRAPS)) feenableexcept(FE_ALL_EXCEPT);
    __builtin_ia32_ldmxcsr(given = value);
}

static void need_registers(const char *what) { need(registers() == given, what); }
#define CALL(expected, what) (need((int)(what) == (expected), #what), need_registers(#what))

#if FMI == 2
#include <fmi2Functions.h>
static void log_message(void *environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)text;
    need_registers("a message");
    messages++;
}
#else
#include <fmi3Functions.h>
static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text) {
    (void)environment, (void)status, (void)category, (void)text;
    need_registers("a message");
    messages++;
}
#endif

static void *run(void *library) {
    static uint32_t references[MOST];
    const double none = NAN;
    enum { OK, ERROR = 3 };
    for (int i = 0; i < wanted; i++) references[i] = (uint32_t)atoi(arguments[6 + i]);
#if FMI == 2
    FUNCTION(fmi2Instantiate, fmi2Component, fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
             fmi2Boolean, fmi2Boolean);
    FUNCTION(fmi2SetupExperiment, fmi2Status, fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
    FUNCTION(fmi2EnterInitializationMode, fmi2Status, fmi2Component);
    FUNCTION(fmi2ExitInitializationMode, fmi2Status, fmi2Component);
    FUNCTION(fmi2DoStep, fmi2Status, fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
    FUNCTION(fmi2GetReal, fmi2Status, fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
    FUNCTION(fmi2SetReal, fmi2Status, fmi2Component, const fmi2ValueReference[], size_t, const fmi2Real[]);
    FUNCTION(fmi2FreeInstance, void, fmi2Component);
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    fmi2Component instance = fmi2Instantiate("host", fmi2CoSimulation, arguments[2], arguments[3], &callbacks, 0, 1);
    need(instance != NULL, "instantiate");
    CALL(OK, fmi2SetupExperiment(instance, 1, 1e-3, 0.0, 1, steps * STEP));
    CALL(OK, fmi2EnterInitializationMode(instance));
#define SET(value) fmi2SetReal(instance, references, 1, value)
#define GET(count, place) fmi2GetReal(instance, references, (size_t)count, place)
#define DO_STEP(now) fmi2DoStep(instance, now, STEP, 1)
#define START() fmi2ExitInitializationMode(instance)
#define END() fmi2FreeInstance(instance)
#else
    fmi3Boolean event, ended, early;
    double reached;
    FUNCTION(fmi3InstantiateCoSimulation, fmi3Instance, fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
             fmi3Boolean, fmi3Boolean, const fmi3ValueReference[], size_t, fmi3InstanceEnvironment,
             fmi3LogMessageCallback, fmi3IntermediateUpdateCallback);
    FUNCTION(fmi3EnterInitializationMode, fmi3Status, fmi3Instance, fmi3Boolean, fmi3Float64, fmi3Float64, fmi3Boolean,
             fmi3Float64);
    FUNCTION(fmi3ExitInitializationMode, fmi3Status, fmi3Instance);
    FUNCTION(fmi3DoStep, fmi3Status, fmi3Instance, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Boolean *, fmi3Boolean *,
             fmi3Boolean *, fmi3Float64 *);
    FUNCTION(fmi3GetFloat64, fmi3Status, fmi3Instance, const fmi3ValueReference[], size_t, fmi3Float64[], size_t);
    FUNCTION(fmi3SetFloat64, fmi3Status, fmi3Instance, const fmi3ValueReference[], size_t, const fmi3Float64[], size_t);
    FUNCTION(fmi3FreeInstance, void, fmi3Instance);
    fmi3Instance instance = fmi3InstantiateCoSimulation("host", arguments[2], arguments[3], 0, 1, 0, 0, NULL, 0, NULL,
                                                        log_message, NULL);
    need(instance != NULL, "instantiate");
    CALL(OK, fmi3EnterInitializationMode(instance, 1, 1e-3, 0.0, 1, steps * STEP));
#define SET(value) fmi3SetFloat64(instance, references, 1, value, 1)
#define GET(count, place) fmi3GetFloat64(instance, references, (size_t)count, place, (size_t)count)
#define DO_STEP(now) fmi3DoStep(instance, now, STEP, 1, &event, &ended, &early, &reached)
#define START() fmi3ExitInitializationMode(instance)
#define END() fmi3FreeInstance(instance)
#endif
    CALL(OK, GET(1, values));
    CALL(ERROR, SET(&none));
    CALL(OK, SET(values));
    CALL(OK, START());
    CALL(ERROR, DO_STEP(0.1));
    for (int k = 0; k < steps; k++) {
        CALL(OK, DO_STEP(k * STEP));
        CALL(OK, GET(wanted, values + k * wanted));
    }
    END();
    need_registers("free");
    return NULL;
}

static void *run_so(void *library) {
    set_registers(given);
    run(library);
    __builtin_ia32_ldmxcsr(USUAL);
    return NULL;
}

int main(int count, char **all) {
    arguments = all;
    wanted = count - 6;
    need(wanted > 0 && wanted <= MOST, "arguments");
    steps = atoi(arguments[5]);
    size_t rows = (size_t)(steps * wanted);
    values = calloc(rows, sizeof *values);
    need(values != NULL, "room for values");
    void *library = loaded(arguments[1]);
    need(library != NULL, "load the library");
    size_t size = (size_t)atoi(arguments[4]) * 1024, unused;
    unsigned char *stack = aligned_alloc(4096, size);
    need(stack != NULL, "room for a stack");
    for (unsigned way = 0; way < 16; way++) {
        pthread_t thread;
        pthread_attr_t how;
        given = (way & 1 ? 0 : TRAPS) | (way & 2 ? FLUSH : 0) | way / 4 * ROUNDING;
        memset(stack, PAINT, size);
        pthread_attr_init(&how);
        need(pthread_attr_setstack(&how, stack, size) == 0, "a stack of this size");
        need(pthread_create(&thread, &how, run_so, library) == 0, "a thread");
        pthread_join(thread, NULL);
        for (unused = 0; unused < size && stack[unused] == PAINT;) unused++;
        printf("%x %zu", given, size - unused);
        for (size_t i = 0; i < rows; i++) {
            uint64_t bits;
            memcpy(&bits, values + i, sizeof bits);
            printf(" %llx", (unsigned long long)bits);
        }
        putchar('\n');
    }
    need(messages >= WORST, "messages of what is refused");
    return 0;
}

/* What a native FMU costs a tool in C: fmu_native BINARY GUID RESOURCES STEP STEPS ROUNDS INPUT REFERENCE...

   Times, in turn, the scenario through FMI with some Reals read after each step, the same with the kernel's own functions,
   and the making of an instance. INPUT is a Real that is changed before each step, by as much as a controller may; -1 if
   there is none, and the kernel alone is not driven. Prints nanoseconds of CPU: a step, a step, an instance; a line a round. */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <fmi2Functions.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static void log_message(void *e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)e, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", text);
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

/* The record of the first instance is caught on its way back from fmi2SerializeFMUstate: 96 bytes of head before it. */
enum { HEAD = 96 };
#define GET(name, type, ...) type (*name)(__VA_ARGS__) = NULL; *(void **)&name = dlsym(library, #name); if (!name) return 2
#define NEED(call) do if ((call) != 0) return 3; while (0)

int main(int count, char **arguments) {
    enum { FIRST = 8, MOST = 100 };
    void *library = dlopen(arguments[1], RTLD_NOW);
    if (!library || count <= FIRST || count > FIRST + MOST) return 1;
    GET(fmi2Instantiate, void *, const char *, int, const char *, const char *, const fmi2CallbackFunctions *, int, int);
    GET(fmi2SetupExperiment, int, void *, int, double, double, int, double);
    GET(fmi2EnterInitializationMode, int, void *);
    GET(fmi2ExitInitializationMode, int, void *);
    GET(fmi2DoStep, int, void *, double, double, int);
    GET(fmi2SetReal, int, void *, const unsigned *, size_t, const double *);
    GET(fmi2GetReal, int, void *, const unsigned *, size_t, double *);
    GET(fmi2GetFMUstate, int, void *, void **);
    GET(fmi2FreeFMUstate, int, void *, void **);
    GET(fmi2SerializedFMUstateSize, int, void *, void *, size_t *);
    GET(fmi2SerializeFMUstate, int, void *, void *, char *, size_t);
    GET(fmi2FreeInstance, void, void *);
    GET(initialize, int32_t, void *, double);
    GET(advance, int32_t, void *, double);
    GET(observe, int32_t, void *);
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    const double size = atof(arguments[4]);
    const int steps = atoi(arguments[5]), rounds = atoi(arguments[6]), driven = atoi(arguments[7]) >= 0;
    const unsigned input = driven ? (unsigned)atoi(arguments[7]) : 0;
    unsigned references[MOST];
    double values[MOST], sum = 0.0;
    const size_t wanted = (size_t)(count - FIRST);
    for (size_t i = 0; i < wanted; i++) references[i] = (unsigned)atoi(arguments[FIRST + i]);
    for (int round = 0; round < rounds; round++) {
        double begin = now();
        void *one = fmi2Instantiate("one", 1, arguments[2], arguments[3], &callbacks, 0, 0), *state = NULL;
        if (!one) return 4;
        NEED(fmi2SetupExperiment(one, 0, 0.0, 0.0, 0, 0.0));
        NEED(fmi2EnterInitializationMode(one));
        NEED(fmi2ExitInitializationMode(one));
        const double instance = now() - begin;
        size_t bytes;
        NEED(fmi2GetFMUstate(one, &state));
        NEED(fmi2SerializedFMUstateSize(one, state, &bytes));
        char *record = aligned_alloc(64, (bytes + 127) / 64 * 64);
        NEED(fmi2SerializeFMUstate(one, state, record, bytes));
        memmove(record, record + HEAD, bytes - HEAD);

        begin = now();
        for (int k = 0; k < steps; k++) {
            const double torque = driven ? sin(20.0 * k * size) : 0.0; /* N.m */
            if (driven) NEED(fmi2SetReal(one, &input, 1, &torque));
            NEED(fmi2DoStep(one, k * size, size, 1));
            NEED(fmi2GetReal(one, references, wanted, values));
        }
        const double interface = (now() - begin) / steps;
        NEED(initialize(record, 0.0));
        begin = now();
        for (int k = 0; k < steps; k++) {
            NEED(advance(record, (k + 1) * size));
            NEED(observe(record));
        }
        const double kernel = (now() - begin) / steps;
        sum += values[0];
        printf("%.1f %.1f %.1f\n", interface, kernel, instance);
        free(record);
        fmi2FreeFMUstate(one, &state);
        fmi2FreeInstance(one);
    }
    return sum == 0.0;
}

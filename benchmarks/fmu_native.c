/* What both kinds of FMU cost a tool in C:
   fmu_native LIBPYTHON EMBEDS STEP STEPS ROUNDS INPUT NATIVE GUID RESOURCES PYTHONFMU GUID RESOURCES REFERENCE...

   Times, in turn, the making of an instance and the scenario through FMI with some Reals read after each step, for the native
   FMU and for that of pythonfmu, which needs LIBPYTHON; and the scenario with the kernel's own functions. If EMBEDS is 1, the
   tool itself starts Python, so that its thread is one that Python knows; else each call of pythonfmu's wrapper makes its thread
   known, and forgotten. INPUT is a Real that is changed before each step, by as much as a controller may; -1 if there is
   none, and the kernel alone is not driven.
   Prints nanoseconds of CPU, a line a round: an instance and a step of the native FMU, of pythonfmu's, a step of the kernel. */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <fmi2Functions.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SETTINGS = 7, FMU = 3, FIRST = SETTINGS + 2 * FMU, MOST = 100 };
/* The record of an instance is in what fmi2SerializeFMUstate writes: 96 bytes of head before it. */
enum { HEAD = 96 };

static double step_size, values[MOST];
static int steps, driven;
static unsigned input, references[MOST];
static size_t wanted;

static void log_message(void *e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)e, (void)name, (void)status, (void)category;
    fprintf(stderr, "%s\n", text);
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

static void need(int right, const char *what) {
    if (right) return;
    fprintf(stderr, "%s failed\n", what);
    exit(1);
}
#define NEED(call) need((call) == 0, #call)
#define GET(name, type, ...) type (*name)(__VA_ARGS__) = NULL; *(void **)&name = dlsym(library, #name); need(name != NULL, #name)

static void *load(const char *path, int how) {
    void *library = dlopen(path, RTLD_NOW | how);
    if (!library) fprintf(stderr, "%s\n", dlerror());
    need(library != NULL, path);
    return library;
}

/* A new instance of one FMU: its address, and the time that it took to make it. */
static void *start(void *library, char **fmu, double *took) {
    static const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    GET(fmi2Instantiate, void *, const char *, int, const char *, const char *, const fmi2CallbackFunctions *, int, int);
    GET(fmi2SetupExperiment, int, void *, int, double, double, int, double);
    GET(fmi2EnterInitializationMode, int, void *);
    GET(fmi2ExitInitializationMode, int, void *);
    const double begin = now();
    void *one = fmi2Instantiate("one", 1, fmu[1], fmu[2], &callbacks, 0, 0);
    need(one != NULL, "fmi2Instantiate");
    NEED(fmi2SetupExperiment(one, 0, 0.0, 0.0, 0, 0.0));
    NEED(fmi2EnterInitializationMode(one));
    NEED(fmi2ExitInitializationMode(one));
    *took = now() - begin;
    return one;
}

/* The time of a step through FMI. */
static double through_fmi(void *library, void *one) {
    GET(fmi2DoStep, int, void *, double, double, int);
    GET(fmi2SetReal, int, void *, const unsigned *, size_t, const double *);
    GET(fmi2GetReal, int, void *, const unsigned *, size_t, double *);
    const double begin = now();
    for (int k = 0; k < steps; k++) {
        const double torque = driven ? sin(20.0 * k * step_size) : 0.0; /* N.m */
        if (driven) NEED(fmi2SetReal(one, &input, 1, &torque));
        NEED(fmi2DoStep(one, k * step_size, step_size, 1));
        NEED(fmi2GetReal(one, references, wanted, values));
    }
    return (now() - begin) / steps;
}

/* The time of a step of the kernel, in a copy of the record of a native instance. */
static double alone(void *library, void *one) {
    GET(fmi2GetFMUstate, int, void *, void **);
    GET(fmi2FreeFMUstate, int, void *, void **);
    GET(fmi2SerializedFMUstateSize, int, void *, void *, size_t *);
    GET(fmi2SerializeFMUstate, int, void *, void *, char *, size_t);
    GET(initialize, int32_t, void *, double);
    GET(advance, int32_t, void *, double);
    GET(observe, int32_t, void *);
    void *state = NULL;
    size_t bytes;
    NEED(fmi2GetFMUstate(one, &state));
    NEED(fmi2SerializedFMUstateSize(one, state, &bytes));
    char *record = aligned_alloc(64, (bytes + 127) / 64 * 64);
    NEED(fmi2SerializeFMUstate(one, state, record, bytes));
    memmove(record, record + HEAD, bytes - HEAD);
    NEED(initialize(record, 0.0));
    const double begin = now();
    for (int k = 0; k < steps; k++) {
        NEED(advance(record, (k + 1) * step_size));
        NEED(observe(record));
    }
    const double time = (now() - begin) / steps;
    free(record);
    fmi2FreeFMUstate(one, &state);
    return time;
}

int main(int count, char **arguments) {
    need(count > FIRST && count <= FIRST + MOST, "count of arguments");
    char **fmus[2] = {arguments + SETTINGS, arguments + SETTINGS + FMU};
    void *library = load(arguments[1], RTLD_GLOBAL); /* the wrapper of pythonfmu is not linked to it */
    if (atoi(arguments[2])) {
        GET(Py_InitializeEx, void, int);
        GET(PyEval_SaveThread, void *, void);
        Py_InitializeEx(0);
        PyEval_SaveThread(); /* it may be used by others */
    }
    step_size = atof(arguments[3]), steps = atoi(arguments[4]);
    const int rounds = atoi(arguments[5]);
    driven = atoi(arguments[6]) >= 0, input = driven ? (unsigned)atoi(arguments[6]) : 0;
    wanted = (size_t)(count - FIRST);
    for (size_t i = 0; i < wanted; i++) references[i] = (unsigned)atoi(arguments[FIRST + i]);
    void *libraries[2] = {load(fmus[0][0], RTLD_LOCAL), load(fmus[1][0], RTLD_LOCAL)};
    for (int round = 0; round < rounds; round++) {
        double last[2], kernel = 0.0;
        for (int kind = 0; kind < 2; kind++) {
            library = libraries[kind];
            GET(fmi2FreeInstance, void, void *);
            double instance;
            void *one = start(library, fmus[kind], &instance);
            if (kind == 0) kernel = alone(library, one);
            printf("%.1f %.1f ", instance, through_fmi(library, one));
            last[kind] = values[0];
            fmi2FreeInstance(one);
        }
        need(last[0] == last[1], "the same results of both");
        printf("%.1f\n", kernel);
    }
    return 0;
}

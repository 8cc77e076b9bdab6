/* An importer in C for FMI 3.0, with event mode: host3 LIBRARY TOKEN RESOURCES STEP STOP TIME COUNT POSITION LENGTH

   The last four are the value references of impact.last_time, impact.count and point.position, and the length of that
   array. It prints a line for each event: the time at which the step returned [s], the time of the impact [s], and the
   number of impacts so far; then the position at the stop time. Numbers have 17 digits. */
#include "host.h"
#include <fmi3Functions.h>

static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text) {
    (void)environment;
    fprintf(stderr, "%d, %s: %s\n", status, category, text);
}

#define CALL(what) need((what) == fmi3OK, #what)

int main(int count, char **arguments) {
    enum { MOST = 100 };
    need(count == 10, "arguments");
    void *library = loaded(arguments[1]);
    need(library != NULL, "load the library");
    FUNCTION(fmi3InstantiateCoSimulation, fmi3Instance, fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
             fmi3Boolean, fmi3Boolean, const fmi3ValueReference[], size_t, fmi3InstanceEnvironment,
             fmi3LogMessageCallback, fmi3IntermediateUpdateCallback);
    FUNCTION(fmi3EnterInitializationMode, fmi3Status, fmi3Instance, fmi3Boolean, fmi3Float64, fmi3Float64, fmi3Boolean,
             fmi3Float64);
    FUNCTION(fmi3ExitInitializationMode, fmi3Status, fmi3Instance);
    FUNCTION(fmi3EnterEventMode, fmi3Status, fmi3Instance);
    FUNCTION(fmi3EnterStepMode, fmi3Status, fmi3Instance);
    FUNCTION(fmi3UpdateDiscreteStates, fmi3Status, fmi3Instance, fmi3Boolean *, fmi3Boolean *, fmi3Boolean *,
             fmi3Boolean *, fmi3Boolean *, fmi3Float64 *);
    FUNCTION(fmi3DoStep, fmi3Status, fmi3Instance, fmi3Float64, fmi3Float64, fmi3Boolean, fmi3Boolean *, fmi3Boolean *,
             fmi3Boolean *, fmi3Float64 *);
    FUNCTION(fmi3GetFloat64, fmi3Status, fmi3Instance, const fmi3ValueReference[], size_t, fmi3Float64[], size_t);
    FUNCTION(fmi3GetInt64, fmi3Status, fmi3Instance, const fmi3ValueReference[], size_t, fmi3Int64[], size_t);
    FUNCTION(fmi3Terminate, fmi3Status, fmi3Instance);
    FUNCTION(fmi3FreeInstance, void, fmi3Instance);

    double size = atof(arguments[4]), stop = atof(arguments[5]), time = 0.0, values[MOST], impact, next;
    fmi3ValueReference last_time = (fmi3ValueReference)atoi(arguments[6]);
    fmi3ValueReference impacts = (fmi3ValueReference)atoi(arguments[7]);
    fmi3ValueReference position = (fmi3ValueReference)atoi(arguments[8]);
    size_t length = (size_t)atoi(arguments[9]);
    need(length <= MOST, "room for the array");
    fmi3Instance instance = fmi3InstantiateCoSimulation("host", arguments[2], arguments[3], fmi3False, fmi3True, fmi3True,
                                                        fmi3True, NULL, 0, NULL, log_message, NULL);
    need(instance != NULL, "instantiate");
    CALL(fmi3EnterInitializationMode(instance, fmi3False, 0.0, 0.0, fmi3True, stop));
    CALL(fmi3ExitInitializationMode(instance));
    for (int k = 0, needed = 1;;) { /* it begins in event mode */
        fmi3Boolean again = fmi3True, ended, early, flag;
        while (needed && again) CALL(fmi3UpdateDiscreteStates(instance, &again, &ended, &flag, &flag, &flag, &next));
        if (needed) CALL(fmi3EnterStepMode(instance));
        if (needed && time > 0.0) {
            fmi3Int64 so_far;
            CALL(fmi3GetFloat64(instance, &last_time, 1, &impact, 1));
            CALL(fmi3GetInt64(instance, &impacts, 1, &so_far, 1));
            printf("%.17g %.17g %lld\n", time, impact, (long long)so_far);
        }
        if (time >= (k + 1) * size) k++;
        if (time >= stop) break;
        fmi3Boolean event;
        double target = (k + 1) * size < stop ? (k + 1) * size : stop;
        CALL(fmi3DoStep(instance, time, target - time, fmi3True, &event, &ended, &early, &time));
        need(!early || event, "an event, where a step returns early");
        needed = event;
        if (needed) CALL(fmi3EnterEventMode(instance));
    }
    CALL(fmi3GetFloat64(instance, &position, 1, values, length));
    for (size_t i = 0; i < length; i++) printf("%.17g%c", values[i], i + 1 < length ? ' ' : '\n');
    CALL(fmi3Terminate(instance));
    fmi3FreeInstance(instance);
    return 0;
}

/* An importer in C: host LIBRARY GUID RESOURCES STEP STEPS REFERENCE... prints these variables at each step, with all
   bits: Reals, and Integers if their references begin with i. */
#include "host.h"
#include <fmi2Functions.h>
#include <stdarg.h>

static void log_message(void *environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    va_list none;
    (void)environment;
    fprintf(stderr, "%s: %d, %s: ", name, status, category);
    va_start(none, text);
    vfprintf(stderr, text, none);
    va_end(none);
    fputc('\n', stderr);
}

#define CALL(what) need((what) == fmi2OK, #what)

int main(int count, char **arguments) {
    enum { FIRST = 6, MOST = 400 };
    need(count > FIRST && count < FIRST + MOST, "arguments");
    void *library = loaded(arguments[1]);
    need(library != NULL, "load the library");
    FUNCTION(fmi2Instantiate, fmi2Component, fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *,
             fmi2Boolean, fmi2Boolean);
    FUNCTION(fmi2SetupExperiment, fmi2Status, fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real);
    FUNCTION(fmi2EnterInitializationMode, fmi2Status, fmi2Component);
    FUNCTION(fmi2ExitInitializationMode, fmi2Status, fmi2Component);
    FUNCTION(fmi2DoStep, fmi2Status, fmi2Component, fmi2Real, fmi2Real, fmi2Boolean);
    FUNCTION(fmi2GetReal, fmi2Status, fmi2Component, const fmi2ValueReference[], size_t, fmi2Real[]);
    FUNCTION(fmi2GetInteger, fmi2Status, fmi2Component, const fmi2ValueReference[], size_t, fmi2Integer[]);
    FUNCTION(fmi2Terminate, fmi2Status, fmi2Component);
    FUNCTION(fmi2FreeInstance, void, fmi2Component);

    fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    fmi2Component instance = fmi2Instantiate("host", fmi2CoSimulation, arguments[2], arguments[3], &callbacks, 0, 1);
    need(instance != NULL, "instantiate");
    double size = atof(arguments[4]), value;
    int steps = atoi(arguments[5]);
    fmi2Integer whole;
    fmi2ValueReference references[MOST];
    int are_integers[MOST], wanted = count - FIRST;
    for (int i = 0; i < wanted; i++) {
        are_integers[i] = arguments[FIRST + i][0] == 'i';
        references[i] = (fmi2ValueReference)atoi(arguments[FIRST + i] + are_integers[i]);
    }
    CALL(fmi2SetupExperiment(instance, 0, 0.0, 0.0, 1, size * steps));
    CALL(fmi2EnterInitializationMode(instance));
    CALL(fmi2ExitInitializationMode(instance));
    for (int k = 0; k < steps; k++) {
        CALL(fmi2DoStep(instance, k * size, size, 1));
        for (int i = 0; i < wanted; i++) {
            if (are_integers[i]) {
                CALL(fmi2GetInteger(instance, references + i, 1, &whole));
                value = whole;
            } else {
                CALL(fmi2GetReal(instance, references + i, 1, &value));
            }
            printf("%.17g%c", value, i + 1 < wanted ? ' ' : '\n');
        }
    }
    CALL(fmi2Terminate(instance));
    fmi2FreeInstance(instance);
    return 0;
}

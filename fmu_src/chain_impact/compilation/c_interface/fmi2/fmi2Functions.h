/* The types of FMI 2.0 for co-simulation: sections 2.1 and 4.2 of the standard, version 2.0.5.
   tests/fmu/test_interface.py also compiles the interface with the standard's own header of this name. */
#ifndef fmi2Functions_h
#define fmi2Functions_h

#include <stddef.h>

/* The same on Windows: with __declspec(dllexport) the library would not export the kernel's own functions. */
#define FMI2_Export __attribute__((visibility("default")))
#define fmi2TypesPlatform "default"
#define fmi2Version "2.0"
enum { fmi2False, fmi2True };

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Char, fmi2Byte;
typedef const fmi2Char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String name, fmi2Status, fmi2String category, fmi2String message, ...);
    void *(*allocateMemory)(size_t count, size_t size);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#endif

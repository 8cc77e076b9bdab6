/* An instance of the native FMU, and the table with the data of its scene: common to FMI 2.0 and 3.0.

   The interface is the same for every scene. It reads the data of a scene from resources/model.bin, which
   chain_impact/fmu/model_bin.py writes: the word of the record for each value reference, when a variable may be set and
   in which range, the texts, and the record with the start values. All numbers are little-endian. shared.h has the
   structures of this file and the functions of the kernel. */
#ifndef instance_h
#define instance_h

#include <stddef.h>
#include <stdint.h>

#include "shared.h"

/* The phase of an instance, which decides which calls are allowed. The phases are the states in 4.2.4 of FMI 2.0,
   without those of unfinished asynchronous steps, and in 2.3 and 4.2 of FMI 3.0. STEPPING means that a step may be
   made, EVENT is event mode, FAILED follows a step that failed; PHASES is the number of phases. */
typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED, EVENT, PHASES } Phase;
#define IN(phase) (1u << (phase))
enum { ANY_PHASE = IN(PHASES) - 1 };

/* the values of fmi2Status and fmi3Status; PENDING exists in FMI 2.0 only. Functions that return a status return it as
   an int. */
enum { OK, WARNING, DISCARD, ERROR, PENDING = 5 };

typedef struct Instance Instance;

/* The differences between FMI 2.0 and FMI 3.0, for the code that both share. */
typedef struct {
    /* names in this version of FMI, for messages: of some arguments, and of the types REAL and INTEGER (shared.h) */
    const char *token, *resources, *references, *values, *state, *types[2];
    /* the characters that must be doubled in a message for the importer's logger, such as "%#" */
    const char *escaped;
    /* 1: the importer gives the folder of the resources as a URI; 0: as a path */
    int by_uri;
    /* 1: errors are logged even if the importer does not want their category; 0: they are not */
    int says_errors;
    /* the status that a call for a step returns if the solver cannot finish the step */
    int unfinished;
    void (*log)(const Instance *, int status, const char *category, const char *message);
} Interface;

struct Instance {
    const Interface *interface;
    /* the importer's function for messages; its true type depends on the version of FMI */
    void (*logger)(void);
    void *environment;
    /* the importer's function, or calloc: returns memory filled with zeros */
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *);
    const char *name;
    /* the categories of messages that the importer wants: bit s is 1 if messages with the status s are wanted */
    unsigned categories;
    const Table *table;
    /* 1: another instance owns `table` and releases it; 0: this instance does */
    int shares_table;
    /* the record on which the kernel works: the state of the run */
    Word *record;
    /* a second record, for outputs that are computed with values that no step has used yet; NULL before first use */
    Word *other;
    Phase phase;
    /* 1: the importer uses event mode */
    int event_mode;
    /* the kernel's function that advances the record to a time [s], for a step */
    int32_t (*advance)(Word *record, double time);
    /* 1: the importer has given the start time, and a stop time if the run has one */
    int set_up;
    /* 1: the start of the run is computed, with all values that were set before the first step */
    int initialized;
    /* the record that has the outputs of the present time; NULL if the outputs must be computed before they are read */
    const Word *observed;
    /* 1: the importer was warned that the position and velocity of a prescribed motion contradict each other */
    int warned;
    /* [s] the time that the instance has reached, and the end of the run, infinite if the importer gives no end */
    double time, stop_time;
};

/* Functions of life.c, for the calls of both versions of FMI. `call` is the name of the call, for messages. */
Instance *new_instance(Instance draft, const char *call, const char *token, const char *resources);
/* Return a new instance of the same FMU, which shares the table of `first`; NULL after an error. */
Instance *another_instance(const Instance *first, const char *call, const char *name);
void free_instance(Instance *instance);
int set_logging(Instance *instance, const char *call, int on, size_t count, const char *const names[]);
int set_up(Instance *instance, const char *call, int with_tolerance, double tolerance, double start, int with_stop,
           double stop);
int enter_initialization(Instance *instance, const char *call);
int exit_initialization(Instance *instance, const char *call);
int terminate(Instance *instance, const char *call);
int reset(Instance *instance, const char *call);
int do_step(Instance *instance, const char *call, double now, double size, int *onset_due);
/* Compute the start of the run, unless it is computed already; return a status. */
int start(Instance *instance, const char *call);
/* Log the kernel's status `fault`, set the phase FAILED, in which no step is allowed, and the time that the kernel has
   reached; return `status`. */
int fail(Instance *instance, int status, int fault);

/* functions of variables.c */
/* the type of the numbers in the importer's arrays */
typedef enum { FLOAT64S, INT32S, INT64S } ArrayType;
int get(Instance *instance, const char *call, ArrayType array, const uint32_t vr[], size_t count, void *values,
        size_t length);
int set(Instance *instance, const char *call, ArrayType array, const uint32_t vr[], size_t count, const void *values,
        size_t length);
/* Return OK for an empty list of variables (`count` 0); else log that there are no `missing`, and return ERROR. */
int none(const Instance *instance, const char *call, size_t count, const char *missing);

/* functions of states.c */
int get_state(Instance *instance, const char *call, void **handle);
int set_state(Instance *instance, const char *call, void *state);
int free_state(const Instance *instance, const char *call, void **handle);
int state_size(const Instance *instance, const char *call, void *state, size_t *size);
int serialize(const Instance *instance, const char *call, void *state, void *bytes, size_t size);
int deserialize(const Instance *instance, const char *call, const void *bytes, size_t size, void **handle);

/* functions of messages.c */
#define ALL_CATEGORIES (~0u)
/* the categories that are logged with debug logging off: reasons why a call was refused or failed */
#define REFUSALS (1u << DISCARD | 1u << ERROR)
/* Return the bits of a category of messages in `categories`: all bits for "logAll", 0 for an unknown name. */
unsigned category_bit(const char *name);
/* Log a sentence if the importer wants messages of `status` or, in FMI 3.0, `status` is an error; return `status`. */
int say(const Instance *instance, int status, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Return 1 if the call is allowed in the present phase; else log an error and return 0. A null instance gives 0 without
   a message. `given` returns 1 if an argument is not NULL; else it logs an error and returns 0. */
int allowed(const Instance *instance, const char *call, unsigned phases);
int given(const Instance *instance, const char *call, const char *name, const void *argument);
/* Return words for the present phase of the instance, such as "before initialization". */
const char *when(const Instance *instance);
typedef struct { char text[1000]; } Sentence;
/* Return the sentence for a status of the kernel. If the record has the part of the scene that is the cause, the name
   of this part follows. */
Sentence reason(const Table *table, const Word *record, int status);
typedef struct { char text[32]; } Number;
/* Return a text of at most 17 digits from which exactly this number is read, such as "0.1" or "1.0". */
Number number(double value);
/* Return the text of a number, rounded to nine significant digits. */
Number rounded(double value);

/* Functions of table.c. */
/* Return the table in the folder `resources`; after an error return NULL, and *reason is the rest of a sentence. */
const Table *read_table(const Instance *draft, const char *resources, const char **reason);
/* Return 1 if the table is valid for this binary, else 0; in whole.c. */
int is_whole(const Table *table);
/* Return the checksum CRC-32 of some bytes, as in zlib and PNG. */
uint32_t checksum(const void *bytes, size_t size);
static inline const void *in_table(const Table *table, int64_t offset) { return (const char *)table + offset; }
const char *text_of(const Table *table, int64_t offset);

#endif

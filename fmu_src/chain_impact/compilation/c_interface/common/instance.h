/* An instance of the native FMU, and the table with the data of its scene: common to FMI 2.0 and 3.0.

   The interface is the same for every scene. It reads the data of a scene from resources/model.bin, which
   chain_impact/fmu/table.py writes: the word of the record for each value reference, when a variable may be set and
   in which range, the texts, and the record with the start values. All numbers are little-endian. shared.h has the
   structures of this file and the functions of the kernel. */
#ifndef instance_h
#define instance_h

#include <stddef.h>
#include <stdint.h>

#include "shared.h"

/* The states of an instance: 4.2.4 of FMI 2.0, without the states of unfinished asynchronous steps, and 2.3 and 4.2
   of FMI 3.0. EVENT is event mode. */
typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED, EVENT, PHASES } Phase;
#define IN(phase) (1u << (phase))
enum { ANY_PHASE = IN(PHASES) - 1 };

/* values of fmi2Status and fmi3Status; PENDING exists in FMI 2.0 only. Functions that return a status return an int. */
enum { OK, WARNING, DISCARD, ERROR, PENDING = 5 };

typedef struct Instance Instance;

/* The differences between the versions of FMI. */
typedef struct {
    /* the names of arguments in messages of this version of FMI */
    const char *token, *resources, *references, *values, *state;
    /* names of the types REAL and INTEGER (shared.h) in this version of FMI */
    const char *types[2];
    const char *escaped; /* characters that must be written twice in a message */
    int by_uri;          /* 1: the importer gives the folder of the resources as a URI; 0: as a path */
    int says_errors;     /* 1: errors are also logged with logging off */
    int unfinished;      /* the status that a step returns which the solver cannot finish */
    void (*log)(const Instance *, int status, const char *category, const char *message);
} Interface;

struct Instance {
    const Interface *interface;
    void (*logger)(void); /* function of the importer for messages; its type depends on the version of FMI */
    void *environment;
    void *(*allocate)(size_t count, size_t size); /* function that returns memory filled with zeros */
    void (*release)(void *);
    const char *name;
    unsigned categories; /* categories of messages that the importer wants, one bit for each */
    const Table *table;
    int shares_table; /* 1: another instance owns the table and releases it */
    Word *record; /* the record on which the kernel works */
    Word *other;  /* a copy of the record, for outputs after values were set; NULL before its first use */
    Phase phase;
    int event_mode;  /* 1: the importer uses event mode */
    int32_t (*advance)(Word *record, double time); /* the function of the kernel that advances the record to a time */
    int set_up;      /* 1: the importer has given start and stop time */
    int initialized; /* 1: the start was computed with all values that were set before the first step */
    const Word *observed; /* the record with the outputs of the present time; NULL if no record has them */
    int warned; /* 1: the importer was warned that positions and velocities of a motion contradict each other */
    double time, stop_time;
};

/* life.c: the parts of the standard's calls that both versions have in common; `call` is the name of a call */
Instance *new_instance(Instance draft, const char *call, const char *token, const char *resources);
/* Return an instance of the same FMU, which shares the table of the first one. */
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
int start(Instance *instance, const char *call); /* Compute the start, if it is not computed yet. */
int fail(Instance *instance, int status, int fault); /* Log a fault of the kernel, after which no step can follow. */

/* functions of variables.c */
typedef enum { FLOAT64S, INT32S, INT64S } ArrayType; /* type of the importer's arrays */
int get(Instance *instance, const char *call, ArrayType array, const uint32_t vr[], size_t count, void *values,
        size_t length);
int set(Instance *instance, const char *call, ArrayType array, const uint32_t vr[], size_t count, const void *values,
        size_t length);
/* Accept an empty list of variables only. */
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
/* Return the bit of a category of messages, all bits for logAll, and 0 for an unknown name. */
unsigned category_bit(const char *name);
/* Send a sentence to the importer's log if the importer wants its category; return the status. */
int say(const Instance *instance, int status, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* `allowed` returns whether a call is allowed in the present phase, `given` whether an argument is not NULL;
   otherwise they log an error. */
int allowed(const Instance *instance, const char *call, unsigned phases);
int given(const Instance *instance, const char *call, const char *name, const void *argument);
const char *when(const Instance *instance); /* Return words for the present phase of the instance. */
typedef struct { char text[1000]; } Sentence;
/* Return the sentence for a status and, if the record names a part of the scene as its cause, the words for this
   part. */
Sentence reason(const Table *table, const Word *record, int status);
typedef struct { char text[32]; } Number;
Number number(double value); /* Return the shortest text of a number from which the same number is read. */
Number rounded(double value); /* Return the text of a number with nine digits. */

/* functions of table.c */
const Table *read_table(const Instance *draft, const char *resources, const char **reason);
int is_whole(const Table *table); /* Return whether the table is valid for this binary (whole.c). */
uint32_t checksum(const void *bytes, size_t size); /* Return the checksum CRC-32 of some bytes, as in zlib and PNG. */
static inline const void *in_table(const Table *table, int64_t offset) { return (const char *)table + offset; }
const char *text_of(const Table *table, int64_t offset);

#endif

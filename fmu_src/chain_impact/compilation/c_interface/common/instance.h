/* An instance of the native FMU, and the table from which it knows its model: common to FMI 2.0 and 3.0.

   The interface is the same for every scene. What it has to know of one it reads from resources/model.bin, which
   chain_impact/fmu/table.py writes: which word of the record a value reference is, what may be set when and in
   which range, the texts, and the record with the start values. All numbers are little-endian. */
#ifndef instance_h
#define instance_h

#include <stddef.h>
#include <stdint.h>

typedef union { double real; int64_t integer; } Word;

enum { REAL, INTEGER };                 /* Variable.type; an enumeration is an integer */
enum { FIXED, TUNABLE, INPUT, OUTPUT, TIME }; /* Variable.kind */

typedef struct {
    double low, high;     /* that can be set, both included */
    int64_t word, set_word; /* of the record; what is set is written to both */
    int64_t length;         /* how many words from there: more than one of an array */
    int32_t type, kind;
    int32_t name, allowed; /* texts */
} Variable;

/* The head of the file. Places are bytes from its beginning, those of texts from `texts_at`. */
typedef struct {
    char magic[8];
    uint64_t size, checksum; /* of the whole file, and of what follows this number */
    char guid[40];
    int64_t variable_count, status_count, place_count;
    int64_t time_word, changed_word, tolerance_word, place_word;
    int64_t contradiction_word, position_word; /* of motions; 0 if there are none */
    int64_t variables_at, statuses_at, places_at, texts_at, record_at, record_size;
} Table;

/* The states of an instance: 4.2.4 of FMI 2.0, without those of steps that are not finished when a step returns, and
   2.3 and 4.2 of FMI 3.0. EVENT is event mode. */
typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED, EVENT, PHASES } Phase;
#define IN(phase) (1u << (phase))
enum { ANY_PHASE = IN(PHASES) - 1 };

/* of fmi2Status and fmi3Status, PENDING of the first; functions that return a status return an int */
enum { OK, WARNING, DISCARD, ERROR, PENDING = 5 };

typedef struct Instance Instance;

/* What differs between the versions of FMI. */
typedef struct {
    const char *token, *resources, *references, *values, *state; /* what their arguments are called */
    const char *types[2];                                        /* of REAL and INTEGER */
    const char *escaped; /* characters that are written twice in a message */
    int by_uri;          /* the folder of the resources is given as a URI */
    int says_errors;     /* also with logging off */
    int unfinished;      /* status of a step that cannot be finished */
    void (*log)(const Instance *, int status, const char *category, const char *message);
} Interface;

struct Instance {
    const Interface *interface;
    void (*logger)(void); /* the importer's, of the type that its interface gives it */
    void *environment;
    void *(*allocate)(size_t count, size_t size); /* zeros */
    void (*release)(void *);
    const char *name;
    unsigned categories; /* of messages that are wanted, a bit for each */
    const Table *table;
    int shares_table; /* with another instance, which releases it */
    Word *record; /* what the kernel works on */
    Word *other;  /* as long, once it has been needed: to try what has been set */
    Phase phase;
    int event_mode;  /* the importer uses event mode */
    int32_t (*advance)(Word *record, double time); /* the function of the kernel that its steps call */
    int set_up;      /* start and stop time are given */
    int initialized; /* the record holds the start that follows from the parameters as they are */
    const Word *observed; /* the record whose outputs are those of the present time; NULL if neither's are */
    int warned; /* of a motion that contradicts its velocity */
    double time, stop_time;
};

/* life.c: each call of the standard as far as it is the same in both versions; `call` is its name */
Instance *new_instance(Instance draft, const char *call, const char *token, const char *resources);
Instance *another_instance(const Instance *first, const char *call, const char *name); /* with the same table */
void free_instance(Instance *one);
int set_logging(Instance *one, const char *call, int on, size_t count, const char *const names[]);
int set_up(Instance *one, const char *call, int with_tolerance, double tolerance, double start, int with_stop,
           double stop);
int enter_initialization(Instance *one, const char *call);
int exit_initialization(Instance *one, const char *call);
int terminate(Instance *one, const char *call);
int reset(Instance *one, const char *call);
int do_step(Instance *one, const char *call, double now, double size, int *onset_due);
int start(Instance *one, const char *call); /* works it out, unless that is done and no parameter has changed since */
int fail(Instance *one, int status, int fault); /* of the kernel: no step can follow */

/* variables.c */
typedef enum { FLOAT64S, INT32S, INT64S } Element; /* of the importer's arrays */
int get(Instance *one, const char *call, Element element, const uint32_t vr[], size_t count, void *values,
        size_t length);
int set(Instance *one, const char *call, Element element, const uint32_t vr[], size_t count, const void *values,
        size_t length);
int none(const Instance *one, const char *call, size_t count, const char *missing); /* can be called for nothing only */

/* states.c */
int get_state(Instance *one, const char *call, void **place);
int set_state(Instance *one, const char *call, void *state);
int free_state(const Instance *one, const char *call, void **place);
int state_size(const Instance *one, const char *call, void *state, size_t *size);
int serialize(const Instance *one, const char *call, void *state, void *bytes, size_t size);
int deserialize(const Instance *one, const char *call, const void *bytes, size_t size, void **place);

/* messages.c */
#define ALL_CATEGORIES (~0u)
/* what is wanted with debug logging off: why something was not done */
#define REFUSALS (1u << DISCARD | 1u << ERROR)
unsigned category_bit(const char *name); /* 0 if there is none of that name */
/* One sentence to the importer's log, if its category is wanted; returns the status. */
int say(const Instance *one, int status, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Whether a call is, in the present phase; whether an argument is no null pointer. If not, they say so. */
int allowed(const Instance *one, const char *call, unsigned phases);
int given(const Instance *one, const char *call, const char *name, const void *argument);
const char *when(const Instance *one); /* is now, in words */
typedef struct { char text[1000]; } Sentence;
Sentence reason(const Table *table, const Word *record, int status); /* of the kernel, with the place, if it has one */
typedef struct { char text[32]; } Number;
Number number(double value); /* in as few digits as tell it from all others */
Number rounded(double value); /* to nine digits */

/* table.c */
const Table *read_table(const Instance *draft, const char *resources, const char **reason);
int is_whole(const Table *table); /* whole.c: whether nothing in it leads beyond it, or beyond the record */
uint32_t checksum(const void *bytes, size_t size); /* CRC-32 of zlib and PNG */
static inline const void *in_table(const Table *table, int64_t place) { return (const char *)table + place; }
const char *text_of(const Table *table, int64_t place);

/* the kernel, chain_impact/compilation/entry_points.py */
extern int32_t initialize(Word *record, double time);
extern int32_t advance(Word *record, double time);
enum { PAUSED = -2, ONSET_DUE = -3 }; /* statuses of the kernel, no faults */
extern int32_t advance_awhile(Word *record, double time);
extern int32_t advance_to_onset(Word *record, double time);
extern int32_t event_update(Word *record);
extern int32_t observe(Word *record);
extern int32_t sound(Word *record);
extern int64_t record_words(Word *record); /* that a record with the sizes at its start has */

#endif

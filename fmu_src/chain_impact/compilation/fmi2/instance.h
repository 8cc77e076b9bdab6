/* An instance of the native FMU, and the table from which it knows its model.

   The interface is the same for every scene. What it has to know of one it reads from resources/model.bin, which
   chain_impact/export/table.py writes: which word of the record a value reference is, what may be set when and in
   which range, the texts, and the record with the start values. All numbers are little-endian. */
#ifndef instance_h
#define instance_h

#include <fmi2Functions.h>
#include <stdint.h>

typedef union { double real; int64_t integer; } Word;

enum { REAL, INTEGER };                 /* Variable.type; an enumeration is an integer */
enum { FIXED, TUNABLE, INPUT, OUTPUT }; /* Variable.kind */

typedef struct {
    double low, high; /* that can be set, both included */
    int64_t word;     /* of the record */
    int32_t type, kind;
    int32_t name, allowed; /* texts */
} Variable;

/* The head of the file. Places are bytes from its beginning, those of texts from `texts_at`. */
typedef struct {
    char magic[8];
    uint64_t size, checksum; /* of the whole file, and of what follows this number */
    char guid[40];
    int64_t variable_count, first_output, status_count;
    int64_t time_word, changed_word, tolerance_word;
    int64_t variables_at, statuses_at, texts_at, record_at, record_size;
} Table;

/* The states of section 4.2.4, without those of steps that are not finished when fmi2DoStep returns. */
typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED, FAILED, PHASES } Phase;
#define IN(phase) (1u << (phase))
enum { ANY_PHASE = IN(PHASES) - 1 };

typedef struct {
    fmi2CallbackFunctions functions;
    const char *name;
    unsigned categories; /* of messages that are wanted, a bit for each */
    const Table *table;
    Word *record; /* what the kernel works on */
    Phase phase;
    int set_up;      /* fmi2SetupExperiment was called */
    int initialized; /* the record holds the start that follows from the parameters as they are */
    int observed;    /* the outputs in the record are those of the present time */
    double time, stop_time;
} Instance;

/* messages.c */
#define ALL_CATEGORIES (~0u)
unsigned category_bit(const char *name); /* 0 if there is none of that name */
/* One sentence to the importer's log, if its category is wanted; returns the status. */
fmi2Status say(const Instance *one, fmi2Status status, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Whether a call is, in the present phase; whether an argument is no null pointer. If not, they say so. */
int allowed(const Instance *one, const char *call, unsigned phases);
int given(const Instance *one, const char *call, const char *name, const void *argument);
const char *when(Phase phase);
const char *status_text(const Table *table, int status); /* of the kernel */
typedef struct { char text[32]; } Number;
Number number(double value); /* in as few digits as tell it from all others */

/* table.c */
const Table *read_table(const fmi2CallbackFunctions *functions, const char *location, const char **reason);
uint32_t checksum(const void *bytes, size_t size); /* CRC-32 of zlib and PNG */
const void *in_table(const Table *table, int64_t place);
const char *text_of(const Table *table, int64_t place);

/* variables.c: works the start out from the parameters, unless that is done and none has changed since. */
fmi2Status start(Instance *one, const char *call);

/* the kernel, chain_impact/compilation/entry_points.py */
extern int32_t initialize(Word *record, double time);
extern int32_t advance(Word *record, double time);
extern int32_t observe(Word *record);
extern int32_t sound(Word *record);

#endif

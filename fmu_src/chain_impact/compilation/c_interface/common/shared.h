/* What Python shares with C. packaging/c_header.py writes this file. */

#ifndef shared_h
#define shared_h

#include <stdint.h>

/* fmu/model_bin.py: values of Variable.type and Variable.role; an enumeration is an integer */
enum { REAL, INTEGER };
enum { FIXED, TUNABLE, INPUT, OUTPUT, INDEPENDENT };

/* fmu/model_bin.py: the structures of resources/model.bin in an FMU */
#define TABLE_MAGIC "chaintab"

typedef struct {
    double low, high;
    int64_t word, set_word, length;
    int32_t type, role, name, allowed;
} Variable;

typedef struct {
    char magic[8];
    uint64_t size, checksum;
    char guid[40];
    int64_t variable_count, status_count, part_count, time_word, changed_word, tolerance_word, part_word,
        contradiction_word, distance_word, duration_word, velocity_word, position_word, variables_at,
        statuses_at, parts_at, texts_at, record_at, record_size;
} Table;

/* kernel/record/counts.py: the counts and flags at the start of a record, then the number of tangent instances */
enum { COUNTS = 8, FEATURES = 2, SIZES = COUNTS + FEATURES + 1, LARGEST_COUNT = 1048575 };

/* kernel/status.py: statuses of the kernel that are no faults */
enum { PAUSED = -2, ONSET_DUE = -3 };

/* kernel/chain/inputs.py: the value of given.pending with which the solver re-initializes */
enum { REINITIALIZE = 1 };

/* compilation/signatures.py: the functions of the kernel */
typedef union { double real; int64_t integer; } Word;
extern int32_t initialize(Word *d, double time);
extern int32_t advance_to(Word *d, double time);
extern int32_t advance_awhile(Word *d, double time);
extern int32_t advance_to_onset(Word *d, double time);
extern int32_t event_update(Word *d);
extern int32_t observe_now(Word *d);
extern int32_t is_sound(Word *d);
extern int32_t log_contacts(Word *d);
extern int64_t record_words(Word *d);
extern int64_t trajectory(Word *d, double *times, int64_t count, int64_t *spans, int64_t span_count, double
    *rows, int64_t columns, int32_t of_state);
extern int64_t run_each(Word *d, int64_t *indices, int64_t parameters, double *values, double *end_times,
    int64_t runs, int64_t *output_indices, int64_t columns, double *rows, int32_t continuing);

#endif

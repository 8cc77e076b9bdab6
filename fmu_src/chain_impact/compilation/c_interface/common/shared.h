/* Structures and numbers that Python shares with C. docs/generate.py writes this file. */

#ifndef shared_h
#define shared_h

#include <stdint.h>

/* fmu/table.py: values of Variable.type and Variable.kind; an enumeration is an integer */
enum { REAL, INTEGER };
enum { FIXED, TUNABLE, INPUT, OUTPUT, INDEPENDENT };

/* fmu/table.py: the structures of the file model.bin */
#define TABLE_MAGIC "chaintab"

typedef struct {
    double low;
    double high;
    int64_t word;
    int64_t set_word;
    int64_t length;
    int32_t type;
    int32_t kind;
    int32_t name;
    int32_t allowed;
} Variable;

typedef struct {
    char magic[8];
    uint64_t size;
    uint64_t checksum;
    char guid[40];
    int64_t variable_count;
    int64_t status_count;
    int64_t part_count;
    int64_t time_word;
    int64_t changed_word;
    int64_t tolerance_word;
    int64_t part_word;
    int64_t contradiction_word;
    int64_t position_word;
    int64_t variables_at;
    int64_t statuses_at;
    int64_t parts_at;
    int64_t texts_at;
    int64_t record_at;
    int64_t record_size;
} Table;

/* kernel/record/counts.py: the sizes at the start of a record, the last for tangent instances */
enum { COUNTS = 8, FEATURES = 2, SIZES = COUNTS + FEATURES + 1 };

/* kernel/status.py: statuses of the kernel that are no faults */
enum { PAUSED = -2, ONSET_DUE = -3 };

/* kernel/forces/inputs.py: the value of given.changed with which the solver re-initializes */
enum { AT_ONCE = 1 };

#endif

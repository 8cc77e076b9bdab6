/* The check that a table is valid for this binary: every offset lies inside the file, every word inside the record, and
   the record has the size that the kernel expects. The checksum alone does not show this, because a program that
   changes the file can also write the checksum that belongs to the changed file. */
#include "instance.h"

/* Return the largest allowed number at index `i` at the start of a record: first counts, for which the kernel is
   compiled up to LARGEST_COUNT, then flags, which are 0 or 1; the last number counts tangent instances. */
static int64_t largest_size(int i) {
    return i < COUNTS ? LARGEST_COUNT : i < COUNTS + FEATURES ? 1 : 1 << 16;
}

/* Return whether `count` items of `size` bytes each, from `offset` on, lie inside the file, after the head of the file,
   and begin at a multiple of 8 bytes. */
static int lies_in(const Table *table, int64_t offset, int64_t count, uint64_t size) {
    if (offset < (int64_t)sizeof *table || offset % (int64_t)sizeof(int64_t) != 0 || count < 0) return 0;
    uint64_t from = (uint64_t)offset;
    return from <= table->size && (uint64_t)count <= (table->size - from) / size;
}

/* Return whether an offset from the start of the texts lies inside the texts, which go on to the end of the file. Every
   text has an end, because the last byte of the file is 0. */
static int is_text(const Table *table, int64_t offset) {
    return offset >= 0 && offset < (int64_t)table->size - table->texts_at;
}

static int are_texts(const Table *table, int64_t offset, int64_t count) {
    const int64_t *texts = in_table(table, offset);
    for (int64_t i = 0; i < count; i++)
        if (!is_text(table, texts[i])) return 0;
    return 1;
}

static int is_word(const Table *table, int64_t word) {
    return word >= SIZES && word < table->record_size / (int64_t)sizeof(Word);
}

static int is_variable(const Table *table, const Variable *variable) {
    return (variable->type == REAL || variable->type == INTEGER) &&
           variable->role >= FIXED && variable->role <= INDEPENDENT &&
           is_text(table, variable->name) && is_text(table, variable->allowed) && is_word(table, variable->word) &&
           is_word(table, variable->set_word) && variable->length >= 1 && variable->length <= table->record_size &&
           is_word(table, variable->word + variable->length - 1);
}

/* Return whether the record has the length that the kernel expects, and every index in the record is within bounds. */
static int is_record(const Table *table) {
    Word *record = (Word *)((char *)table + table->record_at);
    const int64_t words = table->record_size / (int64_t)sizeof *record;
    if (words < SIZES || table->record_size % (int64_t)sizeof *record != 0) return 0;
    for (int i = 0; i < SIZES; i++)
        if (record[i].integer < (i == 0) || record[i].integer > largest_size(i)) return 0;
    return record_words(record) == words && is_sound(record) == 1;
}

int is_whole(const Table *table) {
    const char *bytes = (const char *)table;
    /* without a 0 as last byte, the guid or the last text of the file would be read beyond its end */
    if (table->guid[sizeof table->guid - 1] || bytes[table->size - 1]) return 0;
    if (table->texts_at < (int64_t)sizeof *table || (uint64_t)table->texts_at > table->size) return 0;
    if (!lies_in(table, table->variables_at, table->variable_count, sizeof(Variable)) ||
        !lies_in(table, table->statuses_at, table->status_count, sizeof(int64_t)) ||
        !lies_in(table, table->parts_at, table->part_count, sizeof(int64_t)) ||
        !lies_in(table, table->record_at, table->record_size, 1))
        return 0;
    const int64_t words[] = {table->time_word, table->changed_word, table->tolerance_word, table->part_word,
                             table->contradiction_word, table->distance_word, table->duration_word,
                             table->velocity_word};
    /* the last four words are those of prescribed motions: a scene without these has none */
    for (int i = 0; i < (table->contradiction_word != 0 ? 8 : 4); i++)
        if (!is_word(table, words[i])) return 0;
    const Variable *variables = in_table(table, table->variables_at);
    for (int64_t i = 0; i < table->variable_count; i++)
        if (!is_variable(table, variables + i)) return 0;
    return are_texts(table, table->statuses_at, table->status_count) &&
           are_texts(table, table->parts_at, table->part_count) && is_record(table);
}

/* Reads resources/model.bin, the table with the data of the scene, and checks that the file is complete. */
#include "instance.h"

#include <fcntl.h>
#include <string.h>
#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#define NOGDI
#define NOUSER
#include <io.h>
#include <windows.h>
#else
#include <unistd.h>
#endif

/* [bytes] LONGEST: size of the longest path that can be opened, with the 0 at the end */
enum { LONGEST = 4096 };

/* Open a file for reading by its path in UTF-8, without stdio, which allocates memory. Return −1 if this fails. */
static int open_file(const char *path) {
#ifdef _WIN32
    wchar_t wide[LONGEST];
    if (!MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, wide, LONGEST)) return -1;
    return _wopen(wide, _O_RDONLY | _O_BINARY);
#else
    return open(path, O_RDONLY | O_CLOEXEC);
#endif
}

static int read_all(int file, void *target, uint64_t size) {
    for (char *at = target; size > 0;) {
        long got = (long)read(file, at, size < 1 << 20 ? (unsigned)size : 1 << 20);
        if (got <= 0) return 0;
        at += got;
        size -= (uint64_t)got;
    }
    return 1;
}

static int hexadecimal(char digit) {
    static const char DIGITS[] = "0123456789abcdef0123456789ABCDEF";
    const char *found = digit ? strchr(DIGITS, digit) : NULL;
    return found ? (int)(found - DIGITS) % 16 : -1;
}

static const char NAME[] = "/model.bin";

/* Write the path of model.bin to `path`, from the URI of the folder: file:///folder, file:/folder or
   file://localhost/folder. Beyond the standard, a path of the folder is accepted, too. Return 1; 0 if the URI is not
   valid, or too long. */
static int path_by_uri(const char *uri, char path[LONGEST]) {
    if (strncmp(uri, "file:", 5) == 0) uri += 5;
    if (strncmp(uri, "//", 2) == 0) uri += strncmp(uri, "//localhost/", 12) == 0 ? 11 : 2;
#ifdef _WIN32
    /* in a URI such as /C:/folder, the Windows path begins after the first / */
    if (uri[0] == '/' && uri[1] && uri[2] == ':') uri++;
#endif
    size_t size = 0;
    while (*uri && size + sizeof NAME < LONGEST) {
        char letter = *uri++;
        if (letter == '%') {
            int high = hexadecimal(uri[0]), low = high < 0 ? -1 : hexadecimal(uri[1]);
            if (low < 0 || high + low == 0) return 0;
            letter = (char)(16 * high + low);
            uri += 2;
        }
        path[size++] = letter;
    }
    if (*uri || size == 0) return 0;
    memcpy(path + size - (path[size - 1] == '/'), NAME, sizeof NAME);
    return 1;
}

/* Write the path of model.bin to `path`, from the path of the folder, with or without a separator at the end. Return 1;
   0 if the folder's path is empty or too long. */
static int path_by_path(const char *folder, char path[LONGEST]) {
    size_t size = strlen(folder);
    if (size == 0 || size + sizeof NAME > LONGEST) return 0;
    memcpy(path, folder, size);
    int ends = path[size - 1] == '/';
#ifdef _WIN32
    ends |= path[size - 1] == '\\';
#endif
    memcpy(path + size - ends, NAME, sizeof NAME);
    return 1;
}

const Table *read_table(const Instance *draft, const char *resources, const char **reason) {
    char path[LONGEST];
    int by_uri = draft->interface->by_uri;
    *reason = by_uri ? "is no URI of a folder, such as file:///folder/resources" : "is no path of a folder";
    if (!(by_uri ? path_by_uri(resources, path) : path_by_path(resources, path))) return NULL;
    *reason = "has no file model.bin that can be read";
    int file = open_file(path);
    if (file < 0) return NULL;
    *reason = "has a file model.bin that is damaged";
    Table head, *table = NULL;
    const size_t begin = offsetof(Table, guid); /* the checksum covers all bytes from guid to the file's end */
    if (read_all(file, &head, sizeof head) && memcmp(head.magic, TABLE_MAGIC, sizeof head.magic) == 0 &&
        head.size > sizeof head && !(table = draft->allocate(1, head.size)))
        *reason = "needs more memory than there is";
    if (table) {
        *table = head;
        int is_read = read_all(file, table + 1, head.size - sizeof head) &&
                      head.checksum == checksum((char *)table + begin, head.size - begin);
        if (is_read) *reason = "has a file model.bin that is not for this binary, or damaged";
        if (!is_read || !is_whole(table)) {
            draft->release(table);
            table = NULL;
        }
    }
    close(file);
    return table;
}

/* Return the CRC-32 of `size` bytes. Each step takes four bytes, which are eight groups of four bits; each group has a
   table of 16 entries. tables[0] belongs to the last group. The table of any other group follows from the table of the
   group after it, by a shift of four bits. */
uint32_t checksum(const void *bytes, size_t size) {
    static const uint32_t LAST[16] = {
        0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    uint32_t tables[8][16], crc = ~0u, word;
    memcpy(tables[0], LAST, sizeof LAST);
    for (int k = 1; k < 8; k++)
        for (int i = 0; i < 16; i++) tables[k][i] = tables[k - 1][i] >> 4 ^ LAST[tables[k - 1][i] & 15];
    const unsigned char *at = bytes;
    for (; size >= sizeof word; at += sizeof word, size -= sizeof word) {
        memcpy(&word, at, sizeof word);
        word ^= crc;
        crc = 0;
        for (int k = 0; k < 8; k++) crc ^= tables[7 - k][word >> 4 * k & 15];
    }
    for (; size > 0; at++, size--) {
        crc ^= *at;
        for (int k = 0; k < 2; k++) crc = crc >> 4 ^ LAST[crc & 15];
    }
    return ~crc;
}

const char *text_of(const Table *table, int64_t offset) { return in_table(table, table->texts_at + offset); }

/* A library to preload: it ends the process at an access to a freed C++ object of 128 bytes, such as the state of
   pythonfmu's wrapper. Each such object has a page of memory of its own, which becomes inaccessible with it. */
#define _GNU_SOURCE
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/mman.h>

enum { SIZE = 128, PAGE = 4096, PAGES = 4096 };

static _Alignas(PAGE) char pages[PAGES][PAGE];
static atomic_size_t used;

void *_Znwm(size_t size) { /* operator new(size_t) */
    size_t next = size == SIZE ? atomic_fetch_add(&used, 1) : PAGES;
    return next < PAGES ? pages[next] : malloc(size);
}

void _ZdlPv(void *block) { /* operator delete(void *) */
    if ((char *)block >= pages[0] && (char *)block < pages[PAGES])
        mprotect(block, PAGE, PROT_NONE);
    else
        free(block);
}

void _ZdlPvm(void *block, size_t size) { /* operator delete(void *, size_t) */
    (void)size;
    _ZdlPv(block);
}

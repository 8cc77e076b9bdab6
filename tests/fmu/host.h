/* The common part of the importers in C: they load the binary of an FMU, on Linux and Windows, as tools without Python
   do. */
#include <stdio.h>
#include <stdlib.h>
#ifdef _WIN32
#include <windows.h>
static void *loaded(const char *path) { return (void *)LoadLibraryA(path); }
static void *found(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *loaded(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *found(void *library, const char *name) { return dlsym(library, name); }
#endif

static void need(int right, const char *what) {
    if (right) return;
    fprintf(stderr, "failed: %s\n", what);
    exit(1);
}

#define FUNCTION(name, type, ...)            \
    type (*name)(__VA_ARGS__);               \
    *(void **)&name = found(library, #name); \
    need(name != NULL, #name)

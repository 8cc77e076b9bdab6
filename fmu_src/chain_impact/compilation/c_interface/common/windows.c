/* vsnprintf and snprintf: the C library of Windows exports neither; only the headers of Windows define them, inline. */
#ifdef _WIN32
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

/* flag for the behaviour of the C standard: a text that is cut ends with 0, and the result is the length without cut */
enum { AS_C_SAYS = 2 };

int __stdio_common_vsprintf(uint64_t options, char *text, size_t size, const char *format, void *locale,
                            va_list values);

int vsnprintf(char *text, size_t size, const char *format, va_list values) {
    return __stdio_common_vsprintf(AS_C_SAYS, text, size, format, NULL, values);
}

int snprintf(char *text, size_t size, const char *format, ...) {
    va_list values;
    va_start(values, format);
    int length = vsnprintf(text, size, format, values);
    va_end(values);
    return length;
}
#endif

/* Defect: a stack frame whose size is known only at run time. */
#include <string.h>

int canary_dynamic(const char *text, unsigned size);

int canary_dynamic(const char *text, unsigned size)
{
    char *copy = __builtin_alloca(size);
    memcpy(copy, text, size);
    return ((volatile char *)copy)[size / 2];
}

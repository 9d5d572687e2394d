/* memory.c - block moves and comparing, byte by byte: newlib's are built for speed and take ten times the code.
 *
 * Compiled so that the loops are not turned into calls of the very functions they make up.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    unsigned char *out = to;
    const unsigned char *in = from;
    while (size > 0U) {
        *out++ = *in++;
        size--;
    }
    return to;
}

void *memmove(void *to, const void *from, size_t size)
{
    unsigned char *out = to;
    const unsigned char *in = from;
    const bool upwards = (uintptr_t)out < (uintptr_t)in;
    for (size_t i = 0; i < size; i++) {
        const size_t at = upwards ? i : (size - 1U - i);
        out[at] = in[at];
    }
    return to;
}

int memcmp(const void *a, const void *b, size_t size)
{
    const unsigned char *left = a;
    const unsigned char *right = b;
    int difference = 0;
    for (size_t i = 0; (i < size) && (difference == 0); i++) {
        difference = (int)left[i] - (int)right[i];
    }
    return difference;
}

void *memset(void *to, int value, size_t size)
{
    unsigned char *out = to;
    while (size > 0U) {
        *out++ = (unsigned char)value;
        size--;
    }
    return to;
}

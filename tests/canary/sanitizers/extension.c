/* What a faulty extension module would do inside the interpreter: write the named element of an eight-byte array. */
#include <stdlib.h>

int canary_write(int index);

int canary_write(int index)
{
    volatile char *volatile array = calloc(8, 1); /* volatile: only AddressSanitizer knows its size */
    array[index] = 1;
    free((void *)array);
    return index;
}

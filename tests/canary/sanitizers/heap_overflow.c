/* Writes the element of an eight-byte array that the argument names: 8 and more are beyond its end. */
#include <stdlib.h>

int main(int count, char **arguments)
{
    volatile char *volatile array = calloc(8, 1); /* volatile: only AddressSanitizer knows its size */
    array[(count > 1) ? atoi(arguments[1]) : 0] = 1;
    free((void *)array);
    return 0;
}

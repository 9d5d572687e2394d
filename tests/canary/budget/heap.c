/* Defect: memory from the heap. */
#include <stdlib.h>

void *canary_heap(unsigned size);

void *canary_heap(unsigned size)
{
    return malloc(size);
}

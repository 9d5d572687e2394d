/* resident.c - what the core keeps in RAM on this board, for the budget: the averaging state of one block, and errno.
 *
 * The square root of newlib's libm sets errno. One word of the board's own serves it instead of the reentrancy block
 * that newlib would bring along (96 bytes and more).
 */
#include "core/averaging.h"

int *__errno(void);

tumble_averaging_t tumble_resident_averaging;

int *__errno(void)
{
    static int number;
    return &number;
}

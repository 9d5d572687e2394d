/* host.c - target.h for a program that runs on this machine. */
#include "target.h"

#include <stdio.h>

void target_put(int character)
{
    (void)putchar(character);
}

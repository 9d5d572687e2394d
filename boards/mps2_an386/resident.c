/* resident.c - what the core keeps in RAM on this board, for the budget: the averaging state of one block. */
#include "tumble/core.h"

tumble_averaging_t tumble_resident_averaging;

/* resident_navcomp.c - what navcomp keeps in RAM on this board, for the budget: its one object. */
#include "navcomp/navcomp.h"

tumble_navcomp_t tumble_resident_navcomp;

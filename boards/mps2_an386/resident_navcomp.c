/* resident_navcomp.c - what navcomp keeps in RAM on this board, for the budget: its one object, and that of its stand. */
#include "stand/drive402/drive402.h"
#include "tumble/navcomp.h"

tumble_navcomp_t tumble_resident_navcomp;
tumble_drive402_t tumble_resident_stand;

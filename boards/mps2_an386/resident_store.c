/* resident_store.c - what a computer that keeps its coefficients has in RAM besides, for the budget: store, history and
 * checkpoint, and the sums of one trend. */
#include "tumble/sets.h"

tumble_store_t tumble_resident_store;
tumble_history_t tumble_resident_history;
tumble_checkpoint_t tumble_resident_checkpoint;
tumble_trend_sums_t tumble_resident_trend;

/* history_entry.h - the bytes of an entry of the history (private to the room). */
#ifndef TUMBLE_SETS_HISTORY_ENTRY_H
#define TUMBLE_SETS_HISTORY_ENTRY_H

#include "tumble/sets.h"

/* Give an encoded entry another number. */
void tumble_history_number(uint8_t bytes[TUMBLE_HISTORY_BYTES], uint32_t number);

#endif

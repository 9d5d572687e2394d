/* remedies.h - what to look at when the procedure has stopped for a reason: the words of docs/operations.md, of which
 * remedies.c is made. */
#ifndef TUMBLE_LINUX_REMEDIES_H
#define TUMBLE_LINUX_REMEDIES_H

#include "procedure/states.h"

/* One or two sentences; safe for values outside the list, never null. */
const char *tumble_reason_remedy(tumble_reason_t reason);

#endif

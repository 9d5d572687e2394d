/* positioner_option.h - the option --stand of tumble-node: a controller with registers as its stand, over Modbus TCP. */
#ifndef TUMBLE_NODE_POSITIONER_OPTION_H
#define TUMBLE_NODE_POSITIONER_OPTION_H

#include "tumble/navcomp.h"

#include <stdbool.h>

/* An option's `take` (arguments.h): modbus:HOST:PORT[,NAME=NUMBER...]; the names are `unit` and the numbers of
 * tumble_positioner_profile_t. There is one such stand in a process. */
bool positioner_option_take(void *options, const char *text);

/* If the option was given, begin to talk to the controller, and make it the stand. False: errno says why it cannot. */
bool positioner_option_use(tumble_navcomp_config_t *config);

/* Once the computer makes no more steps. */
void positioner_option_close(void);

#endif

/* communication.h - a node's own objects, 1001h to 1BFFh, as dictionary hooks; private to canopen.
 *
 * The context of the hooks is the tumble_node_t. Objects whose value never changes (1000h, 1005h, 1018h)
 * have their home in the table and do not come here.
 */
#ifndef TUMBLE_CANOPEN_COMMUNICATION_H
#define TUMBLE_CANOPEN_COMMUNICATION_H

#include "canopen/node.h"

extern const tumble_object_hooks_t tumble_communication_hooks;

/* Clear the error register's communication bit when no watched node is silent and no receive PDO falls short. */
void tumble_communication_mend(tumble_node_t *node);

#endif

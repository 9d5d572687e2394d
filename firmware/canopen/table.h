/* table.h - how a generated table of objects is written, and what it says of a struct that others write, checked when it
 * is compiled.
 *
 * An entry of a table has size and offset of a member; a row for several has those of the first, and the others lie one
 * after the other. `where` is what the compiler is to say of one that does not: the object, as a text.
 */
#ifndef TUMBLE_CANOPEN_TABLE_H
#define TUMBLE_CANOPEN_TABLE_H

#include "canopen/dictionary.h"

#include <assert.h>
#include <stddef.h>

/* A row (tumble_entry_t), and its access in the words of the EDS files. */
#define TUMBLE_ROW(index, subindex, type, home, access, size, limit, more_objects, more_subindices, offset, source)    \
    {(index), (subindex),     TUMBLE_TYPE_##type, TUMBLE_HOME_##home, (access), (size),                                \
     (limit), (more_objects), (more_subindices),  (offset),           (source)}
#define RO TUMBLE_ACCESS_READ
#define WO TUMBLE_ACCESS_WRITE
#define RW (TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE)
#define RPDO TUMBLE_ACCESS_MAP_RECEIVE
#define TPDO TUMBLE_ACCESS_MAP_TRANSMIT
#define SERVICE TUMBLE_ACCESS_SERVICE

/* A member has so many bytes. */
#define TUMBLE_HAS_SIZE(where, type, size, member) static_assert(sizeof(((const type *)NULL)->member) == (size), where)

/* So many have that size, and lie one right behind the other. */
#define TUMBLE_IN_LINE_2(where, type, size, a, b)                                                                      \
    TUMBLE_HAS_SIZE(where, type, size, a);                                                                             \
    TUMBLE_HAS_SIZE(where, type, size, b);                                                                             \
    static_assert(offsetof(type, b) == (offsetof(type, a) + (size)), where)
#define TUMBLE_IN_LINE_3(where, type, size, a, b, c)                                                                   \
    TUMBLE_IN_LINE_2(where, type, size, a, b);                                                                         \
    TUMBLE_IN_LINE_2(where, type, size, b, c)
#define TUMBLE_IN_LINE_4(where, type, size, a, b, c, d)                                                                \
    TUMBLE_IN_LINE_2(where, type, size, a, b);                                                                         \
    TUMBLE_IN_LINE_3(where, type, size, b, c, d)

/* An array has so many elements of that size, and this is the first. */
#define TUMBLE_IS_ARRAY(where, type, size, array, first, count)                                                        \
    TUMBLE_HAS_SIZE(where, type, size, first);                                                                         \
    TUMBLE_HAS_SIZE(where, type, (size) * (size_t)(count), array);                                                     \
    static_assert(offsetof(type, first) == offsetof(type, array), where)

#endif

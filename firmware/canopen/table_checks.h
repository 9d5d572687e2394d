/* table_checks.h - what a table of objects says of a struct that others write, checked when it is compiled.
 *
 * An entry of a table has size and offset of a member; a row for several has those of the first, and the others lie one
 * after the other. `where` is what the compiler is to say of one that does not: the object, as a text.
 */
#ifndef TUMBLE_CANOPEN_TABLE_CHECKS_H
#define TUMBLE_CANOPEN_TABLE_CHECKS_H

#include <assert.h>
#include <stddef.h>

/* A member has so many bytes. */
#define TUMBLE_HAS_SIZE(where, type, member, size) static_assert(sizeof(((const type *)NULL)->member) == (size), where)

/* The same, and it lies right behind another one of its size. */
#define TUMBLE_FOLLOWS(where, type, before, member, size)                                                              \
    TUMBLE_HAS_SIZE(where, type, member, size);                                                                        \
    static_assert(offsetof(type, member) == (offsetof(type, before) + (size)), where)

/* An array has so many elements of that size, and this is the first. */
#define TUMBLE_IS_ARRAY(where, type, array, first, size, count)                                                        \
    TUMBLE_HAS_SIZE(where, type, first, size);                                                                         \
    TUMBLE_HAS_SIZE(where, type, array, (size) * (size_t)(count));                                                     \
    static_assert(offsetof(type, first) == offsetof(type, array), where)

#endif

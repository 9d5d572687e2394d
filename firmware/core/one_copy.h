/* one_copy.h - a function that stays one function.
 *
 * Link-time optimisation copies a function to its callers if it takes that for shorter. Sometimes it is wrong, and the
 * image grows by more than there is room for. Where that was measured the function is marked.
 */
#ifndef TUMBLE_CORE_ONE_COPY_H
#define TUMBLE_CORE_ONE_COPY_H

#if defined(__GNUC__)
#define TUMBLE_ONE_COPY __attribute__((noinline))
#else
#define TUMBLE_ONE_COPY
#endif

#endif

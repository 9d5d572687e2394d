/* one_copy.h - a function that stays one function.
 *
 * A link that optimises the whole copies functions to where they are called if it takes that for shorter. It is mistaken at
 * times, and by as much as the image is short of: so where that was measured the function is marked.
 */
#ifndef TUMBLE_CORE_ONE_COPY_H
#define TUMBLE_CORE_ONE_COPY_H

#if defined(__GNUC__)
#define TUMBLE_ONE_COPY __attribute__((noinline))
#else
#define TUMBLE_ONE_COPY
#endif

#endif

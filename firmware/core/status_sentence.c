/* status_sentence.c - apart from the names: a target whose compiler keeps the constants of a file together, and which shows
 * names alone, would hold 2 kB of sentences. */
#include "tumble/status.h"

const char *tumble_status_sentence(tumble_status_t status)
{
    static const char *const sentences[] = {
#define TUMBLE_STATUS_SENTENCE(name, sentence) sentence,
        TUMBLE_STATUS_LIST(TUMBLE_STATUS_SENTENCE)
#undef TUMBLE_STATUS_SENTENCE
    };
    const unsigned index = (unsigned)status;
    return (index < (unsigned)TUMBLE_STATUS_COUNT) ? sentences[index] : "this status is not in the list";
}

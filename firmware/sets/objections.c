/* The names of the commit rules' objections. */
#include "tumble/sets.h"

const char *tumble_objection_name(tumble_objection_t objection)
{
    static const char *const names[] = {
#define TUMBLE_OBJECTION_NAME(name, sentence) #name,
        TUMBLE_OBJECTION_LIST(TUMBLE_OBJECTION_NAME)
#undef TUMBLE_OBJECTION_NAME
    };
    const unsigned index = (unsigned)objection;
    return (index < (unsigned)TUMBLE_OBJECTION_COUNT) ? names[index] : "TUMBLE_OBJECTION_UNKNOWN";
}

const char *tumble_objection_sentence(tumble_objection_t objection)
{
    static const char *const sentences[] = {
#define TUMBLE_OBJECTION_SENTENCE(name, sentence) sentence,
        TUMBLE_OBJECTION_LIST(TUMBLE_OBJECTION_SENTENCE)
#undef TUMBLE_OBJECTION_SENTENCE
    };
    const unsigned index = (unsigned)objection;
    return (index < (unsigned)TUMBLE_OBJECTION_COUNT) ? sentences[index] : "this objection is not in the list";
}

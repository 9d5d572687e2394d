#include "canopen/abort.h"

#include <stddef.h>

const char *tumble_abort_sentence(uint32_t code)
{
    static const struct {
        uint32_t code;
        const char *sentence;
    } texts[] = {
#define ABORT_TEXT(name, code, sentence) {(uint32_t)(name), (sentence)},
        TUMBLE_ABORT_LIST(ABORT_TEXT)
#undef ABORT_TEXT
    };
    const char *sentence = "this abort code is not in the list";

    for (size_t i = 0; i < (sizeof texts / sizeof texts[0]); i++) {
        if (texts[i].code == code) {
            sentence = texts[i].sentence;
        }
    }
    return sentence;
}

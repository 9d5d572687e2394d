/* Defect: a pointer to bytes read as a pointer to words (rule 11.3). */
#include <stdint.h>

extern uint32_t canary_word(const uint8_t *bytes);

uint32_t canary_word(const uint8_t *bytes)
{
    return *(const uint32_t *)bytes;
}

#include "canopen/dictionary.h"

#include "core/arith.h"
#include "core/bytes.h"
#include "core/one_copy.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

const tumble_entry_t *tumble_dictionary_row(const tumble_dictionary_t *dictionary, uint8_t place)
{
    const uint8_t first = dictionary->table->count;
    return (place < first) ? &dictionary->table->entries[place] : &dictionary->extension->table->entries[place - first];
}

tumble_abort_t tumble_dictionary_place(const tumble_dictionary_t *dictionary, uint16_t index, uint8_t subindex,
                                       uint8_t *place)
{
    const uint8_t further = (dictionary->extension != NULL) ? dictionary->extension->table->count : 0U;
    const uint8_t count = (uint8_t)(dictionary->table->count + further);
    tumble_abort_t refusal = TUMBLE_ABORT_NO_OBJECT;
    for (uint8_t i = 0; i < count; i++) {
        const tumble_entry_t *entry = tumble_dictionary_row(dictionary, i);
        if ((index >= entry->index) && ((index - entry->index) <= entry->more_objects)) {
            *place = i;
            if ((subindex >= entry->subindex) && ((subindex - entry->subindex) <= entry->more_subindices)) {
                return TUMBLE_ABORT_NONE;
            }
            refusal = TUMBLE_ABORT_NO_SUBINDEX;
        }
    }
    /* The number of entries, which the object's last entry tells. */
    return ((refusal == TUMBLE_ABORT_NO_SUBINDEX) && (subindex == 0U)) ? TUMBLE_ABORT_NONE : refusal;
}

tumble_entry_t tumble_dictionary_entry(const tumble_dictionary_t *dictionary, uint8_t place, uint16_t index,
                                       uint8_t subindex)
{
    tumble_entry_t entry = *tumble_dictionary_row(dictionary, place);
    if (subindex < entry.subindex) {
        const uint8_t highest = (uint8_t)(entry.subindex + entry.more_subindices);
        entry.type = TUMBLE_TYPE_UNSIGNED8;
        entry.access = TUMBLE_ACCESS_READ;
        entry.home = TUMBLE_HOME_IMMEDIATE;
        entry.size = 1;
        entry.limit = 0;
        entry.offset = highest;
    } else {
        entry.offset = (entry.offset + ((uint32_t)(subindex - entry.subindex) * entry.size)) & TUMBLE_MAX_OFFSET;
    }
    if (place >= dictionary->table->count) {
        entry.access |= TUMBLE_ACCESS_EXTENSION;
    }
    entry.index = index;
    entry.subindex = subindex;
    return entry;
}

tumble_abort_t tumble_dictionary_find(const tumble_dictionary_t *dictionary, uint16_t index, uint8_t subindex,
                                      tumble_entry_t *entry)
{
    uint8_t place;
    const tumble_abort_t refusal = tumble_dictionary_place(dictionary, index, subindex, &place);
    if (refusal == TUMBLE_ABORT_NONE) {
        *entry = tumble_dictionary_entry(dictionary, place, index, subindex);
    }
    return refusal;
}

static bool is_string(const tumble_entry_t *entry)
{
    return entry->type == TUMBLE_TYPE_VISIBLE_STRING;
}

static bool is_further(const tumble_entry_t *entry)
{
    return (entry->access & TUMBLE_ACCESS_EXTENSION) != 0U;
}

/* The table that an entry came from. */
static const tumble_object_table_t *table_of(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry)
{
    return is_further(entry) ? dictionary->extension->table : dictionary->table;
}

static tumble_object_owner_t owner_of(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry)
{
    if (entry->home == TUMBLE_HOME_COMMUNICATION) {
        return dictionary->communication;
    }
    return (tumble_object_owner_t){.hooks =
                                       is_further(entry) ? dictionary->extension->hooks : dictionary->application.hooks,
                                   .context = dictionary->application.context};
}

/* The variable of an entry whose home is RAM, else null. */
static uint8_t *variable_of(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry)
{
    if (entry->home == TUMBLE_HOME_VARIABLES) {
        return (uint8_t *)dictionary->variables + entry->offset;
    }
    return (entry->home == TUMBLE_HOME_OTHER) ? ((uint8_t *)dictionary->other + entry->offset) : NULL;
}

/* Padded with zeros up to its size, or as long as it can be. */
static uint8_t string_length(const uint8_t *at, uint8_t size)
{
    uint8_t length = 0;
    while ((length < size) && (at[length] != 0U)) {
        ++length;
    }
    return length;
}

void tumble_dictionary_pack(const tumble_entry_t *entry, const void *variable, uint8_t *bytes, uint8_t *size)
{
    const uint8_t *at = (const uint8_t *)variable;
    if (is_string(entry)) {
        *size = string_length(at, entry->size);
        (void)memcpy(bytes, at, *size);
    } else {
        *size = entry->size;
        tumble_copy_numbers(bytes, at, entry->size, 1);
    }
}

void tumble_dictionary_unpack(const tumble_entry_t *entry, void *variable, const uint8_t *bytes, uint8_t size)
{
    uint8_t *at = (uint8_t *)variable;
    if (is_string(entry)) {
        (void)memset(at, 0, entry->size);
        (void)memcpy(at, bytes, size);
    } else {
        tumble_copy_numbers(at, bytes, size, 1);
    }
}

/* A hook can make a string shorter, never a value longer. */
static tumble_abort_t read_by_hook(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry, uint8_t *bytes,
                                   uint8_t *size)
{
    const tumble_object_owner_t owner = owner_of(dictionary, entry);
    tumble_abort_t refusal = TUMBLE_ABORT_NO_DATA;
    if ((owner.hooks != NULL) && (owner.hooks->read != NULL)) {
        refusal = owner.hooks->read(owner.context, entry, bytes, size);
    }
    if ((*size > entry->size) || !is_string(entry)) {
        *size = entry->size;
    }
    return refusal;
}

tumble_abort_t tumble_dictionary_read(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry,
                                      uint8_t *bytes, uint8_t *size)
{
    const uint8_t *variable = variable_of(dictionary, entry);
    *size = entry->size;
    if ((entry->access & TUMBLE_ACCESS_READ) == 0U) {
        return TUMBLE_ABORT_WRITE_ONLY;
    }
    if (entry->home == TUMBLE_HOME_IMMEDIATE) {
        tumble_put_u64(bytes, entry->offset);
        return TUMBLE_ABORT_NONE;
    }
    if (entry->home == TUMBLE_HOME_CONSTANT) {
        variable = (const uint8_t *)table_of(dictionary, entry)->constants + entry->offset;
    }
    if (variable == NULL) {
        return read_by_hook(dictionary, entry, bytes, size);
    }
    tumble_dictionary_pack(entry, variable, bytes, size);
    return TUMBLE_ABORT_NONE;
}

/* A number of any type that can have limits. */
TUMBLE_ONE_COPY static double number_of(const tumble_entry_t *entry, const uint8_t *bytes)
{
    uint32_t bits = 0;
    uint32_t sign = 0;
    double number;
    for (uint32_t i = 0; (i < entry->size) && (i < sizeof bits); i++) { /* wider integers have no limits */
        bits |= (uint32_t)bytes[i] << (8U * i);
        sign = (uint32_t)0x80U << (8U * i);
    }
    switch (entry->type) {
    case TUMBLE_TYPE_REAL32:
        number = (double)tumble_get_f32(bytes);
        break;
    case TUMBLE_TYPE_REAL64:
        number = tumble_get_f64(bytes);
        break;
    case TUMBLE_TYPE_INTEGER8:
    case TUMBLE_TYPE_INTEGER16:
    case TUMBLE_TYPE_INTEGER32: /* two's complement */
        number = (double)(bits ^ sign) - (double)sign;
        break;
    default:
        number = (double)bits;
        break;
    }
    return number;
}

static bool is_real(const tumble_entry_t *entry)
{
    return (entry->type == TUMBLE_TYPE_REAL32) || (entry->type == TUMBLE_TYPE_REAL64);
}

static tumble_abort_t check_value(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry,
                                  const uint8_t *bytes)
{
    if ((entry->type == TUMBLE_TYPE_BOOLEAN) && (bytes[0] > 1U)) {
        return TUMBLE_ABORT_VALUE;
    }
    if ((entry->limit == 0U) && !is_real(entry)) {
        return TUMBLE_ABORT_NONE;
    }
    const double number = number_of(entry, bytes);
    if (!tumble_is_finite(number)) {
        return TUMBLE_ABORT_VALUE;
    }
    if (entry->limit == 0U) {
        return TUMBLE_ABORT_NONE;
    }
    const tumble_limit_t *limit = &table_of(dictionary, entry)->limits[entry->limit - 1U];
    if (tumble_exceeds(number, limit->high)) {
        return TUMBLE_ABORT_TOO_HIGH;
    }
    return tumble_exceeds(limit->low, number) ? TUMBLE_ABORT_TOO_LOW : TUMBLE_ABORT_NONE;
}

tumble_abort_t tumble_dictionary_accepts(const tumble_entry_t *entry, uint32_t size)
{
    if ((entry->access & TUMBLE_ACCESS_WRITE) == 0U) {
        return TUMBLE_ABORT_READ_ONLY;
    }
    if (size > entry->size) {
        return TUMBLE_ABORT_TOO_LONG;
    }
    return ((size < entry->size) && !is_string(entry)) ? TUMBLE_ABORT_TOO_SHORT : TUMBLE_ABORT_NONE;
}

/* Ask the entry's owner. Without a hook a variable may be written, a computed value may not. */
static tumble_abort_t write_by_hook(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry,
                                    const uint8_t *bytes, uint8_t size)
{
    const tumble_object_owner_t owner = owner_of(dictionary, entry);
    if ((owner.hooks != NULL) && (owner.hooks->write != NULL)) {
        return owner.hooks->write(owner.context, entry, bytes, size);
    }
    const bool computed = (entry->home == TUMBLE_HOME_COMPUTED) || (entry->home == TUMBLE_HOME_COMMUNICATION);
    return computed ? TUMBLE_ABORT_ACCESS : TUMBLE_ABORT_NONE;
}

tumble_abort_t tumble_dictionary_write(const tumble_dictionary_t *dictionary, const tumble_entry_t *entry,
                                       const uint8_t *bytes, uint8_t size)
{
    tumble_abort_t refusal = tumble_dictionary_accepts(entry, size);
    if (refusal == TUMBLE_ABORT_NONE) {
        refusal = check_value(dictionary, entry, bytes);
    }
    if ((refusal == TUMBLE_ABORT_NONE) && (entry->home != TUMBLE_HOME_IMMEDIATE)) {
        refusal = write_by_hook(dictionary, entry, bytes, size);
    }
    uint8_t *variable = (refusal == TUMBLE_ABORT_NONE) ? variable_of(dictionary, entry) : NULL;
    if (variable != NULL) {
        tumble_dictionary_unpack(entry, variable, bytes, size);
    }
    return refusal;
}

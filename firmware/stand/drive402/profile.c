#include "stand/drive402/internal.h"

#include "core/arith.h"

#include <stddef.h>
#include <string.h>

/* Objects of the bus that are written here. */
#define CONSUMER_HEARTBEAT 0x1016U
#define RECEIVE_COMMUNICATION 0x1400U
#define TRANSMIT_COMMUNICATION 0x1800U

/* Identifiers. */
#define FIRST_ID 0x181U
#define LAST_ID 0x57FU
#define OWN_PDO_ID 0x180U /* and the node: where the navigation computer shows its state */

/* What is written: further objects, these, then the PDOs. */

/* object_row_t.kind */
enum {
    VALUE_CONSTANT = 0, /* the row's number itself; otherwise where the value stands in the profile */
    VALUE_BYTE,
    VALUE_WORD,
    VALUE_LIMIT,    /* of the position; both 0: not written */
    VALUE_CONSUMER, /* the milliseconds of our heartbeat, with our node's number above them; from here on 0 is not
                         * written */
    VALUE_VELOCITY, /* quantities */
    VALUE_ACCELERATION
};

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t size;
    uint8_t kind;
    uint8_t number;
} object_row_t;

#define AT(member) (uint8_t)offsetof(tumble_drive_profile_t, member)

/* clang-format off */
static const object_row_t object_rows[] = {
    {CONSUMER_HEARTBEAT,                 1, 4, VALUE_CONSUMER,     AT(heartbeat_timeout_ms)},
    {TUMBLE_DRIVE_HEARTBEAT,             0, 2, VALUE_WORD,         AT(heartbeat_ms)},
    {TUMBLE_402_MODE,                    0, 1, VALUE_CONSTANT,     TUMBLE_402_MODE_PROFILE_POSITION},
    {TUMBLE_402_HOMING_METHOD,           0, 1, VALUE_BYTE,         AT(homing_method)},
    {TUMBLE_402_PROFILE_VELOCITY,        0, 4, VALUE_VELOCITY,     AT(velocity_deg_s)},
    {TUMBLE_402_PROFILE_ACCELERATION,    0, 4, VALUE_ACCELERATION, AT(acceleration_deg_s2)},
    {TUMBLE_402_PROFILE_DECELERATION,    0, 4, VALUE_ACCELERATION, AT(deceleration_deg_s2)},
    {TUMBLE_402_QUICK_STOP_DECELERATION, 0, 4, VALUE_ACCELERATION, AT(quick_stop_deg_s2)},
    {TUMBLE_402_HOMING_SPEED,            1, 4, VALUE_VELOCITY,     AT(homing_fast_deg_s)},
    {TUMBLE_402_HOMING_SPEED,            2, 4, VALUE_VELOCITY,     AT(homing_slow_deg_s)},
    {TUMBLE_402_HOMING_ACCELERATION,     0, 4, VALUE_ACCELERATION, AT(homing_acceleration_deg_s2)},
    {TUMBLE_402_SOFTWARE_LIMIT,          1, 4, VALUE_LIMIT,        0},
    {TUMBLE_402_SOFTWARE_LIMIT,          2, 4, VALUE_LIMIT,        0},
};
/* clang-format on */

#define OBJECT_COUNT (sizeof object_rows / sizeof object_rows[0])

static bool is_quantity(const object_row_t *row)
{
    return row->kind >= (uint8_t)VALUE_VELOCITY;
}

/* A quantity in drive units. */
static double units_of(const tumble_drive_profile_t *profile, const object_row_t *row)
{
    double quantity;
    (void)memcpy(&quantity, (const unsigned char *)profile + row->number, sizeof quantity);
    const bool is_velocity = (row->kind == (uint8_t)VALUE_VELOCITY);
    return quantity * (is_velocity ? profile->velocity_units_per_deg_s : profile->acceleration_units_per_deg_s2);
}

#define FIRST_OF_MOTION 4U /* among the rows above */

uint8_t tumble_drive_first_of_motion(const tumble_drive402_t *drive)
{
    return (uint8_t)(drive->profile->write_count + FIRST_OF_MOTION);
}

uint32_t tumble_drive_limit(const tumble_drive402_t *drive, uint8_t subindex)
{
    return (uint32_t)((subindex == 1U) ? drive->low_counts : drive->high_counts);
}

static uint32_t value_of(const tumble_drive402_t *drive, const object_row_t *row)
{
    const unsigned char *at = (const unsigned char *)drive->profile + row->number;
    uint16_t word;
    (void)memcpy(&word, at, sizeof word);
    switch (row->kind) {
    case VALUE_CONSTANT:
        return row->number;
    case VALUE_BYTE:
        return *at;
    case VALUE_WORD:
        return word;
    case VALUE_LIMIT:
        return tumble_drive_limit(drive, row->subindex);
    case VALUE_CONSUMER:
        return (word != 0U) ? (((uint32_t)drive->node->config->node << 16) | word) : 0U;
    default:
        return (uint32_t)tumble_whole(units_of(drive->profile, row) + 0.5);
    }
}

static void write_object(const tumble_drive402_t *drive, const object_row_t *row, tumble_object_write_t *write)
{
    const bool optional = (row->kind >= (uint8_t)VALUE_CONSUMER);
    const bool unlimited = (row->kind == (uint8_t)VALUE_LIMIT) && !drive->report.limited;
    write->index = row->index;
    write->subindex = row->subindex;
    write->value = value_of(drive, row);
    write->size = (unlimited || (optional && (write->value == 0U))) ? 0U : row->size;
}

/* The drive's receive PDOs, then its transmit PDOs. */
static const tumble_drive_pdo_t *pdo_at(const tumble_drive_profile_t *profile, unsigned at)
{
    return (at < profile->receive_count) ? &profile->receive[at] : &profile->transmit[at - profile->receive_count];
}

static unsigned pdo_count_of(const tumble_drive_profile_t *profile)
{
    return (unsigned)profile->receive_count + profile->transmit_count;
}

bool tumble_drive_configuration(const tumble_drive402_t *drive, uint8_t step, tumble_object_write_t *write)
{
    const tumble_drive_profile_t *profile = drive->profile;
    unsigned at = step;
    if (at < profile->write_count) {
        *write = profile->writes[at];
        return true;
    }
    at -= profile->write_count;
    if (at < OBJECT_COUNT) {
        write_object(drive, &object_rows[at], write);
        return true;
    }
    at -= (unsigned)OBJECT_COUNT;
    const unsigned number = at / TUMBLE_PDO_SETUP_STEPS;
    if (number >= pdo_count_of(profile)) {
        return false;
    }
    const tumble_drive_pdo_t *pdo = pdo_at(profile, number);
    const uint16_t base = (number < profile->receive_count) ? RECEIVE_COMMUNICATION : TRANSMIT_COMMUNICATION;
    tumble_pdo_setup_write(&pdo->setup, (uint16_t)(base + pdo->number), (uint8_t)(at % TUMBLE_PDO_SETUP_STEPS), write);
    return true;
}

/* Our own PDOs. */

static_assert((TUMBLE_DRIVE402_PDOS <= TUMBLE_MAX_TRANSMIT_PDOS) && (TUMBLE_DRIVE402_PDOS <= TUMBLE_MAX_RECEIVE_PDOS),
              "the node must have the PDOs that the drive may need");

/* The object of ours that stands for one of the drive's; what we have no use for goes into CiA 301's dummies. */
static uint32_t own_object(uint32_t object)
{
    static const uint16_t mirrored[] = {
        /* in the order of the mirror's subindices, from 1 */
        TUMBLE_402_CONTROLWORD,     TUMBLE_402_TARGET_POSITION, TUMBLE_402_MODE,
        TUMBLE_402_STATUSWORD,      TUMBLE_402_POSITION_ACTUAL, TUMBLE_402_MODE_DISPLAY,
        TUMBLE_402_VELOCITY_ACTUAL, TUMBLE_402_ERROR_CODE,
    };
    const uint32_t bits = object & 0xFFU;
    for (unsigned i = 0; i < (sizeof mirrored / sizeof mirrored[0]); i++) {
        if (object == TUMBLE_MAP(mirrored[i], 0, bits)) {
            return TUMBLE_MAP(TUMBLE_DRIVE402_MIRROR, i + 1U, bits);
        }
    }
    const uint32_t longer = (bits == 16U) ? TUMBLE_TYPE_UNSIGNED16 : TUMBLE_TYPE_UNSIGNED32;
    return TUMBLE_MAP((bits == 8U) ? TUMBLE_TYPE_UNSIGNED8 : longer, 0, bits);
}

static void own_setup(const tumble_pdo_setup_t *theirs, tumble_pdo_setup_t *own)
{
    *own = (tumble_pdo_setup_t){
        .cob_id = theirs->cob_id & TUMBLE_CAN_MAX_ID, .type = TUMBLE_PDO_EVENT_PROFILE, .count = theirs->count};
    for (uint8_t i = 0; i < own->count; i++) {
        own->map[i] = own_object(theirs->map[i]);
    }
}

/* Those that are told to go keep that. */
static bool map_own(const tumble_drive402_t *drive, tumble_pdo_direction_t direction, uint8_t number,
                    const tumble_drive_pdo_t *pdo)
{
    tumble_pdos_t *pdos = &drive->node->pdos;
    tumble_pdo_setup_t setup;
    own_setup(&pdo->setup, &setup);
    const bool due = (direction == TUMBLE_PDO_TRANSMIT) && pdos->transmit[number].pdo.due;
    const tumble_abort_t refusal = tumble_pdo_configure(pdos, &drive->node->dictionary, direction, number, &setup);
    if (direction == TUMBLE_PDO_TRANSMIT) {
        pdos->transmit[number].pdo.due = due;
    }
    return refusal == TUMBLE_ABORT_NONE;
}

bool tumble_drive_map_own(const tumble_drive402_t *drive)
{
    const tumble_drive_profile_t *profile = drive->profile;
    bool mapped = true;
    for (uint8_t i = 0; i < profile->receive_count; i++) {
        mapped = mapped && map_own(drive, TUMBLE_PDO_TRANSMIT, i, &profile->receive[i]);
    }
    for (uint8_t i = 0; i < profile->transmit_count; i++) {
        mapped = mapped && map_own(drive, TUMBLE_PDO_RECEIVE, i, &profile->transmit[i]);
    }
    return mapped;
}

/* Is a profile usable? */

static bool numbers_are_valid(const tumble_drive_profile_t *profile)
{
    static const uint8_t positive_numbers[] = {AT(counts_per_revolution), AT(velocity_units_per_deg_s),
                                               AT(acceleration_units_per_deg_s2)};
    static const uint8_t times[] = {AT(start_timeout_ms), AT(power_timeout_ms), AT(handshake_timeout_ms),
                                    AT(home_timeout_ms),  AT(move_timeout_ms),  AT(stop_timeout_ms)};
    bool valid = true;
    for (unsigned i = 0; i < sizeof positive_numbers; i++) {
        double x;
        (void)memcpy(&x, (const unsigned char *)profile + positive_numbers[i], sizeof x);
        valid = valid && tumble_is_positive(x);
    }
    for (unsigned i = 0; i < sizeof times; i++) {
        uint32_t ms;
        (void)memcpy(&ms, (const unsigned char *)profile + times[i], sizeof ms);
        valid = valid && (ms > 0U);
    }
    return valid && tumble_is_finite(profile->homing_travel_deg) && !tumble_is_positive(-profile->homing_travel_deg) &&
           (profile->heartbeat_ms > 0U) && ((profile->sign == 1) || (profile->sign == -1)) &&
           (profile->wrap_counts <= (uint32_t)INT32_MAX) && (profile->stop <= (uint8_t)TUMBLE_STOP_BY_HALT);
}

static bool quantities_are_valid(const tumble_drive_profile_t *profile)
{
    bool valid = true;
    for (unsigned i = 0; i < OBJECT_COUNT; i++) {
        const double units = is_quantity(&object_rows[i]) ? units_of(profile, &object_rows[i]) : 0.0;
        valid = valid && (tumble_within(units, 0.0) ||
                          (!tumble_exceeds(0.5, units) && tumble_within(units, (double)UINT32_MAX)));
    }
    return valid;
}

bool tumble_drive_carries(const tumble_drive_pdo_t *pdo, uint32_t object)
{
    bool carried = false;
    for (uint8_t i = 0; (i < pdo->setup.count) && (i < TUMBLE_MAX_MAPPED); i++) {
        carried = carried || (pdo->setup.map[i] == object);
    }
    return carried;
}

static bool carry(const tumble_drive_pdo_t *pdos, uint8_t pdo_count, uint32_t object)
{
    bool carried = false;
    for (uint8_t p = 0; p < pdo_count; p++) {
        carried = carried || tumble_drive_carries(&pdos[p], object);
    }
    return carried;
}

static bool counts_are_valid(const tumble_drive_pdo_t *pdos, uint8_t pdo_count)
{
    bool valid = (pdos != NULL) && (pdo_count <= TUMBLE_DRIVE402_PDOS);
    for (uint8_t p = 0; valid && (p < pdo_count); p++) {
        valid = (pdos[p].setup.count <= TUMBLE_MAX_MAPPED);
    }
    return valid;
}

/* None is wanted twice, nor our own, nor that of another service: from FIRST_ID to LAST_ID there are PDOs, and what our
 * second SDO server hears and says. */
static bool identifiers_are_valid(const tumble_drive_profile_t *profile, uint8_t node)
{
    bool valid = true;
    for (unsigned i = 0; i < pdo_count_of(profile); i++) {
        const uint32_t id = pdo_at(profile, i)->setup.cob_id & ~TUMBLE_PDO_NO_RTR;
        valid = valid && (id >= FIRST_ID) && (id <= LAST_ID) && (id != (OWN_PDO_ID + node)) &&
                (id != (TUMBLE_SDO_SECOND_REQUEST_ID + node)) && (id != (TUMBLE_SDO_SECOND_RESPONSE_ID + node));
        for (unsigned before = 0; before < i; before++) {
            valid = valid && (id != (pdo_at(profile, before)->setup.cob_id & ~TUMBLE_PDO_NO_RTR));
        }
    }
    return valid;
}

static bool pdos_are_valid(const tumble_drive_profile_t *profile)
{
    return counts_are_valid(profile->receive, profile->receive_count) &&
           counts_are_valid(profile->transmit, profile->transmit_count) &&
           carry(profile->receive, profile->receive_count, TUMBLE_MAP(TUMBLE_402_CONTROLWORD, 0, 16)) &&
           carry(profile->receive, profile->receive_count, TUMBLE_MAP(TUMBLE_402_TARGET_POSITION, 0, 32)) &&
           carry(profile->transmit, profile->transmit_count, TUMBLE_DRIVE_STATUS) &&
           carry(profile->transmit, profile->transmit_count, TUMBLE_DRIVE_POSITION);
}

static bool writes_are_valid(const tumble_drive_profile_t *profile)
{
    const unsigned steps =
        (unsigned)profile->write_count + (unsigned)OBJECT_COUNT + (pdo_count_of(profile) * TUMBLE_PDO_SETUP_STEPS);
    bool valid = ((profile->write_count == 0U) || (profile->writes != NULL)) && (steps < UINT8_MAX);
    for (uint8_t i = 0; valid && (i < profile->write_count); i++) {
        const uint8_t size = profile->writes[i].size;
        valid = (size == 1U) || (size == 2U) || (size == 4U);
    }
    return valid;
}

tumble_status_t tumble_drive402_validate(const tumble_drive_profile_t *profile, uint8_t node)
{
    const bool valid = (profile != NULL) && numbers_are_valid(profile) && quantities_are_valid(profile) &&
                       pdos_are_valid(profile) && identifiers_are_valid(profile, node) && writes_are_valid(profile);
    return valid ? TUMBLE_OK : TUMBLE_E_ARGUMENT;
}

/* tumble/sets.h - coefficient sets in non-volatile memory, and their life: judged, committed or held, due again,
 * resumed.
 *
 * A set is K and U0 of one calibration with all that is known of it. What is here, from the memory upwards:
 *
 *     regions        where in the memory what is kept
 *     set            a set, and its bytes
 *     store          the active set, the factory set, a proposal, the set before: two slots, and what goes into them
 *     over temperature    sets with slopes, for a board that asks for them
 *     history        the last sets that became active, in short, and their trend
 *     trend          what the history says of each coefficient's drift
 *     checkpoint     the finished positions of the run under way
 *     rules          may a new set replace the active one by itself?
 *     life           settings and state of all of it together: from a finished run to a verdict and the next run
 *
 * The shortest program, for a board that reads the active set from its memory:
 *
 *     static tumble_store_t store;
 *     const tumble_nv_t memory = {0};                   // the board's, with its three functions (tumble/port.h)
 *     tumble_set_t set;
 *     double k_xx_v_per_g = 1.0;
 *     if (tumble_store_init(&store, &memory) == TUMBLE_OK) {
 *         tumble_status_t outcome;
 *         do {
 *             outcome = tumble_store_step(&store);      // in a control loop: one step in each of its cycles
 *         } while (outcome == TUMBLE_E_PORT_BUSY);
 *         if ((outcome == TUMBLE_OK) && (tumble_store_read(&store, TUMBLE_SET_ACTIVE, &set) == TUMBLE_OK)) {
 *             k_xx_v_per_g = set.coefficients.k_v_per_g[0][0];
 *         }
 *     }
 *     (void)k_xx_v_per_g;
 *
 * Nothing waits: a call begins a job, and each step makes at most one call of the memory. Only one job at a time may
 * run on one memory. Where store, history and checkpoint lie in the same memory, step one of them until it is not busy,
 * then the next; the keeper of a navigation computer does so by itself. The caller owns every object; its members are private unless said
 * otherwise. Not re-entrant on one object. No pointer may be null unless said otherwise. docs/embedding.md defines
 * every byte, and says what a loss of power does.
 */
#ifndef TUMBLE_SETS_H
#define TUMBLE_SETS_H

#include "tumble/core.h"
#include "tumble/port.h"
#include "tumble/status.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Regions: where in the memory what is kept. Region n begins at n sectors.
 *
 * Only the first TUMBLE_STORE_MIN_SECTOR bytes of a sector are used, so the layout is the same for every larger sector
 * and for every granule.
 */
enum {
    TUMBLE_REGION_FACTORY = 0, /* the factory set: written once, never erased by the firmware */
    TUMBLE_REGION_SLOT_A = 1,  /* the active set is in one of the two slots, or it is the factory set */
    TUMBLE_REGION_SLOT_B = 2,
    TUMBLE_REGION_PROPOSAL = 3,   /* the held set */
    TUMBLE_REGION_HISTORY = 4,    /* two sectors in turns */
    TUMBLE_REGION_CHECKPOINT = 6, /* finished positions of a run: one log through two sectors */
    TUMBLE_REGION_COUNT = 8
};

#define TUMBLE_STORE_MIN_SECTOR 4096U

/* Has this memory room for all regions? A board whose memory has smaller sectors joins several to one.
 * Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (null); TUMBLE_E_NV (fewer than TUMBLE_REGION_COUNT sectors, one smaller than
 * TUMBLE_STORE_MIN_SECTOR, or a granule that is no power of two up to TUMBLE_NV_MAX_GRANULE). */
tumble_status_t tumble_regions_check(const tumble_nv_t *nv);

/* Cells of one size, and what is under way: a scan of all, or a job that writes some. Private, as are all members of the
 * objects here. Cell n lies in sector n / per_sector, counted from the first region on. */
#define TUMBLE_NV_CHUNK 64U

typedef struct {
    uint8_t region;        /* of the first sector */
    uint8_t per_sector;    /* cells in a sector */
    uint8_t count;         /* of all cells */
    uint8_t attempts;      /* to read one, before it counts as lost */
    uint16_t pitch;        /* from one to the next in its sector */
    uint16_t bytes;        /* of a cell: its record, and the mark behind it if there is one */
    uint16_t record_bytes; /* without the mark */
    uint16_t erased_bytes; /* of a sector: to be blank after an erase */
} tumble_cells_kind_t;

typedef struct {
    uint32_t verify;      /* read back wrong, since init, as all counters here; they stop at UINT32_MAX */
    uint32_t nv_errors;   /* a call of the memory failed */
    uint32_t torn;        /* cells that the first scan found neither blank nor valid */
    uint8_t at;           /* the cell that is looked at */
    uint8_t failed_reads; /* in a row, of the cell that is read */
    uint8_t where[5];     /* the cells of the job's places */
    bool scans;
    bool booted;             /* the first scan is over */
    bool was_read;           /* the cell that is looked at */
    bool unread;             /* the last scan could not read a cell: what is there must not be overwritten */
    bool changes;            /* the present action's erase or program is still to be made */
    bool failed_to_hold;     /* the memory said that it was done, and it was not */
    tumble_status_t outcome; /* of the last job */
    uint16_t checked;        /* bytes of the action read back so far */
    const tumble_cells_kind_t *kind;
    const tumble_nv_t *nv; /* null: init has refused */
    const uint8_t *plan;   /* the actions that are left of the job; null: no job */
    uint8_t chunk[TUMBLE_NV_CHUNK];
} tumble_cells_t;

/* ---- A set: coefficients with all that is known of them, and their bytes.
 *
 * 320 bytes, little endian, a CRC-32 at the end. Encoding and decoding are pure functions, byte by byte, the same on
 * every machine. What is unknown has its flag cleared and is 0, never NaN.
 */
#define TUMBLE_SET_SCHEMA 1U
#define TUMBLE_SET_BYTES 320U
#define TUMBLE_SET_SERIAL_BYTES 24U

/* How a set came to be where it is (`origin`). The store writes it. */
enum {
    TUMBLE_ORIGIN_FACTORY = 1,     /* written once, with the block */
    TUMBLE_ORIGIN_COMMITTED = 2,   /* by the rules, without an operator */
    TUMBLE_ORIGIN_ACCEPTED = 3,    /* a proposal that an operator accepted */
    TUMBLE_ORIGIN_ROLLED_BACK = 4, /* an earlier set that an operator brought back */
    TUMBLE_ORIGIN_HELD = 5,        /* a proposal */
    TUMBLE_ORIGIN_DECAYED = 6      /* in the history alone, no set has it: the active set was found to have decayed */
};

/* What is known of a set (bits of `flags`). */
#define TUMBLE_SET_HAS_TEMPERATURE 0x0001U
#define TUMBLE_SET_HAS_GRAVITY 0x0002U
#define TUMBLE_SET_HAS_UNCERTAINTY 0x0004U
#define TUMBLE_SET_HAS_CHECK 0x0008U /* the gravity check: maxima, limit, positions */
#define TUMBLE_SET_HAS_CLOSURE 0x0010U
#define TUMBLE_SET_RESUMED 0x0020U /* the run was interrupted by a loss of power, and went on after it */
#define TUMBLE_SET_OTHER_RULES                                                                                         \
    0x0040U /* judged, committed or accepted under other rules than the board's, or with the
                                        * service level open, when they could be changed */
#define TUMBLE_SET_HAS_TEMPERATURE_RANGE 0x0080U /* of all samples averaged, also for means given up */
#define TUMBLE_SET_FLAGS 0x00FFU
#define TUMBLE_SET_HAS_SLOPES 0x0100U /* of version 2 alone: see "Sets over temperature" */

typedef struct {
    /* Written by the store's jobs, which do not read what a caller puts here. For tumble_set_encode the caller fills them. */
    uint32_t sequence; /* one more with each commit; of a proposal, that which it would have had; 0: factory */
    uint32_t restores; /* origin rolled back: the sequence of the set that was brought back; else 0 */
    uint32_t from_crc; /* origin accepted or rolled back: CRC-32 at the end of the proposal's record; else 0 */
    uint8_t origin;    /* TUMBLE_ORIGIN_... */

    uint8_t estimator; /* its number in the procedure's configuration */
    uint16_t flags;
    uint8_t block_serial[TUMBLE_SET_SERIAL_BYTES]; /* UTF-8, padded with zeros; all zero: unknown */
    uint64_t date_utc_s;                           /* since 1970; 0: unknown */
    double temperature_c;
    double gravity_m_s2; /* local gravity: the size of the unit g of K; above 0 where known */
    tumble_coefficients_t coefficients;
    tumble_uncertainty_t uncertainty; /* each 0 or above */
    double max_abs_fit_g;             /* the gravity check on fit and on check positions, and its limit; 0 or above */
    double max_abs_check_g;
    double limit_g;
    double closure_v; /* the largest difference in magnitude; 0 or above */
    uint32_t samples; /* of the whole run; 0: unknown */
    uint8_t fit_positions;
    uint8_t check_positions;
    int8_t temperature_min_half_c; /* in half degrees Celsius, as samples tell it; not above ... */
    int8_t temperature_max_half_c; /* ... this one */
    uint32_t schedule_crc;         /* fingerprint, tumble_gain_record_schedule_crc; 0: unknown */
    uint32_t stand_crc;            /* fingerprint of the stand as the application makes it; 0: unknown */
    uint32_t reasons;              /* why it was held, bits of the application; 0: it was not */
    uint32_t record_crc;           /* read: CRC-32 at the end of the record; ignored on writing */
} tumble_set_t;

/* Write the record of `set`. Fields whose flag is cleared are unknown and written as 0. After a refusal the content of
 * `bytes` is undefined.
 * Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (null, a flag or origin that does not exist, a serial with a byte behind its
 * first zero, or a number out of its range above); TUMBLE_E_NOT_FINITE (K, U0 or a number that is said to be known). */
tumble_status_t tumble_set_encode(const tumble_set_t *set, uint8_t bytes[TUMBLE_SET_BYTES]);

/* Read a record. `*set` is written on TUMBLE_OK alone. Costs one bitwise CRC over 320 bytes.
 * Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (null); TUMBLE_E_FRAME (not the magic, schema and size of a set); TUMBLE_E_CRC;
 * and with a right CRC, when its writer was wrong, TUMBLE_E_ARGUMENT or TUMBLE_E_NOT_FINITE as tumble_set_encode, and
 * TUMBLE_E_FRAME (bytes that must be 0). */
tumble_status_t tumble_set_decode(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set);

/* Private: what the store writes of a set itself. */
typedef struct {
    uint32_t sequence;
    uint32_t restores;
    uint32_t from_crc;
    uint8_t origin;
} tumble_set_stamp_t;

/* ---- The store: two slots, a factory set, and a proposal.
 *
 * The active set is the one with the highest sequence in the two slots; where neither holds one, it is the factory set.
 * A new set goes to the other slot: erase, check that it is blank, program the record, read it back, and only then
 * program the mark that makes it valid, in a granule of its own. So at every instant either the old set is active or
 * the new one, whatever bytes a loss of power leaves in the place that was being written (docs/embedding.md).
 */
#define TUMBLE_SET_MARK_BYTES 32U /* a cell for the mark behind the record */
#define TUMBLE_SET_PLACE_BYTES (TUMBLE_SET_BYTES + TUMBLE_SET_MARK_BYTES)
#define TUMBLE_FACTORY_PLACES 4U /* attempts to write the factory set; the first valid one counts */
#define TUMBLE_FACTORY_PITCH 512U
#define TUMBLE_MAX_SEQUENCE (UINT32_MAX - 1U) /* then commits are refused: a sequence never wraps */

typedef enum {
    TUMBLE_SET_ACTIVE = 0,
    TUMBLE_SET_FACTORY = 1,
    TUMBLE_SET_PROPOSAL = 2,
    TUMBLE_SET_PREVIOUS = 3 /* what a rollback would bring back: the other slot's set, or else the factory set */
} tumble_which_set_t;

/* What the last scan found in a region. Private to the store, as all that follows. */
typedef struct {
    tumble_set_stamp_t stamp; /* origin 0: there is no set */
    uint32_t crc;
} tumble_store_place_t;

typedef struct {
    tumble_status_t (*read_set)(const uint8_t bytes[TUMBLE_SET_BYTES],
                                tumble_set_t *set); /* of the versions it knows */
    uint8_t factory; /* the cell where the factory set is, or else where it would go; TUMBLE_FACTORY_PLACES: nowhere */
    bool lent;       /* `bytes` are: nothing else may be put there */
    uint16_t flags;  /* further ones for the record that is loaded */
    uint32_t sequence;                     /* of the active set */
    uint32_t highest;                      /* known so far: of the active set, or given */
    tumble_set_stamp_t stamp;              /* of the record in `bytes` */
    tumble_store_place_t places[4];        /* by region */
    uint32_t commits;                      /* sets that became active since init: committed, accepted, rolled back */
    tumble_cells_t cells;                  /* four of TUMBLE_FACTORY_PITCH in a sector */
    uint8_t bytes[TUMBLE_SET_PLACE_BYTES]; /* record and mark; lent to the owner for a record of its own, which no job
                                            * of the store can meet: there is one job at a time on one memory */
    bool newer;                            /* in one of the places something is whole, but of a newer version */
} tumble_store_t;

static_assert(sizeof(tumble_store_t) <= 768U, "the store must stay small");

/* Start the boot scan: find what the memory holds, and clear what a job left behind that lost power. Step until it is
 * done: eight calls of the memory, some more where there is something to clear. `*nv` must stay valid as long as the
 * object is used.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT, TUMBLE_E_NV (tumble_regions_check); after a refusal the object answers every
 * call with TUMBLE_E_STATE and holds nothing. */
tumble_status_t tumble_store_init(tumble_store_t *store, const tumble_nv_t *nv);

/* Go on with the job under way: at most one call of the memory.
 * Returns TUMBLE_E_PORT_BUSY while it goes on: call again. When nothing is under way, it returns the outcome of the
 * last job: TUMBLE_OK; TUMBLE_E_NV (the memory failed, or did not hold what it had confirmed; the old set is still
 * active or, in rare cases, the new one: begin the job again); TUMBLE_E_CRC (the set that was to be copied is no longer
 * valid). */
tumble_status_t tumble_store_step(tumble_store_t *store);

bool tumble_store_busy(const tumble_store_t *store);
tumble_status_t tumble_store_outcome(const tumble_store_t *store); /* as tumble_store_step, without a step */

/* Is there such a set? By the last scan; false while busy. */
bool tumble_store_has(const tumble_store_t *store, tumble_which_set_t which);

/* The name of the proposal: the CRC-32 at the end of its record. 0: there is no proposal, or the store is busy. By the
 * last scan. */
uint32_t tumble_store_proposal(const tumble_store_t *store);

/* The sequence of the active set: the calibration counter, which grows with every set that becomes active by a job. 0:
 * the factory set, or none. If the active set decays, the counter goes back to the set before; the next set that
 * becomes active gets a sequence that no set had. While busy the counter keeps its last value. */
uint32_t tumble_store_sequence(const tumble_store_t *store);

/* Tell the store of a sequence that a set once had, for instance by the history: the next set that becomes active gets
 * a higher one, even if that set has decayed since. A sequence of TUMBLE_MAX_SEQUENCE or more is ignored. */
void tumble_store_number_above(tumble_store_t *store, uint32_t sequence);

/* Read a set: one read of the memory and one check of its CRC. `*set` is written on TUMBLE_OK only.
 * Returns TUMBLE_OK; TUMBLE_E_PORT_BUSY (a job is under way, the memory is busy or written by the owner of the store,
 * or it failed for the first or second time in a row: step, and ask again); TUMBLE_E_STATE (there is no such set);
 * TUMBLE_E_ARGUMENT (null, or no such kind); and if the memory cannot be read or has decayed since the last scan,
 * TUMBLE_E_NV, TUMBLE_E_FRAME or TUMBLE_E_CRC: a scan begins then, after which the next valid set is active. */
tumble_status_t tumble_store_read(tumble_store_t *store, tumble_which_set_t which, tumble_set_t *set);

/* The jobs. Each returns TUMBLE_OK (begun: step the store, then look at the outcome: after a job that failed,
 * tumble_store_read gives the old set), or why it has not begun: TUMBLE_E_PORT_BUSY (a job is under way);
 * TUMBLE_E_STATE (see each job); TUMBLE_E_NV (a place could not be read and may hold the active set: the store scans
 * again, then begin again). Jobs that take a set also return TUMBLE_E_ARGUMENT or TUMBLE_E_NOT_FINITE
 * (tumble_set_encode); they copy the set at once. */

/* Make a set active. TUMBLE_E_STATE: the sequence has reached TUMBLE_MAX_SEQUENCE. */
tumble_status_t tumble_store_commit(tumble_store_t *store, const tumble_set_t *set);

/* Is there a set that a newer version of the firmware wrote: whole by its checksum and its mark, but with a schema or with
 * flags that this version does not know? It counts as none, and stays until a job needs its place. */
bool tumble_store_has_newer(const tumble_store_t *store);

/* Keep a set as the proposal, in place of one that is held. Power lost on the way may lose both proposals.
 * TUMBLE_E_STATE: as tumble_store_commit. */
tumble_status_t tumble_store_hold(tumble_store_t *store, const tumble_set_t *set);

/* Make the proposal active, then clear it. The set that becomes active gets these flags (TUMBLE_SET_...) besides those of
 * the proposal. TUMBLE_E_STATE: there is none, or as tumble_store_commit. */
tumble_status_t tumble_store_accept(tumble_store_t *store, uint16_t flags);

/* Clear the proposal. TUMBLE_E_STATE: there is none. */
tumble_status_t tumble_store_discard(tumble_store_t *store);

/* Make the previous set active again, as a copy with a new sequence, and clear the slot of the one that was active.
 * The copy is staged as the proposal, so a proposal must be accepted or discarded before. After a loss of power on the
 * way either the copy is active, or nothing has changed, or the copy is the proposal: then a rollback, or an accept,
 * goes on with it, and a discard gives it up. TUMBLE_E_STATE: nothing to go back to (the factory set, or a copy of it,
 * is active, or there is none), a proposal is held, or as tumble_store_commit. */
tumble_status_t tumble_store_rollback(tumble_store_t *store);

/* Write the factory set. TUMBLE_E_STATE: there is one, or all TUMBLE_FACTORY_PLACES attempts are spent. */
tumble_status_t tumble_store_write_factory(tumble_store_t *store, const tumble_set_t *set);

/* ---- Sets over temperature: polynomials up to the second degree (tumble_thermal_t), in records of version 2.
 *
 * A board that calls tumble_store_init_thermal reads both versions; to any other a set of version 2 is one of a newer
 * version. The record has the size of version 1, so jobs, power cuts and places are the same; all coefficients and
 * uncertainties in it are single precision. Those numbers are the set: what is computed from them is the same everywhere.
 *
 * In the tumble_set_t of a set of version 2, the flag TUMBLE_SET_HAS_SLOPES is set, the coefficients are those at
 * temperature_c, which is T0 and no temperature of a run (TUMBLE_SET_HAS_TEMPERATURE is cleared), and the range of temperatures is that of the polynomials. Its uncertainties are those at the
 * temperature of the last run; of a factory set, the largest over the range. Without its slopes it cannot be written again:
 * tumble_set_encode refuses the flag.
 */
#define TUMBLE_SET_SCHEMA_THERMAL 2U

/* As tumble_set_encode, version 2. The set's coefficients, temperature and range are taken from `thermal`; its range is
 * narrowed to half degrees within -64 and 63.5 degrees C, which a sample can tell.
 * Returns as tumble_set_encode, and TUMBLE_E_ARGUMENT where nothing is left of the range; TUMBLE_E_NOT_FINITE also where a
 * number is too large for single precision. */
tumble_status_t tumble_set_encode_thermal(const tumble_set_t *set, const tumble_thermal_t *thermal,
                                          uint8_t bytes[TUMBLE_SET_BYTES]);

/* As tumble_set_decode, either version. A set of version 1 has no slopes: its coefficients hold at all temperatures that a
 * sample can tell, -64 to 63.5 degrees C. */
tumble_status_t tumble_set_decode_thermal(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set,
                                          tumble_thermal_t *thermal);

/* As tumble_store_init, for a store that reads both versions. */
tumble_status_t tumble_store_init_thermal(tumble_store_t *store, const tumble_nv_t *nv);

/* As tumble_store_read, with the polynomials. */
tumble_status_t tumble_store_read_thermal(tumble_store_t *store, tumble_which_set_t which, tumble_set_t *set,
                                          tumble_thermal_t *thermal);

/* As tumble_store_commit (TUMBLE_SET_ACTIVE), tumble_store_hold (TUMBLE_SET_PROPOSAL) or tumble_store_write_factory
 * (TUMBLE_SET_FACTORY), version 2. Returns as those and as tumble_set_encode_thermal. */
tumble_status_t tumble_store_write_thermal(tumble_store_t *store, tumble_which_set_t which, const tumble_set_t *set,
                                           const tumble_thermal_t *thermal);

/* ---- The history: the last sets that became active, in short.
 *
 * Each sector has room for TUMBLE_HISTORY_CELLS entries. When one is full, the other, which holds the oldest, is erased
 * and takes the next. So the last 32 entries are there at any time, whatever a loss of power does to the one being
 * written; each entry that a loss of power tore takes the place of one. Power may fail between a commit and its entry:
 * at start-up compare the newest entry's sequence with the store's, and append the entry that is missing.
 */
#define TUMBLE_HISTORY_BYTES 128U
#define TUMBLE_HISTORY_CELLS (TUMBLE_STORE_MIN_SECTOR / TUMBLE_HISTORY_BYTES)

/* A flag of an entry that its writer may add: the sets before are of another block. */
#define TUMBLE_HISTORY_OTHER_BLOCK 0x8000U

/* The numbers as single precision: six parts in 10^8, far below what a calibration can resolve. */
typedef struct {
    uint32_t number;     /* of the entry, from 1; written by the log */
    uint32_t sequence;   /* of the set */
    uint64_t date_utc_s; /* 0: unknown */
    float temperature_c;
    uint8_t origin;
    uint8_t estimator;
    uint16_t flags;                   /* TUMBLE_SET_HAS_TEMPERATURE, TUMBLE_SET_HAS_UNCERTAINTY; TUMBLE_HISTORY_... */
    float value[TUMBLE_COEFFICIENTS]; /* K row by row (V/g), then U0 (V) */
    float u[TUMBLE_COEFFICIENTS];     /* standard uncertainties; 0 where not known */
} tumble_history_entry_t;

typedef struct {
    uint8_t sector;    /* 0 or 1: where the newest is */
    uint8_t used[2];   /* cells of each sector up to the last that is not blank; the next entry goes there */
    uint32_t valid[2]; /* one bit a cell */
    uint32_t newest;   /* its number; 0: the log is empty */
    uint32_t sequence; /* of the newest */
    tumble_cells_t cells;
    uint8_t bytes[TUMBLE_HISTORY_BYTES];
} tumble_history_t;

/* What of a set goes into the log. Pure.
 * Returns TUMBLE_OK, TUMBLE_E_ARGUMENT (null), TUMBLE_E_NOT_FINITE (a number too large for single precision). */
tumble_status_t tumble_history_from_set(const tumble_set_t *set, tumble_history_entry_t *entry);

/* Bytes of an entry (docs/embedding.md). `encode`: TUMBLE_E_ARGUMENT (null), TUMBLE_E_NOT_FINITE. `decode`:
 * TUMBLE_E_ARGUMENT, TUMBLE_E_FRAME (blank, or not the magic), TUMBLE_E_CRC, TUMBLE_E_NOT_FINITE. */
tumble_status_t tumble_history_encode(const tumble_history_entry_t *entry, uint8_t bytes[TUMBLE_HISTORY_BYTES]);
tumble_status_t tumble_history_decode(const uint8_t bytes[TUMBLE_HISTORY_BYTES], tumble_history_entry_t *entry);

/* As tumble_store_init (64 calls of the memory), tumble_store_step and tumble_store_busy. */
tumble_status_t tumble_history_init(tumble_history_t *history, const tumble_nv_t *nv);
tumble_status_t tumble_history_step(tumble_history_t *history);
bool tumble_history_busy(const tumble_history_t *history);

/* Begin to append.
 * Returns TUMBLE_OK (begun), TUMBLE_E_PORT_BUSY (a job is under way), TUMBLE_E_STATE (init refused, or the number of
 * entries has reached UINT32_MAX - 1), TUMBLE_E_NV (the last scan could not read a cell; a new scan has begun: step,
 * then try again), TUMBLE_E_ARGUMENT or TUMBLE_E_NOT_FINITE (tumble_history_encode). */
tumble_status_t tumble_history_append(tumble_history_t *history, const tumble_history_entry_t *entry);

/* How many entries there are: after more than 32, 32 to 64. 0 while busy. */
uint8_t tumble_history_count(const tumble_history_t *history);

/* The sequence of the newest entry; 0: none. */
uint32_t tumble_history_sequence(const tumble_history_t *history);

/* One entry, `age` 0 the newest, below tumble_history_count(). One read.
 * Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (ask again), TUMBLE_E_ARGUMENT (null, or no such age), TUMBLE_E_NV,
 * TUMBLE_E_FRAME, TUMBLE_E_CRC. */
tumble_status_t tumble_history_read(tumble_history_t *history, uint8_t age, tumble_history_entry_t *entry);

/* ---- The trend: how a coefficient drifts: a weighted straight line through its values over time. Pure functions.
 *
 * Each value weighs (u of the first / u)^2. Means and sums of products are carried along (West, Comm. ACM 22, 1979,
 * 532), relative to the first date, so nothing cancels. The uncertainty of the drift is that of independent values. An
 * error that all calibrations on one stand share makes no drift; the stated uncertainty is then too large, not too
 * small.
 */
#define TUMBLE_MONTH_S 2629746.0 /* a twelfth of a Gregorian year of 365.2425 days */

/* Begun as all zero. */
typedef struct {
    uint64_t first_utc_s;
    double first_value;
    double unit; /* u of the first value, which weighs 1 */
    double weight;
    double mean[2]; /* of months and values */
    double
        products[3]; /* weighted sums of products of deviations from the means: month month, month value, value value */
    uint32_t count;
} tumble_trend_sums_t;

typedef struct {
    double per_month;   /* unit of the values per TUMBLE_MONTH_S */
    double u_per_month; /* its standard uncertainty, from those of the values */
    double chi_squared; /* of the line; `freedom` where the uncertainties are right and the drift is a line */
    uint32_t freedom;   /* values - 2 */
} tumble_trend_t;

/* Add one value; values may come in any order of time.
 * Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (null, date 0, or u not above 0); TUMBLE_E_NOT_FINITE (the value, or u, no
 * number or beyond 1e100 in magnitude, or u below 1e-100). */
tumble_status_t tumble_trend_add(tumble_trend_sums_t *sums, uint64_t date_utc_s, double value, double u);

/* Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (null); TUMBLE_E_TOO_FEW (fewer than two values, or all of one date);
 * TUMBLE_E_NOT_FINITE (overflow). */
tumble_status_t tumble_trend_fit(const tumble_trend_sums_t *sums, tumble_trend_t *trend);

/* ---- The checkpoint: the finished positions of a run, so that it can go on after a loss of power.
 *
 * The checkpoint is a log: a header with the fingerprint of the run, then one entry for each position. The application
 * makes the fingerprint: a CRC-32 over everything that must not have changed (stand, block, schedule, configuration,
 * and the sequence of the active set, so that the checkpoint of a run that ended in a commit is not resumed). The CRC
 * of every entry covers it too. Jobs work as in the store above: begin, then step; each step makes at most one call of
 * the memory.
 */
#define TUMBLE_CHECKPOINT_BYTES 64U
#define TUMBLE_CHECKPOINT_CELLS ((2U * TUMBLE_STORE_MIN_SECTOR) / TUMBLE_CHECKPOINT_BYTES) /* the first is the header */

/* The range of a run's temperatures, by its margins to the ends of what a sample can tell, in half degrees: none is below
 * -64 degrees C plus `cold`, none above 63.5 degrees C less `warm`. {UINT8_MAX, UINT8_MAX}: there was none yet. With
 * `cold` 0 or 1 or `warm` 0 it touches an end and is not known; entries of earlier versions have {0, 0}. Of two ranges the
 * smaller margins are those of both. */
typedef struct {
    uint8_t cold;
    uint8_t warm;
} tumble_margins_t;

typedef struct {
    uint8_t next;                        /* the cell where the next entry goes */
    bool kept;                           /* a run has been begun */
    tumble_margins_t margins;            /* the owner's, {0, 0} from init on: appended with every entry */
    uint32_t fingerprint;                /* of the run that is kept */
    uint8_t place[TUMBLE_MAX_POSITIONS]; /* the cell of the last valid entry of each position; 0: none */
    tumble_cells_t cells;                /* the first is the header; `torn` of a run that is kept only */
    uint8_t bytes[TUMBLE_CHECKPOINT_BYTES];
} tumble_checkpoint_t;

/* As tumble_store_init, tumble_store_step and tumble_store_busy. */
tumble_status_t tumble_checkpoint_init(tumble_checkpoint_t *checkpoint, const tumble_nv_t *nv);
tumble_status_t tumble_checkpoint_step(tumble_checkpoint_t *checkpoint);
bool tumble_checkpoint_busy(const tumble_checkpoint_t *checkpoint);

/* Forget the run that is kept and begin a new one.
 * Returns TUMBLE_OK (begun), TUMBLE_E_PORT_BUSY, TUMBLE_E_STATE (init refused). */
tumble_status_t tumble_checkpoint_begin(tumble_checkpoint_t *checkpoint, uint32_t fingerprint);

/* Keep one finished position.
 * Returns TUMBLE_OK (begun); TUMBLE_E_PORT_BUSY; TUMBLE_E_STATE (no run has been begun); TUMBLE_E_FULL (no cell is
 * left: TUMBLE_CHECKPOINT_CELLS - 1 entries, torn ones included); TUMBLE_E_ARGUMENT (null, an index not below
 * TUMBLE_MAX_POSITIONS, samples 0 or above TUMBLE_MAX_SAMPLES, a negative scatter); TUMBLE_E_NOT_FINITE (the
 * scatter). */
tumble_status_t tumble_checkpoint_append(tumble_checkpoint_t *checkpoint, uint8_t index,
                                         const tumble_average_t *average);

/* These temperatures are of the run as well: narrow its margins. */
void tumble_checkpoint_narrow(tumble_checkpoint_t *checkpoint, tumble_margins_t seen);

/* The temperatures of a set whose run has these margins, with their flag; nothing where they are not known. */
void tumble_margins_range(const tumble_margins_t *margins, tumble_set_t *set);

/* Forget the run. Returns TUMBLE_OK (begun), TUMBLE_E_PORT_BUSY, TUMBLE_E_STATE (init refused). */
tumble_status_t tumble_checkpoint_clear(tumble_checkpoint_t *checkpoint);

/* Is a run with this fingerprint kept? False while busy. */
bool tumble_checkpoint_matches(const tumble_checkpoint_t *checkpoint, uint32_t fingerprint);

/* Is this position kept? The last entry of a position counts. False while busy, and for an index out of range. */
bool tumble_checkpoint_has(const tumble_checkpoint_t *checkpoint, uint8_t index);

/* One kept position, whose margins narrow those of the checkpoint; one read. The caller has asked
 * tumble_checkpoint_matches before.
 * Returns TUMBLE_OK, TUMBLE_E_PORT_BUSY (ask again), TUMBLE_E_MISSING_POSITION (not kept), TUMBLE_E_ARGUMENT (null),
 * TUMBLE_E_NV, TUMBLE_E_CRC. */
tumble_status_t tumble_checkpoint_read(tumble_checkpoint_t *checkpoint, uint8_t index, tumble_average_t *average);

/* ---- The rules: may a new set of coefficients replace the active one by itself?
 *
 * A pure function: candidate, active set and limits go in, one bit for each objection comes out. Without any bit the
 * set may be committed. With one the set is held as a proposal with these bits, for an operator to accept or discard.
 * Whatever cannot be judged is an objection.
 *
 * Everything is relative to the length of a row of the candidate's K, |K_i| = sqrt(K_ix^2 + K_iy^2 + K_iz^2) in V/g:
 * a scale factor's limit is a ratio, a cross-axis sensitivity's an angle in rad, and a bias's is in g.
 *
 *     uncertainty   u_c / |K_i| <= uncertainty[c]
 *     change        |c - c_active| / |K_i| <= coverage sqrt(u_c^2 + u_c,active^2) / |K_i|
 *                                             + drift_per_month[c] months + drift_per_kelvin[c] kelvin
 *
 * with months the time between the dates of the two sets, at least 1 (and 1 where a date is unknown) and at most
 * TUMBLE_COMMIT_MAX_MONTHS, and kelvin the difference of their temperatures (0 where one is unknown). An unknown
 * uncertainty of the active set counts as 0: it excuses no change.
 *
 * The caller adds TUMBLE_OBJECTION_DOES_NOT_FIT, TUMBLE_OBJECTION_WHOLE_MODEL, TUMBLE_OBJECTION_DISTURBED,
 * TUMBLE_OBJECTION_OTHER_RULES, TUMBLE_OBJECTION_NEWER_SET and TUMBLE_OBJECTION_NOT_SHOWN: a set holds neither means nor
 * covariances, and knows neither its bus nor who set its rules, nor what else is in the memory. TUMBLE_OBJECTION_TEMPERATURE
 * comes of tumble_thermal_sets_t.
 */
/* Drift is allowed for so many months at most, however far apart the dates are. Otherwise a clock that is years ahead
 * would excuse any change; and after so long a time the block should be inspected. */
#define TUMBLE_COMMIT_MAX_MONTHS 24.0

/* Bit numbers travel over CAN and Modbus: new ones go to the end, 32 at most. Those from 16 on have an object of their
 * own (2120h:15). */
#define TUMBLE_OBJECTION_LIST(X)                                                                                       \
    X(TUMBLE_OBJECTION_GRAVITY_CHECK, "the result fails the gravity check")                                            \
    X(TUMBLE_OBJECTION_NOT_FINITE, "a number of the set is infinite or not a number, or a row of K is zero")           \
    X(TUMBLE_OBJECTION_UNCERTAINTY_UNKNOWN, "the uncertainties are not known: the stand is not declared")              \
    X(TUMBLE_OBJECTION_UNCERTAIN, "a coefficient is less certain than its limit asks")                                 \
    X(TUMBLE_OBJECTION_CHANGE, "a coefficient changed by more than drift and uncertainty explain")                     \
    X(TUMBLE_OBJECTION_OTHER_BLOCK, "the active set is of a block with another serial number")                         \
    X(TUMBLE_OBJECTION_FIRST, "there is no active set to compare with")                                                \
    X(TUMBLE_OBJECTION_OLDER, "it is dated before the active set: the clock is wrong or the run is an old one")        \
    X(TUMBLE_OBJECTION_REPLAYED, "the same coefficients, to the last bit, were found before: the run is not new")      \
    X(TUMBLE_OBJECTION_LIMITS, "a limit of these rules is out of its range")                                           \
    X(TUMBLE_OBJECTION_BY_HAND, "every set is to be accepted by an operator")                                          \
    X(TUMBLE_OBJECTION_OTHER_RULES, "the rules were changed from the board's")                                         \
    X(TUMBLE_OBJECTION_DOES_NOT_FIT, "the means scatter by more than the declared stand and noise explain")            \
    X(TUMBLE_OBJECTION_WHOLE_MODEL, "twelve coefficients and the declared stand do not explain the run as a whole")    \
    X(TUMBLE_OBJECTION_DISTURBED, "too many samples or position reports were lost, refused or not believed")           \
    X(TUMBLE_OBJECTION_NEWER_SET, "the memory holds a set of a newer version, which this one would replace")           \
    X(TUMBLE_OBJECTION_NOT_SHOWN, "three u(|a|) exceed the gravity limit at some attitude: it is not shown to be met") \
    X(TUMBLE_OBJECTION_TEMPERATURE, "the temperature is not known, or outside the range of the active set's slopes")

/* The bit numbers. */
typedef enum {
#define TUMBLE_OBJECTION_ENUM(name, sentence) name,
    TUMBLE_OBJECTION_LIST(TUMBLE_OBJECTION_ENUM)
#undef TUMBLE_OBJECTION_ENUM
        TUMBLE_OBJECTION_COUNT
} tumble_objection_t;

#define TUMBLE_OBJECTION_BIT(objection) ((uint32_t)1U << (unsigned)(objection))
#define TUMBLE_OBJECTION_MORE 16U /* the first bit of tumble_sets_state_t.more_objections */

/* So many u(|a|) must be within the limit of the gravity check at every attitude: the limit is three sigma. */
#define TUMBLE_NORM_COVERAGE 3.0

/* tumble_commit_limits_t.flags */
enum {
    TUMBLE_COMMIT_BY_ITSELF = 1, /* else every set waits for an operator */
    TUMBLE_COMMIT_FIRST = 2      /* with no active set the first one may be committed, too */
};

/* Coefficients in the order K row by row, then U0. */
typedef struct {
    float uncertainty[TUMBLE_COEFFICIENTS];      /* largest standard uncertainty, ratio or g; above 0, to 1 */
    float drift_per_month[TUMBLE_COEFFICIENTS];  /* plausible change, ratio or g per TUMBLE_MONTH_S; 0 to 1 */
    float drift_per_kelvin[TUMBLE_COEFFICIENTS]; /* ratio or g per K; 0 to 1 */
    float coverage;                              /* k, how many combined standard uncertainties; 1 to 10 */
    uint8_t flags;                               /* TUMBLE_COMMIT_... */
} tumble_commit_limits_t;

/* The objections to `candidate`, as bits; `active` null: there is none. `replayed`: the caller has seen these
 * coefficients before. Some 200 double operations, 48 square roots at most. No other pointer may be null. */
uint16_t tumble_commit_objections(const tumble_set_t *candidate, const tumble_set_t *active,
                                  const tumble_commit_limits_t *limits, bool replayed);

/* Are these limits in their ranges? */
bool tumble_commit_limits_valid(const tumble_commit_limits_t *limits);

/* Name and sentence of a bit number; safe for values outside the list, never null. */
const char *tumble_objection_name(tumble_objection_t objection);
const char *tumble_objection_sentence(tumble_objection_t objection);

/* ---- The life: what is done with the results of runs, and when the next one is due. The navigation computer leads it
 * (navcomp/keeper.h); here are its inputs and its reports.
 */

/* tumble_sets_settings_t.flags */
enum {
    TUMBLE_SETS_STARTS = 1 /* begins a run by itself when one is due, unless a proposal waits */
};

#define TUMBLE_SETS_MIN_PAUSE_S 60U
#define TUMBLE_SETS_TRIES 3U

/* What may be changed from outside, between runs. */
typedef struct {
    tumble_commit_limits_t limits;
    double gravity_m_s2;          /* of the place, recorded with every set; 9.7 to 9.9; 0: not known */
    uint32_t interval_s;          /* a run is due so long after the last set; 0: never by time */
    uint32_t pause_s;             /* no start by itself so long after the last one, the end of any run, and
                                   * tumble_keeper_pause; TUMBLE_SETS_MIN_PAUSE_S or more */
    uint16_t temperature_samples; /* a run is due after so many samples in a row, 1 or more, ... */
    uint8_t temperature_half_c;   /* ... more than this off the active set's temperature, half degrees C; 0: never */
    uint8_t flags;                /* TUMBLE_SETS_... */
} tumble_sets_settings_t;

/* Sets with slopes in a navigation computer, which asks for them by lending this memory, after tumble_thermal_sets_init.
 * Private.
 *
 * Where the active set has slopes, a run is compared with its coefficients at the run's temperature. If they agree,
 * tumble_thermal_update makes the next set of both, with the drift that the rules allow for the time between as growth; if
 * they do not (TUMBLE_OBJECTION_CHANGE), or one of the uncertainties is not known, offset and scale are those of the run
 * alone. The slopes stay either way. A run whose temperature is not known or outside the range is held, without slopes
 * (TUMBLE_OBJECTION_TEMPERATURE). A run that is offered again is known by its gravity check, equal to the last bit. */
typedef struct tumble_thermal_sets {
    tumble_status_t (*read_set)(const uint8_t bytes[TUMBLE_SET_BYTES], tumble_set_t *set);
    /* Bring a set, which the store has just read, to the run's temperature; returns objections. Null: a job has begun to
     * write the run, and writes what it makes of the last such set. */
    uint32_t (*consult)(struct tumble_thermal_sets *sets, tumble_store_t *store, const tumble_set_t *run,
                        const tumble_commit_limits_t *limits, tumble_set_t *set);
    tumble_thermal_t thermal; /* of the last set, as it was read */
    tumble_uncertainty_t uncertainty;
    uint64_t date_utc_s;
    bool moves;    /* there are slopes, and the run can move them */
    bool is_known; /* the uncertainty */
} tumble_thermal_sets_t;

void tumble_thermal_sets_init(tumble_thermal_sets_t *sets);

/* The board's, const; must outlive the owner. */
typedef struct {
    const char *serial;                     /* of the block, 1 to TUMBLE_SET_SERIAL_BYTES characters */
    const tumble_sets_settings_t *settings; /* at power-on */

    /* Does the board inhibit runs now (a discrete input, the vehicle's state)? Called at least once in every step. May
     * be null: the board never inhibits. */
    bool (*inhibited)(void *context);
    void *context; /* handed to it */

    /* tumble_whole_step and its memory: does the run as a whole fit its model? Asked where the stand is declared, a step
     * of it in each step. Both null: not tested, and nothing of it is linked. */
    bool (*whole_step)(tumble_whole_work_t *work, const tumble_misfit_run_t *run);
    tumble_whole_work_t *whole_work;

    /* Sets with slopes are read, and recalibrated. Null: they are of a newer version, and nothing of it is linked. */
    tumble_thermal_sets_t *thermal;
} tumble_sets_config_t;

/* A clock that is set back by less than this makes no run due. */
#define TUMBLE_SETS_CLOCK_SLACK_S 3600U

/* Why a run is due: bits. */
enum {
    TUMBLE_DUE_TIME = 1,        /* the interval is over */
    TUMBLE_DUE_TEMPERATURE = 2, /* the block is warmer or colder than it was when calibrated */
    TUMBLE_DUE_NO_SET = 4,      /* there is no active set */
    TUMBLE_DUE_DATE = 8,        /* the active set is dated more than TUMBLE_SETS_CLOCK_SLACK_S after the present */
    TUMBLE_DUE_DECAYED = 16,    /* the active set has decayed in the memory, and the one before it counts */
    TUMBLE_DUE_NEWER = 32       /* the memory holds a set of a newer version, which cannot be read */
};

/* What became of the last result, or of the last command about sets. The numbers travel over CAN and Modbus. */
typedef enum {
    TUMBLE_VERDICT_NONE = 0,        /* nothing yet since power-on */
    TUMBLE_VERDICT_WORKING = 1,     /* not decided or not written yet */
    TUMBLE_VERDICT_COMMITTED = 2,   /* the result is the active set */
    TUMBLE_VERDICT_HELD = 3,        /* it is the proposal; see `objections` */
    TUMBLE_VERDICT_REPEATED = 4,    /* it is one that the store has held before: nothing was written */
    TUMBLE_VERDICT_ACCEPTED = 5,    /* the proposal is the active set */
    TUMBLE_VERDICT_DISCARDED = 6,   /* the proposal is gone */
    TUMBLE_VERDICT_ROLLED_BACK = 7, /* the set before is active again */
    TUMBLE_VERDICT_FAILED = 8       /* the memory failed; see `status` */
} tumble_verdict_t;

/* Monotonic since power-on; they stop at UINT32_MAX. Store, history and checkpoint have their own. */
typedef struct {
    uint32_t judged; /* results */
    uint32_t committed;
    uint32_t held;
    uint32_t repeated;
    uint32_t accepted;
    uint32_t discarded;
    uint32_t rolled_back;
    uint32_t failures;    /* jobs of the memory that ended in anything but TUMBLE_OK */
    uint32_t checkpoints; /* positions kept */
    uint32_t resumed;     /* runs that went on after a loss of power */
    uint32_t not_resumed; /* refused: nothing kept, or of another block, stand, schedule or configuration */
    uint32_t inhibited;   /* commands refused, runs given up and tables stopped because of the inhibit */
    uint32_t self_started;
    uint32_t refused; /* commands about sets in a state that does not allow them, and to start before what was
                            * saved is in force */
} tumble_sets_counters_t;

/* What is readable, in one copy. */
typedef struct {
    uint64_t utc_s;      /* 0: not known */
    uint32_t counter;    /* tumble_keeper_counter */
    uint32_t age_s;      /* of the active set, by its date, or else since power-on or its change; 0 if there is none */
    uint32_t due_in_s;   /* until the interval is over; 0: it is, or there is no interval */
    uint16_t inhibit_s;  /* left of the host's inhibit, rounded up */
    uint16_t objections; /* to the last result: TUMBLE_OBJECTION_BIT, below TUMBLE_OBJECTION_MORE */
    uint8_t verdict;     /* tumble_verdict_t */
    uint8_t status;      /* tumble_status_t of the last failure of the memory */
    uint8_t due;         /* TUMBLE_DUE_... */
    uint8_t resumable;   /* finished positions of a run that lost power and can be resumed; 0: none */
    bool inhibited;      /* by host or board */
    bool busy;           /* the memory is at work, or about to be */
    bool has_proposal;
    bool has_factory;
    uint16_t more_objections; /* bits from TUMBLE_OBJECTION_MORE on */
} tumble_sets_state_t;

#ifdef __cplusplus
}
#endif

#endif

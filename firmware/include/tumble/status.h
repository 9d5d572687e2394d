/* tumble/status.h - the closed list of outcomes of every function that can fail.
 *
 * One value, one name, one sentence. TUMBLE_OK is 0; everything else is a refusal, and a function that refuses leaves
 * its outputs as it found them unless its own comment says otherwise. New values go to the end: the numbers travel
 * over CAN and Modbus.
 */
#ifndef TUMBLE_STATUS_H
#define TUMBLE_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

#define TUMBLE_STATUS_LIST(X)                                                                                          \
    X(TUMBLE_OK, "done")                                                                                               \
    X(TUMBLE_E_ARGUMENT, "an argument is null or outside its documented range")                                        \
    X(TUMBLE_E_NOT_FINITE, "a number is infinite or not a number")                                                     \
    X(TUMBLE_E_SCHEDULE_SIZE, "the schedule has no positions, or more than fit")                                       \
    X(TUMBLE_E_SCHEDULE_ROTATION, "a mounting matrix is not a proper rotation")                                        \
    X(TUMBLE_E_SCHEDULE_ANGLE, "an angle is out of range or disagrees with its sine and cosine")                       \
    X(TUMBLE_E_SCHEDULE_MOUNTING, "a position refers to a mounting that the schedule does not have")                   \
    X(TUMBLE_E_SCHEDULE_DUPLICATE, "two mountings or two positions have the same number")                              \
    X(TUMBLE_E_NOT_HARMONIC, "a harmonic estimator needs circles through all block axes, which the schedule lacks")    \
    X(TUMBLE_E_MISSING_POSITION, "a position that is needed was not measured")                                         \
    X(TUMBLE_E_RANK, "the measured positions cannot identify all twelve coefficients")                                 \
    X(TUMBLE_E_SINGULAR, "the matrix K cannot be inverted: a channel is dead or two channels are parallel")            \
    X(TUMBLE_E_GAIN_TABLE, "the gain table does not fit the schedule")                                                 \
    X(TUMBLE_E_NOT_OPEN, "no position is open for averaging")                                                          \
    X(TUMBLE_E_FULL, "there is no room for another sample or record")                                                  \
    X(TUMBLE_E_TOO_FEW, "there are fewer samples, positions or sets than required")                                    \
    X(TUMBLE_E_SATURATED, "a sample lies at or beyond the range of the converter")                                     \
    X(TUMBLE_E_DEVIATION, "a sample lies too far from the first one of its position")                                  \
    X(TUMBLE_E_REPEATED, "a sample counter is repeated")                                                               \
    X(TUMBLE_E_REORDERED, "a sample counter went backwards")                                                           \
    X(TUMBLE_E_LOST, "more samples were lost than allowed")                                                            \
    X(TUMBLE_E_STUCK, "a channel repeated one value too often")                                                        \
    X(TUMBLE_E_NOT_STILL, "the scatter exceeds what the declared noise allows: the block was moving")                  \
    X(TUMBLE_E_STATE, "not allowed in this state, or a part it needs is missing")                                      \
    X(TUMBLE_E_PORT_BUSY, "busy now: try again at a later step")                                                       \
    X(TUMBLE_E_PORT_EMPTY, "no received frame is waiting")                                                             \
    X(TUMBLE_E_PORT_DOWN, "the CAN controller is off the bus")                                                         \
    X(TUMBLE_E_STAND_STATE, "the stand does not allow this action in its state")                                       \
    X(TUMBLE_E_SDO_BUSY, "an SDO transfer is already under way")                                                       \
    X(TUMBLE_E_SDO_ABORTED, "the SDO transfer was aborted by the other node")                                          \
    X(TUMBLE_E_SDO_TIMEOUT, "the SDO server did not answer in time")                                                   \
    X(TUMBLE_E_FRAME, "a frame or a stored record is malformed")                                                       \
    X(TUMBLE_E_CRC, "a checksum is wrong")                                                                             \
    X(TUMBLE_E_GAIN_RECORD, "the memory holds no gain record that this software reads")                                \
    X(TUMBLE_E_STAND_ERROR,                                                                                            \
      "an error of the stand came out larger than any stand can have: wrong gains, mounting or means")                 \
    X(TUMBLE_E_UNCERTAIN, "the mean of a position exceeds its error budget with the most samples allowed")             \
    X(TUMBLE_E_NV, "the non-volatile memory failed, or has no such place")                                             \
    X(TUMBLE_E_UNHEALTHY, "the block marks the sample as faulty")                                                      \
    X(TUMBLE_E_NOT_INCLINED, "the schedule has no inclinations of one bolting on both sides of the level")             \
    X(TUMBLE_E_ALIKE, "the run shows no inclinations of the axis")                                                     \
    X(TUMBLE_E_ONE_SIDE, "the run shows all inclinations on one side of the level")

typedef enum {
#define TUMBLE_STATUS_ENUM(name, sentence) name,
    TUMBLE_STATUS_LIST(TUMBLE_STATUS_ENUM)
#undef TUMBLE_STATUS_ENUM
        TUMBLE_STATUS_COUNT
} tumble_status_t;

/* The name of a status, such as "TUMBLE_E_RANK"; "TUMBLE_STATUS_UNKNOWN" for a value outside the list. Never null;
 * the text is constant. */
const char *tumble_status_name(tumble_status_t status);

/* One sentence for a person, without full stop; "this status is not in the list" for a value outside it. Never null. */
const char *tumble_status_sentence(tumble_status_t status);

#ifdef __cplusplus
}
#endif

#endif

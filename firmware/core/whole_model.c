/* A round of Gauss and Newton linearises where the one before ended, and goes through the run twice. The stages:
 *
 *     ROUND --> OPEN --> LOOK --> ROW --> LOOK ... --> OPEN, the next mounting ... --> SOLVE --> the last round: done
 *                 ^                                                                      |
 *                 |   all unknowns; what they have in common stays in the triangle       v
 *                 '---------- the unknowns of a mounting alone, given the others <-------'
 *                                --> ANGLE, for each of its positions --> the next mounting ... --> ROUND
 *
 * A step is one stage, but that a row is turned in over several, so that no step takes more than those of the misfit test.
 */
#include "core/whole_model.h"

#include "core/arith.h"
#include "core/stand_record.h"
#include "core/triangle.h"
#include "core/vector.h"

#define ROUNDS 4         /* of Gauss and Newton */
#define TURNS 6          /* rotations of a row in one step, */
#define LONG_ROW_TURNS 4 /* and of one that has encoder and drift */
#define MOST_INCLINED_RAD                                                                                              \
    0.3 /* how far an inclination may be from its schedule's: no further than tumble_turn is good for */
#define SMALLEST_NOISE 1e-7 /* of a mean, relative to the largest element of its row of K, so that all have weights */

/* The unknowns: what a mounting has for itself comes first, so that it is eliminated with the mounting. Then the
 * coefficients channel by channel (K_ix, K_iy, K_iz, U0_i), then what all share, then, where either is declared, encoder
 * and drift. */
#define COEFFICIENTS TUMBLE_WHOLE_LOCAL
#define SHARED (COEFFICIENTS + TUMBLE_COEFFICIENTS)
#define COURSE (SHARED + TUMBLE_WHOLE_SHARED)

enum { ROUND, OPEN, LOOK, ROW, SOLVE, ANGLE };

static double *triangle_row(tumble_whole_work_t *work, int j)
{
    return tumble_triangle_row(work->triangle, (int)work->unknowns, j);
}

static void clear_rows(tumble_whole_work_t *work, int from, int to)
{
    for (int j = from; j < to; j++) {
        double *r = triangle_row(work, j);
        for (int k = 0; k <= ((int)work->unknowns - j); k++) {
            r[k] = 0.0;
        }
    }
}

/* Turn work->row into the rows of the triangle `from` to below `to`. */
static void turn_row(tumble_whole_work_t *work, int from, int to)
{
    tumble_triangle_turn(work->triangle, (int)work->unknowns, work->row, from, to, 0.0);
}

/* What is left of a row's right side is a residual, if the row was turned into all. */
static void end_row(tumble_whole_work_t *work)
{
    work->residual_square += work->row[work->unknowns] * work->row[work->unknowns];
}

/* An error of the stand is one of its sigmas, give or take one. */
static void add_prior(tumble_whole_work_t *work, int unknown, double error_rad, double sigma_rad)
{
    for (int k = 0; k <= (int)work->unknowns; k++) {
        work->row[k] = 0.0;
    }
    work->row[unknown] = 1.0;
    work->row[work->unknowns] = tumble_exceeds(sigma_rad, 0.0) ? (-error_rad / sigma_rad) : 0.0;
    turn_row(work, unknown, work->columns);
    end_row(work);
}

/* Its part by encoder and drift, if it has one. */
static void make_row_of_course(tumble_whole_work_t *work, const double mix[TUMBLE_CHANNELS])
{
    const tumble_whole_place_t *place = &work->place;
    const double by_angle = tumble_dot(mix, place->by_angle);
    for (int e = 0; e < ((int)work->unknowns - COURSE); e++) {
        const int i = e - TUMBLE_WAVES;
        work->row[COURSE + e] = (i < 0) ? (place->wave_rad[e] * by_angle) : (place->drift_v[i] * mix[i]);
    }
}

/* The row of the outputs combined by `mix`. */
static void make_row(tumble_whole_work_t *work, const double mix[TUMBLE_CHANNELS])
{
    const tumble_whole_place_t *place = &work->place;
    double *row = work->row;
    for (int e = 0; e < TUMBLE_WHOLE_LOCAL; e++) {
        row[e] = tumble_dot(mix, place->by_local[e]);
    }
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        double *of_channel = &row[COEFFICIENTS + (TUMBLE_UNKNOWNS * i)];
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            of_channel[j] = mix[i] * place->attitude_g[j];
        }
        of_channel[TUMBLE_CHANNELS] = mix[i];
    }
    for (int e = 0; e < TUMBLE_WHOLE_SHARED; e++) {
        row[SHARED + e] = tumble_dot(mix, place->by_shared[e]);
    }
    make_row_of_course(work, mix);
    row[work->unknowns] = tumble_dot(mix, place->residual_v);
}

/* The whitened row of a channel. The covariance of the outputs is diag(v) + sigma^2 d d^T; in units of their noise, with
 * e_i = d_i / sqrt(v_i), it is I + sigma^2 e e^T, whose inverse root is I - c e e^T. */
static void make_row_of_channel(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    const tumble_whole_place_t *place = &work->place;
    const int i = (int)work->channel;
    double weight[TUMBLE_CHANNELS];
    double e[TUMBLE_CHANNELS];
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        weight[j] = 1.0 / tumble_sqrt(place->variance_v2[j]);
        e[j] = weight[j] * place->by_angle[j];
    }
    const double square = tumble_dot(e, e);
    const double along = model->stand->angle_rad * model->stand->angle_rad * square;
    const double c = tumble_exceeds(square, 0.0) ? ((1.0 - (1.0 / tumble_sqrt(1.0 + along))) / square) : 0.0;
    double mix[TUMBLE_CHANNELS];
    for (int j = 0; j < TUMBLE_CHANNELS; j++) {
        mix[j] = weight[j] * (((i == j) ? 1.0 : 0.0) - (c * e[i] * e[j]));
    }
    make_row(work, mix);
}

/* The unknowns `from` to below `to`, those after them being known. */
static void substitute_back(tumble_whole_work_t *work, int from, int to)
{
    for (int j = to - 1; j >= from; j--) {
        const double *r = triangle_row(work, j);
        double value = r[(int)work->unknowns - j];
        for (int k = j + 1; k < (int)work->unknowns; k++) {
            value -= r[k - j] * work->change[k];
        }
        work->change[j] = tumble_within(r[0], 0.0) ? 0.0 : (value / r[0]);
    }
}

static double held_within(double most, double error)
{
    return tumble_within(error, most) ? error : (tumble_exceeds(error, 0.0) ? most : -most);
}

static double held(double error_rad)
{
    return held_within(TUMBLE_MAX_STAND_ERROR_RAD, error_rad);
}

/* The best estimate of the error of a set angle, from what this round leaves of the outputs. */
static double angle_error(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    const tumble_whole_place_t *place = &work->place;
    const double square = model->stand->angle_rad * model->stand->angle_rad;
    double mix[TUMBLE_CHANNELS];
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        mix[i] = place->by_angle[i] / place->variance_v2[i];
    }
    make_row(work, mix);
    double along = work->row[work->unknowns];
    for (int k = 0; k < (int)work->unknowns; k++) {
        along -= work->row[k] * work->change[k];
    }
    return held(square * along / (1.0 + (square * tumble_dot(mix, place->by_angle))));
}

/* What the mounting has for itself. */
static void update_mounting(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    tumble_whole_sigmas_t sigmas;
    tumble_whole_sigmas(model, work->mounting, &sigmas);
    const double most = (model->bolted > 0U) ? MOST_INCLINED_RAD : TUMBLE_MAX_STAND_ERROR_RAD;
    float *own = work->local_rad[work->mounting];
    for (int e = 0; e < TUMBLE_WHOLE_LOCAL; e++) {
        const double error = (double)own[e] + (sigmas.local_rad[e] * work->change[e]);
        own[e] = tumble_to_float(held_within(most, error));
    }
}

/* What all have in common. */
static void update_common(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    tumble_whole_sigmas_t sigmas;
    tumble_whole_sigmas(model, work->mounting, &sigmas);
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        const double *change = &work->change[COEFFICIENTS + (TUMBLE_UNKNOWNS * i)];
        for (int j = 0; j < TUMBLE_CHANNELS; j++) {
            work->coefficients.k_v_per_g[i][j] += change[j];
        }
        work->coefficients.u0_v[i] += change[TUMBLE_CHANNELS];
    }
    for (int e = 0; e < TUMBLE_WHOLE_SHARED; e++) {
        work->shared_rad[e] = held(work->shared_rad[e] + (sigmas.shared_rad[e] * work->change[SHARED + e]));
    }
    for (int e = 0; e < ((int)work->unknowns - COURSE); e++) {
        const double error = work->course[e] + (sigmas.course[e] * work->change[COURSE + e]);
        work->course[e] = (e < TUMBLE_WAVES) ? held(error) : error;
    }
}

/* The stages. */

/* The next fit position of the mounting, from work->position on; behind the last one of all there is none. */
static void seek(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    const tumble_schedule_t *schedule = model->schedule;
    const uint8_t number = schedule->mountings[work->mounting].number;
    while ((work->position < schedule->position_count) &&
           ((schedule->positions[work->position].mounting != number) ||
            (schedule->positions[work->position].use != TUMBLE_USE_FIT))) {
        work->position++;
    }
}

static void seek_first(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    work->position = 0;
    seek(model, work);
}

static void seek_next(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    work->position++;
    seek(model, work);
}

static void begin_pass(tumble_whole_work_t *work, int columns)
{
    work->columns = (uint8_t)columns;
    work->mounting = 0;
    work->stage = OPEN;
}

static void begin_round(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    tumble_whole_sigmas_t sigmas;
    tumble_whole_sigmas(model, work->mounting, &sigmas);
    const bool has_course = tumble_is_positive(model->stand->encoder_rad) || tumble_stand_drifts(model->stand);
    work->unknowns = (uint8_t)(has_course ? TUMBLE_WHOLE_UNKNOWNS : COURSE);
    begin_pass(work, (int)work->unknowns);
    clear_rows(work, 0, (int)work->unknowns);
    work->residual_square = 0.0;
    work->means = 0;
    for (int e = 0; e < TUMBLE_WHOLE_SHARED; e++) {
        add_prior(work, SHARED + e, work->shared_rad[e], sigmas.shared_rad[e]);
    }
    for (int e = 0; e < ((int)work->unknowns - COURSE); e++) {
        add_prior(work, COURSE + e, work->course[e], sigmas.course[e]);
    }
}

static void open_mounting(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    tumble_whole_sigmas_t sigmas;
    tumble_whole_sigmas(model, work->mounting, &sigmas);
    clear_rows(work, 0, TUMBLE_WHOLE_LOCAL);
    for (int e = 0; e < TUMBLE_WHOLE_LOCAL; e++) {
        add_prior(work, e, (double)work->local_rad[work->mounting][e], sigmas.local_rad[e]);
    }
    seek_first(model, work);
    work->stage = LOOK;
}

static void end_mounting(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    work->mounting++;
    if (work->mounting < model->schedule->mounting_count) {
        work->stage = OPEN;
    } else if (work->columns == work->unknowns) {
        work->stage = SOLVE;
    } else {
        update_common(model, work);
        work->stage = ROUND;
    }
}

static void start_place(const tumble_whole_model_t *model, const tumble_whole_reading_t *reading,
                        tumble_whole_work_t *work)
{
    if (work->position < model->schedule->position_count) {
        tumble_whole_linearise(model, reading, work);
        work->means += (uint8_t)TUMBLE_CHANNELS;
        work->channel = 0;
        work->column = 0;
        work->stage = ROW;
    } else if (work->columns == work->unknowns) {
        end_mounting(model, work);
    } else {
        substitute_back(work, 0, TUMBLE_WHOLE_LOCAL);
        seek_first(model, work);
        work->stage = ANGLE;
    }
}

static void add_row(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    const int from = (int)work->column;
    const int turns = (work->unknowns > (uint8_t)COURSE) ? LONG_ROW_TURNS : TURNS;
    const int to = ((from + turns) < (int)work->columns) ? (from + turns) : (int)work->columns;
    if (from == 0) {
        make_row_of_channel(model, work);
    }
    turn_row(work, from, to);
    work->column = (uint8_t)to;
    if (to == (int)work->columns) {
        end_row(work);
        work->column = 0;
        work->channel++;
    }
    if (work->channel == (uint8_t)TUMBLE_CHANNELS) {
        seek_next(model, work);
        work->stage = LOOK;
    }
}

/* Each inclination, and each zero of the table angle but the first, takes a square with it. False: that was the last
 * round. */
static bool solve(const tumble_whole_model_t *model, tumble_whole_work_t *work)
{
    const unsigned inclinations = (model->bolted > 0U) ? ((2U * model->bolted) + 1U) : 0U;
    work->chi_squared = work->residual_square;
    work->freedom = (uint8_t)(work->means - (uint8_t)TUMBLE_COEFFICIENTS - inclinations);
    work->round++;
    substitute_back(work, TUMBLE_WHOLE_LOCAL, (int)work->unknowns);
    begin_pass(work, TUMBLE_WHOLE_LOCAL);
    return work->round < (uint8_t)ROUNDS;
}

static void find_angle(const tumble_whole_model_t *model, const tumble_whole_reading_t *reading,
                       tumble_whole_work_t *work)
{
    if (work->position < model->schedule->position_count) {
        tumble_whole_linearise(model, reading, work);
        work->angle_rad[work->position] = tumble_to_float(angle_error(model, work));
        seek_next(model, work);
    } else {
        update_mounting(model, work);
        end_mounting(model, work);
    }
}

bool tumble_whole_go_on(const tumble_whole_model_t *model, const tumble_whole_reading_t *reading,
                        tumble_whole_work_t *work)
{
    bool more = true;
    const bool looks = (work->stage == (uint8_t)LOOK) || (work->stage == (uint8_t)ANGLE);
    if (looks && !reading->measured && (work->position < model->schedule->position_count)) {
        seek_next(model, work);
    } else if (work->stage == (uint8_t)ROUND) {
        begin_round(model, work);
    } else if (work->stage == (uint8_t)OPEN) {
        open_mounting(model, work);
    } else if (work->stage == (uint8_t)LOOK) {
        start_place(model, reading, work);
    } else if (work->stage == (uint8_t)ROW) {
        add_row(model, work);
    } else if (work->stage == (uint8_t)SOLVE) {
        more = solve(model, work);
    } else {
        find_angle(model, reading, work);
    }
    return more;
}

void tumble_whole_start(tumble_whole_work_t *work, const tumble_coefficients_t *coefficients)
{
    *work = (tumble_whole_work_t){.under_way = true, .stage = ROUND};
    work->coefficients = *coefficients;
    for (int i = 0; i < TUMBLE_CHANNELS; i++) {
        work->least_v2[i] = tumble_square(SMALLEST_NOISE * tumble_largest(coefficients->k_v_per_g[i]));
    }
}

/* The gain record: what is read where, and that nothing but a whole, right record is ever taken. */
#include "gain_bench.h"
#include "six_faces.h"

static gain_bytes_t record;
static random_schedule_t random;

static void set_up(void)
{
    empty_gains(&tumble_schedule_paper, 2, &record);
}

static void assert_open(tumble_status_t expected, const void *memory, size_t size, const tumble_schedule_t *schedule)
{
    const tumble_gain_record_t *const before = (const tumble_gain_record_t *)&random;
    const tumble_gain_record_t *opened = before;
    ASSERT_STATUS(expected, tumble_gain_record_open(memory, size, schedule, &opened));
    TEST_ASSERT_EQUAL_PTR((expected == TUMBLE_OK) ? memory : before, opened);
}

static void assert_paper(tumble_status_t expected)
{
    assert_open(expected, record.bytes, record.size, &tumble_schedule_paper);
}

static void test_every_number_is_where_the_layout_says(void)
{
    dice_t dice = {41};
    for (int round = 0; round < 50; round++) {
        random_schedule(&dice, &random);
        const tumble_schedule_t *schedule = &random.schedule;
        const unsigned yaws = (round % 2 == 0) ? 1U : schedule->mounting_count;
        const unsigned columns = 3U * count_fit_positions(schedule);
        empty_gains(schedule, yaws, &record);
        put_word(record.bytes + 20, 0xABCD1234U);
        for (unsigned n = 0; n < AT_GAINS + (14U + yaws) * columns; n++) {
            set_number(&record, n, (double)(n + 1U) / 8192.0);
        }
        seal(&record);
        const tumble_gain_record_t *opened = open_gains(&record, schedule);
        TEST_ASSERT_EQUAL_UINT(columns, 3U * opened->fit_positions);
        TEST_ASSERT_EQUAL_UINT(schedule->mounting_count, opened->mountings);
        TEST_ASSERT_EQUAL_UINT(yaws, opened->yaws);
        TEST_ASSERT_EQUAL_HEX32(0xABCD1234U, opened->block_crc);
        for (unsigned n = 0; n < 9U; n++) {
            ASSERT_SAME_DOUBLE((double)(n + 1U) / 8192.0, opened->k_v_per_g[n / 3U][n % 3U]);
            ASSERT_SAME_DOUBLE((double)(n + 15U) / 8192.0, opened->u_k_v_per_g[n / 3U][n % 3U]);
        }
        ASSERT_SAME_DOUBLE(10.0 / 8192.0, opened->sigma_rad[0]);
        ASSERT_SAME_DOUBLE(13.0 / 8192.0, opened->sigma_rad[3]);
        ASSERT_SAME_DOUBLE(14.0 / 8192.0, opened->sigma_mean_v);
        ASSERT_SAME_DOUBLE(26.0 / 8192.0, opened->u_u0_v[2]);
        TEST_ASSERT_EQUAL_PTR(record.bytes + GAIN_HEAD, tumble_gain_record_gains(opened));
        TEST_ASSERT_EQUAL_PTR(record.bytes + GAIN_HEAD + 96U * columns, tumble_gain_record_stand_gains(opened));
    }
}

static void test_the_record_may_end_before_the_memory(void)
{
    memset(record.bytes + record.size, 0xFF, 100);
    assert_open(TUMBLE_OK, record.bytes, record.size + 100U, &tumble_schedule_paper);
    for (size_t size = 0; size < record.size; size++) {
        assert_open(TUMBLE_E_GAIN_RECORD, record.bytes, size, &tumble_schedule_paper);
    }
}

/* Behind the gains, if the channels differ. */
static void test_weights_of_channels_follow_the_gains(void)
{
    const tumble_gain_record_t *opened = open_gains(&record, &tumble_schedule_paper);
    TEST_ASSERT_NULL(tumble_gain_record_weights(opened));
    const uint32_t at = record.size - 8U;
    record.size += 24U;
    put_word(record.bytes + 4, record.size);
    for (uint32_t i = 0; i < 3U; i++) {
        (void)put_double(record.bytes + at + (8U * i), (double)(1U + i));
    }
    put_word(record.bytes + record.size - 8U, 0);
    seal(&record);
    opened = open_gains(&record, &tumble_schedule_paper);
    TEST_ASSERT_EQUAL_PTR(record.bytes + at, tumble_gain_record_weights(opened));
    (void)put_double(record.bytes + at + 8U, 0.0);
    seal(&record);
    assert_paper(TUMBLE_E_NOT_FINITE);
}

/* Rows of beta and tau behind those of the stand, then their standard deviation, which comes before the weights. */
static void test_inclinations_are_behind_the_gains(void)
{
    static const struct {
        double sigma_rad;
        tumble_status_t status;
    } sigmas[] = {{-1e-300, TUMBLE_E_NOT_FINITE},
                  {1.0000001, TUMBLE_E_NOT_FINITE},
                  {NOT_A_NUMBER, TUMBLE_E_NOT_FINITE},
                  {0.0, TUMBLE_OK},
                  {1.0, TUMBLE_OK},
                  {2e-3, TUMBLE_OK}};
    const tumble_schedule_t *schedule = &tumble_schedule_inclined;
    const unsigned columns = 3U * count_fit_positions(schedule);
    empty_gains(schedule, 1, &record);
    ASSERT_SAME_DOUBLE(0.0, tumble_gain_record_inclination(open_gains(&record, schedule)));
    record.bytes[9] = schedule->mounting_count;
    put_word(record.bytes + record.size - 4U, 0); /* the checksum makes room */
    record.size += 8U * (2U * schedule->mounting_count * columns + 1U);
    put_word(record.bytes + 4, record.size);
    for (size_t i = 0; i < COUNT_OF(sigmas); i++) {
        (void)put_double(record.bytes + record.size - 16U, sigmas[i].sigma_rad);
        seal(&record);
        assert_open(sigmas[i].status, record.bytes, record.size, schedule);
    }
    const tumble_gain_record_t *opened = open_gains(&record, schedule);
    ASSERT_SAME_DOUBLE(2e-3, tumble_gain_record_inclination(opened));
    TEST_ASSERT_NULL(tumble_gain_record_weights(opened));
    record.bytes[9] = (uint8_t)(schedule->mounting_count - 1U);
    seal(&record);
    assert_open(TUMBLE_E_GAIN_RECORD, record.bytes, record.size, schedule);
    record.bytes[9] = schedule->mounting_count;
    seal(&record);
    memcpy(random.mountings, schedule->mountings, schedule->mounting_count * sizeof random.mountings[0]);
    random.schedule = *schedule;
    random.schedule.mountings = random.mountings;
    for (unsigned m = 0; m < schedule->mounting_count; m++) {
        random.mountings[m].bolting = 0;
    }
    assert_open(TUMBLE_E_GAIN_TABLE, record.bytes, record.size, &random.schedule);
}

static void test_null_and_crooked_pointers_are_refused(void)
{
    const tumble_gain_record_t *opened;
    assert_open(TUMBLE_E_ARGUMENT, NULL, record.size, &tumble_schedule_paper);
    assert_open(TUMBLE_E_ARGUMENT, record.bytes, record.size, NULL);
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_gain_record_open(record.bytes, record.size, &tumble_schedule_paper, NULL));
    for (unsigned shift = 1; shift < 8U; shift++) {
        memmove(record.bytes + shift, record.bytes + shift - 1U, record.size);
        ASSERT_STATUS(TUMBLE_E_ARGUMENT,
                      tumble_gain_record_open(record.bytes + shift, record.size, &tumble_schedule_paper, &opened));
    }
}

static void test_every_altered_bit_is_noticed(void)
{
    static random_schedule_t small;
    dice_t dice = {42};
    do {
        random_schedule(&dice, &small);
    } while (count_fit_positions(&small.schedule) != 4U || small.schedule.mounting_count != 2U);
    empty_gains(&small.schedule, 2, &record);
    for (unsigned bit = 0; bit < 8U * record.size; bit++) {
        const bool is_format = bit < 80U; /* magic, size, schema: before the CRC */
        const tumble_gain_record_t *opened = NULL;
        record.bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        const tumble_status_t status = tumble_gain_record_open(record.bytes, record.size, &small.schedule, &opened);
        TEST_ASSERT_TRUE(status == TUMBLE_E_CRC || (is_format && status == TUMBLE_E_GAIN_RECORD));
        TEST_ASSERT_NULL(opened);
        record.bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    assert_open(TUMBLE_OK, record.bytes, record.size, &small.schedule);
}

typedef struct {
    unsigned byte;
    uint8_t value;
    tumble_status_t status;
} alteration_t;

/* A writer's mistakes: wrong, but with the right CRC. */
static void test_what_is_wrong_under_a_right_crc_is_refused(void)
{
    static const alteration_t alterations[] = {
        {0, 't', TUMBLE_E_GAIN_RECORD},
        {3, '2', TUMBLE_E_GAIN_RECORD},
        {8, 2, TUMBLE_E_GAIN_RECORD},
        {8, 0, TUMBLE_E_GAIN_RECORD},
        {9, 1, TUMBLE_E_GAIN_RECORD},
        {10, 17, TUMBLE_E_GAIN_RECORD},
        {10, 19, TUMBLE_E_GAIN_RECORD},
        {10, 0, TUMBLE_E_GAIN_RECORD},
        {11, 1, TUMBLE_E_GAIN_RECORD},
        {11, 3, TUMBLE_E_GAIN_RECORD},
        {12, 0, TUMBLE_E_GAIN_RECORD},
        {12, 1, TUMBLE_E_GAIN_RECORD},
        {12, 3, TUMBLE_E_GAIN_RECORD},
        {13, 1, TUMBLE_E_GAIN_RECORD},
        {14, 128, TUMBLE_E_GAIN_RECORD},
        {15, 255, TUMBLE_E_GAIN_RECORD},
        {16, 0, TUMBLE_E_GAIN_TABLE},
        {19, 0, TUMBLE_E_GAIN_TABLE},
        {22, 1, TUMBLE_OK},
    };
    for (size_t i = 0; i < COUNT_OF(alterations); i++) {
        empty_gains(&tumble_schedule_paper, 2, &record);
        record.bytes[alterations[i].byte] = alterations[i].value;
        seal(&record);
        assert_paper(alterations[i].status);
    }
    for (unsigned tail = 5; tail <= 8U; tail++) {
        empty_gains(&tumble_schedule_paper, 2, &record);
        record.bytes[record.size - tail] = 1;
        seal(&record);
        assert_paper(TUMBLE_E_GAIN_RECORD);
    }
}

/* Gains for a block that measures nothing: no number is wrong, but the whole. */
static void test_a_k_of_zeros_is_refused(void)
{
    set_number(&record, AT_K, 0.0);
    seal(&record);
    assert_paper(TUMBLE_E_NOT_FINITE);
    for (unsigned n = AT_K; n < AT_SIGMA; n++) {
        set_number(&record, n, -1e-30);
        seal(&record);
        assert_paper(TUMBLE_OK);
        set_number(&record, n, -0.0);
    }
}

static void test_a_size_that_is_not_that_of_its_counts_is_refused(void)
{
    static const uint32_t sizes[] = {0, 4, 239, 240, 7000, 7144, 7151};
    const uint32_t right = record.size;
    TEST_ASSERT_EQUAL_UINT(7152, right);
    for (size_t i = 0; i < COUNT_OF(sizes); i++) {
        empty_gains(&tumble_schedule_paper, 2, &record);
        put_word(record.bytes + 4, sizes[i]);
        record.size = (sizes[i] < 240U) ? right : sizes[i];
        seal(&record);
        assert_open(TUMBLE_E_GAIN_RECORD, record.bytes, right, &tumble_schedule_paper);
    }
    empty_gains(&tumble_schedule_paper, 2, &record);
    record.size = right + 8U;
    put_word(record.bytes + 4, record.size);
    seal(&record);
    assert_paper(TUMBLE_E_GAIN_RECORD);
    put_word(record.bytes + 4, 0xFFFFFFFFU);
    seal(&record);
    assert_paper(TUMBLE_E_GAIN_RECORD);
}

static void test_a_record_of_another_schedule_is_refused(void)
{
    static tumble_mounting_t mountings[3];
    static tumble_position_t positions[19];
    assert_open(TUMBLE_E_GAIN_TABLE, record.bytes, record.size, &six_faces);
    for (unsigned kind = 0; kind < 9U; kind++) {
        memcpy(mountings, tumble_schedule_paper.mountings, 2U * sizeof mountings[0]);
        memcpy(positions, tumble_schedule_paper.positions, 18U * sizeof positions[0]);
        tumble_schedule_t other = {mountings, positions, 2, 18};
        positions[18] = (tumble_position_t){1, 50, TUMBLE_USE_CHECK, steps_of_7_5_deg[1]};
        mountings[2] = mountings[1];
        mountings[2].number = 3;
        mountings[0].matrix[0][1] = (kind == 0U) ? 1e-12 : 0.0;
        mountings[1].number = 2;
        mountings[1].tilt.deg = (kind == 1U) ? 1e-9 : -0.0; /* a negative zero is a zero */
        positions[4].angle.deg = (kind == 2U) ? -180.0 : 180.0;
        positions[4].number = (kind == 3U) ? 44 : 5;
        positions[4].mounting = (kind == 4U) ? 2 : 1;
        positions[4].use = (kind == 5U) ? TUMBLE_USE_CHECK : TUMBLE_USE_FIT;
        positions[18].use = (kind == 6U) ? TUMBLE_USE_FIT : TUMBLE_USE_CHECK;
        other.position_count = 19;
        other.mounting_count = (kind == 7U) ? 3 : 2;
        assert_open((kind == 8U) ? TUMBLE_OK : TUMBLE_E_GAIN_TABLE, record.bytes, record.size, &other);
    }
}

static void test_more_mountings_than_yaws_are_refused(void)
{
    tumble_mounting_t mountings[TUMBLE_MAX_YAWS + 1];
    tumble_position_t positions[TUMBLE_MAX_YAWS + 1];
    tumble_schedule_t schedule;
    for (uint8_t count = TUMBLE_MAX_YAWS; count <= (TUMBLE_MAX_YAWS + 1); count++) {
        free_attitudes(count, mountings, positions, &schedule);
        empty_gains(&schedule, 1, &record);
        assert_open((count > TUMBLE_MAX_YAWS) ? TUMBLE_E_GAIN_RECORD : TUMBLE_OK, record.bytes, record.size, &schedule);
    }
}

/* The counts are compared too: a fingerprint alone could agree by accident. */
static void test_the_counts_are_compared_beside_the_fingerprint(void)
{
    gain_bytes_t *r = &record;
    random = (random_schedule_t){0};
    memcpy(random.mountings, tumble_schedule_paper.mountings, 2U * sizeof random.mountings[0]);
    memcpy(random.positions, tumble_schedule_paper.positions, 18U * sizeof random.positions[0]);
    random.schedule = (tumble_schedule_t){random.mountings, random.positions, 2, 17};
    empty_gains(&random.schedule, 2, r);
    put_word(r->bytes + 16, fingerprint_of(&tumble_schedule_paper));
    seal(r);
    assert_paper(TUMBLE_E_GAIN_TABLE);
    empty_gains(&tumble_schedule_paper, 1, r);
    r->bytes[11] = 3;
    seal(r);
    assert_paper(TUMBLE_E_GAIN_TABLE);
}

static void test_every_number_must_be_finite_and_in_its_range(void)
{
    static const double bad[] = {NOT_A_NUMBER, INFINITE, -INFINITE, 1.0000001e100, -1.0000001e100};
    for (unsigned n = 0; n < (record.size - 32U) / 8U; n++) {
        const double good = number_at(&record, n);
        set_number(&record, n, bad[n % COUNT_OF(bad)]);
        seal(&record);
        assert_paper(TUMBLE_E_NOT_FINITE);
        set_number(&record, n, good);
    }
    static const struct {
        unsigned number;
        double value;
        tumble_status_t status;
    } limits[] = {
        {AT_SIGMA, -1e-300, TUMBLE_E_NOT_FINITE},
        {AT_SIGMA + 3U, 1.0000001, TUMBLE_E_NOT_FINITE},
        {AT_SIGMA + 3U, 1.0, TUMBLE_OK},
        {AT_NOISE, 0.0, TUMBLE_E_NOT_FINITE},
        {AT_NOISE, -1.0, TUMBLE_E_NOT_FINITE},
        {AT_NOISE, 1e-300, TUMBLE_OK},
        {AT_U, -1e-300, TUMBLE_E_NOT_FINITE},
        {AT_U + 9U, -1e-300, TUMBLE_E_NOT_FINITE},
        {AT_U + 11U, -1e-300, TUMBLE_E_NOT_FINITE},
        {AT_U + 11U, 1e100, TUMBLE_OK},
        {AT_GAINS, -1e100, TUMBLE_OK},
        {AT_K, -2.0, TUMBLE_OK},
    };
    for (size_t i = 0; i < COUNT_OF(limits); i++) {
        const double good = number_at(&record, limits[i].number);
        set_number(&record, limits[i].number, limits[i].value);
        seal(&record);
        assert_paper(limits[i].status);
        set_number(&record, limits[i].number, good);
    }
}

static void test_fingerprints_agree(void)
{
    dice_t dice = {43};
    TEST_ASSERT_EQUAL_HEX32(0x140E4A73U, tumble_gain_record_schedule_crc(&tumble_schedule_paper));
    TEST_ASSERT_EQUAL_HEX32(0x2E070B7DU, tumble_gain_record_schedule_crc(&tumble_schedule_inclined));
    for (int round = 0; round < 200; round++) {
        random_schedule(&dice, &random);
        for (unsigned m = 0; m < random.schedule.mounting_count; m++) {
            random.mountings[m].bolting = (uint8_t)dice_below(&dice, 3);
        }
        TEST_ASSERT_EQUAL_HEX32(fingerprint_of(&random.schedule), tumble_gain_record_schedule_crc(&random.schedule));
    }
}

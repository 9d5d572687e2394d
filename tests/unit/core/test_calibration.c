/* Turning coefficients round, applying them, and what is intrinsic to a block. */
#include "model.h"
#include "tumble/core.h"

static tumble_coefficients_t diagonal(double x, double y, double z)
{
    return (tumble_coefficients_t){{{x, 0, 0}, {0, y, 0}, {0, 0, z}}, {0, 0, 0}};
}

static void assert_invert_refuses(const tumble_coefficients_t *coefficients, tumble_status_t expected)
{
    tumble_calibration_t calibration;
    tumble_calibration_t as_it_was;
    memset(&calibration, 0x5A, sizeof calibration);
    as_it_was = calibration;
    ASSERT_STATUS(expected, tumble_calibration_invert(coefficients, &calibration));
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &calibration, sizeof calibration);
}

static void assert_intrinsic_refuses(const tumble_coefficients_t *coefficients, tumble_status_t expected)
{
    tumble_intrinsic_t intrinsic;
    tumble_intrinsic_t as_it_was;
    memset(&intrinsic, 0x5A, sizeof intrinsic);
    as_it_was = intrinsic;
    ASSERT_STATUS(expected, tumble_calibration_intrinsic(coefficients, &intrinsic));
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &intrinsic, sizeof intrinsic);
}

static tumble_calibration_t inverted(const tumble_coefficients_t *coefficients)
{
    tumble_calibration_t calibration;
    ASSERT_STATUS(TUMBLE_OK, tumble_calibration_invert(coefficients, &calibration));
    return calibration;
}

static void test_null_pointers_are_refused(void)
{
    const tumble_coefficients_t block = diagonal(1, 1, 1);
    tumble_calibration_t calibration;
    tumble_intrinsic_t intrinsic;
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_calibration_invert(NULL, &calibration));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_calibration_invert(&block, NULL));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_calibration_intrinsic(NULL, &intrinsic));
    ASSERT_STATUS(TUMBLE_E_ARGUMENT, tumble_calibration_intrinsic(&block, NULL));
}

/* K K^-1 = K^-1 K = 1, summed with 31 digits. */
static void test_the_inverse_times_k_is_one(void)
{
    dice_t dice = {30};
    for (int round = 0; round < 2000; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        const tumble_calibration_t calibration = inverted(&block);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                dd_t left = dd_of(0.0);
                dd_t right = dd_of(0.0);
                for (int k = 0; k < 3; k++) {
                    left = dd_add(left, dd_two_product(block.k_v_per_g[i][k], calibration.k_inverse_g_per_v[k][j]));
                    right = dd_add(right, dd_two_product(calibration.k_inverse_g_per_v[i][k], block.k_v_per_g[k][j]));
                }
                TEST_ASSERT_DOUBLE_WITHIN(3e-15, (i == j) ? 1.0 : 0.0, dd_round(left));
                TEST_ASSERT_DOUBLE_WITHIN(3e-15, (i == j) ? 1.0 : 0.0, dd_round(right));
            }
            ASSERT_SAME_DOUBLE(block.u0_v[i], calibration.u0_v[i]);
        }
    }
}

static void test_apply_undoes_the_block(void)
{
    dice_t dice = {31};
    for (int round = 0; round < 2000; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        const tumble_calibration_t calibration = inverted(&block);
        const double force[3] = {2.0 * dice_signed_unit(&dice), 2.0 * dice_signed_unit(&dice),
                                 2.0 * dice_signed_unit(&dice)};
        const dd_t exact[3] = {dd_of(force[0]), dd_of(force[1]), dd_of(force[2])};
        double u[3];
        double a[3];
        for (int i = 0; i < 3; i++) {
            u[i] = dd_round(model_output(&block, i, exact));
        }
        tumble_calibration_apply(&calibration, u, a);
        for (int i = 0; i < 3; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(2e-14, force[i], a[i]);
        }
    }
}

static void test_apply_counts_is_apply_to_scaled_counts(void)
{
    static const double sizes[] = {1.0, -2.5e-6, 0x1p-20};
    dice_t dice = {32};
    for (int round = 0; round < 300; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        const tumble_calibration_t calibration = inverted(&block);
        const int32_t counts[3] = {dice_between(&dice, INT32_MIN, INT32_MAX), INT32_MIN, INT32_MAX};
        const double size = sizes[round % 3];
        const double u[3] = {size * (double)counts[0], size * (double)counts[1], size * (double)counts[2]};
        double expected[3];
        double a[3];
        tumble_calibration_apply(&calibration, u, expected);
        tumble_calibration_apply_counts(&calibration, size, counts, a);
        for (int i = 0; i < 3; i++) {
            ASSERT_SAME_DOUBLE(expected[i], a[i]);
        }
    }
}

/* Neither the sign nor the size of K is assumed. */
static void test_any_sign_and_any_unit_will_do(void)
{
    static const double units[] = {1.0, 1e-30, 8388608.0, 1e60};
    for (size_t s = 0; s < COUNT_OF(units); s++) {
        for (unsigned signs = 0; signs < 8U; signs++) {
            const tumble_coefficients_t block =
                diagonal((signs & 1U) ? -units[s] : units[s], (signs & 2U) ? -2.0 * units[s] : 2.0 * units[s],
                         (signs & 4U) ? -4.0 * units[s] : 4.0 * units[s]);
            const tumble_calibration_t calibration = inverted(&block);
            for (int i = 0; i < 3; i++) {
                const double product = calibration.k_inverse_g_per_v[i][i] * block.k_v_per_g[i][i];
                TEST_ASSERT_DOUBLE_WITHIN(5e-16, 1.0, product);
            }
        }
    }
}

static void test_a_dead_channel_is_singular(void)
{
    for (int dead = 0; dead < 3; dead++) {
        tumble_coefficients_t block = diagonal(2, 2, 2);
        block.k_v_per_g[dead][dead] = 0.0;
        assert_invert_refuses(&block, TUMBLE_E_SINGULAR);
        assert_intrinsic_refuses(&block, TUMBLE_E_SINGULAR);
        block.k_v_per_g[dead][dead] = 0.9 * 2.0 * TUMBLE_MIN_ROW_RATIO;
        assert_invert_refuses(&block, TUMBLE_E_SINGULAR);
        assert_intrinsic_refuses(&block, TUMBLE_E_SINGULAR);
        block.k_v_per_g[dead][dead] = 1.1 * 2.0 * TUMBLE_MIN_ROW_RATIO;
        tumble_intrinsic_t intrinsic;
        (void)inverted(&block);
        ASSERT_STATUS(TUMBLE_OK, tumble_calibration_intrinsic(&block, &intrinsic));
    }
    const tumble_coefficients_t nothing = diagonal(0, 0, 0);
    assert_invert_refuses(&nothing, TUMBLE_E_SINGULAR);
    assert_intrinsic_refuses(&nothing, TUMBLE_E_SINGULAR);
}

/* Two channels at a small angle span a small volume: its sine, when the third stands upright on them. */
static tumble_coefficients_t nearly_parallel(int first, int second, double sine, double scale)
{
    tumble_coefficients_t block = diagonal(3, 3, 3);
    for (int k = 0; k < 3; k++) {
        block.k_v_per_g[second][k] = scale * ((k == first) ? sqrt(1.0 - sine * sine) : (k == second) ? sine : 0.0);
    }
    return block;
}

static void test_two_parallel_channels_are_singular(void)
{
    static const double scales[] = {3.0, -3.0, 0.01, -200.0};
    for (int pair = 0; pair < 12; pair++) {
        const int first = pair % 3;
        const int second = (first + 1 + (pair % 2)) % 3;
        const double scale = scales[pair % 4];
        tumble_coefficients_t block = nearly_parallel(first, second, 0.0, scale);
        assert_invert_refuses(&block, TUMBLE_E_SINGULAR);
        block = nearly_parallel(first, second, 0.9 * TUMBLE_MIN_ROW_VOLUME, scale);
        assert_invert_refuses(&block, TUMBLE_E_SINGULAR);
        block = nearly_parallel(first, second, -0.9 * TUMBLE_MIN_ROW_VOLUME, scale);
        assert_invert_refuses(&block, TUMBLE_E_SINGULAR);
        block = nearly_parallel(first, second, 1.1 * TUMBLE_MIN_ROW_VOLUME, scale);
        (void)inverted(&block);
        block = nearly_parallel(first, second, -1.1 * TUMBLE_MIN_ROW_VOLUME, scale);
        (void)inverted(&block);
    }
}

static void test_three_channels_in_one_plane_are_singular(void)
{
    const tumble_coefficients_t flat = {{{2, 0, 0}, {0, 2, 0}, {1.5, -1, 0}}, {0, 0, 0}};
    assert_invert_refuses(&flat, TUMBLE_E_SINGULAR);
}

static void test_what_is_not_finite_is_refused(void)
{
    static const double bad[] = {NOT_A_NUMBER, INFINITE, -INFINITE};
    for (int element = 0; element < 12; element++) {
        for (size_t b = 0; b < COUNT_OF(bad); b++) {
            tumble_coefficients_t block = diagonal(2, 2, 2);
            *((element < 9) ? &block.k_v_per_g[element / 3][element % 3] : &block.u0_v[element - 9]) = bad[b];
            assert_invert_refuses(&block, TUMBLE_E_NOT_FINITE);
            assert_intrinsic_refuses(&block, TUMBLE_E_NOT_FINITE);
        }
    }
}

/* Rows (2, 0, 0), (3, 4, 0), (0, -5, 12): lengths 2, 5, 13. */
static void test_intrinsic_parameters_of_a_known_block(void)
{
    const tumble_coefficients_t block = {{{2, 0, 0}, {3, 4, 0}, {0, -5, 12}}, {1, -1, 2}};
    tumble_intrinsic_t intrinsic;
    ASSERT_STATUS(TUMBLE_OK, tumble_calibration_intrinsic(&block, &intrinsic));
    ASSERT_SAME_DOUBLE(2.0, intrinsic.scale_v_per_g[0]);
    ASSERT_SAME_DOUBLE(5.0, intrinsic.scale_v_per_g[1]);
    ASSERT_SAME_DOUBLE(13.0, intrinsic.scale_v_per_g[2]);
    TEST_ASSERT_DOUBLE_WITHIN(2e-16, 0.6, intrinsic.cosine_xy);
    ASSERT_SAME_DOUBLE(0.0, intrinsic.cosine_xz);
    TEST_ASSERT_DOUBLE_WITHIN(1e-16, -20.0 / 65.0, intrinsic.cosine_yz);
    ASSERT_SAME_DOUBLE(0.5, intrinsic.bias_g[0]);
    ASSERT_SAME_DOUBLE(-0.2, intrinsic.bias_g[1]);
    ASSERT_SAME_DOUBLE(2.0 / 13.0, intrinsic.bias_g[2]);
}

/* Rows (-2, 0, 0), (3, 4, 0), (12, 0, 5): no right angle among them. */
static void test_each_cosine_is_that_of_its_own_pair(void)
{
    const tumble_coefficients_t block = {{{-2, 0, 0}, {3, 4, 0}, {12, 0, 5}}, {0, 0, 0}};
    tumble_intrinsic_t intrinsic;
    ASSERT_STATUS(TUMBLE_OK, tumble_calibration_intrinsic(&block, &intrinsic));
    TEST_ASSERT_DOUBLE_WITHIN(2e-16, -0.6, intrinsic.cosine_xy);
    TEST_ASSERT_DOUBLE_WITHIN(2e-16, -12.0 / 13.0, intrinsic.cosine_xz);
    TEST_ASSERT_DOUBLE_WITHIN(2e-16, 36.0 / 65.0, intrinsic.cosine_yz);
}

static void test_parallel_channels_have_intrinsic_parameters(void)
{
    const tumble_coefficients_t block = {{{2, 0, 0}, {-3, 0, 0}, {0, 0, 1}}, {0, 0, 0}};
    tumble_intrinsic_t intrinsic;
    ASSERT_STATUS(TUMBLE_OK, tumble_calibration_intrinsic(&block, &intrinsic));
    ASSERT_SAME_DOUBLE(-1.0, intrinsic.cosine_xy);
}

/* However the block sits on the stand, K becomes K R; what is intrinsic stays. */
static void test_intrinsic_parameters_do_not_depend_on_the_mounting(void)
{
    dice_t dice = {33};
    for (int round = 0; round < 1000; round++) {
        const tumble_coefficients_t block = random_block(&dice);
        tumble_coefficients_t turned = block;
        double rotation[3][3];
        random_rotation(&dice, rotation);
        for (int cell = 0; cell < 9; cell++) {
            double sum = 0.0;
            for (int k = 0; k < 3; k++) {
                sum += block.k_v_per_g[cell / 3][k] * rotation[k][cell % 3];
            }
            turned.k_v_per_g[cell / 3][cell % 3] = sum;
        }
        tumble_intrinsic_t one;
        tumble_intrinsic_t other;
        ASSERT_STATUS(TUMBLE_OK, tumble_calibration_intrinsic(&block, &one));
        ASSERT_STATUS(TUMBLE_OK, tumble_calibration_intrinsic(&turned, &other));
        for (int i = 0; i < 3; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(4e-15, one.scale_v_per_g[i], other.scale_v_per_g[i]);
            TEST_ASSERT_DOUBLE_WITHIN(1e-15, one.bias_g[i], other.bias_g[i]);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, one.cosine_xy, other.cosine_xy);
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, one.cosine_xz, other.cosine_xz);
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, one.cosine_yz, other.cosine_yz);
    }
}

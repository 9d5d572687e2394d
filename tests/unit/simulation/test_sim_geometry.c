/* The geometry of a block on an imperfect stand, against the formulas written out by themselves, rotation by rotation.
 */
#include "model.h"
#include "simulation/geometry.h"
#include "support.h"

#include <math.h>

#define DEG 57.29577951308232

typedef struct {
    double x, y, z;
} vector_t;

/* f = (cos alpha1 sin p, sin alpha1, cos alpha1 cos p) in (h, n, v), p = phi + alpha2 + delta. */
static vector_t table_force(double alpha1, double p)
{
    return (vector_t){cos(alpha1) * sin(p), sin(alpha1), cos(alpha1) * cos(p)};
}

/* Yaw: h' = h cos alpha3 + n sin alpha3, n' = -h sin alpha3 + n cos alpha3, v' = v. */
static vector_t yawed(vector_t f, double alpha3)
{
    return (vector_t){f.x * cos(alpha3) + f.y * sin(alpha3), -f.x * sin(alpha3) + f.y * cos(alpha3), f.z};
}

/* A seat that leans turns n towards v. */
static vector_t leaning(vector_t f, double theta_h)
{
    return (vector_t){f.x, f.y * cos(theta_h) + f.z * sin(theta_h), f.z * cos(theta_h) - f.y * sin(theta_h)};
}

static void assert_force(vector_t expected, const double a_g[3], double tolerance)
{
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected.x, a_g[0]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected.y, a_g[1]);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, expected.z, a_g[2]);
}

/* Mounting 1: (h', n', v'); mounting 2: (-h', v', n'). Errors far larger than real ones, so that no term can hide. */
static void test_both_mountings_of_the_paper(void)
{
    dice_t dice = {6};
    for (int n = 0; n < 20000; n++) {
        const double alpha1 = 0.3 * dice_signed_unit(&dice);
        const double alpha2 = 0.3 * dice_signed_unit(&dice);
        const double alpha3 = 0.3 * dice_signed_unit(&dice);
        const double theta_h = 0.3 * dice_signed_unit(&dice);
        const double theta_n = 0.3 * dice_signed_unit(&dice);
        const double actual_deg = 400.0 * dice_signed_unit(&dice);
        const vector_t f = table_force(alpha1, actual_deg / DEG + alpha2 + theta_n);
        const vector_t t = yawed(leaning(f, theta_h), alpha3);
        const sim_seat_t seat = {alpha1, alpha2, alpha3, theta_h, theta_n, {0.0}};
        sim_geometry_t geometry;
        double a_g[3];
        sim_geometry_init(&geometry, &tumble_schedule_paper.mountings[0], &seat);
        sim_geometry_force(&geometry, actual_deg, a_g);
        assert_force((vector_t){t.x, t.y, t.z}, a_g, 3e-15);
        sim_geometry_init(&geometry, &tumble_schedule_paper.mountings[1], &seat);
        sim_geometry_force(&geometry, actual_deg, a_g);
        assert_force((vector_t){-t.x, t.z, t.y}, a_g, 3e-15);
    }
}

/* Any mounting matrix, and an axis whose tilt is known: it adds to alpha1. The force stays a unit vector. */
static void test_any_mounting_and_tilt(void)
{
    dice_t dice = {7};
    for (int n = 0; n < 5000; n++) {
        const double tilt_deg = 80.0 * dice_signed_unit(&dice);
        const double alpha1 = 0.1 * dice_signed_unit(&dice);
        const double alpha3 = 0.1 * dice_signed_unit(&dice);
        const double actual_deg = 360.0 * dice_signed_unit(&dice);
        tumble_mounting_t mounting = {.number = 1, .tilt = {tilt_deg, sin(tilt_deg / DEG), cos(tilt_deg / DEG)}};
        random_rotation(&dice, mounting.matrix);
        sim_geometry_t geometry;
        double a_g[3];
        sim_geometry_init(&geometry, &mounting, &(sim_seat_t){alpha1, 0.0, alpha3, 0.0, 0.0, {0.0}});
        sim_geometry_force(&geometry, actual_deg, a_g);
        const vector_t t = yawed(table_force(tilt_deg / DEG + alpha1, actual_deg / DEG), alpha3);
        for (int i = 0; i < 3; i++) {
            const double *const m = mounting.matrix[i];
            TEST_ASSERT_DOUBLE_WITHIN(4e-15, m[0] * t.x + m[1] * t.y + m[2] * t.z, a_g[i]);
        }
        TEST_ASSERT_DOUBLE_WITHIN(4e-15, 1.0, a_g[0] * a_g[0] + a_g[1] * a_g[1] + a_g[2] * a_g[2]);
    }
}

/* Without errors it is the schedule's own attitude. */
static void test_the_ideal_stand_is_the_schedules(void)
{
    for (uint8_t i = 0; i < tumble_schedule_paper.position_count; i++) {
        sim_geometry_t geometry;
        double a_g[3];
        double ideal_g[3];
        sim_geometry_init(&geometry, tumble_schedule_mounting_of(&tumble_schedule_paper, i), &(sim_seat_t){0});
        sim_geometry_force(&geometry, tumble_schedule_paper.positions[i].angle.deg, a_g);
        tumble_schedule_attitude(&tumble_schedule_paper, i, ideal_g);
        assert_force((vector_t){ideal_g[0], ideal_g[1], ideal_g[2]}, a_g, 2.3e-16);
    }
}

/* alpha2 = -alpha3 cannot be told from a turn of the body's own axes, and neither from the angle error: signs matter. A
 * positive alpha2 turns gravity towards +x in mounting 1 at position 1, and towards -x in mounting 2. */
static void test_signs_at_the_first_position(void)
{
    sim_geometry_t geometry;
    double a_g[3];
    sim_geometry_init(&geometry, &tumble_schedule_paper.mountings[0], &(sim_seat_t){0.0, 1e-3, 0.0, 0.0, 0.0, {0.0}});
    sim_geometry_force(&geometry, 0.0, a_g);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1e-3, a_g[0]);
    sim_geometry_init(&geometry, &tumble_schedule_paper.mountings[1], &(sim_seat_t){0.0, 1e-3, 0.0, 0.0, 0.0, {0.0}});
    sim_geometry_force(&geometry, 0.0, a_g);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -1e-3, a_g[0]);
    sim_geometry_init(&geometry, &tumble_schedule_paper.mountings[0], &(sim_seat_t){1e-3, 0.0, 0.0, 0.0, 0.0, {0.0}});
    sim_geometry_force(&geometry, 0.0, a_g);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1e-3, a_g[1]);
    sim_geometry_init(&geometry, &tumble_schedule_paper.mountings[0], &(sim_seat_t){0.0, 0.0, 1e-3, 0.0, 0.0, {0.0}});
    sim_geometry_force(&geometry, 90.0, a_g);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, -1e-3, a_g[1]);
}

/* unity.h - the few checks that the benches of tests/lib make of themselves, for programs that are not Unity's. */
#ifndef TUMBLE_TESTS_PLAIN_UNITY_H
#define TUMBLE_TESTS_PLAIN_UNITY_H

#define UNITY_SUPPORT_64

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PLAIN_REQUIRE(condition, what)                                                                                 \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            (void)fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, what);                                            \
            exit(3);                                                                                                   \
        }                                                                                                              \
    } while (0)

#define TEST_FAIL_MESSAGE(message) PLAIN_REQUIRE(0, message)
#define TEST_ASSERT_TRUE_MESSAGE(condition, message) PLAIN_REQUIRE(condition, message)
#define TEST_ASSERT_TRUE(condition) PLAIN_REQUIRE(condition, #condition)
#define TEST_ASSERT_FALSE(condition) PLAIN_REQUIRE(!(condition), #condition)
#define TEST_ASSERT_EQUAL(wanted, found) PLAIN_REQUIRE((wanted) == (found), #found)
#define TEST_ASSERT_NOT_EQUAL(other, found) PLAIN_REQUIRE((other) != (found), #found)
#define TEST_ASSERT_EQUAL_INT(wanted, found) TEST_ASSERT_EQUAL(wanted, found)
#define TEST_ASSERT_EQUAL_STRING(wanted, found) PLAIN_REQUIRE(strcmp(wanted, found) == 0, #found)
#define TEST_ASSERT_EQUAL_UINT8(wanted, found) TEST_ASSERT_EQUAL(wanted, found)
#define TEST_ASSERT_EQUAL_UINT32(wanted, found) TEST_ASSERT_EQUAL(wanted, found)
#define TEST_ASSERT_EQUAL_HEX16(wanted, found) TEST_ASSERT_EQUAL(wanted, found)
#define TEST_ASSERT_EQUAL_HEX64(wanted, found) TEST_ASSERT_EQUAL(wanted, found)
#define UNITY_LINE_TYPE int
#define UNITY_TEST_ASSERT_EQUAL_HEX64(wanted, found, line, message)                                                    \
    PLAIN_REQUIRE(((wanted) == (found)) && ((line) != 0), message)
#define TEST_ASSERT_DOUBLE_WITHIN(delta, wanted, found) PLAIN_REQUIRE(fabs((wanted) - (found)) <= (delta), #found)

#endif

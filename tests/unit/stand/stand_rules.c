#include "stand_rules.h"

#include "support.h"

#include <setjmp.h>

#define NEAR_DEG 0.1
#define RULE(holds, sentence)                                                                                          \
    if (!(holds)) {                                                                                                    \
        broken = (sentence);                                                                                           \
        longjmp(end, 1);                                                                                               \
    }

static const played_stand_t *it;
static const char *broken;
static jmp_buf end;

static tumble_stand_state_t state(void)
{
    return it->stand.kind->state(it->stand.self);
}

static tumble_status_t move(double angle_deg)
{
    return it->stand.kind->move(it->stand.self, angle_deg);
}

static tumble_status_t home(void)
{
    return it->stand.kind->home(it->stand.self);
}

static void stop(void)
{
    it->stand.kind->stop(it->stand.self);
}

static bool turns(void)
{
    return (it->turns != NULL) && it->turns();
}

static bool is_refused(void)
{
    return move(1.0) == TUMBLE_E_STAND_STATE && home() == TUMBLE_E_STAND_STATE;
}

static bool is_near(double angle_deg)
{
    return magnitude(it->stand.kind->angle_deg(it->stand.self) - angle_deg) <= NEAR_DEG &&
           magnitude(it->angle_deg() - angle_deg) <= NEAR_DEG;
}

/* What holds at every moment. */
static void assert_always(void)
{
    const bool faulty = it->stand.kind->fault(it->stand.self) != TUMBLE_STAND_FAULT_NONE;
    RULE((state() == TUMBLE_STAND_FAULT) == faulty, "there is a fault if and only if the state is FAULT");
    RULE(state() != TUMBLE_STAND_IN_POSITION || !turns(), "a table that turns is not in position");
    RULE(state() != TUMBLE_STAND_STOPPED || !turns(), "a table that turns has not stopped");
    RULE(tumble_stand_report(&it->stand)->asks == false || it->stand.kind->confirm != NULL,
         "a kind that asks can be answered");
}

static void pass_ms(unsigned ms)
{
    for (unsigned i = 0; i < ms; i++) {
        it->pass();
        assert_always();
    }
}

static bool comes_to(tumble_stand_state_t wanted, unsigned most_ms)
{
    for (unsigned ms = 0; ms < most_ms && state() != wanted; ms++) {
        pass_ms(1);
    }
    assert_always();
    return state() == wanted;
}

static void begin(void)
{
    it->begin();
    RULE(comes_to(TUMBLE_STAND_READY, it->most_ms), "with contact it becomes ready by itself");
}

static void begin_at_home(void)
{
    begin();
    RULE(home() == TUMBLE_OK, "a stand that is ready homes");
    RULE(comes_to(TUMBLE_STAND_IN_POSITION, it->most_ms), "homing ends");
}

static void begin_moving(void)
{
    begin_at_home();
    RULE(move(90.0) == TUMBLE_OK, "a stand in position moves");
    pass_ms(30);
    RULE(state() == TUMBLE_STAND_MOVING, "a move takes time");
}

/* The rules. */

static void homes_before_it_moves(void)
{
    begin();
    RULE(move(45.0) == TUMBLE_E_STAND_STATE, "before homing a move is refused");
    RULE(home() == TUMBLE_OK, "a stand that is ready homes");
    RULE(state() == TUMBLE_STAND_HOMING, "from the moment that home returns, the old state does not count");
    RULE(is_refused(), "while it homes it takes no other order");
    RULE(comes_to(TUMBLE_STAND_IN_POSITION, it->most_ms) && is_near(0.0), "after homing it is at home");
}

static void moves_to_where_it_is_told(void)
{
    static const double angles_deg[] = {45.0, -10.0, 370.0, 0.0, 0.0};
    begin_at_home();
    for (size_t i = 0; i < COUNT_OF(angles_deg); i++) {
        RULE(move(angles_deg[i]) == TUMBLE_OK, "a stand in position moves");
        RULE(state() == TUMBLE_STAND_MOVING, "from the moment that move returns, the old position does not count");
        RULE(is_refused(), "while it moves it takes no other order");
        RULE(comes_to(TUMBLE_STAND_IN_POSITION, it->most_ms) && is_near(angles_deg[i]),
             "it is where it was told to be");
    }
    pass_ms(1000);
    RULE(state() == TUMBLE_STAND_IN_POSITION && is_near(0.0), "it stays in position");
}

static void refuses_what_is_no_angle(void)
{
    begin_at_home();
    RULE(move(NOT_A_NUMBER) == TUMBLE_E_ARGUMENT && move(INFINITE) == TUMBLE_E_ARGUMENT, "what is no angle is refused");
    RULE(state() == TUMBLE_STAND_IN_POSITION, "what is refused changes nothing");
}

static void stops_wherever_it_is(void)
{
    begin_moving();
    stop();
    RULE(comes_to(TUMBLE_STAND_STOPPED, it->most_ms), "a stop ends at rest, with the position known");
    RULE(move(20.0) == TUMBLE_OK && comes_to(TUMBLE_STAND_IN_POSITION, it->most_ms) && is_near(20.0),
         "after a stop it goes on by command");
    stop();
    stop();
    RULE(comes_to(TUMBLE_STAND_STOPPED, it->most_ms), "a stop at rest, and twice, is no fault");
    RULE(home() == TUMBLE_OK, "a stand that has stopped homes");
    stop();
    pass_ms(it->most_ms);
    RULE(state() == TUMBLE_STAND_STOPPED || state() == TUMBLE_STAND_READY, "a stop ends homing");
    RULE(!turns(), "the table rests after a stop");
}

static void has_no_fault_to_clear(void)
{
    begin_moving();
    RULE(it->stand.kind->clear_fault(it->stand.self) == TUMBLE_E_STAND_STATE, "without a fault there is none to clear");
    RULE(comes_to(TUMBLE_STAND_IN_POSITION, it->most_ms), "a refused clear_fault does not disturb a move");
}

static void clear(void)
{
    tumble_status_t status = TUMBLE_E_STAND_STATE;
    for (unsigned ms = 0; ms < 10000U && status == TUMBLE_E_STAND_STATE; ms++) {
        pass_ms(1);
        status = it->stand.kind->clear_fault(it->stand.self);
    }
    RULE(status == TUMBLE_OK, "a fault can be cleared, in seconds at most");
}

static void notices_that_contact_is_lost(void)
{
    begin_moving();
    it->lose();
    RULE(comes_to(TUMBLE_STAND_FAULT, it->fault_ms), "a lost contact is a fault, in bounded time");
    pass_ms(it->fault_ms);
    RULE(!turns(), "a table without contact comes to rest");
    RULE(is_refused(), "in a fault it takes no order");
    stop();
    RULE(state() == TUMBLE_STAND_FAULT, "stop does not clear a fault");
    it->find();
    pass_ms(it->fault_ms);
    RULE(state() == TUMBLE_STAND_FAULT, "a fault stays until it is cleared");
    clear();
    pass_ms(it->most_ms);
    RULE(state() == TUMBLE_STAND_READY || state() == TUMBLE_STAND_STOPPED, "clear_fault leads to READY or STOPPED");
    RULE(home() == TUMBLE_OK && comes_to(TUMBLE_STAND_IN_POSITION, it->most_ms), "from there on it works again");
}

/* A computer that asks again at once without end would sleep no more. */
static void lets_time_pass(void)
{
    begin_at_home();
    pass_ms(100);
    RULE(it->stand.kind->next_us(it->stand.self) > 0U, "at rest its next step is not due at once");
}

const char *stand_rules_broken(const played_stand_t *played)
{
    it = played;
    broken = NULL;
    if (setjmp(end) != 0) {
        return broken;
    }
    homes_before_it_moves();
    moves_to_where_it_is_told();
    refuses_what_is_no_angle();
    stops_wherever_it_is();
    has_no_fault_to_clear();
    notices_that_contact_is_lost();
    lets_time_pass();
    return NULL;
}

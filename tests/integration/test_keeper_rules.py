"""The commit rules against the same inequalities in exact and 60-digit arithmetic,
on cases on both sides of the limits."""

import random
import struct
import subprocess
from decimal import Decimal, getcontext
from fractions import Fraction

import pytest
from c_compiler import compiled

SOURCES = ["tests/integration/keeper_rules_harness.c", "firmware/sets/rules.c", "firmware/core/arith.c",
           "firmware/core/vector.c"]
MONTH_S = 2629746
MOST_MONTHS = 24
UNCERTAIN, CHANGE = 1 << 3, 1 << 4
DOUBTFUL = Decimal("1e-12")  # nearer to a limit than this, relative, double precision may decide either way

getcontext().prec = 60


@pytest.fixture(scope="module")
def rules(tmp_path_factory):
    """A function: the objections to each of many cases."""
    program = compiled(tmp_path_factory.mktemp("rules") / "keeper_rules", *SOURCES)

    def judge(cases):
        lines = "\n".join(" ".join(float(x).hex() for x in flat(case)) for case in cases)
        done = subprocess.run([program], input=lines, capture_output=True, text=True, check=True, timeout=60)
        return [int(line) for line in done.stdout.split()]

    return judge


def single(x):
    """The nearest single-precision number, as the limits are kept."""
    return struct.unpack("f", struct.pack("f", x))[0]


def flat(case):
    return [*case["new"], *case["u_new"], *case["old"], *case["u_old"], *case["limit"], *case["drift"], *case["kelvin"],
            case["coverage"], case["date"], case["date_old"], case["warmth"], case["warmth_old"]]


def exact(x):
    fraction = Fraction(x)
    return Decimal(fraction.numerator) / Decimal(fraction.denominator)


def length(case, c):
    """|K_i| of the row that coefficient c belongs to."""
    row = c // 3 if c < 9 else c - 9
    return sum(exact(x) ** 2 for x in case["new"][3 * row:3 * row + 3]).sqrt()


def allowed_change(case, c):
    months = min(Decimal(MOST_MONTHS), max(Decimal(1), Decimal(case["date"] - case["date_old"]) / MONTH_S))
    kelvin = abs(exact(case["warmth"]) - exact(case["warmth_old"]))
    combined = (exact(case["u_new"][c]) ** 2 + exact(case["u_old"][c]) ** 2).sqrt()
    drift = exact(case["drift"][c]) * months + exact(case["kelvin"][c]) * kelvin
    return exact(case["coverage"]) * combined + drift * length(case, c)


def make(dice):
    """A case that is well within all limits."""
    scale = dice.choice([-1, 1]) * 10 ** dice.uniform(-2, 2)
    new = [scale * ((c % 4 == 0) + dice.uniform(-0.05, 0.05)) for c in range(9)] + [scale * dice.uniform(-0.1, 0.1)
                                                                                     for _ in range(3)]
    case = {"new": new, "date": 1_800_000_000 + dice.randrange(100_000_000), "coverage": single(dice.uniform(1, 10)),
            "warmth": dice.uniform(-40, 60), "warmth_old": dice.uniform(-40, 60)}
    case["date_old"] = case["date"] - dice.choice([0, dice.randrange(MONTH_S), dice.randrange(40 * MONTH_S)])
    for name, low in (("limit", -6), ("drift", -7), ("kelvin", -8)):
        case[name] = [single(10 ** dice.uniform(low, low + 3)) for _ in range(12)]
    case["u_new"] = [float(exact(case["limit"][c]) * length(case, c)) * dice.uniform(0.01, 0.9) for c in range(12)]
    case["u_old"] = [u * dice.uniform(0.1, 3) for u in case["u_new"]]
    case["old"] = [float(exact(new[c]) + Decimal(dice.uniform(-0.9, 0.9)) * allowed_change(case, c)) for c in range(12)]
    return case


def push(case, dice):
    """One number to just this side, or just that side, of its limit."""
    c, beyond = dice.randrange(12), 1 + dice.choice([-1, 1]) * Decimal(10) ** dice.randint(-9, -1)
    if dice.random() < 0.5:
        case["u_new"][c] = float(exact(case["limit"][c]) * length(case, c) * beyond)
    else:
        case["old"][c] = float(exact(case["new"][c]) + dice.choice([-1, 1]) * beyond * allowed_change(case, c))


def expected(case):
    """The objections, or None where a case is too near to a limit."""
    objections = 0
    for c in range(12):
        for bit, size, most in ((UNCERTAIN, exact(case["u_new"][c]), exact(case["limit"][c]) * length(case, c)),
                                (CHANGE, abs(exact(case["new"][c]) - exact(case["old"][c])), allowed_change(case, c))):
            if abs(size - most) < DOUBTFUL * max(most, abs(exact(case["new"][c]))):
                return None
            objections |= bit if size > most else 0
    return objections


def test_random_cases_on_both_sides_of_each_limit(rules, cases):
    """4000 with --full."""
    dice, count = random.Random(6), cases(4000)
    made = [make(dice) for _ in range(count)]
    for case in made[count // 10:]:
        push(case, dice)
    wanted = [expected(case) for case in made]
    found = rules(made)
    assert len(found) == count
    wrong = [(case, want, have) for case, want, have in zip(made, wanted, found, strict=True)
             if want is not None and want != have]
    assert not wrong, wrong[0]
    counts = {want: wanted.count(want) for want in set(wanted)}
    assert counts.get(None, 0) < count // 10, counts
    assert min(counts[0], counts[UNCERTAIN], counts[CHANGE]) > count // 10, counts


def test_the_witness_notices_a_limit_that_is_off(rules):
    dice = random.Random(7)
    cases = [make(dice) for _ in range(200)]
    for case in cases:
        push(case, dice)
    wanted = [expected(case) for case in cases]
    for case in cases:
        case["coverage"] = single(case["coverage"] * 1.01)
    assert any(want is not None and want != have for want, have in zip(wanted, rules(cases), strict=True))

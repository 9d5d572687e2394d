"""What the line about an ordinary logger's file advises leads to a solved run, and never in a circle."""

import re

import numpy as np
import pytest
from blocks import NOMINAL_K

from tumble.model import Geometry, built_in

pytestmark = pytest.mark.python

OUTPUTS = 1e4 * Geometry(built_in("paper")).outputs(NOMINAL_K, [0.1, 0.2, 0.3])  # to 20,000
PREAMBLE = "Logger 7, serial 12\nstarted;2026-05-01 10:00\n\nrange;+-5 V;;;\n"
NAMES = "mounting;position;ux;uy;uz\n"
OTHERS = "M;P;A;B;C\n"
SAY = ("--columns", "mounting=M,position=P,ux=A,uy=B,uz=C")


def point(output):
    return f"{output:.1f}"


def comma(output):
    return point(output).replace(".", ",")


def thousands(output):
    return f"{output:,.1f}".translate(str.maketrans(",.", ".,"))


def whole(output):
    return f"{output:.0f}"


def rows(number=point):
    places = [(position.mounting, position.number) for position in built_in("paper").positions]
    return "".join(
        f"{mounting};{position};{';'.join(map(number, outputs))}\n"
        for (mounting, position), outputs in zip(places, OUTPUTS.tolist())
    )


ADVICE = {  # of a file and options each: what is advised; the last is what follows the advice
    "rows above the header": [
        (PREAMBLE + NAMES + rows(), (), "row 1: is no header; row 5 looks like it: delete the rows above it, or begin"),
        (NAMES + rows(), ()),
    ],
    "the same, begun with #": [
        (PREAMBLE + NAMES + rows(), (), "or begin each of them with #"),
        (re.sub("^(?=.)", "# ", PREAMBLE, flags=re.MULTILINE) + NAMES + rows(), ()),
    ],
    "and units below": [
        (PREAMBLE + NAMES + "-;-;mV;mV;mV\n" + rows(), (), "row 5 looks like it"),
        (NAMES + "-;-;mV;mV;mV\n" + rows(), (), "row 2, column mounting: '-' is not a number (a row of units? Delete"),
        (NAMES + rows(), ("--unit", "mV")),
    ],
    "and other names": [
        (PREAMBLE + OTHERS + "-;-;mV;mV;mV\n" + rows(comma), (), "row 5 looks like it"),
        (
            OTHERS + rows(comma),
            (),
            "no columns mounting, position, ux, uy and uz among 'M;P;A;B;C'".replace(";", ",")
            + "; name what is missing with --columns mounting=NAME,position=NAME,ux=NAME,uy=NAME,uz=NAME, or add it",
        ),
        (OTHERS + rows(comma), ("--columns", "mounting=M,position=Q,ux=X"), "no columns 'Q' and 'X' (for position and"),
        (OTHERS + rows(comma), SAY),
    ],
    "angles for positions": [
        (NAMES.replace("position", "angle_deg") + rows(comma), (), "or add it; a position is counted from 1 in its"),
        (NAMES + rows(comma), ()),
    ],
    "another separator": [
        ((NAMES + rows()).replace(";", "|"), (), "say what separates the columns with --delimiter"),
        ((NAMES + rows()).replace(";", "|"), ("--delimiter", "|")),
    ],
    "a separator of thousands": [
        (NAMES + rows(thousands), (), "is not a number (write all numbers with the same decimal mark, and without"),
        (NAMES + rows(comma), ()),
    ],
    "the same, with the wrong option": [
        (NAMES + rows(thousands), ("--decimal", ","), "and without thousands separators"),
        (NAMES + rows(thousands), ("--decimal", "."), "and without thousands separators"),
        (NAMES + rows(comma), ()),
    ],
    "a decimal comma that comes late": [
        (NAMES + 12 * rows(whole) + rows(comma), (), "is not a number (its decimal mark? see --decimal ,)"),
        (NAMES + 12 * rows(whole) + rows(comma), ("--decimal", ",")),
    ],
}


@pytest.mark.parametrize("case", ADVICE)
def test_advice_that_is_followed_ends_in_a_result(case, tumble, refused, tmp_path):
    *steps, (good, options) = ADVICE[case]
    run = tmp_path / "run.csv"
    for text, wrong, message in steps:
        run.write_text(text)
        assert message in refused("solve", run, *wrong)
    run.write_text(good)
    done = tumble("solve", run, *options, "--limit", "1e-2")
    assert done.returncode == 0, done.stderr


def test_the_header_is_named_in_full(refused, tmp_path):
    """However many columns there are: a name that is cut off cannot be typed."""
    names = [f"Channel number {number}" for number in range(20)]
    run = tmp_path / "run.csv"
    run.write_text(",".join(names) + "\n" + ",".join(map(str, np.arange(20))) + "\n")
    assert ",".join(names) in refused("solve", run)

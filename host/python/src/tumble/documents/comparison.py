"""tumble.comparison/1: two calibrations of one block, as `compare` prints them. Differences are B less A."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Annotated, Final, Generic, Literal, TypeAlias, TypeVar

from msgspec import Meta, field

from tumble.documents.base import Count, Document, Positive, Share, Size, exactly
from tumble.documents.further import OF_FORCE
from tumble.documents.result import REASONS, Labels, Name

COMPARISON: Final = "tumble.comparison/1"

Text: TypeAlias = Annotated[str, Meta(min_length=1)]
Parameter: TypeAlias = Annotated[str, exactly(f"(scale_[xyz]|angle_(xy|xz|yz)|bias_[xyz]|{OF_FORCE})")]
Coefficient: TypeAlias = Annotated[str, exactly(f"(K_[xyz][xyz]|U0_[xyz]|{OF_FORCE})")]
if TYPE_CHECKING:
    Verdict: TypeAlias = str
    Apparent: TypeAlias = str
    Reason: TypeAlias = str
    Millionths: TypeAlias = str
    Levelled: TypeAlias = str
    Source: TypeAlias = str
else:
    Verdict = Literal["unchanged", "seat", "block", "cannot tell"]
    Apparent = Literal["unchanged", "seat", "block"]
    Reason = Literal[tuple(" and ".join(some) for count in (1, 2, 3) for some in combinations(REASONS, count))]
    Millionths = Literal["ppm", "urad", "ug", "ug/g", "ug/g^2", "ug/g^3"]
    Levelled = Literal["once", "anew"]
    Source = Literal["alpha1", "alpha2", "platform", "encoder"]
_UNIQUE: Final = Meta(extra_json_schema={"uniqueItems": True})

NameT = TypeVar("NameT")
UnitT = TypeVar("UnitT")


class Difference(Document, Generic[NameT, UnitT]):
    """u: Standard uncertainty of the difference; null: a result has none.
    in_u: The difference over u; null where u is unknown or 0.
    """

    name: NameT
    difference: float
    u: Size | None
    in_u: float | None
    unit: UnitT


class OfParameter(Difference[Parameter, Millionths]):
    """p: How often one of them is as far off by chance: after Holm. null without uncertainties."""

    p: Share | None
    changed: bool


class OfSeat(Difference[Literal["seat_x", "seat_y", "seat_z"], Literal["urad"]]):
    pass


class OfCoefficient(Difference[Coefficient, Text]):
    pass


class Explained(Document):
    name: Parameter
    difference: float
    u: Positive
    unit: Millionths
    p: Share


class ResultSummary(Document, kw_only=True):
    """From its result; null: unknown.

    passed: Whether it passed: gravity check, fit and uncertainty.
    pass_reason: Why it did not pass. Of uncertainty alone the verdict is NOT SHOWN, and its numbers are compared as
        others are.
    uncertainties: Whether it states any.
    temperature_c: Lowest and highest.
    """

    file: str
    created: str | None
    run_file: str | None
    serial: str | None
    estimator: str
    item: Labels | None
    passed: bool = field(name="pass")
    pass_reason: Reason | None
    uncertainties: bool
    temperature_c: tuple[float, float] | None
    gravity_m_s2: Positive | None


class Test(Document):
    """p: How often chi2 is as large by chance."""

    chi2: Size
    dof: Count
    p: Share


class Alone(Document):
    """Of the parameter that stands out most: its p times their number."""

    p: Share


class AfterHolm(Document):
    """p of the three questions (whole: of block), corrected for asking three; below 1 - confidence it counts."""

    whole: Share
    alone: Share
    seat: Share


class Tests(Document):
    """all: Of the twelve differences.
    block: Of the parameters.
    seat: Of the three angles.
    """

    all: Test
    block: Test
    alone: Alone
    seat: Test
    after_holm: AfterHolm


class Shared(Document):
    """stand: File or name of the stand of both; null: none is known.
    sources: Errors of the stand that both have in common and that count once; null: no stand of both is known, or it
        does not give the uncertainties that the results state.
    """

    stand: str | None
    levelled: Levelled | None
    sources: Annotated[tuple[Source, ...], _UNIQUE] | None


class Comparison(Document, kw_only=True):
    """What tumble compare prints with --json: two calibrations of one block. Differences are B less A. Unknown is null,
    never NaN.

    verdict: Whether the block has changed, only its seat, or neither; cannot tell: a result has no uncertainties, or
        failed its check.
    apparent: What the numbers alone say. It is the verdict, but where a result failed its check: then nothing firm can
        be said. null without uncertainties.
    confidence: The least share of untouched blocks that are called unchanged.
    changed: Names of the parameters that have changed by themselves; none of a block that has not changed.
    explained_by: The one parameter whose change alone would explain the difference, by how much it would have changed,
        and the p of what that leaves: 0.01 or more. null where none does, and of a block that has not changed.
    assumes: What the one or the other result rests on, as assumes of tumble.result/1.
    unit: Of the outputs of both.
    parameters: What does not depend on how the block sits: scale_x, scale_y, scale_z, relative, in ppm; angle_xy,
        angle_xz, angle_yz in urad; bias_x, bias_y, bias_z in ug; further terms where both results have them.
    seat: Turn of the block in its seat, about its axes x, y and z, if nothing else has changed.
    coefficients: K row by row, U0, then further terms where both results have them.
    tests: null without uncertainties.
    warnings: Sentences that a person is told on stderr beside the comparison.
    notes: What the comparison rests on, and what it leaves out.
    """

    schema: Literal["tumble.comparison/1"] = COMPARISON
    verdict: Verdict
    apparent: Apparent | None
    confidence: Annotated[float, Meta(ge=0.5, le=0.999999)]
    changed: Annotated[tuple[Parameter, ...], _UNIQUE]
    explained_by: Explained | None
    assumes: Annotated[tuple[Name, ...], _UNIQUE]
    a: ResultSummary
    b: ResultSummary
    unit: Annotated[str, Meta(min_length=1, max_length=16)]
    parameters: Annotated[tuple[OfParameter, ...], Meta(min_length=9)]
    seat: Annotated[tuple[OfSeat, ...], Meta(min_length=3, max_length=3)]
    coefficients: Annotated[tuple[OfCoefficient, ...], Meta(min_length=12)]
    tests: Tests | None
    shared: Shared
    warnings: tuple[Text, ...]
    notes: tuple[Text, ...]

"""tumble.fixture/1: a stand, judged by the runs made on it, as `fixture check` prints it."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Annotated, Final, Literal, TypeAlias

from msgspec import UNSET, Meta, UnsetType, field

from tumble.documents.base import Count, Document, Matrix, Size, SizeMatrix, Sizes, Vector, exactly
from tumble.documents.result import Fit, Inclination, StandSeen

FIXTURE: Final = "tumble.fixture/1"

Assumption: TypeAlias = Annotated[str, exactly("[a-z_]+")]
if TYPE_CHECKING:
    Against: TypeAlias = str
    Levelled: TypeAlias = str
else:
    Against = Literal["declared", "needed"]
    Levelled = Literal["once", "anew"]


class Verdict(str, Enum):
    """What the runs say about a source and its limit."""

    MEETS = "meets"
    DOES_NOT_MEET = "does not meet"
    CANNOT_TELL = "cannot tell"


class RunOnStand(Document):
    """passed: Of the gravity check.
    fit: As fit of tumble.result/1.
    stand_seen: As stand_seen of tumble.result/1, but with uncertainties from the run itself where it has any.
    inclinations: As inclinations of tumble.result/1.
    """

    file: str
    passed: bool = field(name="pass")
    max_abs_delta_g_g: Size
    fit: Fit | None
    stand_seen: StandSeen
    inclinations: tuple[Inclination, ...] | UnsetType = UNSET


class Judged(Document):
    """limit: null: no requirement."""

    limit: Size | None
    verdict: Verdict


class Judgement(Document):
    """value: From the runs: a systematic angle with its sign if it is one draw, the root mean square of several draws,
        or a standard deviation; null: the runs do not show it.
    limit: The limit that decides; null: no requirement.
    chi_squared: Of the measured values, if the source were as declared.
    sigma_low: Standard deviations from here ...
    sigma_high: ... to here are compatible with the measured values.
    """

    value: float | None
    u: Size | None
    limit: Size | None
    verdict: Verdict
    chi_squared: Size | None
    freedom: Size | None
    sigma_low: Size | None
    sigma_high: Size | None


class Source(Judgement):
    """declared: Against the stand file: a standard deviation.
    needed: Against what the limit of the gravity check needs: for a systematic angle the largest it may be now, else a
        standard deviation; null where the stand file says nothing of the block.
    """

    declared: Judged
    needed: Judged | None


class Sources(Document):
    """inclination_rad: Of runs on a stand that is inclined, where the stand file declares how well."""

    alpha1_rad: Source
    alpha2_plus_alpha3_rad: Source
    alpha3_difference_rad: Source
    alpha4_rad: Source
    noise_v: Source
    inclination_rad: Source | UnsetType = UNSET


class Units(Document):
    K: str
    U0: str


class Combined(Document):
    """K: null, like U0, u_K and u_U0, where the runs are not consistent.
    chi_squared: Of the differences between the runs.
    consistent: False: other blocks, or a stand that is not as declared.
    """

    units: Units
    K: Matrix | None
    U0: Vector | None
    u_K: SizeMatrix | None
    u_U0: Sizes | None
    chi_squared: Size
    freedom: Count
    chi_squared_limit: Size
    consistent: bool


class Fixture(Document, kw_only=True):
    """What tumble fixture check prints with --json: a stand, judged by the runs made on it. Angles in rad, noise in
    volts for outputs in V, mV, uV or kV, else in the unit of the outputs.

    stand: Its name in the stand file.
    confidence: Of all verdicts together.
    against: Which limits decide.
    levelled: Once for all runs, or again before each; as given or as the runs show.
    runs: Per file: gravity check, fit, and the stand as the run shows it.
    sources: By name: `value`, `u` as the runs show it, `limit`, `verdict` ("meets", "does not meet", "cannot tell"),
        `chi_squared` with `freedom`, the range `sigma_low` to `sigma_high` of standard deviations that fit what was
        seen; `declared` and `needed`, each with `limit` and `verdict`, of which `against` says which one counts.
    assumes: Assumptions of coefficients and combined, as assumes of tumble.result/1; with assumed_for.
    warnings: The warnings on stderr.
    combined: Several runs of one block as one result: whether they are `consistent`, and if so `K`, `U0`, `u_K`,
        `u_U0`; null for one run.
    passed: No verdict is "does not meet", and every run passes the gravity check and, where the verdict goes by
        `declared`, fits: exit 0, else 1.
    """

    schema: Literal["tumble.fixture/1"] = FIXTURE
    stand: str
    confidence: Annotated[float, Meta(ge=0.5, le=0.9999)]
    against: Against
    levelled: Levelled
    delta_g_limit_g: Annotated[float, Meta(gt=0, le=1)]
    runs: Annotated[tuple[RunOnStand, ...], Meta(min_length=1)]
    sources: Sources
    assumes: Annotated[tuple[Assumption, ...], Meta(extra_json_schema={"uniqueItems": True})] = ()
    assumed_for: dict[Assumption, tuple[str, ...]] = field(default_factory=dict)
    warnings: tuple[Annotated[str, Meta(min_length=1)], ...] = ()
    combined: Combined | None
    passed: bool = field(name="pass")

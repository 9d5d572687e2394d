"""tumble.import/1: what `import` found in recordings, and what it took for granted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Literal, TypeAlias

from msgspec import Meta

from tumble.documents.base import Document, Matrix, PlaceNumber, Size, Vector, exactly
from tumble.documents.result import AtLeastOne

IMPORT: Final = "tumble.import/1"

if TYPE_CHECKING:
    Order: TypeAlias = str
    Sign: TypeAlias = int
    State: TypeAlias = str
else:
    Order = Literal["schedule", "any"]
    Sign = Literal[1, -1]
    State = Literal["taken", "joined", "repeated", "off", "no position", "left out"]


class Recording(Document):
    file: str
    sha256: Annotated[str, exactly("[0-9a-f]{64}")]
    rows: AtLeastOne


class Thresholds(Document):
    """What is called a rest. Lengths in seconds, or of recordings without a clock in samples; the others are null."""

    window_s: float | None
    min_rest_s: float | None
    window_samples: int | None
    min_rest_samples: int | None
    still: float
    drift: float
    tolerance_deg: float


class Rest(Document):
    """file: Which of the recordings, from 1.
    first_row: Line of that file.
    position: null, like mounting: at none.
    off_rad: From its position, or from the nearest attitude of the schedule.
    """

    file: AtLeastOne
    first_row: AtLeastOne
    last_row: AtLeastOne
    from_s: float | None
    to_s: float | None
    samples: AtLeastOne
    mounting: PlaceNumber | None
    position: PlaceNumber | None
    state: State
    off_rad: Size
    mean: Vector


class Missing(Document):
    """A position of the schedule without a rest."""

    mounting: int
    position: int


class Import(Document, kw_only=True):
    """What tumble import prints with --json.

    tumble: Version.
    unit: Of the outputs; null: nobody says.
    signs: Of K_xx, K_yy, K_zz; null: nobody says, taken for positive, or given by the labels.
    by_labels: Positions by the rows' own labels, which gravity confirmed.
    noise: Standard deviation of a sample at rest, x, y, z.
    K: Rough: for matching.
    spread_rad: Usual distance of a rest from its position.
    assumed: What was taken for granted, and what was found.
    """

    schema: Literal["tumble.import/1"] = IMPORT
    tumble: str
    recordings: Annotated[tuple[Recording, ...], Meta(min_length=1)]
    schedule: str
    unit: str | None
    order: Order
    signs: tuple[Sign, Sign, Sign] | None
    by_labels: bool
    thresholds: Thresholds
    noise: Vector
    rests: tuple[Rest, ...]
    missing: tuple[Missing, ...]
    K: Matrix
    U0: Vector
    spread_rad: Size
    assumed: tuple[str, ...]

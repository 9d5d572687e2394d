"""The part of tumble.result/1 about the last calibration of a block, where a run was solved with it."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from tumble.documents.base import Count, Document, Number, Share, Size, Vector, exactly

Parameter: TypeAlias = Annotated[str, exactly("[a-z_]+")]


class OfParameters(Document):
    """Of the block's parameters, x, y, z, or xy, xz, yz.

    scale: Relative.
    """

    scale: Vector
    angle_rad: Vector
    bias_g: Vector


class Change(Document):
    """Of a parameter, if it alone has changed: its size and standard uncertainty."""

    parameter: Parameter
    size: Number
    u: Size
    unit: Literal["ppm", "urad", "ug"]


class Prior(Document, kw_only=True):
    """The last calibration of a block, and whether the run agrees with it.

    source: Its file, or its history with block and day.
    created: When it was measured.
    days: From then to this run.
    growth: Standard deviations of what may have changed in these days.
    growth_by: Who says so: declared, or the history of its type.
    drift: What is expected to have changed in these days, by the history; the values that were used have it in them.
    chi2: Of the difference of run and prior, in units of their joint covariance, with `dof` degrees of freedom.
    p: How often a block that has not changed comes out above.
    used: Whether they agree, at the confidence of `fit`. If not, all other numbers of the result are those of the run
        alone.
    changes: Parameters that explain the difference by themselves, by more than three standard uncertainties, the
        likeliest first.
    undetermined: Coefficients that the run alone does not determine.
    u_norm_worst_without_g: Worst standard uncertainty of |a| by the run alone; null where any is undetermined.
    u_norm_worst_alone_g: The same by the prior alone, on the day of the run.
    """

    source: str
    created: Annotated[str, exactly("[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}Z")]
    days: Size
    growth: OfParameters
    growth_by: Literal["declared", "history"]
    drift: OfParameters
    chi2: Size
    dof: Count
    p: Share
    used: bool
    changes: tuple[Change, ...] = ()
    undetermined: tuple[Annotated[str, exactly("(K_[xyz][xyz]|U0_[xyz])")], ...] = ()
    u_norm_worst_without_g: Size | None
    u_norm_worst_alone_g: Size

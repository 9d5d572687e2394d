"""Results as they are held against each other."""

from __future__ import annotations

from tumble.comparison import pair, report
from tumble.defaults import DEFAULT_CONFIDENCE
from tumble.documents.comparison import Comparison
from tumble.documents.result import Result
from tumble.solving.decision import complaints_of_result


def side_of(name: str, checked: Result) -> pair.Side:
    """A result, called `name`, as it was read. Raises BadInput."""
    return pair.Side.of(name, checked, complaints_of_result(checked))


def since(earlier: Result, later: Result) -> Comparison:
    """What has changed, for a report on the later one: schema tumble.comparison/1, by what the results themselves tell.
    Raises BadInput."""
    sides = side_of("the earlier result", earlier), side_of("this result", later)
    return report.document(pair.compare(*sides, None, DEFAULT_CONFIDENCE))

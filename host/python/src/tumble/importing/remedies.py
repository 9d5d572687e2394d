"""The remedy of a refusal, found by trying: what it advises, then what the user says left out, option by option.

What a refusal advises may lead to the next refusal, whose advice is followed in turn. So an import with these options
has been done.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping

from tumble.errors import Remedy, TumbleError, listed
from tumble.schedule import ANY_POSE

_DEEPEST = 6  # refusals on one way
_MOST_ROWS = 2_000_000  # that are read for it, at all
_MOST = 40  # tries
NAMED = ("columns", "mountings", "leave_out")  # options of several parts, which are joined
_SUSPECTS = (  # that may be why, if the user says them
    "rate", "time_unit", "min_rest", "window", "still", "drift", "tolerance", "schedule", "signs", "order", "rows",
    "unit", "decimal", "delimiter", "mountings", "columns", "leave_out", "take", "can_id", "can_channel",
)  # fmt: skip
_HABITS = (  # of people and loggers
    Remedy({"order": "any"}),
    Remedy({"min_rest": "0.3"}),
    Remedy({"window": "16", "min_rest": "24"}),  # samples, where there is no clock
    Remedy({"columns": "time="}, "the time column is not a clock"),
)


def found(
    refusal: TumbleError,
    said: Mapping[str, str],
    rows: int,
    attempt: Callable[[dict[str, str | None]], TumbleError | int],
) -> Remedy | None:
    """What makes `attempt` succeed, if anything does that is worth a try. `said`: the options of the user, by name;
    `rows`: of the recordings, roughly; `attempt`: with other options, how many positions are missing then."""
    best: tuple[int, Remedy] | None = None
    tries = min(_MOST, _MOST_ROWS // max(rows, 1))
    tried: set[frozenset[tuple[str, str | None]]] = set()

    def follow(way: Remedy, advised: Iterable[Remedy]) -> Remedy | None:
        nonlocal tries, best
        for options, condition in advised:
            chosen = joined(way.options, options)
            key = frozenset(chosen.items())
            if key in tried or tries <= 0 or len(chosen) > _DEEPEST:
                continue
            tried.add(key)
            tries -= 1
            conditions = [one for one in (way.condition, condition) if one]
            after, on = attempt(chosen), Remedy(chosen, " and ".join(dict.fromkeys(conditions)))
            if after == 0:
                return on
            if isinstance(after, int) and (best is None or after < best[0]):
                best = after, on
            if (whole := follow(on, _HABITS if isinstance(after, int) else after.remedies)) is not None:
                return whole
        return None

    whole = follow(Remedy({}), (*refusal.remedies, *_suspected(said)))
    return whole or (None if best is None else best[1])


def joined(options: Mapping[str, str | None], further: Mapping[str, str | None]) -> dict[str, str | None]:
    """Both; of options of several parts, NAME=VALUE or numbers, all parts."""
    both = {**options, **further}
    for name in NAMED:
        one, other = options.get(name), further.get(name)
        if one and other:
            parts = [part for part in one.split(",") if part.partition("=")[0] not in _names(other)]
            both[name] = ",".join([*parts, other])
    return both


def _names(parts: str) -> set[str]:
    return {part.partition("=")[0] for part in parts.split(",")}


def _suspected(said: Mapping[str, str]) -> Iterator[Remedy]:
    """Each option of the user's left out, which may be the cause; then two at a time; then what helps elsewhere."""
    suspects = [name for name in _SUSPECTS if said.get(name)]
    for names in (*itertools.combinations(suspects, 1), *itertools.combinations(suspects, 2)):
        told = listed([f"--{name.replace('_', '-')} {said[name]}" for name in names])
        yield Remedy(dict.fromkeys(names), f"{told} {'is' if len(names) == 1 else 'are'} the cause")
    if said.get("schedule") != ANY_POSE:  # there any rests fit, so a guess is never wrong
        yield from (one for one in _HABITS if not set(one.options) & set(said) or "columns" in one.options)

"""Runs on a declared stand, drawn thousands at a time; and one stream of random numbers, cut for others to go on with.

A seed means one stream, whoever draws from it. Normal numbers take from it as many bits as they happen to need, so
where a later chunk begins is known only to whoever has drawn all before: whoever cuts the stream draws as well, and
leaves what is computed from the numbers to others.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np

from tumble.arrays import Floats
from tumble.model.errors import Source, exact_outputs
from tumble.schedule import Schedule
from tumble.stand import SIGMA
from tumble.workers.over import Piece

Sources: TypeAlias = dict[str, Source]
Chunk: TypeAlias = "tuple[int, dict[str, Any]]"  # runs, and the state of the stream where they begin
_RUNS = 2000  # at a time: part of what a seed means


def chunks(errors: Sources, limits: str, runs: int, seed: int) -> Iterator[Piece]:
    """Of a campaign of `runs`, each a Chunk that `stream_of` goes on with."""
    rng = np.random.default_rng(seed)
    for start in range(0, runs, _RUNS):
        if start:
            _draws(errors, limits, _RUNS, rng)
        count = min(_RUNS, runs - start)
        yield Piece(f"runs {start} to {start + count - 1}", (count, rng.bit_generator.state), count)


def stream_of(chunk: Chunk) -> np.random.Generator:
    """Random numbers from the beginning of a chunk on."""
    rng = np.random.default_rng(0)
    rng.bit_generator.state = chunk[1]
    return rng


def drawn_outputs(
    schedule: Schedule, k: Floats, u0: Floats, errors: Sources, limits: str, runs: int, rng: np.random.Generator
) -> Floats:
    """Outputs (runs, positions, 3) of the exact geometry, every error drawn anew for every run: by a uniform law where
    the stand's `limits` are half-widths, but noise, which is normal, by a normal one."""
    return exact_outputs(schedule, k, u0, errors, np.concatenate(_draws(errors, limits, runs, rng), axis=1))


def _draws(errors: Sources, limits: str, runs: int, rng: np.random.Generator) -> list[Floats]:
    laws = [(SIGMA if source.normal else limits, len(source.sigma)) for source in errors.values()]
    return [unit_draws(rng, law, (runs, count)) for law, count in laws]


def unit_draws(rng: np.random.Generator, limits: str, shape: tuple[int, int]) -> Floats:
    """Numbers of mean 0 and variance 1; of a uniform law where the stand declares half-widths."""
    return rng.uniform(-(3.0**0.5), 3.0**0.5, shape) if limits == "uniform" else rng.standard_normal(shape)

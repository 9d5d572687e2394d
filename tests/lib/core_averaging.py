"""The core's averaging of raw counts, for tests in Python: exact integer sums per position, gates, counters."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from _tumble_core import ffi, lib

from tumble.core import require_ok

MAX_DEVIATION_COUNTS: int = lib.TUMBLE_MAX_DEVIATION_COUNTS


@dataclass(frozen=True)
class AveragingConfig:
    """The gates. Counts are raw converter counts.

    `saturation_counts`: at or beyond it a sample is refused; `min_samples` of a finished position; `max_lost` samples;
    `stuck_run` equal values in a row (0: gate off); `noise_counts` declared for one sample (0: stillness gate off);
    `stillness_ratio`: scatter over declared noise that still counts as still.
    """

    saturation_counts: int = 2**31 - 1
    min_samples: int = 1
    max_lost: int = 0
    stuck_run: int = 0
    noise_counts: float = 0.0
    stillness_ratio: float = 1.0


class Averaging:
    """One block's averaging state. Positions are indices into a schedule.

    Every method raises CoreRefusal where the core refuses; a refused sample changes neither sums nor scatter.
    """

    def __init__(self, config: AveragingConfig | None = None):
        self._config = ffi.new("tumble_averaging_config_t *", asdict(config or AveragingConfig()))
        self._state = ffi.new("tumble_averaging_t *")
        self._sample = ffi.new("tumble_sample_t *")
        require_ok(lib.tumble_averaging_init(self._state, self._config))

    @property
    def state(self):
        """The core's own struct."""
        return self._state

    def begin(self, index: int) -> None:
        """Open a position, forgetting what it held."""
        require_ok(lib.tumble_averaging_begin(self._state, index))

    def add(self, counts: tuple[int, int, int], counter: int) -> None:
        """Take one sample of three int32 counts; `counter` is the block's own, 0 to 65535."""
        self._sample.counts = counts
        self._sample.counter = counter
        require_ok(lib.tumble_averaging_add(self._state, self._config, self._sample))

    def finish(self) -> None:
        """Close the open position and judge it."""
        require_ok(lib.tumble_averaging_finish(self._state, self._config))

    def mean(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard error (counts, both (3,)) of a finished position."""
        return self._pair(lambda mean, error: lib.tumble_averaging_mean(self._state, index, mean, error))

    def running(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard error (counts, both (3,)) of the open position so far."""
        return self._pair(lambda mean, error: lib.tumble_averaging_running(self._state, mean, error))

    @staticmethod
    def _pair(call) -> tuple[np.ndarray, np.ndarray]:
        mean, error = np.empty(3), np.empty(3)
        require_ok(call(ffi.from_buffer("double[]", mean), ffi.from_buffer("double[]", error)))
        return mean, error

    def means(self, v_per_count: float, positions: int) -> tuple[np.ndarray, np.ndarray]:
        """Means (positions, 3) in volts and which of them are measured, as the estimators take them."""
        struct = ffi.new("tumble_means_t *")
        require_ok(lib.tumble_averaging_means(self._state, v_per_count, struct))
        values = np.frombuffer(ffi.buffer(struct.u_v)).reshape(-1, 3)[:positions].copy()
        return values, np.frombuffer(ffi.buffer(struct.measured), dtype=bool)[:positions].copy()

    @property
    def samples(self) -> int:
        """Samples in the open position so far; 0 when none is open."""
        return lib.tumble_averaging_samples(self._state)

    @property
    def counters(self) -> dict[str, int]:
        """What was refused or missed since the start, by name."""
        counters = self._state.counters
        return {name: getattr(counters, name) for name in dir(counters)}

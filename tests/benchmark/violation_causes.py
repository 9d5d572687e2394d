"""Which cause `solve` names first, for thousands of runs at once: the search of tumble.model.fit on one
stand, linear in the outputs, as K and the stand's errors are small. `tests/integration/test_outside_the_model.py` holds
it against the search itself, run by run.
"""

import math
from functools import cached_property

import numpy as np

from tumble import model
from tumble.distributions import chi_squared_log_above
from tumble.model.fit import ALIKE, CONFIDENCE, EXPLAINED, SYSTEMATIC, basis, variance_of_means
from tumble.model.patterns import BY_NAME, PATTERNS

_CONTAINED = 0.9999
_NULL = 1e-7
_GRID = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 6000)])  # of the root of a chi-squared


class Causes:
    """For runs of a block with `k`, `u0` on a `stand`."""

    def __init__(self, schedule, stand, k, u0):
        self._ideal = model.Geometry(schedule).outputs(k, u0)
        variance = variance_of_means(stand, np.full(len(self._ideal), stand.samples), 0.0)
        self._model = model.WholeModel(schedule, self._ideal, variance, stand)
        whole = np.eye(self._ideal.size).reshape(-1, *self._ideal.shape)
        self._whiten = self._model.whitened(dict(enumerate(whole)))
        self._pairs, self._tails = {}, {}

    @property
    def freedom(self):
        """Degrees of freedom of chi-squared."""
        return self._model.freedom

    def shown(self, outputs):
        """What remains of outputs (runs, positions, 3), whitened: (runs, freedom)."""
        return outputs.reshape(-1, self._whiten.shape[1]) @ self._whiten.T

    def rest(self, means):
        """The same of runs."""
        return self.shown(means - self._ideal)

    @cached_property
    def _variants(self):
        """By pattern: its columns at every place where the residuals show it, with an orthonormal basis."""
        besides = {}
        for name in SYSTEMATIC:
            besides |= {f"{name} {label}": one for label, one in self._columns(name)[0].items()}
        known = self._space(besides)
        found = {}
        for pattern in PATTERNS:
            spaces = [(columns, self._space(columns)) for columns in self._columns(pattern.name)]
            if pattern.random:
                spaces = [(columns, self._beside(self._model.whitened(columns), known)) for columns, _ in spaces]
            found[pattern.name] = [(columns, space) for columns, space in spaces if space.shape[1]]
        return {name: variants for name, variants in found.items() if variants}

    def _columns(self, name):
        return BY_NAME[name].columns(self._model.scene)

    def _space(self, columns):
        return basis(self._model.whitened(columns))

    @staticmethod
    def _beside(shown, known):
        left = shown - known @ (known.T @ shown)
        lost = np.linalg.norm(left, axis=0) <= _NULL * np.linalg.norm(shown, axis=0)
        return basis(np.where(lost, 0.0, left))

    def _log_p(self, squares, freedom):
        """Of chi-squared, by a table."""
        if freedom not in self._tails:
            self._tails[freedom] = np.array([chi_squared_log_above(root * root, freedom) for root in _GRID])
        return np.interp(np.sqrt(squares), _GRID, self._tails[freedom])

    def first(self, rest, fits, among=tuple(BY_NAME)):
        """The names of the first explanation of every run, empty where there is none; of names that cannot be told from
        the likeliest only those `among`. `fits`: which runs do as a whole."""
        best, log_p = {}, {}
        for name, variants in self._variants.items():
            tested = [self._log_p(((rest @ space) ** 2).sum(axis=1), space.shape[1]) for _, space in variants]
            best[name] = np.argmin(tested, axis=0)
            log_p[name] = np.min(tested, axis=0) + math.log(len(variants))
        names = list(self._variants)
        order = np.argmin([log_p[name] for name in names], axis=0)
        found = []
        for run, one in enumerate(order):
            name = names[one]
            if (len(PATTERNS) + 1) * math.exp(log_p[name][run]) > (1 - CONFIDENCE if fits[run] else EXPLAINED):
                found.append(())
                continue
            others = [other for other in names if other != name and other in among]
            alike = [o for o in others if self._may_be((name, best[name][run]), (o, best[o][run]), rest[run])]
            found.append((name, *alike))
        return found

    def _may_be(self, one, other, rest):
        """Whether another pattern explains as well what one does."""
        if BY_NAME[one[0]].random or BY_NAME[other[0]].random:
            return False
        if (one, other) not in self._pairs:
            self._pairs[one, other] = self._compare(one, other)
        own = self._pairs[one, other]
        if own is None:
            return False
        log_p = self._log_p(((own.T @ rest) ** 2).sum(), own.shape[1]) if own.shape[1] else 0.0
        places = len(self._variants[one[0]])
        return (len(PATTERNS) + 1) * places * math.exp(log_p) > EXPLAINED

    def _compare(self, one, other):
        """What one shows beside the other: a basis; None where they do not look alike."""
        spaces = [self._variants[name][place][1] for name, place in (one, other)]
        cosines = np.linalg.svd(spaces[0].T @ spaces[1], compute_uv=False)
        wider = spaces[1].shape[1] > spaces[0].shape[1] and bool((cosines > _CONTAINED).all())
        if wider or cosines.max() < ALIKE:
            return None
        return self._beside(self._model.whitened(self._variants[one[0]][one[1]][0]), spaces[1])

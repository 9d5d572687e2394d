"""Results made of coefficients and a covariance that a test states."""

import numpy as np

U = np.concatenate([np.full(9, 2e-5), np.full(3, 1e-5)])


def result(k, u0, covariance=None, **more):
    """A document of schema tumble.result/1 with as much as whoever uses its coefficients needs; `more` of its keys."""
    u = None if covariance is None else np.sqrt(np.diag(covariance))
    document = {
        "schema": "tumble.result/1",
        "estimator": "refined",
        "unit": "V",
        "K": np.asarray(k).tolist(),
        "U0": np.asarray(u0).tolist(),
        "u_K": None if u is None else u[:9].reshape(3, 3).tolist(),
        "u_U0": None if u is None else u[9:].tolist(),
        "covariance": None if covariance is None else np.asarray(covariance).tolist(),
        "verification": {"pass": True, "max_abs_delta_g_g": 1e-5, "limit_g": 3e-4},
    }
    return {**document, **more}

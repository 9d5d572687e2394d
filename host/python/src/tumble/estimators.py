"""The estimators and the coefficients that they find, by name: typed here once for options, core, gains and reports."""

PAPER = ("averaged", "refined")  # closed forms on the paper's positions
LINEAR = (*PAPER, "least_squares")  # that need no stand
OPTIMAL = "optimal"  # weighs by the stand's errors
ESTIMATORS = (*LINEAR, OPTIMAL)

COEFFICIENTS = (*(f"K_{i}{j}" for i in "xyz" for j in "xyz"), *(f"U0_{i}" for i in "xyz"))

"""The estimators by name: typed here once for the options of the command line, the core, and the gains."""

PAPER = ("averaged", "refined")  # closed forms on the paper's positions
LINEAR = (*PAPER, "least_squares")  # that need no stand
OPTIMAL = "optimal"  # weighs by the stand's errors
ESTIMATORS = (*LINEAR, OPTIMAL)

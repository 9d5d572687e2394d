"""The estimators and the coefficients that they find, by name, for options, core, gains and reports.

The tuples are written by tools/estimators.py from the table in tumble/core.h: a command line is parsed without the
core.
"""

HARMONIC = ("averaged", "refined")  # closed forms, on circles through two block axes
LINEAR = ("averaged", "refined", "least_squares", "inclined")  # that need no stand
ESTIMATORS = ("averaged", "refined", "least_squares", "optimal", "inclined")
OPTIMAL = "optimal"  # weighs by the stand's errors

COEFFICIENTS = (*(f"K_{i}{j}" for i in "xyz" for j in "xyz"), *(f"U0_{i}" for i in "xyz"))

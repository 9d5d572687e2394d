"""The estimators and the coefficients that they find, by name, for options, core, gains and reports.

The tuples are written by tools/estimators.py from the table in tumble/core.h: a command line is parsed without the
core.
"""

# Closed forms, on circles through two block axes.
HARMONIC = ("averaged", "refined")
# In the outputs, of blocks that are bolted on in every mounting.
LINEAR = ("averaged", "refined", "least_squares")
ESTIMATORS = ("averaged", "refined", "least_squares", "optimal", "inclined")
LEAST_SQUARES = "least_squares"  # of any schedule
OPTIMAL = "optimal"  # weighs by the stand's errors
INCLINED = "inclined"  # of a block that is bolted on once: finds its inclinations, too
NORM = "norm"  # of poses that nobody knows: by |a| alone, nine coefficients; for solve, no firmware has it
INCLINATIONS = (  # what inclined needs
    "three inclinations or more of one bolting, on both sides of the level, at table angles that divide a turn equally"
)

COEFFICIENTS = (*(f"K_{i}{j}" for i in "xyz" for j in "xyz"), *(f"U0_{i}" for i in "xyz"))

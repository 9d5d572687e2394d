"""What holds unless somebody says otherwise: for callers, and for the command line, which loads no numpy for it."""

DEFAULT_ESTIMATOR = "refined"  # where a schedule goes round whole circles; of a block bolted on once and inclined:
DEFAULT_INCLINED = "inclined"
DEFAULT_LIMIT_G = 3e-4  # of the gravity check
DEFAULT_COVERAGE_FACTOR = 3.0  # of u(|a|): the limit is three sigma of the length of a calibrated acceleration
DEFAULT_CONFIDENCE = 0.999  # at which a run must fit its stand
DEFAULT_SCHEDULE = "paper"
UNDECLARED_RAD = 5e-3  # by which simulated inclinations err that nobody declares

NEEDS_STAND = "--estimator optimal weighs the means by the stand's errors: it needs --stand FILE"
ONCE, ANEW = LEVELLED = ("once", "anew")  # when a stand was levelled: for all runs, before each of them

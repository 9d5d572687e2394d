"""From a run to a stated result, for the command line, the bench, fixture checks and plans.

The core computes, the numpy witness confirms, and only then is there a solution with its uncertainties.

    solution     solve a run; what is known afterwards
    computation  what the core makes of the means
    optimal_run  the optimal estimator for one run: weights made for it (gains, gain_record), evaluated by the core
    uncertainty  the standard uncertainties that a result states
    noise        the noise that a run itself shows, and where it counts
    assumptions  what a result rests on that nobody tested
    stand_seen   the stand's errors as the run shows them
    crosscheck   core against witness; a disagreement gives no result
    result       the document that is written of a solution, schema tumble.result/1
"""

"""From a run to a stated result, for the command line, the bench, fixture checks and plans.

The core computes, the numpy model confirms, and only then is there a solution with its uncertainties.

    solution     solve a run; what is known afterwards
    computation  what the core makes of the means
    optimal_run  the optimal estimator for one run: weights made for it, their record, evaluated by the core
    further      further terms of the model, K2, K3 and drift: how they are found, and what they cost
    uncertainty  the standard uncertainties that a result states
    noise        the noise that a run itself shows, and where it counts
    coverage     how well the uncertainties are known, and by what factor to multiply them for 95 %
    temperature  where the coefficients hold: the temperatures of the run
    coefficients those of a result, in g or m/s^2, with K^-1 (si: in units of the SI)
    many_runs    thousands of runs at once, and whether they confirm a result's uncertainties; tables_of_runs
    declared     the stand and the schedule of a result, and when it was made
    expected     what the declared stand makes one expect of a result, source by source
    assumptions  what a result rests on that nobody tested
    crosscheck   core against model; a disagreement gives no result
    result       the document that is written of a solution, schema tumble.result/1
"""

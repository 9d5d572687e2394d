"""From a run to a stated result, for the command line, the bench, fixture checks and plans.

The core computes, the numpy model confirms, and only then is there a solution with its uncertainties.

    solution     solve a run; what is known afterwards
    computation  what the core makes of the means of one run or of many, held against the model; a disagreement gives
                 no result
    optimal_run  the weights of the optimal estimator: made for a run or for many, their record, evaluated by the core
    prior        what became of the last calibration of a block beside its run
    prior_run    a run solved with it
    hands        the stand of a block that is laid by hand
    noise        the noise that a run itself shows, and where it counts
    uncertainty  the standard uncertainties that a result states, of further terms too, and how well they are known
    plausibility is K that of the declared block; at which temperatures was it measured
    decision     what a result rests on, whether it passes, and what would show its limit
    result       the document that is written of a solution, schema tumble.result/1, and stand and schedule read back
    coefficients those of a result, in g or m/s^2, with K^-1
    expected     what the declared stand makes one expect of a result, source by source
    set_angles   a run on a stand whose set angles are known
    thermal      runs at several temperatures, together, and the decision on them
    many_runs    thousands of runs drawn from a stand, and whether they confirm a result's uncertainties
"""

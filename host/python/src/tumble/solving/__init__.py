"""From a run to a stated result, for the command line, the bench, fixture checks and plans.

The core computes, the numpy witness confirms, and only then is there a solution with its uncertainties.

    solution     solve a run; what is known afterwards
    computation  what the core makes of the means
    optimal_run  the optimal estimator for one run: weights made for it (gains, gain_record), evaluated by the core
    extended     further terms of the model, K2, K3 and drift; further: what is known of them and what they cost
    uncertainty  the standard uncertainties that a result states
    noise        the noise that a run itself shows, and where it counts
    coverage     how well the uncertainties are known, and by what factor to multiply them for 95 %
    temperature  where the coefficients hold: the temperatures of the run
    covariance   what the covariance of the coefficients says of what is computed from them (si: in units of the SI)
    coefficients those of a result, in g or m/s^2, with K^-1; force: what they make of outputs
    second_order what these leave out; monte_carlo: whether simulated runs confirm them (many_runs: solved at once)
    provenance   when, by what and from what a result was made
    stand_seen   the stand's errors as the run shows them
    expected     what the declared stand makes one expect of a result, source by source
    assumptions  what a result rests on that nobody tested
    crosscheck   core against witness; a disagreement gives no result
    result       the document that is written of a solution, schema tumble.result/1
"""

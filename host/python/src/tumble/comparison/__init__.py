"""Are two calibrations of one block the same?

calibration   one of the two: coefficients, and the parameters that do not depend on how the block sits
statistics    tests of the difference
verdict       neither, the seat, the block, or nobody can tell
shared        what both share of one stand
pair          from two results to a comparison
report        a comparison as a document of schema tumble.comparison/1
text          that document for people
"""

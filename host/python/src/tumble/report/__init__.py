"""A result as a report for people: one HTML file that needs no other, or the same as PDF.

    make         from a result's document to the bytes of a report: what `tumble report` and Result.report call
    source       what a report may say: every number and text of the document with its path, exact, as it is printed
    sections     who, what, where, when, and how; the coefficients; verdict and decision rule
    coefficients those of a result for other programs, by templates in exports
    thermal      those over temperature, likewise
    history      what a history says of a block, and its page in a browser
    temperatures the sections of a report on a calibration over temperature
    certificate  what a Digital Calibration Certificate says of one
    pages        the template (report.html.j2, report.css) filled in, numbered, and turned into PDF

The JSON result is authoritative: a report computes nothing but k times u, and rounds.
"""

"""A run as it goes, for people who look on: on a terminal or as a page in a browser. Whoever watches changes nothing.

snapshot            what is known of a run at one moment, and what a source must be able to tell
runs                asks a source again and again; a run of the bench as a source
node_run            a navigation computer as a source; from what the user calls a source to the source
terminal, server    show what has been found
"""

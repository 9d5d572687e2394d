"""Watch a run live, on a terminal or as a page in a browser. Watching changes nothing.

snapshot            the state of a run at one moment, and the interface of a source
runs                polls a source; a run of the bench as a source
node_run            a navigation computer as a source; opens the source that the user names
terminal, server    show the view
metrics, mqtt       export the view: to Prometheus, to an MQTT broker
"""

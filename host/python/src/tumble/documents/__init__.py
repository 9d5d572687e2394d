"""What the programs write as JSON, as types: documents are made of them, checked by them where they are read, and
described by them in docs/schemas and docs/files.md.

base         the kinds of numbers, arrays and texts; reading and writing
bench        tumble.bench/1, node/1, stand/1, replay/1 and log/1, of `bench`, `replay` and the programs
campaign     tumble.campaign/1 and tumble.hostile/1, of `campaign`
comparison   tumble.comparison/1, of `compare`
fixture      tumble.fixture/1, of `fixture check`
further      further terms of the model, in a result
history      tumble.history/1, of `history`
importing    tumble.import/1, of `import`
labels       the block and the day of a result, by keys or labels
plan         tumble.plan/1, of `plan`
prior        what tumble.result/1 says of the last calibration of a block
result       tumble.result/1, of `solve` and `bench`
store        tumble.store/1, of `store dump`
thermal      tumble.thermal/1, of `solve --temperature`
watch        tumble.watch/1, of `watch`

tools/schemas.py makes the JSON schemas of them.
"""

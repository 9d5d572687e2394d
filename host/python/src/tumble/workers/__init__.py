"""Work cut into pieces by its seeds, and whoever does it: this process, processes of this machine, or a cluster.

over     the one loop that all campaigns are: results in the order of their pieces, whoever did them, and in which order
pieces   what is handed out: a job, pieces, results; and what a worker does with them
local    processes of this machine; a dead one is replaced
cluster  Dask distributed, which is imported for --cluster alone
kept     what is done, as Parquet, to go on from
"""

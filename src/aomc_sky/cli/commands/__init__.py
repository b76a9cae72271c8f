"""The sub-commands, with what they print.

atmosphere/    aomc-sky atmosphere: the clear sky of an atmosphere description.
info/          aomc-sky info: what a file or folder contains.
lobes/         aomc-sky lobes: background skies without AMC files.
perez/         aomc-sky perez: one Perez sky, or a year of them, without AMC files.
plot/          aomc-sky plot: pictures of skies, runs and files.
bench          ``aomc-sky bench``: speed against error of our samplers and of the best peers, and the bars they ...
export         ``aomc-sky export``: other formats from a run folder
merge          ``aomc-sky merge``: the shards of a run become the run
run            ``aomc-sky run``: from amc.inp to a run folder
run_report     The texts that ``run`` prints: the table of a run, and what a dry run would model
shard_report   The texts of shards: what ``run --shard`` and ``merge`` print
validate       ``aomc-sky validate``: every problem of every file, and nothing else
verify         ``aomc-sky verify``: a run, or photons that another code made, against what they ought to be
verify_report  What ``verify`` prints and draws: a table of checks, and where the photons of a failed test lie off
"""

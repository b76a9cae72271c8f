"""The plan of a run: what every shard, export and check reads and never recomputes.

file         plan.npz as a stranger's file: its kind, its sizes and its members are judged before anything is read
laws         The rules of a plan's components: parameters of cells, and the tables that a law reads besides
members      One array of a plan as a line of a table: its type, its lengths, its range
options      The options of a plan: every key, what it may say, and what ties keys together
plan         What every shard, export and check reads and never recomputes: counts, cells, keys, options
problem      How a rule of the schema of plans says what is wrong
schema       What a plan may be: one table of its members, one of its options, and what ties them together
stream_keys  The keys of a plan's random streams: a pure function of its options, so that they can be made again
"""

"""Speed against error: the report of `aomc-sky bench`. Bars and other peers stand in `bench/`.

run         What a run measures, its results, their tables, CSV and JSON
skies       What shines, the same as a table for samplers that know patches alone, and the truth of each
quantities  The five quantities whose error is measured: their sums over photons, and their exact values
samplers    The samplers that are compared, ours and numpy's, and photons per second of each
accuracy    Errors over replicates and what they cost; convergence slopes, and the time until an error is reached
timing      Contenders take turns: medians and ratios, given with the machine
figure      Error against time: skies from top to bottom, quantities from left to right, a line per method
"""

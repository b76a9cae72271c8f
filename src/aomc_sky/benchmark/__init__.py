"""Speed against error: what each sampler costs and what accuracy it buys. Bars and other peers stand in `bench/`.

methods     The samplers of this package that are compared: names, and the options of `Scene.source` that they are
skies       What shines, the same as a table for samplers that know patches alone, and the truth of each
quantities  The five quantities whose error is measured, and their sums over emitted photons
quadrature  Integrals over the hemisphere and over a cone at two orders, whose difference is the stated error
truth       Exact values of the quantities, by sums over patches or by quadrature
timing      Contenders take turns: medians and ratios, given with the machine
accuracy    Errors over replicates and what they cost: the rows of the table
speed       Photons per second of our methods and of numpy's `choice`
trends      What the rows say together: convergence slopes, and the time until an error is reached
run         What a run measures, its results, CSV and JSON
tables      The tables of a run
figure      Error against time: skies from top to bottom, quantities from left to right, a line per method
"""

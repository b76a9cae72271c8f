"""The sub-commands, with what they print.

run          ``aomc-sky run``: from amc.inp to a run folder, or one shard of it
validate     ``aomc-sky validate``: report every problem of every file, and make no photons
info         ``aomc-sky info``: what a file or folder contains
plot         ``aomc-sky plot``: pictures of skies, runs and files
export       ``aomc-sky export``: other formats from a run folder
verify       ``aomc-sky verify``: check a run, or photons that another code made
perez        ``aomc-sky perez``: one Perez sky without AMC files
atmosphere   ``aomc-sky atmosphere``: the clear sky of an atmosphere description
"""

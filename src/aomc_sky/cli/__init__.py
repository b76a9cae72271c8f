"""The command line: parses and prints; heavy imports stay inside functions.

command    The first step of ``aomc-sky``, which hears Ctrl-C before anything else is imported
interrupts Ctrl-C while a command runs, also where numba's compiler hears none
main       ``aomc-sky``: runs one sub-command, with its streams, warnings and Ctrl-C, and reports why it failed: a text
           for a person, or one JSON object (`error.schema.json`)
usage      The parser: all sub-commands, help in two lengths, and usage errors that suggest the word that was meant
options    Options that several sub-commands share
values     Types of options, which turn their text into values
commands/  The sub-commands, with what they print
terminal   Texts of commands for a person: tables, reports and errors
background_report  The contents of a background-sky file: animations and spectra, and its lobes at one time
"""

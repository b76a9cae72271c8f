"""The command line: parses and prints; heavy imports stay inside functions.

main       ``aomc-sky``: its sub-commands, the streams, warnings and Ctrl-C of every one, and what is said of one that
           fails: a text for a person, or one JSON object (`error.schema.json`)
usage      The parser: help in two lengths, and usage errors that begin with what is wrong and name what was meant
options    Options that several sub-commands share, and the types that turn their text into values
commands/  The sub-commands, with what they print
terminal   What a command prints: streams that escape control characters, tables, warnings and errors
background_report  What a background-sky file holds: animations and spectra, and at one time its lobes
"""

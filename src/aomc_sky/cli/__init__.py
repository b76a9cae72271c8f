"""The command line: parses and prints; heavy imports stay inside functions.

main       ``aomc-sky``: the parser, the exit codes, and how errors, warnings and Ctrl-C reach a person
options    Options that several sub-commands share, and the types that turn their text into values
commands/  The sub-commands, with what they print
terminal   What the terminal behind a stream can show: tables, warnings and errors on it, plain text elsewhere
progress   Progress on standard error, when that is a terminal: a bar, the share done, the rate and the time left
"""

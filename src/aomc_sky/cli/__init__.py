"""The command line: parses and prints; heavy imports stay inside functions.

main       ``aomc-sky``: the exit codes, and how errors, warnings and Ctrl-C reach a person
parser     The parser: every sub-command by name, and the options of the one that was asked for
options    Options that several sub-commands share, and the types that turn their text into values
commands/  The sub-commands, with what they print.
table      Tables: rich ones or plain ones on a terminal, folded to its width, and plain whole ones everywhere else
progress   Progress on standard error, when that is a terminal: a bar, the share done, the rate and the time left
terminal   What the terminal behind a stream can show, and how warnings and errors stand on it
"""

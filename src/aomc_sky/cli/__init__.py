"""The command line: parses and prints; heavy imports stay inside functions.

commands/           The sub-commands, with what they print.
background_options  Options of a background sky: when it is looked at, and what of it
completion          ``aomc-sky completion``: completion scripts for shells, made from the parser
interrupts          Ctrl-C: remembered, for C code that it interrupts may answer with an error of its own
main                ``aomc-sky``: the parser, the exit codes, and how errors and warnings reach a person
notices             Warnings of a command: kept while it works, printed once each when it is done
options             Options that several sub-commands share, and the types that turn their text into values
parser_words        The words of a parser as data: sub-commands, options, and the values that they take
progress            Progress on standard error, when that is a terminal: a bar, the share done, the rate and the ...
table               Tables: rich ones or plain ones on a terminal, folded to its width, and plain whole ones ...
terminal            What the terminal behind a stream can show; a pipe, a file and a dumb terminal get plain text
"""

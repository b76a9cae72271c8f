"""The command line: parses and prints, one file per sub-command; heavy imports stay inside functions."""

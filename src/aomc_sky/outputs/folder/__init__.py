"""A run folder: its lock, its files, what may be replaced.

run_folder   The folder of one plan: it is claimed, its files appear when they are complete, and only ours are removed
target_file  Files and folders that a user names for output: what is there is replaced only where we wrote it
"""

"""A run folder: its lock, its files, what may be replaced.

run_folder   The folder of one run: its lock, and its files, which appear when they are complete
target_file  Output files and folders that a user names: only files that aomc-sky wrote are replaced
"""

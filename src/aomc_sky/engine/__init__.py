"""Every job: one scene into a run folder or a stream, and the hours of a year into one set of files."""

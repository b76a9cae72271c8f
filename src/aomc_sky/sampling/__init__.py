"""Mass, integer counts and streams: numbers and arrays only, never a sky or a file."""

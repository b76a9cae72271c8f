"""Pictures of the sky dome: sources, runs, tables, pulls and animations, all drawn by one code (extra ``plot``)."""

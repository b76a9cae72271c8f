"""One file format per file, ``read_x`` and ``write_x``: numbers and where they stood, no physics."""

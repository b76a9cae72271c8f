"""How much a bad file may cost in a test."""

from __future__ import annotations

MOST_CPU_S = 30.0
"""Processor time of one file. The promise is 2 s on a calm machine; here only a reader whose time grows with the
square of a file's size fails, never a busy machine."""

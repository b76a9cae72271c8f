"""Checks of a run, and of photons that anybody made: counts, hashes, directions."""

from aomc_sky.verify.counts import FAMILY_LEVEL, CountCheck, CountsReport, verify_counts

__all__ = ["FAMILY_LEVEL", "CountCheck", "CountsReport", "verify_counts"]

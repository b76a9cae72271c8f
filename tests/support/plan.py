"""The level of the statistical tests: a correct program fails any of them with chance 1e-6.

Each p-value is compared with Sidak's share of that level among as many p-values as there may be: so many cases of
tests, which tests/statistical/conftest.py counts, with so many p-values each, which the plan of a case counts.
"""

import numpy as np

FAMILY_LEVEL = 1e-6
MOST_CASES, MOST_P_VALUES = 240, 12


class StatisticalPlan:
    """What one case of a test compares."""

    level = float(-np.expm1(np.log1p(-FAMILY_LEVEL) / (MOST_CASES * MOST_P_VALUES)))

    def __init__(self):
        self.compared = 0

    def check(self, p_value):
        """Count one p-value, and fail where it is below the level."""
        self.compared += 1
        if self.compared > MOST_P_VALUES:
            raise AssertionError(f"more than {MOST_P_VALUES} p-values in one case: raise the bound in {__file__}")
        if not p_value >= self.level:  # NaN fails, too
            raise AssertionError(f"p = {p_value:.3g} is below the level {self.level:.3g}")

    def catches(self, p_value):
        """Fail unless a planted defect is rejected at the level of the suite; costs no share of it."""
        if not p_value < self.level:
            raise AssertionError(f"the planted defect is not caught: p = {p_value:.3g}, level {self.level:.3g}")

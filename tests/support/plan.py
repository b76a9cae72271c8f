"""The declared statistical tests, which share one level of significance.

A correct program fails the whole suite of statistical tests with chance 1e-6: each p-value is compared
with Sidak's share of it. The shares hold only if the list is complete: a test that asks for an undeclared
name fails, and tests/statistical/conftest.py compares the list with the tests that are there.
"""

from dataclasses import dataclass, field

import numpy as np

FAMILY_LEVEL = 1e-6


@dataclass
class StatisticalPlan:
    """Names of tests, each with the number of p-values it compares."""

    declared: dict[str, int]
    family_level: float = FAMILY_LEVEL  #: Chance that a correct program fails any of them
    used: dict[str, int] = field(default_factory=dict)

    @property
    def level(self):
        return float(-np.expm1(np.log1p(-self.family_level) / sum(self.declared.values())))

    def check(self, name, p_value):
        """Count one p-value of a declared test, and fail where it is below the level."""
        if name not in self.declared:
            raise AssertionError(f"{name!r} is not declared in tests/statistical/declared.py")
        self.used[name] = self.used.get(name, 0) + 1
        if self.used[name] > self.declared[name]:
            raise AssertionError(f"{name!r} declares {self.declared[name]} p-values and compares more")
        if not p_value >= self.level:  # NaN fails, too
            raise AssertionError(f"{name}: p = {p_value:.3g} is below the level {self.level:.3g}")

    def catches(self, p_value):
        """Fail unless a planted defect is rejected at the level of the suite; costs no share of it."""
        if not p_value < self.level:
            raise AssertionError(f"the planted defect is not caught: p = {p_value:.3g}, level {self.level:.3g}")

    def bind(self, name):
        return BoundPlan(plan=self, name=name)


@dataclass
class BoundPlan:
    """The plan as one running test sees it: its name is given, its comparisons are counted."""

    plan: StatisticalPlan
    name: str
    compared: int = 0

    def check(self, p_value):
        self.compared += 1
        self.plan.check(self.name, p_value)

    def catches(self, p_value):
        self.plan.catches(p_value)

"""The shared level of the statistical tests; see tests/support/plan.py."""

import pytest

from tests.support.plan import MOST_CASES, StatisticalPlan


@pytest.fixture
def plan(request):
    """The plan of a test, which must compare something."""
    plan, n_failed = StatisticalPlan(), request.session.testsfailed
    yield plan
    assert plan.compared or request.session.testsfailed > n_failed, "no p-value was compared"


@pytest.fixture
def plan_only():
    """The plan for tests that only plant defects and compare no p-value of ours."""
    return StatisticalPlan()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Slow ones included: they are deselected later."""
    n_cases = sum("plan" in getattr(item, "fixturenames", ()) for item in items)
    if n_cases > MOST_CASES:
        raise pytest.UsageError(f"{n_cases} cases of statistical tests: raise the bound in tests/support/plan.py")

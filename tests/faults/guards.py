"""All guards of the matrix of faults: each row has one or more, and each guard a test that fails without it."""

from __future__ import annotations

from tests.faults.guards_of_folders import FOLDER_GUARDS
from tests.faults.guards_of_foreign_files import FOREIGN_FILE_GUARDS
from tests.faults.guards_of_models import MODEL_GUARDS
from tests.faults.guards_of_plans import FORGED_GUARDS, PLAN_GUARDS
from tests.faults.guards_of_runs import RUN_GUARDS
from tests.faults.guards_of_scenes import SCENE_GUARDS
from tests.faults.guards_of_sky_files import SKY_FILE_GUARDS
from tests.faults.guards_of_sky_readings import SKY_READING_GUARDS

GUARDS = (
    *SKY_FILE_GUARDS,
    *SKY_READING_GUARDS,
    *SCENE_GUARDS,
    *MODEL_GUARDS,
    *FOREIGN_FILE_GUARDS,
    *RUN_GUARDS,
    *FOLDER_GUARDS,
    *PLAN_GUARDS,
    *FORGED_GUARDS,
)

if __name__ == "__main__":
    for guard in GUARDS:
        print(f"{guard.row:2d}  {guard.place}  {guard.test}{'  (goes on without an end)' if guard.hangs else ''}")

"""Football as the language sees it: which `.scenic` file each importable name means.

The names of Scenic4RL (`scenic.simulators.gfootball...`) are aliases, so that programs written for it run unchanged.
Read next: `library/model.scenic`.
"""

from pathlib import Path

from scenic_lite.domain import Domain

LIBRARY = Path(__file__).parent / "library"
MODULES = {name: LIBRARY / f"{name}.scenic" for name in ("model", "actions", "behaviors", "simulator")}

FOOTBALL = Domain(
    name="football",
    library={
        f"{package}.{name}": path
        for package in ("football", "scenic.simulators.gfootball")
        for name, path in MODULES.items()
    },
    default_model="football.model",
)

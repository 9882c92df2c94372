"""Programs for Scenic itself, where it is installed, and how tests write and load them."""

from pathlib import Path

import pytest

try:
    import regista.envs.scenic3 as scenic3
except ImportError:
    scenic3 = None
needed = pytest.mark.skipif(scenic3 is None, reason="Scenic 3 is not installed: pip install 'regista[scenic3]'")
ROOT = Path(__file__).parent.parent.parent

THING = """
class Thing:
    requireVisible: False
    allowCollisions: True
    color: (Range(0, 1), 0, 0)
"""
DRIVE = (
    """
param render = False
model scenic.simulators.newtonian.model
"""
    + THING
    + """
behavior Wander():
    while True:
        wait
        self.velocity = Vector(Range(-1, 1), self.velocity.y)

speed = Range(1, 5)
ego = new Thing at (0, 0), with behavior Wander
other = new Thing at (0, Range(5, 10)), with velocity (0, speed), with behavior Wander
terminate when other.position.y > 12
"""
)
MODULAR = """
param render = False
param weather = Uniform('sun', 'rain')
model scenic.simulators.newtonian.model
class Thing:
    length: 2
    requireVisible: False
    allowCollisions: True
behavior Go(pace):
    while True:
        wait
        self.velocity = Vector(pace, 0)
scenario Late(pace):
    setup:
        new Thing at (0, 60), with behavior Go(pace)
scenario Main():
    setup:
        gap = Range(4, 5)
        ego = new Thing at (0, 0)
        other = new Thing ahead of ego by gap, with behavior Go(Range(1, 2))
    compose:
        wait
        do Late(Range(3, 4)) for 1 seconds
        do choose Late(1), Late(2)
"""
STILL = DRIVE.replace("terminate when other.position.y > 12", "")


def load_program(folder, text, **settings):
    """Write a program to a folder and load it."""
    path = folder / f"program{len(list(folder.iterdir()))}.scenic"
    path.write_text(text)
    return scenic3.ScenicProgram(path, **settings)

"""Stop a build from a tree whose symbolic links are lost: it would leave out football, the minigames and the commands.

Everything else about the build is in `pyproject.toml`.
"""

import sys
from pathlib import Path

from setuptools import setup

LINKS = {f"regista/{name}": f"../{name}" for name in ("kernels", "envs", "minigames", "experiments")}
LOST = """\
Regista cannot be built from {root}: {links} must be symbolic links to {targets}, and are not. \
Git on Windows and some programs that unpack zip archives write a small file in place of a link. \
In a clone, run `git config core.symlinks true`, then `git checkout -- regista` (on Windows: in developer mode). \
Instead of a zip archive, take a clone, a tar archive or `pip install git+URL`."""

root = Path(__file__).resolve().parent
lost = [link for link in LINKS if not (root / link / "__init__.py").is_file()]  # in an sdist they are folders
if lost:
    sys.exit(LOST.format(root=root, links=", ".join(lost), targets=", ".join(LINKS[link] for link in lost)))
setup()

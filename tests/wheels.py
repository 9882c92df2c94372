"""Builds wheels and source distributions of the checkout, and virtual environments with an installed wheel.

Read next: `test_build`, the contents of a wheel; `test_install`, the commands of an installed wheel.
"""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

ROOT = Path(__file__).parent.parent
LINKS = ("regista/kernels", "regista/envs", "regista/minigames", "regista/experiments")


def clone(folder: Path, *, links: bool = True) -> Path:
    """Copy the checkout into a folder, as `git clone` does; without `links`, links become text files, as on Windows."""
    words = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\0")
    for name in filter(lambda name: name and os.path.lexists(ROOT / name), names):  # Git also lists deleted files
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if not (ROOT / name).is_symlink():
            target.write_bytes((ROOT / name).read_bytes())
        elif links:
            target.symlink_to(os.readlink(ROOT / name))
        else:
            target.write_text(os.readlink(ROOT / name))
    return folder


def run(words: list[str | Path], folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a program in a folder, with no path to the checkout in its environment."""
    inherited = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    environment = {**inherited, "OMP_NUM_THREADS": "1", **environment}
    return subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


def pip(*words: str | Path, folder: Path, python: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run pip without a network, for another Python if one is given."""
    command = [
        sys.executable,
        "-m",
        "pip",
        *(["--python", python] if python else []),
        *words,
        "--no-index",
        "--no-deps",
    ]
    return run(command, folder, PIP_DISABLE_PIP_VERSION_CHECK="1")


def build_wheel(source: Path, folder: Path) -> Path:
    """Build the wheel of a source tree into a folder and return it."""
    done = pip("wheel", "--no-build-isolation", "--wheel-dir", folder, source, folder=source)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,) = folder.glob("*.whl")
    return wheel


def build_sdist(source: Path, folder: Path) -> Path:
    """Build the source distribution of a source tree into a folder and return it."""
    folder.mkdir()
    code = "import setuptools.build_meta, sys; setuptools.build_meta.build_sdist(sys.argv[1])"
    done = run([sys.executable, "-c", code, folder], source)
    assert done.returncode == 0, done.stdout + done.stderr
    (sdist,) = folder.glob("*.tar.gz")
    return sdist


def install(wheel: Path, folder: Path) -> Path:
    """Create an environment with a wheel and this environment's dependencies, but no checkout; return its Python."""
    venv.create(folder, symlinks=True)
    python = folder / "bin" / "python"
    done = pip("install", wheel, folder=folder, python=python)
    assert done.returncode == 0, done.stdout + done.stderr
    site = Path(run([python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], folder).stdout.strip())
    ours = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (site / "dependencies.pth").write_text("\n".join(sorted(ours)))  # their own .pth files are not read
    return python

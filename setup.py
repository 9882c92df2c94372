"""Install `envs`, `minigames` and `experiments` inside the package `regista`: nearly every project has an `envs`.

In a checkout, and installed with `--editable`, they are folders of their own, and so they are imported. What is built
of it has `regista.envs` and so on: the files are copied there, and what they import, or name as "envs.football...", is
renamed. `ued` and `scenic_lite` are the names that others import, and stay.
"""

import re
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

MOVED = ("envs", "minigames", "experiments")
NAMES = "|".join(MOVED)
IMPORT = re.compile(rf"^(\s*(?:from|import) )({NAMES})(?=[. ])", re.MULTILINE)
NAMED = re.compile(rf"([\"'])({NAMES})(?=\.\w)")  # a dotted name at the beginning of a string


def renamed(text: str) -> str:
    """Return a file's text with the names that its packages are installed under."""
    return NAMED.sub(r"\1regista.\2", IMPORT.sub(r"\1regista.\2", text))


class BuildInside(build_py):
    """Put the packages of `MOVED` below `regista`."""

    def get_package_dir(self, package: str) -> str:
        return super().get_package_dir(package.removeprefix("regista.") if self._moved(package) else package)

    def finalize_options(self) -> None:
        super().finalize_options()
        if self.editable_mode:
            return
        inside = [package for package in self.packages if package.partition(".")[0] in MOVED]
        self.packages = [name for name in self.packages if name not in inside] + [f"regista.{name}" for name in inside]
        for name in [name for name in self.package_data if name.partition(".")[0] in MOVED]:
            self.package_data[f"regista.{name}"] = self.package_data.pop(name)

    def build_module(self, module, module_file, package):
        built = super().build_module(module, module_file, package)
        if not self.editable_mode:
            name = package if isinstance(package, str) else ".".join(package)
            target = Path(self.get_module_outfile(self.build_lib, name.split("."), module))
            text = target.read_text(encoding="utf-8")
            if renamed(text) != text:
                target.chmod(0o644)
                target.write_text(renamed(text), encoding="utf-8")
        return built

    @staticmethod
    def _moved(package: str) -> bool:
        inside = package.split(".")[1:2]
        return package.startswith("regista.") and inside[0] in MOVED


setup(cmdclass={"build_py": BuildInside})

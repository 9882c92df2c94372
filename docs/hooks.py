"""Hooks of mkdocs: pages that lie elsewhere in the repository, and links that hold there as on the site.

A link in a page is relative to the file that the page lies in, so that it works in an editor and on a forge. On the
site a link to another page leads to that page, one to a picture to a copy of it, one to any other file of the
repository to a page with its text. Read next: `mkdocs.yml`.
"""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parent.parent
ELSEWHERE = {  # page of the site: the file that it is
    "language.md": "scenic_lite/README.md",
    "football.md": "envs/football/README.md",
    "dynamics.md": "envs/football/DYNAMICS.md",
    "ued.md": "ued/README.md",
    "grf.md": "envs/grf/README.md",
    "grf-data.md": "lab/grf/data/README.md",
    "oracle.md": "tests/oracle/README.md",
    "results.md": "RESULTS.md",
    "transfer.md": "TRANSFER.md",
    "benchmark.md": "BENCHMARK.md",
    "reliability.md": "RELIABILITY.md",
    "contributing.md": "CONTRIBUTING.md",
    "changelog.md": "CHANGELOG.md",
}
FENCED = re.compile(r"^(`{3,}|~{3,}).*?^\1[^\n]*$", re.M | re.S)
LINK = re.compile(r"(?<=\]\()(?![a-z]+:|#|<)([^)#\s]+)(#[^)\s]*)?(?=\))")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that lie elsewhere, and what all pages link to."""
    for uri, path in ELSEWHERE.items():
        files.append(File.generated(config, uri, abs_src_path=str(ROOT / path)))
    for page in [file for file in files if file.is_documentation_page()]:
        for path in _targets(page):
            uri = _uri(path)
            if not files.get_file_from_path(uri):
                files.append(_shown(config, uri, path))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Let links between files of the repository lead to where these are on the site."""
    place, home = _place(page.file), posixpath.dirname(page.file.src_uri)

    def moved(link: re.Match) -> str:
        path = posixpath.normpath(posixpath.join(posixpath.dirname(place), link[1]))
        return posixpath.relpath(_uri(path), home or ".") + (link[2] or "")

    return "".join(text if fenced else LINK.sub(moved, text) for fenced, text in _parts(markdown))


def _parts(markdown: str) -> Iterator[tuple[bool, str]]:
    """Yield the parts of a page in order, and whether they are fenced blocks."""
    at = 0
    for block in FENCED.finditer(markdown):
        yield False, markdown[at : block.start()]
        yield True, block[0]
        at = block.end()
    yield False, markdown[at:]


def _place(file: File) -> str:
    """Return where the file of a page lies in the repository."""
    return ELSEWHERE.get(file.src_uri, f"docs/{file.src_uri}")


def _targets(page: File) -> set[str]:
    """Return the files of the repository that a page links to. Raises `PluginError` for one that is not there."""
    folder, found = posixpath.dirname(_place(page)), set()
    if page.src_uri.startswith("source/"):
        return found
    for fenced, text in _parts(page.content_string):
        for link in LINK.finditer(text) if not fenced else ():
            path = posixpath.normpath(posixpath.join(folder, link[1]))
            if not (ROOT / path).is_file():
                raise PluginError(f"{_place(page)} links to {path}, which is no file")
            found.add(path)
    return found


def _uri(path: str) -> str:
    """Return what a file of the repository is called on the site."""
    if path == "README.md":  # the front page of a forge
        return "index.md"
    for uri, elsewhere in ELSEWHERE.items():
        if path == elsewhere:
            return uri
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return path if path.endswith(".png") else f"source/{path.lstrip('.')}.md"  # what begins with a dot is left out


def _cells(notebook: str) -> str:
    """Return a notebook as Markdown: its text without links, its code, and its stored outputs."""
    parts = []
    for cell in json.loads(notebook)["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "code":
            parts += [_fenced("python", text), *map(_output, cell["outputs"])]
        else:
            parts.append(re.sub(r"^#", "##", re.sub(r"\[([^]]+)\]\([^)]*\)", r"\1", text), flags=re.M))
    return "\n\n".join(parts)


def _output(output: dict) -> str:
    """Return an output of a cell: an image, or text."""
    data = output.get("data", {"text/plain": output.get("text", "")})
    for kind in ("image/png", "image/gif"):
        if kind in data:
            return f"![output](data:{kind};base64,{''.join(data[kind]).replace(chr(10), '')})"
    return _fenced("text", "".join(data.get("text/plain", "")))


def _fenced(kind: str, text: str) -> str:
    return f"`````{kind}\n{text}\n`````"


def _shown(config: MkDocsConfig, uri: str, path: str) -> File:
    """Return a picture as it is, or a page with the text of a file, which a search does not find."""
    if not uri.startswith("source/"):
        return File.generated(config, uri, abs_src_path=str(ROOT / path))
    kind = {".py": "python", ".sh": "sh", ".csv": "text"}.get(Path(path).suffix, "text")
    text = (ROOT / path).read_text()
    shown = _cells(text) if path.endswith(".ipynb") else _fenced(kind, text)
    return File.generated(config, uri, content=f"---\nsearch:\n  exclude: true\n---\n# `{path}`\n\n{shown}\n")

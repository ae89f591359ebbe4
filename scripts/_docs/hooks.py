"""Hooks of mkdocs: pages made from the package, the notebooks and the files of the root.

Markers in the pages name what is put in their place:

    <!-- commands -->      what `--help` of every command says
    <!-- catalogue -->     the table of effects
    <!-- gallery -->       what each of them does to a run, drawn
    <!-- python -->        the names of `tp_jax`, from their docstrings
"""

import os
from pathlib import Path
from typing import Any

os.environ.setdefault("EQX_ON_ERROR", "nan")  # before equinox is imported: see tp_jax._config

# mkdocs finds them beside this file
import catalogue
import commands
import notebook_pages
from mathematics import with_mathml

import tp_jax as tp

ROOT = Path(__file__).parent.parent.parent

#: Files of the root that are pages too.
ALSO_PAGES = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}


def on_files(files: Any, config: Any) -> Any:
    """Adds the pages that are made."""
    from mkdocs.structure.files import File

    for source, name in ALSO_PAGES.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=text))
    for page in notebook_pages.pages(ROOT / "notebooks"):
        name = f"notebooks/{page.name}.md"
        files.append(File.generated(config, name, content=page.markdown))
        for picture, content in page.pictures.items():
            files.append(File.generated(config, f"notebooks/{picture}", content=content))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Puts what is made in place of the markers."""
    for marker, make in MARKERS.items():
        if marker in markdown:
            markdown = markdown.replace(marker, make())
    return markdown


def on_page_content(content: str, **_: Any) -> str:
    """Draws the formulae."""
    return with_mathml(content)


def on_post_page(output: str, **_: Any) -> str:
    """Names the theme's search, for those who hear the page."""
    search = 'data-md-component="search" role="dialog"'
    return output.replace(search, f'{search} aria-label="Search"')


def _python() -> str:
    """The names of `tp_jax`, functions before classes; modules have sections of their own."""
    names = [name for name in tp.__all__ if callable(getattr(tp, name))]
    order = sorted(names, key=lambda name: (name[0].isupper(), name))
    return "\n".join(f"::: tp_jax.{name}\n" for name in order)


MARKERS = {
    "<!-- commands -->": commands.reference,
    "<!-- catalogue -->": catalogue.table,
    "<!-- gallery -->": catalogue.gallery,
    "<!-- python -->": _python,
}

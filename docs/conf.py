"""The documentation as a site: `docs/build.sh` makes it."""

import os
import re
import subprocess
import sys
from pathlib import Path

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parent.parent

project = "streakcast"
author = "the streakcast developers"
copyright = author  # noqa: A001 - the name that Sphinx asks for
release = re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE).group(1)

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc"]
# The tables are parts of pages.
exclude_patterns = ["_build", "tables"]
html_theme = "furo"
html_title = f"streakcast {release}"
html_theme_options = {"source_directory": "docs/"}
# What a page says is said once: no copies of the sources beside it.
html_copy_source = False

myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]

# The Python pages need the package's texts, not its compiled part.
sys.path.insert(0, str(ROOT / "plugins/python/python"))
autodoc_mock_imports = ["streakcast._core"]
autodoc_typehints = "none"
numpydoc_show_class_members = False


class CommandHelp(SphinxDirective):
    """The help of a verb, as the command line prints it: flags on the page are those that there are."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self):
        binary = os.environ.get("STREAKCAST_BIN")
        if binary is None:
            raise self.error("STREAKCAST_BIN names no command line; docs/build.sh does")
        command = [*self.arguments[0].split(), "--help"]
        done = subprocess.run([binary, *command], capture_output=True, text=True, check=False, env={**os.environ, "NO_COLOR": "1"})
        if done.returncode != 0:
            raise self.error(f"streakcast {' '.join(command)}: {done.stderr.strip()}")
        block = nodes.literal_block(done.stdout, done.stdout)
        block["language"] = "text"
        return [block]


def verbs_under(*words):
    """The verbs that follow these words, and those that follow them, as far as flags."""
    command = [os.environ["STREAKCAST_BIN"], *words, "--help"]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    _, _, commands = listed.partition("Commands:\n")
    verbs = re.findall(r"^  ([a-z][a-z-]*)(?: |$)", commands.split("\n\n")[0], re.MULTILINE)
    below = [verbs_under(*words, verb) for verb in verbs if verb != "help"]
    return [verb for verbs in below for verb in verbs] or [" ".join(words)]


def tell_missing_verbs(app, environment):
    """Every verb that takes flags has its section on the page of verbs, and so has every verb below a verb."""
    page = (ROOT / "docs/verbs.md").read_text()
    missing = [verb for verb in verbs_under() if f"```{{command-help}} {verb}\n" not in page]
    if missing:
        raise RuntimeError(f"docs/verbs.md has no section of: {', '.join(missing)}")


def link_to_repository(app, name, source):
    """The plugins' own pages are not of the site: links to them lead to the repository."""
    source[0] = source[0].replace("](../plugins/", "](https://github.com/streakcast/streakcast/blob/main/plugins/")


def setup(app):
    app.add_directive("command-help", CommandHelp)
    app.connect("source-read", link_to_repository)
    app.connect("env-updated", tell_missing_verbs)
    return {"parallel_read_safe": True}

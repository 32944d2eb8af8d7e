"""Configuration of the documentation site.

`docs/build.sh` copies docs/ with the generated pages and pictures, and builds the site in the copy.
"""

import os
import re
import sys
from pathlib import Path

ROOT = Path(os.environ["STREAKCAST_ROOT"])
REPOSITORY = "https://github.com/streakcast/streakcast/blob/main/"

project = "streakcast"
author = "the streakcast developers"
copyright = author  # noqa: A001 - Sphinx requires this name
release = re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE).group(1)

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc", "sphinx_copybutton"]
# These folders have no pages of their own; other pages include the tables, the generated parts and the pictures.
exclude_patterns = ["_build", "paper", "tables", "generated", "pictures"]
html_theme = "furo"
html_title = f"streakcast {release}"
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["wide.css"]

myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]

# Copies contain commands without prompts and without output.
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True
copybutton_line_continuation_character = "\\"
copybutton_here_doc_delimiter = "EOF"

# The pages need the sources of the Python package, not its compiled part.
sys.path.insert(0, str(ROOT / "plugins/python/python"))
autodoc_mock_imports = ["streakcast._core"]
autodoc_typehints = "signature"
# Signatures contain the names of these types, not their definitions.
TYPES = ROOT / "plugins/python/python/streakcast/typing.py"
NAMES = ["ArrayLike", *re.findall(r'^    "(\w+)",$', TYPES.read_text(), re.MULTILINE)]
autodoc_type_aliases = {name: name for name in NAMES}
autodoc_member_order = "bysource"
python_maximum_signature_line_length = 88
numpydoc_show_class_members = False


def link_to_repository(app, name, source):
    """Turns links out of docs/ into links to the repository."""
    depth = name.count("/") + 1
    source[0] = re.sub(r"\]\((?:\.\./){%d}(?!\.)([\w./-]+\)|[\w./-]+#)" % depth, lambda found: f"]({REPOSITORY}{found[1]}", source[0])


def setup(app):
    app.connect("source-read", link_to_repository)
    return {"parallel_read_safe": True}

# SPDX-License-Identifier: GPL-2.0-or-later
"""Settings of the documentation site; ``make docs`` builds it."""

import sys
from pathlib import Path

from pygments.lexers.special import TextLexer

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from making import pages  # noqa: E402

from lammps_jump import __version__  # noqa: E402

project = "lammps-jump"
author = "The lammps-jump developers"
copyright = author
version = release = __version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton", "sphinx_design"]
exclude_patterns = ["_build", "_made", "figures", "making", "stored"]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4
suppress_warnings = ["mystnb.unknown_mime_type"]

nb_execution_mode = "off"  # a build simulates nothing: `make gallery X=notebook` keeps the outputs in the notebook

autodoc_typehints = "none"  # the docstrings tell the types
autodoc_member_order = "bysource"
napoleon_google_docstring = False

html_theme = "furo"
html_title = f"lammps-jump {version}"
html_static_path = ["making/site"]
html_css_files = ["site.css"]
html_extra_path = ["_made/extra"]
html_copy_source = False
html_show_sphinx = False
copybutton_prompt_text = "$ "


def setup(app: object) -> None:
    """Make the generated pages before Sphinx looks for files."""
    app.add_lexer("csv", TextLexer)
    app.connect("config-inited", lambda *_: pages.make(HERE))

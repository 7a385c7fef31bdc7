"""Settings of the documentation: ``sphinx-build -W --keep-going docs site`` builds it.

Nothing here or in the built pages asks the network for anything: equations become MathML while the
pages are built, the search is a local index, fonts come from the reader's system.
"""

import logging
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

import fretwear

# Embedded fonts are logged at length.
logging.getLogger("fontTools").setLevel(logging.WARNING)

project = "fretwear"
author = "The fretwear developers"
copyright = "the fretwear developers"
version = release = fretwear.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_copybutton",
    "mathml",
    "pictures",
]
exclude_patterns = ["extensions", "generated"]
source_suffix = {".md": "markdown"}

myst_enable_extensions = ["dollarmath", "deflist"]
myst_dmath_double_inline = True
myst_heading_anchors = 4
myst_links_external_new_tab = False
# The pages come from files; nothing is fetched to check the few links that leave them.
suppress_warnings = ["myst.header"]

default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autosummary_generate = False
numpydoc_show_class_members = False
numpydoc_attributes_as_param_list = True
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = f"fretwear {version}"
html_static_path = ["static"]
html_css_files = ["style.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_copyright = False
# Excerpts in the search would be fetched, which a page opened from disk may not do.
html_show_search_summary = False
html_last_updated_fmt = None
html_theme_options = {
    "navigation_with_keys": True,
    "light_css_variables": {
        "color-brand-primary": "#1f5f8b",
        "color-brand-content": "#1f5f8b",
        "font-stack": "system-ui, -apple-system, 'Segoe UI', 'Noto Sans', sans-serif",
    },
    "dark_css_variables": {
        "color-brand-primary": "#7cb8e0",
        "color-brand-content": "#7cb8e0",
    },
}
copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True

# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""The site: the pages of doc/ as they stand, and the reference of both languages (doc/decisions/sphinx.md).

The source folder is the top of the repository, so that links between pages work here and on a code host alike.
"""

import sys
from pathlib import Path

import cv_active_handeye

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(Path(__file__).parent))

project = "active_handeye"
author = "active_handeye contributors"
project_copyright = author
version = release = cv_active_handeye.__version__
language = "en"

root_doc = "doc/site/index"
include_patterns = [
    "*.md",
    "benchmark/README.md",
    "doc/**.md",
    "fuzz/README.md",
    "modules/active_handeye/README.md",
    "modules/active_handeye/tutorials/**.md",
    "samples/*/README.md",
]
exclude_patterns = [".*", "build", "out", "**/__pycache__"]
source_suffix = {".md": "markdown"}

extensions = ["breathe", "docstrings", "mathml", "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
myst_links_external_new_tab = True

breathe_projects = {"active_handeye": str(ROOT / "build/doxygen/xml")}
breathe_default_project = "active_handeye"
breathe_show_include = False
cpp_id_attributes = ["CV_EXPORTS", "CV_EXPORTS_W", "CV_EXPORTS_W_SIMPLE", "CV_WRAP", "CV_OUT", "CV_PROP_RW"]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
napoleon_custom_sections = [("Returns", "params_style")]
nitpick_ignore_regex = [
    ("py:class", ".*"),  # annotations: names of numpy, pydantic and pathlib, and our own that no page shows
    (
        "cpp:identifier",
        r"cv|std|cv::Exception|std::.*|noArray|Mat|Rect|Size|(Input|Output|InputOutput)Array(OfArrays)?",
    ),
    ("cpp:identifier", r"(HandEye|Plan|Refine|Stripe|Verify)(Params|Summary)"),  # in the scope of cv::active_handeye
]

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"active_handeye {release}"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_additional_pages = {"index": "redirect.html"}
templates_path = ["templates"]
html_copy_source = False
html_show_sphinx = False
pygments_style = "friendly"
pygments_dark_style = "native"

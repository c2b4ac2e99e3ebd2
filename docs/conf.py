# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""How Sphinx builds the documentation."""

from __future__ import annotations

from tumtools import __version__

project = "tumtools"
author = "The tumtools authors"
release = __version__
extensions = ["myst_parser"]
source_suffix = [".md"]
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = f"tumtools {release}"
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3

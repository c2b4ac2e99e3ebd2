# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Checks of a sequence: the rules, the engine that runs them, and the physics that some rest on."""

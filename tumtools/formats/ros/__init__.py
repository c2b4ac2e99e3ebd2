# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""Messages, layouts and streams shared by the three ROS containers."""

# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""ROS 1 bags, version 2.0 (http://wiki.ros.org/Bags/Format/2.0)."""

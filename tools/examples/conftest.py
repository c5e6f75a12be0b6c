# SPDX-License-Identifier: MIT
"""The fixture `drehgeber_rig` starts rigs. Put tools/python on PYTHONPATH, and `drehgeber` on PATH or
its path into DREHGEBER."""

pytest_plugins = ["drehgeber.fixture"]

"""Runs a test module inside of Blender: blender -b --factory-startup -P run.py -- MODULE [unittest's arguments]."""

import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import support  # noqa: E402

support.enable()
arguments = sys.argv[sys.argv.index("--") + 1 :]
program = unittest.main(module=arguments[0], argv=["run.py", "-v", *arguments[1:]], exit=False)
sys.stdout.flush()
sys.stderr.flush()
# Blender would end with status 0.
os._exit(0 if program.result.wasSuccessful() and program.result.testsRun else 1)

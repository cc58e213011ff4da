"""The plants that tests take their truth from can be imported by every test."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "plants"))

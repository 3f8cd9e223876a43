"""Makes the modules shared by the tests of this folder importable."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))

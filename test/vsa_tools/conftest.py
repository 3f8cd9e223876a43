# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Makes the modules shared by the tests of this folder importable."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))

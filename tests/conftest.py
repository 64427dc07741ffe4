"""Makes the tests' own modules (meshes, reference) importable, and runs reproducible."""

import sys
from pathlib import Path

from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))

# The first example of a test may wait for the compiler; what is found must be found again.
settings.register_profile("reproducible", deadline=None, derandomize=True, database=None)
settings.load_profile("reproducible")

#: Run by ParaView's Python, not by pytest.
collect_ignore = ["paraview_session.py"]

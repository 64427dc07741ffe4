"""``python -m vtksmooth_gui``."""

import sys

from .app import main

sys.exit(main())

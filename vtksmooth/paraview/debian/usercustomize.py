"""For Debian's ParaView 5.11: with this folder on PYTHONPATH it can load Python plugins.

Its own code asks for inspect.getargspec, which Python 3.11 no longer has. Every other Python is left
alone, and so is Debian's sitecustomize.
"""

import inspect

if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec  # type: ignore[attr-defined]

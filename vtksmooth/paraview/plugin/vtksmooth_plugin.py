"""The plugin that ParaView loads: every filter of vtksmooth under Filters > Surface smoothing.

Load it in Tools > Manage Plugins, or name its folder in PV_PLUGIN_PATH; docs/paraview.md says what must
be installed where.
"""

import sys
from pathlib import Path

from paraview.util.vtkAlgorithm import smproperty, smproxy

# Packages beside this one serve when ParaView has none of its own: its numpy and VTK come first.
sys.path.append(str(Path(__file__).resolve().parents[3]))
try:
    import vtksmooth
    from vtksmooth.paraview import proxies
except ImportError as error:
    # ParaView answers an ImportError by loading the file a second time, in another way.
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    raise RuntimeError(
        f"vtksmooth cannot be loaded: {error}. ParaView runs Python {python} and needs numba, llvmlite and "
        f"filelock for it in {sys.path[-1]}; docs/paraview.md of vtksmooth says how to install them."
    ) from None

paraview_plugin_name = "vtksmooth"
paraview_plugin_version = vtksmooth.__version__

for _filter, _proxy in proxies.PROXIES.items():
    _label = proxies.words(_filter.__name__)
    _decorate = smproxy.filter(name=_filter.__name__, label=_label, support_reload=False)
    globals()[_filter.__name__] = _decorate(smproperty.xml(proxies.definition(_filter))(_proxy))

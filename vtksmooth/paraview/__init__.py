"""The filters in ParaView: ``plugin/vtksmooth_plugin.py`` is what ParaView loads (docs/paraview.md)."""

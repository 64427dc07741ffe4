"""Ridges and corners: the metric tensor, filtered normals, detection, and edits by hand."""

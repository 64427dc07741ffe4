"""Arrays only: kernels know points, offsets and connectivity, and neither VTK nor windows."""

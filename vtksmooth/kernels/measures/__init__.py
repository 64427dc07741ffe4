"""What is measured on a mesh: quality of elements, angles, curvature, volume, change."""

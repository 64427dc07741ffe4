"""Distances and sight: closest points, signed distance, winding number, rays."""

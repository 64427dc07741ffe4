"""The mesh as arrays, and who is next to whom: adjacency, regions, paths, triangulation."""

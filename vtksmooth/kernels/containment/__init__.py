"""Staying within a space: crossings, separating planes, and moves that are safe."""

"""Widgets, one a file: they show what they are given and say what the user asked for."""

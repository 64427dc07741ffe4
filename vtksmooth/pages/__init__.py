"""Before and after, for people: measures, tables, pictures, and one-page reports as HTML and PDF.

``measures`` compares two meshes, ``tables`` puts the figures into words and rows, ``pictures`` draws
without a window, ``histogram`` counts and draws as SVG. ``page`` collects what a report shows, ``html`` and
``pdf`` lay it out, ``writing`` writes it.
"""

"""The desktop application of vtksmooth; started by ``vtksmooth-gui`` or ``vtksmooth gui``.

``model`` knows meshes, their history and their measures, and nothing of windows; ``views`` are widgets,
one a file, that show what they are given and say what the user asked for; ``controllers`` join the two.
"""

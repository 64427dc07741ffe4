"""Compilation and threads: how Python functions become kernels, where machine code is kept, who runs it."""

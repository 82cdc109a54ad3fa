"""Utilities of all other folders: types, argument validation, atomic files, `.npy` files, progress bars.

Reading order: types, public, moved_module, interrupts, memmap, npy, progress, suggestions, masked, arguments,
error_context, atomic_files.
"""

"""Utilities of all other folders: types, argument validation, files written whole, `.npy` files, progress bars.

Reading order: types, widen, public, pictured, moved_module, interrupts, forks, memmap, npy, allocator, git_lfs,
printable, progress, suggestions, masked, arguments, error_context, limited_process, whole_writes, targets, file_locks,
atomic_files.
"""

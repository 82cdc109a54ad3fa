"""What every other folder may use: types, argument checks, files written whole, progress.

Reading order: types, public, moved_module, interrupts, memmap, npy, progress, arguments, error_context, atomic_files.
"""

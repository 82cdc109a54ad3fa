"""What every other folder may use: types, argument checks, files written whole, progress.

Reading order: types, interrupts, memmap, npy, progress, arguments, error_context, atomic_files.
"""

"""Leapfrog on the host: what the steps' shaders do, by loops over the processors that numba compiles, or by NumPy.

Reading order: constants, loops, vectorized, springs_by_slot, leapfrog.
"""

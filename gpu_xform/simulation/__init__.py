"""Simulation: points joined by springs, moved by the laws of Newton and Hooke.

Reading order: _validation, obstacles, mesh_springs, spring_system, stability, incidence, grid, conditions, step_choice,
energy, state_file, point_state, leapfrog, host, stepper, trajectory, springs, children.
"""

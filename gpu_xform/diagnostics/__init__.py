"""What tells about a device: whether it works, and how fast.

Reading order: bench, doctor.
"""

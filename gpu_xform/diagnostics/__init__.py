"""Diagnostics of a device: whether its results are right, and how fast it is.

Reading order: bench, bench_report, tune, doctor_report, doctor.
"""

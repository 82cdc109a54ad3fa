"""Attacks that run for as long as one likes: `make fuzz`, `make attack`. They are no tests of pytest."""

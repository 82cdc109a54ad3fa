"""Draw lists to pixels."""

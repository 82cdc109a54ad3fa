"""What every other folder may use: types, argument checks, files written whole, progress."""

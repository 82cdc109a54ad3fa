"""Argument types: each function parses the text of one kind of option value; argparse names the option in errors.

Reading order: texts, numbers, paths, vectors, models, styles, pictures.
"""

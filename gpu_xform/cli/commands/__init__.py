"""The subcommands, one a file.

Reading order: render, animate, view, transform.
"""

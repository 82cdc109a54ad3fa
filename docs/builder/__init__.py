"""The documentation site: pages of the repository, and what is made of scripts, parser and docstrings, through Sphinx.

Reading order: project, links, pages, reference, conf, check, __main__.
"""

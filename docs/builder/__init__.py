"""The documentation site: pages of the repository, and what is made of scripts, parser and docstrings, through Sphinx.

Reading order: project, links, pages, reference, command, gallery, options, notebook, conf, check, __main__.
"""

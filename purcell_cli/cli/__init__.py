"""The command line: parse, load, call the library, show; one command a file.

Thin on purpose: documents and tables are made in `reports`. Imports everything below.
"""

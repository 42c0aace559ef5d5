"""The JSON documents that commands print, as types: each key with its type, its unit and its meaning.

`docs/json.md` is made from `catalogue`. Imports enumerations of the library, and of no command.
"""

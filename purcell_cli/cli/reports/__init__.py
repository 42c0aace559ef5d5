"""Results as JSON documents and as tables for the terminal.

Each module makes the document of one command and shows it. Imports the library, never a command.
"""

"""The command line as `python -m purcell_cli`."""

from purcell_cli.cli.app import main

if __name__ == "__main__":
    main()

"""The command line, as `purcell` and as `python -m purcell_cli`: Ctrl-C is one line during imports, too."""

import sys


def main() -> None:
    """Run the command line, see `cli.app.main`, and exit with its code, or with 130 where that is interrupted."""
    try:
        from purcell_cli.cli.app import main as run

        run()
    except KeyboardInterrupt:
        sys.stderr.write("purcell: interrupted\n")
        sys.exit(130)
    finally:
        import signal

        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Python's own end takes a moment, and all is done


if __name__ == "__main__":
    main()

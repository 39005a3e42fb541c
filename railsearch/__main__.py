"""The entry point of `railsearch` and `python -m railsearch`: small, so that Ctrl-C is answered while the rest is loaded."""

import sys


def main() -> None:
    """Load and run the command line; Ctrl-C before a command has begun ends it with code 130, as a shell expects."""
    try:
        from railsearch.cli import main as command_line

        command_line()
    except KeyboardInterrupt:
        sys.stderr.write("railsearch: stopped before anything was done\n")
        sys.exit(130)


if __name__ == "__main__":
    main()

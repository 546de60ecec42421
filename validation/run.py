"""See run.sh."""
import sys

from suite.arguments import parse


def main():
    options = parse()
    if options.check:
        print(*options.modes)
        return 0
    from suite.command import main as run  # needs packages, which run.sh installs
    return run(options)


if __name__ == "__main__":
    sys.exit(main())

"""``python -m fretwear`` is the command ``fretwear``."""

from fretwear.cli import main

if __name__ == "__main__":
    main()

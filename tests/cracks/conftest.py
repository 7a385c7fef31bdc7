from ..cli.conftest import case_file, desk  # noqa: F401 - the commands are called as those of the core

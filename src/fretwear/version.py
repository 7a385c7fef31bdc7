"""The version of the package, and the digest of all that its numbers depend on.

The module imports nothing of the package, because every start of the workflow loads it.
"""

from functools import cache
from pathlib import Path

__version__ = "0.1.0"

# The sources that turn the parameters of a case into the numbers in its file. Sources that read,
# check, doubt or plan a case, or draw and report its numbers, do not count.
_SOURCES = ("mechanics", "theory", "parts.py", "forms.py", "vocabulary.py")
_CASE = ("study/case.py", "study/members.py", "study/setup.py", "study/spacing.py")
_DRIVERS = ("run/accuracy.py", "run/simulate.py", "data/labels.py")
_LIBRARIES = ("numpy", "scipy", "ducc0")


@cache
def code_digest() -> str:
    """Return the digest of everything but its parameters that decides the bits of a result.

    It covers the sources that compute the result and the versions of the libraries, and is the
    same from a checkout and from a wheel.
    """
    import hashlib
    from importlib import metadata

    package = Path(__file__).parent
    digest = hashlib.sha256()
    places = (package / name for name in (*_SOURCES, *_CASE, *_DRIVERS))
    files = (file for place in places for file in (place, *place.rglob("*")))
    for file in sorted(file for file in files if file.suffix in (".py", ".cpp", ".h")):
        content = file.read_bytes()
        digest.update(f"{file.relative_to(package).as_posix()} {len(content)}\n".encode())
        digest.update(content)
    for library in _LIBRARIES:
        installed = next((copy.version for copy in metadata.distributions(name=library)), "")
        digest.update(f"{library} {installed}\n".encode())
    return digest.hexdigest()[:16]

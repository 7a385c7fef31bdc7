"""The version of the package, and the digest of what its numbers come from.

Nothing else is imported here, because every start of the workflow needs it.
"""

from functools import cache
from pathlib import Path

__version__ = "0.1.0"

# What lies between the parameters of a case and the numbers in its file: not what reads, checks,
# doubts or plans a case, nor what draws and reports its numbers.
_SOURCES = ("mechanics", "theory", "parts.py", "vocabulary.py")
_CASE = ("study/case.py", "study/members.py", "study/setup.py", "study/spacing.py")
_DRIVERS = ("running/simulate.py", "data/labels.py")
_LIBRARIES = ("numpy", "scipy", "ducc0")


@cache
def code_digest() -> str:
    """Return the digest of everything, besides its parameters, that a result depends on to the bit.

    These are the sources that compute it and the versions of the libraries, from a checkout as from
    a wheel.
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
        found = next((each.version for each in metadata.distributions(name=library)), "")
        digest.update(f"{library} {found}\n".encode())
    return digest.hexdigest()[:16]

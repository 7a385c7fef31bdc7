"""Shakes the last bits of what BLAS, LAPACK and transforms compute for the mechanics.

Kernels of other processors round elsewhere. Python imports this module by itself, in the processes
that tests start as well, where its folder is on the path:

    PYTHONPATH=tests/shaken FRETWEAR_TEST_SHAKEN=1 pytest

A number changes by up to four units in its last place, in single or double precision. By how much
follows from the seed, its place in the array and the number itself: the same computation gives the
same bits, as it does on any one machine. FRETWEAR_TEST_WITHOUT=ducc0 hides that library.
"""

import ast
import os
import re
import sys
from functools import lru_cache
from importlib.machinery import PathFinder, SourceFileLoader

PACKAGES = "fretwear.mechanics.", "fretwear_cracks."
LIBRARIES = re.compile(r"scipy\.(linalg|fft)(\.\w+)*")
CALLS = re.compile(r"np\.(dot|vdot|einsum|linalg\.\w+|fft\.\w+)|(ducc0|scipy)\.fft\.\w+")
NAME = "__shaken__"
_FACTORS = {4: 0x9E3779B1, 8: 0x9E3779B97F4A7C15}


@lru_cache(64)
def _places(shape, size):
    """A number for each place of an array, by the seed."""
    import numpy as np

    seed = int(os.environ["FRETWEAR_TEST_SHAKEN"])
    places = np.arange(1, 1 + int(np.prod(shape)), dtype=f"u{size}").reshape(shape)
    return places * places.dtype.type(_FACTORS[size] + 2 * seed)


def shaken(result):
    """Return a result with other last bits; arrays are changed in their own memory."""
    import numpy as np

    if isinstance(result, tuple):
        return tuple(map(shaken, result))
    if isinstance(result, float | complex):
        return type(result)(shaken(np.array([result]))[0])
    if not isinstance(result, np.ndarray) or result.dtype.kind not in "fc":
        return result
    if not result.flags.writeable:
        result = result.copy()
    for part in (result.real, result.imag) if result.dtype.kind == "c" else (result,):
        size = part.itemsize
        mixed = part.view(f"u{size}") ^ _places(part.shape, size)
        mixed *= mixed.dtype.type(_FACTORS[size])
        units = mixed.view(f"i{size}") >> (8 * size - 3)  # -4 to 3
        bits = part.view(f"i{size}")
        np.add(bits, units, out=bits, where=np.isfinite(part) & (part != 0.0))
    return result


class _Shaking(ast.NodeTransformer):
    """Passes results of products and calls through `shaken`."""

    def __init__(self, tree):
        imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        found = [node for node in imports if LIBRARIES.fullmatch(node.module or "")]
        self.names = {name.asname or name.name for node in found for name in node.names}

    def visit_BinOp(self, node):
        self.generic_visit(node)
        return _call(NAME, node) if isinstance(node.op, ast.MatMult) else node

    def visit_Call(self, node):
        self.generic_visit(node)
        name = ast.unparse(node.func)
        return _call(NAME, node) if name in self.names or CALLS.fullmatch(name) else node


def _call(name, node):
    return ast.copy_location(ast.Call(ast.Name(name, ast.Load()), [node], []), node)


class _Loader(SourceFileLoader):
    """Compiles a source each time, so that no other run finds shaken code in a cache."""

    def get_code(self, fullname):
        path = self.get_filename(fullname)
        tree = ast.parse(self.get_data(path), path)
        tree = ast.fix_missing_locations(_Shaking(tree).visit(tree))
        return compile(tree, path, "exec", dont_inherit=True)

    def exec_module(self, module):
        vars(module)[NAME] = shaken
        super().exec_module(module)


class _Finder:
    @staticmethod
    def find_spec(name, path=None, target=None):
        spec = PathFinder.find_spec(name, path, target) if name.startswith(PACKAGES) else None
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = _Loader(spec.loader.name, spec.loader.path)
        return spec


if os.environ.get("FRETWEAR_TEST_SHAKEN"):
    sys.meta_path.insert(0, _Finder)
for _name in os.environ.get("FRETWEAR_TEST_WITHOUT", "").split():
    sys.modules[_name] = None

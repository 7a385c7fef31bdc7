"""How the property tests run everywhere: the same examples each time, however slow the machine.

With ``--hypothesis-profile=thorough`` they try other and far more examples every time.
"""

import os

from hypothesis import settings

# Tests run beside each other; threads of BLAS on top of that only wait for one another. It reads
# this when numpy is imported.
os.environ.setdefault("OMP_NUM_THREADS", "1")

settings.register_profile("reproducible", deadline=None, derandomize=True)
settings.register_profile("thorough", deadline=None, max_examples=10_000, print_blob=True)
settings.load_profile("reproducible")

"""How the property tests run everywhere: the same examples each time, however slow the machine.

With ``--hypothesis-profile=thorough`` they try other and far more examples every time.
"""

from hypothesis import settings

settings.register_profile("reproducible", deadline=None, derandomize=True)
settings.register_profile("thorough", deadline=None, max_examples=10_000, print_blob=True)
settings.load_profile("reproducible")

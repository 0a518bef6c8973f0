"""What laws are tried on: the same cases each time; by `make laws` ten times as many, new ones each time."""

import os

from hypothesis import settings

USUAL = 100


def load_profile() -> None:
    """Load the profile that is asked for: `laws` with BELTSORT_LAWS=1."""
    settings.register_profile("default", max_examples=USUAL, derandomize=True, deadline=None, database=None)
    settings.register_profile(
        "laws", max_examples=10 * USUAL, derandomize=False, deadline=None, database=None, print_blob=True
    )
    settings.load_profile("laws" if os.environ.get("BELTSORT_LAWS") == "1" else "default")


def cases(count: int) -> settings:
    """So many cases by default, and in proportion where the profile says more."""
    return settings(max_examples=count * settings().max_examples // USUAL)

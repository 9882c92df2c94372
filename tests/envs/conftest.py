"""What is known to be amiss, with its cause."""

import pytest

KNOWN = {
    "test_a_program_does_what_it_says[counterattack]": "the ball comes later since bodies start as in the real engine",
    "test_slips_of_behaviors_are_warned_of[simulation().scenic_rewards": "the hint went with shared attributes",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        for name, reason in KNOWN.items():
            if item.name.startswith(name):
                item.add_marker(pytest.mark.xfail(reason=reason))

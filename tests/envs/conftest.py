"""What is known to be amiss, with its cause."""

import pytest

KNOWN = {
    "test_a_program_does_what_it_says[counterattack]": "the ball comes later since bodies start as in the real engine",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        for name, reason in KNOWN.items():
            if item.name.startswith(name):
                item.add_marker(pytest.mark.xfail(reason=reason))

"""What `from ued import ...` offers."""

import pytest

import ued


def test_every_name_is_there():
    for name in ued.__all__:
        assert getattr(ued, name).__name__ == name
    assert set(ued.__all__) == set(ued._HOME)


def test_a_name_that_is_not_there():
    with pytest.raises(AttributeError, match="module 'ued' has no attribute 'PLR2'"):
        _ = ued.PLR2

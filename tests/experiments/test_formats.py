"""`--format` of commands that train: every picture has the format, and none is a PNG."""

import pytest

from regista.experiments.__main__ import main

pytestmark = pytest.mark.drawn

SHORT = ["--total-env-steps", "2000", "--eval-every", "1000", "--eval-episodes", "4", "--no-record"]
BEGINS = {"svg": b"<?xml", "pdf": b"%PDF"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", BEGINS)
@pytest.mark.long
def test_pictures_of_a_training_and_a_comparison_have_the_format_that_is_asked_for(
    probe, trained_here, tmp_path, capsys, kind
):
    flags = [*SHORT, "--format", kind]
    assert main(["train", "1v1Free", "--method", "dr", *flags, "--out", str(tmp_path / "one")]) == 0
    words = ["compare", "1v1Free", "--seeds", "1", "--episodes", "4", "--levels", "0", *flags]
    assert main([*words, "--out", str(tmp_path / "all")]) == 0
    said = capsys.readouterr().out
    wanted = ["one/learning_curve", *(f"all/{name}" for name in ("overview", "learning_curves", "levels"))]
    assert all((tmp_path / f"{name}.{kind}").read_bytes().startswith(BEGINS[kind]) for name in wanted)
    assert not [*(tmp_path / "one").glob("*.png"), *(tmp_path / "all").glob("*.png")] and f"overview.{kind}" in said
